"""The page's process: its routes, the seats that it shows, and the channel to the supervisor."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import socket
import time
from collections.abc import Awaitable, Callable, Mapping
from contextlib import nullcontext
from functools import cache
from http import HTTPStatus
from pathlib import Path
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE
from simx_server.browsers import is_of_another_page
from simx_server.classroom import channel
from simx_server.classroom.editor.plan import MOST_TEXT
from simx_server.classroom.plan import ClassPlan, Seat
from simx_server.gateways.descriptors import raise_limit

from . import texts
from .access import Access
from .editor_routes import WITH_TEXT, EditorRoutes
from .http import MOST_BODY, HttpServer, Request, Response
from .seat_view import IMAGE_AGE, NoImage, SeatView

logger = logging.getLogger(__name__)

AT_ONCE = 4
"""Images that all seats together make at the same time: more browsers get fewer images a second, not a slower class."""

RESET_PAUSE = 2.0
"""Seconds between two resets of a seat."""

FILES = Path(__file__).with_name("files")
KINDS = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
}

STATIC = ("class.css", "common.js", "class.js", "seat.js", "editor.css", "editor.js", "editing.js", "view.js")
"""Styles and scripts of the page."""

_SEAT = re.compile(r"/seat/([1-9][0-9]{0,3})(?:/([a-z]+))?")


def serve_page(plan: ClassPlan, listener: socket.socket, supervisor: socket.socket) -> int:
    """Serve the page until the supervisor ends. Returns the exit code."""
    raise_limit()
    asyncio.run(ClassPage(plan, listener.getsockname()[1]).serve(listener, supervisor))
    return DONE


class ClassPage:
    """Routes of the page. Used by the event loop's thread."""

    def __init__(self, plan: ClassPlan, port: int) -> None:
        """Make the page of a class whose seats have not started.

        Args:
            port: where browsers reach the page.
        """
        self._plan, self._port = plan, port
        self._access = Access(plan, port)
        gate = asyncio.Semaphore(AT_ONCE)
        self._seats = {seat.number: seat for seat in plan.seats}
        self.views = {number: SeatView(number, gate) for number in self._seats}
        self._reset_at: dict[int, float] = {}
        self._supervisor: socket.socket | None = None
        self._routes: Mapping[tuple[str, str], Callable[[Request], Awaitable[Response]]] = {
            ("GET", "/"): self._page,
            ("GET", "/class"): self._class,
            ("GET", "/links"): self._links,
            ("POST", "/reset"): self._reset_all,
        }
        self._seat_routes: Mapping[tuple[str, str], Callable[[Request, Seat], Awaitable[Response]]] = {
            ("GET", "state"): self._state,
            ("GET", "lines"): self._lines,
            ("GET", "image"): self._image,
            ("POST", "reset"): self._reset,
        }
        self._editor = None if plan.editor is None else EditorRoutes(plan, plan.editor, self.views)
        if self._editor is not None:
            self._seat_routes = {**self._seat_routes, **self._editor.routes}

    async def serve(self, listener: socket.socket, supervisor: socket.socket) -> None:
        """Serve until the supervisor closes its end."""
        self._supervisor = supervisor
        is_over = asyncio.Event()
        asyncio.get_running_loop().add_reader(supervisor, self._hear, supervisor, is_over)
        server = HttpServer(self.answer, self._most_body)
        async with self._editor or nullcontext(), await server.listen(listener):
            await is_over.wait()

    def _most_body(self, request: Request) -> int:
        """Return the bytes of body that a request may have: a program's text, from somebody who may use the seat."""
        found = _SEAT.fullmatch(request.path)
        if self._editor is None or found is None or found[2] not in WITH_TEXT:
            return MOST_BODY
        number = int(found[1])
        is_known = number in self._seats and self._access.may_use(request, number)
        return MOST_TEXT if is_known and self._access.is_from_here(request) else MOST_BODY

    def _hear(self, supervisor: socket.socket, is_over: asyncio.Event) -> None:
        """Take a message of the supervisor."""
        try:
            data, descriptors, _, _ = socket.recv_fds(supervisor, 4096, 1)
        except (BlockingIOError, InterruptedError):
            return
        if not data:
            is_over.set()
            return
        message = channel.unpacked(data).fields
        if "seat" in message:
            view = self.views[message["seat"]]
            view.started(socket.socket(fileno=descriptors[0]), is_ready=bool(message.get("is_ready")))
        elif "ready" in message:
            self.views[message["ready"]].ready()
        elif "gone" in message:
            self.views[message["gone"]].gone(message["reason"])
            if self._editor is not None:
                self._editor.seats[message["gone"]].stop("the simulator of the seat has ended")

    # --- requests --------------------------------------------------------------------------------

    async def answer(self, request: Request) -> Response:
        """Answer a request of a browser."""
        method = "GET" if request.method == "HEAD" else request.method
        if method not in ("GET", "POST"):
            return _refusal(
                HTTPStatus.METHOD_NOT_ALLOWED, "This page knows GET and POST.", ("Allow", "GET, HEAD, POST")
            )
        if is_of_another_page(request.headers) or (
            method == "POST" and not self._access.is_from_here(request)
        ):
            return _refusal(HTTPStatus.FORBIDDEN, "Another web site may not use this page.")
        if method == "GET" and (file := _file(request.path.removeprefix("/"))) is not None:
            return file
        if self._editor is not None and method == "GET" and (part := self._editor.component.file(request)):
            return part
        if found := _SEAT.fullmatch(request.path):
            return await self._answer_seat(method, request, int(found[1]), found[2])
        route = self._routes.get((method, request.path))
        if route is None:
            return _refusal(HTTPStatus.NOT_FOUND, "There is nothing here.")
        if request.path == "/" and "token" in request.query:
            return _logged_in(self._access.teachers_login(request.query["token"]), "/")
        if not self._access.is_teacher(request):
            return _refusal(
                HTTPStatus.UNAUTHORIZED,
                "This page is the teacher's. Open the link that simx classroom printed when it started.",
            )
        return await route(request)

    async def _answer_seat(self, method: str, request: Request, number: int, what: str | None) -> Response:
        seat = self._seats.get(number)
        is_link = what is None and method == "GET" and "token" in request.query
        if seat is None:  # as for a wrong token: strangers do not learn how many seats there are
            return _logged_in(None, "") if is_link else _refusal(HTTPStatus.UNAUTHORIZED, _ASK_FOR_LINK)
        if is_link:
            return _logged_in(self._access.login(request.query["token"], number), f"/seat/{number}")
        if not self._access.may_use(request, number):
            return _refusal(HTTPStatus.UNAUTHORIZED, _ASK_FOR_LINK)
        if what is None and method == "GET":
            return self._own_page(seat)
        route = self._seat_routes.get((method, what or ""))
        if route is None:
            return _refusal(HTTPStatus.NOT_FOUND, "There is nothing here.")
        return await route(request, seat)

    def _own_page(self, seat: Seat) -> Response:
        if self._editor is None:
            return _seat_page("connect.html")
        return _seat_page("editor.html", self._editor.header(seat))

    async def _page(self, _: Request) -> Response:
        return _document("class.html")

    async def _class(self, _: Request) -> Response:
        states = await asyncio.gather(*(self._described(seat) for seat in self._plan.seats))
        return _json({"scene": self._plan.scene, "seats": states})

    async def _described(self, seat: Seat) -> dict[str, Any]:
        program = None if self._editor is None else self._editor.seats[seat.number].summary()
        return {"student": seat.student, "program": program, **await self.views[seat.number].state()}

    async def _links(self, _: Request) -> Response:
        return _json(
            [
                {
                    "number": seat.number,
                    "student": seat.student,
                    "link": texts.link(self._plan, seat, self._port),
                    "lines": texts.lines(self._plan, seat),
                }
                for seat in self._plan.seats
            ]
        )

    async def _state(self, _: Request, seat: Seat) -> Response:
        return _json({"scene": self._plan.scene, **await self._described(seat)})

    async def _lines(self, _: Request, seat: Seat) -> Response:
        return _json(texts.lines(self._plan, seat))

    async def _image(self, request: Request, seat: Seat) -> Response:
        size = request.query.get("size", "small")
        if size not in IMAGE_AGE:
            return _refusal(HTTPStatus.BAD_REQUEST, f"There is no such size; valid: {', '.join(IMAGE_AGE)}.")
        try:
            return Response(HTTPStatus.OK, await self.views[seat.number].image(size), "image/jpeg")
        except NoImage as problem:
            return _refusal(HTTPStatus.SERVICE_UNAVAILABLE, f"There is no image: {problem}.")

    async def _reset(self, _: Request, seat: Seat) -> Response:
        now = time.monotonic()
        if now - self._reset_at.get(seat.number, -RESET_PAUSE) < RESET_PAUSE:
            return _refusal(
                HTTPStatus.TOO_MANY_REQUESTS, "This seat was reset a moment ago.", ("Retry-After", "2")
            )
        self._reset_at[seat.number] = now
        return self._ask_supervisor(seat.number)

    async def _reset_all(self, _: Request) -> Response:
        self._reset_at = dict.fromkeys(self._seats, time.monotonic())
        return self._ask_supervisor("all")

    def _ask_supervisor(self, wanted: int | str) -> Response:
        assert self._supervisor is not None
        try:
            self._supervisor.send(channel.packed({"reset": wanted}))
        except OSError:
            return _refusal(HTTPStatus.SERVICE_UNAVAILABLE, "The class is busy; try again.")
        return Response(HTTPStatus.ACCEPTED, b"{}", "application/json")


_ASK_FOR_LINK = "This seat has its own link, with a token. Ask your teacher for it, and open it again."


def _logged_in(cookie: str | None, path: str) -> Response:
    """Set the cookie, and take the token out of the address bar."""
    if cookie is None:
        return _refusal(HTTPStatus.FORBIDDEN, "The token in this link is wrong, or of an earlier class.")
    return Response(HTTPStatus.SEE_OTHER, headers=(("Set-Cookie", cookie), ("Location", path)))


def _refusal(status: HTTPStatus, text: str, *headers: tuple[str, str]) -> Response:
    return Response(status, text.encode() + b"\n", headers=headers)


def _json(value: object) -> Response:
    return Response(HTTPStatus.OK, json.dumps(value).encode(), "application/json")


def _document(name: str, *headers: tuple[str, str]) -> Response:
    return Response(HTTPStatus.OK, _read(name), KINDS[Path(name).suffix], headers)


def _seat_page(main: str, *headers: tuple[str, str]) -> Response:
    """Return the page of a seat with its main part, from its separate file."""
    text = _read("seat.html").replace(b"<!-- main -->\n", _read(main))
    return Response(HTTPStatus.OK, text, KINDS[".html"], headers)


@cache
def _read(name: str) -> bytes:
    return (FILES / name).read_bytes()


def _file(name: str) -> Response | None:
    """Return a style or script of the page, which hold nothing secret; None if it is not one."""
    if name not in STATIC:
        return None
    return _document(name)
