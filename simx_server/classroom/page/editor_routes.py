"""The part of the page that is the editor's: programs, runs, 3-D views, and Monaco's files."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AsyncExitStack
from http import HTTPStatus
from typing import Any

from simx_server.classroom.editor.component import Component, line_for_students, policy
from simx_server.classroom.editor.plan import MOST_TEXT, EditorPlan
from simx_server.classroom.editor.seat_editor import NotSaved, NotStarted, SeatEditor
from simx_server.classroom.editor.views import NoView, Views
from simx_server.classroom.plan import ClassPlan, Seat
from simx_server.viewer.launching import missing

from .http import Request, Response
from .seat_view import SeatView

SeatRoute = Callable[[Request, Seat], Awaitable[Response]]

WITH_TEXT = ("program", "run")
"""Parts of a seat's address whose requests have the text of a program."""


class EditorRoutes:
    """Answers for all seats. Used by the event loop's thread."""

    def __init__(self, plan: ClassPlan, editor: EditorPlan, views: Mapping[int, SeatView]) -> None:
        """Make the editors of all seats.

        Args:
            views: the seats as the page sees them, by number.
        """
        self._kept = AsyncExitStack()
        self.seats = {
            seat.number: SeatEditor(editor, seat.user, views[seat.number].let_in) for seat in plan.seats
        }
        self.views = Views(plan, editor)
        self.component = Component()
        self._no_views = line_for_students("viewer") if not editor.view_ports and missing() else ""
        self.routes: Mapping[tuple[str, str], SeatRoute] = {
            ("GET", "editor"): self._settings,
            ("GET", "program"): self._program,
            ("POST", "program"): self._save,
            ("POST", "run"): self._run,
            ("POST", "stop"): self._stop,
            ("GET", "output"): self._output,
            ("POST", "view"): self._view,
        }

    async def __aenter__(self) -> EditorRoutes:
        task = asyncio.create_task(self.views.end_unseen())
        self._kept.callback(task.cancel)
        self._kept.callback(self.views.close)
        self._kept.push_async_callback(self._end_programs)
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._kept.aclose()

    async def _end_programs(self) -> None:
        for each in self.seats.values():
            each.stop("the class has ended")
            await each.wait()

    def header(self, seat: Seat) -> tuple[str, str]:
        """Return the header with the rules of a seat's page."""
        return policy(self.views.port_of(seat.number))

    async def _settings(self, _: Request, seat: Seat) -> Response:
        hints = {"component": self.component.missing, "view": self._no_views}
        return _json(
            {
                "component": self.component.place,
                "has_view": self.views.port_of(seat.number) is not None,
                "most_text": MOST_TEXT,
                "missing": {name: text for name, text in hints.items() if text},
            }
        )

    async def _program(self, _: Request, seat: Seat) -> Response:
        return _json(self.seats[seat.number].program())

    async def _save(self, request: Request, seat: Seat) -> Response:
        try:
            return _json(self.seats[seat.number].save(request.body))
        except NotSaved as problem:
            return _refusal(HTTPStatus.UNPROCESSABLE_ENTITY, problem)

    async def _run(self, request: Request, seat: Seat) -> Response:
        try:
            return _json(await self.seats[seat.number].start(request.body))
        except NotSaved as problem:
            return _refusal(HTTPStatus.UNPROCESSABLE_ENTITY, problem)
        except NotStarted as problem:
            return _refusal(HTTPStatus.CONFLICT, problem)

    async def _stop(self, _: Request, seat: Seat) -> Response:
        editor = self.seats[seat.number]
        editor.stop()
        await editor.wait()
        return _json({})

    async def _output(self, request: Request, seat: Seat) -> Response:
        run, number = _number(request.query, "run"), _number(request.query, "from")
        found = self.seats[seat.number].state(run, number)
        if "view" in request.query:
            found["view"] = self.views.look(seat.number)
        return _json(found)

    async def _view(self, _: Request, seat: Seat) -> Response:
        try:
            return _json(self.views.open(seat))
        except NoView as problem:
            return _refusal(HTTPStatus.SERVICE_UNAVAILABLE, problem)


def _number(query: Mapping[str, str], name: str) -> int:
    """Return a number of an address; 0 for everything that is none."""
    with contextlib.suppress(ValueError):
        return max(0, int(query.get(name, "0")[:12]))
    return 0


def _json(value: Any) -> Response:
    return Response(HTTPStatus.OK, json.dumps(value).encode(), "application/json")


def _refusal(status: HTTPStatus, problem: Exception) -> Response:
    text = str(problem)
    return Response(status, f"{text[:1].upper()}{text[1:]}.\n".encode())
