"""The page's routes and its view of the seats: who may see what, and what requests cost a seat. Seats are stand-ins."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any

import pytest

from simx_server.classroom import channel
from simx_server.classroom.page import seat_view
from simx_server.classroom.page.http import Request, Response
from simx_server.classroom.page.serving import ClassPage
from simx_server.classroom.plan import ClassPlan, Seat, make_seats
from simx_server.classroom.tokens import make_tokens
from simx_server.settings.settings import Settings

pytestmark = pytest.mark.slow

PORT = 8088
REPORT = {
    "state": "running", "scene": "room", "time": 1.5, "clients": [{"name": "<b>x</b>", "reads": False}],
    "connected": 1, "error": "", "error_ago": None,
}  # fmt: skip


def plan() -> ClassPlan:
    seats = [
        Seat(number, "", f"seat-{number:02d}", f"token-of-seat-{number}", 20_000 + number, Settings())
        for number in (1, 2, 11)
    ]
    return ClassPlan(tuple(seats), "token-of-teacher", "192.168.1.5", None, "room")


class StandIn:
    """Answers as a seat's server does, or not at all."""

    def __init__(self) -> None:
        self.here, self.there = channel.pair()
        self.asked: list[dict[str, Any]] = []
        self.is_silent = False
        asyncio.get_running_loop().add_reader(self.there, self._answer)

    def _answer(self) -> None:
        fields = channel.unpacked(self.there.recv(4096)).fields
        self.asked.append(fields)
        if self.is_silent:
            return
        if "size" in fields:
            self.there.send(channel.packed({"id": fields["id"]}, b"jpeg of " + fields["size"].encode()))
        else:
            self.there.send(channel.packed({"id": fields["id"], "report": REPORT}))

    def close(self) -> None:
        asyncio.get_running_loop().remove_reader(self.there)
        self.there.close()


class Stage:
    """A page with three seats."""

    def __init__(self) -> None:
        self.page = ClassPage(plan(), PORT)
        self.seats = {number: StandIn() for number in (1, 2, 11)}
        for number, seat in self.seats.items():
            self.page.views[number].started(seat.here, is_ready=True)
        self.supervisor, there = channel.pair()
        self.page._supervisor = there

    async def ask(self, path: str, cookie: str = "", method: str = "GET", **headers: str) -> Response:
        path, _, query = path.partition("?")
        pairs = dict(pair.split("=") for pair in query.split("&") if pair)
        return await self.page.answer(Request(method, path, pairs, {"cookie": cookie, **headers}))

    async def status(self, path: str, cookie: str = "", method: str = "GET", **headers: str) -> int:
        return (await self.ask(path, cookie, method, **headers)).status

    def close(self) -> None:
        for number, seat in self.seats.items():
            self.page.views[number].gone("the test ends")
            seat.close()
        self.supervisor.close()
        if self.page._supervisor is not None:
            self.page._supervisor.close()


def staged(work: Callable[[Stage], Awaitable[None]]) -> None:
    async def run() -> None:
        stage = Stage()
        try:
            async with asyncio.timeout(60):
                await work(stage)
        finally:
            stage.close()

    asyncio.run(run())


TEACHER = f"simx_teacher_{PORT}=token-of-teacher"
OWN = f"simx_seat_1_{PORT}=token-of-seat-1"
HERE = {"host": "class:8088", "origin": "http://class:8088"}


def test_link_with_the_right_token_gives_a_cookie_and_another_none() -> None:
    async def work(stage: Stage) -> None:
        for path, cookie in (("/?token=token-of-teacher", TEACHER), ("/seat/1?token=token-of-seat-1", OWN)):
            answer = await stage.ask(path)
            assert answer.status == HTTPStatus.SEE_OTHER
            headers = dict(answer.headers)
            assert headers["Set-Cookie"].startswith(cookie + "; Path=")
            assert "HttpOnly" in headers["Set-Cookie"]
            assert "token" not in headers["Location"]
        for path in (
            "/?token=token-of-seat-1", "/?token=", "/seat/1?token=token-of-seat-2", "/seat/2?token=token-of-teacher",
            "/seat/1?token=\u00fc", "/seat/3?token=token-of-seat-1",
        ):  # fmt: skip
            assert await stage.status(path) == HTTPStatus.FORBIDDEN
        assert await stage.status("/seat/3") == await stage.status("/seat/1")  # no such seat

    staged(work)


def test_student_sees_the_own_seat_and_the_teacher_all() -> None:
    async def work(stage: Stage) -> None:
        for path in ("/", "/class", "/links"):
            assert await stage.status(path, TEACHER) == HTTPStatus.OK
            assert await stage.status(path, OWN) == HTTPStatus.UNAUTHORIZED
            assert await stage.status(path) == HTTPStatus.UNAUTHORIZED
        for what in ("", "/state", "/lines", "/image"):
            assert await stage.status(f"/seat/1{what}", OWN) == HTTPStatus.OK
            assert await stage.status(f"/seat/1{what}", TEACHER) == HTTPStatus.OK
            for other in (2, 11, 99):
                assert await stage.status(f"/seat/{other}{what}", OWN) == HTTPStatus.UNAUTHORIZED
        swapped = OWN.replace("seat_1_", "seat_2_")
        assert await stage.status("/seat/2/state", swapped) == HTTPStatus.UNAUTHORIZED

    staged(work)


def test_a_link_from_anywhere_leads_here_and_no_other_page_shows_or_reads_it() -> None:
    async def work(stage: Stage) -> None:
        for site in ("cross-site", "same-site"):
            for place in ("iframe", "image", "script", "empty"):
                told = {"sec-fetch-site": site, "sec-fetch-dest": place}
                assert await stage.status("/seat/1/state", OWN, **told) == HTTPStatus.FORBIDDEN
            link = {"sec-fetch-site": site, "sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
            assert await stage.status("/seat/1", OWN, **link) == HTTPStatus.OK
        own = {"sec-fetch-site": "same-origin", "sec-fetch-dest": "empty"}
        assert await stage.status("/seat/1/state", OWN, **own) == HTTPStatus.OK

    staged(work)


def test_only_this_page_resets_and_only_the_own_seat() -> None:
    async def work(stage: Stage) -> None:
        elsewhere = {"host": "class:8088", "origin": "http://elsewhere"}
        for headers in (
            {"host": "class:8088"},
            elsewhere,
            {"origin": "http://"},
            {"origin": "null", "host": "null"},
        ):
            assert await stage.status("/seat/1/reset", TEACHER, "POST", **headers) == HTTPStatus.FORBIDDEN
        assert await stage.status("/seat/1/reset", OWN) == HTTPStatus.NOT_FOUND  # a GET changes nothing
        assert await stage.status("/seat/2/reset", OWN, "POST", **HERE) == HTTPStatus.UNAUTHORIZED
        assert await stage.status("/reset", OWN, "POST", **HERE) == HTTPStatus.UNAUTHORIZED
        with pytest.raises(BlockingIOError):
            stage.supervisor.recv(4096)
        assert await stage.status("/seat/1/reset", OWN, "POST", **HERE) == HTTPStatus.ACCEPTED
        assert json.loads(stage.supervisor.recv(4096)) == {"reset": 1}
        assert await stage.status("/seat/1/reset", OWN, "POST", **HERE) == HTTPStatus.TOO_MANY_REQUESTS
        assert await stage.status("/reset", TEACHER, "POST", **HERE) == HTTPStatus.ACCEPTED
        assert json.loads(stage.supervisor.recv(4096)) == {"reset": "all"}

    staged(work)


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/nothing", HTTPStatus.NOT_FOUND),
        ("GET", "/seat/1/nothing", HTTPStatus.NOT_FOUND),
        ("GET", "/seat/01", HTTPStatus.NOT_FOUND),
        ("GET", "/seat/1/image?size=huge", HTTPStatus.BAD_REQUEST),
        ("GET", "/../tokens.py", HTTPStatus.NOT_FOUND),
        ("GET", "/class.html", HTTPStatus.NOT_FOUND),
        ("DELETE", "/seat/1", HTTPStatus.METHOD_NOT_ALLOWED),
        ("HEAD", "/class.css", HTTPStatus.OK),
    ],
)
def test_paths_that_are_not_there(method: str, path: str, status: HTTPStatus) -> None:
    async def work(stage: Stage) -> None:
        assert await stage.status(path, TEACHER, method) == status

    staged(work)


def test_many_browsers_cost_a_seat_one_request() -> None:
    async def work(stage: Stage) -> None:
        answers = await asyncio.gather(*(stage.ask("/seat/1/image", OWN) for _ in range(50)))
        assert {answer.body for answer in answers} == {b"jpeg of small"}
        await asyncio.gather(*(stage.ask("/seat/1/state", OWN) for _ in range(50)))
        assert [fields.get("size") for fields in stage.seats[1].asked] == ["small", None]
        assert not stage.seats[2].asked  # nobody looks there

    staged(work)


def test_seat_that_does_not_answer_is_busy_and_delays_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seat_view, "BUSY_AFTER", 0.0)
    monkeypatch.setattr(seat_view, "ANSWERS_WITHIN", 0.1)
    monkeypatch.setattr(seat_view, "REPORT_AGE", 0.0)

    async def work(stage: Stage) -> None:
        stage.seats[1].is_silent = True
        states = json.loads((await stage.ask("/class", TEACHER)).body)["seats"]
        assert [state["state"] for state in states] == ["busy", "running", "running"]
        assert await stage.status("/seat/1/image", OWN) == HTTPStatus.SERVICE_UNAVAILABLE
        assert await stage.status("/seat/2/image", TEACHER) == HTTPStatus.OK
        stage.seats[1].is_silent = False
        states = json.loads((await stage.ask("/class", TEACHER)).body)["seats"]
        assert states[0]["state"] == "running"

    staged(work)


def test_seat_whose_images_take_too_long_rests_and_tells_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seat_view, "ANSWERS_WITHIN", 0.05)

    async def work(stage: Stage) -> None:
        view = stage.page.views[1]
        stage.seats[1].is_silent = True
        for _ in range(5):
            assert await stage.status("/seat/1/image", OWN) == HTTPStatus.SERVICE_UNAVAILABLE
        assert len(stage.seats[1].asked) == 1
        assert view._described()["problem"] == ""  # its renderer may start
        view._rests_until = 0.0
        assert await stage.status("/seat/1/image", OWN) == HTTPStatus.SERVICE_UNAVAILABLE
        stage.seats[1].is_silent = False
        assert "takes more than" in json.loads((await stage.ask("/seat/1/state", OWN)).body)["problem"]
        view._rests_until = 0.0
        assert await stage.status("/seat/1/image", OWN) == HTTPStatus.OK
        assert view._described()["problem"] == ""

    staged(work)


def test_seat_that_ends_is_starting_with_the_reason_until_the_next_is_ready() -> None:
    async def work(stage: Stage) -> None:
        stage.seats[1].is_silent = True
        waiting = asyncio.create_task(stage.ask("/seat/1/image", OWN))
        while not stage.seats[1].asked:
            await asyncio.sleep(0)
        view = stage.page.views[1]
        view.gone("the server ended by signal 9 (SIGKILL) and was started again")
        assert (await waiting).status == HTTPStatus.SERVICE_UNAVAILABLE
        state = json.loads((await stage.ask("/seat/1/state", OWN)).body)
        assert (state["state"], state["note"][:19]) == ("starting", "the server ended by")
        stage.seats[1].close()
        stage.seats[1] = StandIn()
        view.started(stage.seats[1].here, is_ready=False)
        assert json.loads((await stage.ask("/seat/1/state", OWN)).body)["state"] == "starting"
        view.ready()
        state = json.loads((await stage.ask("/seat/1/state", OWN)).body)
        assert (state["state"], state["connected"]) == ("running", 1)

    staged(work)


def test_nonsense_of_a_seat_harms_only_its_own_tile() -> None:
    async def work(stage: Stage) -> None:
        for nonsense in (b"\xff", b"[]\n", b'{"id": []}\n', b'{"id": 1}\n'):
            stage.seats[1].there.send(nonsense)
        assert json.loads((await stage.ask("/seat/2/state", TEACHER)).body)["state"] == "running"
        assert json.loads((await stage.ask("/seat/1/state", TEACHER)).body)["state"] == "running"

    staged(work)


def test_links_and_lines_lead_to_the_seat() -> None:
    async def work(stage: Stage) -> None:
        links = json.loads((await stage.ask("/links", TEACHER)).body)
        assert links[0]["link"] == "http://192.168.1.5:8088/seat/1?token=token-of-seat-1"
        assert links[2]["lines"]["Linux, macOS"][0] == (
            "export SIMX_CONNECT=tcp/192.168.1.5:20011 SIMX_LOGIN=seat-11:token-of-seat-11"
        )
        assert all(len(lines) == 2 for lines in links[0]["lines"].values())

    staged(work)


def test_each_seat_has_its_own_login_folder_and_port(tmp_path: Path) -> None:
    private, work = tmp_path / "private", tmp_path / "work"
    private.mkdir()
    work.mkdir()
    tokens = make_tokens(3)
    seats = make_seats(Settings(workspace=work), ["Ada", "", ""], tokens, "127.0.0.1", 0, private)
    assert [seat.student for seat in seats] == ["Ada", "", ""]
    assert len({seat.port for seat in seats}) == 3
    for seat in seats:
        settings = seat.settings
        assert settings.listen == (f"tcp/127.0.0.1:{seat.port}",)
        assert settings.ports == ()  # a port of simx-server's own would need no token of this seat
        assert settings.workspace == work / seat.user
        assert settings.config is not None
        file = Path(json.loads(settings.config.read_text())["transport"]["auth"]["usrpwd"]["dictionary_file"])
        assert file.read_text() == f"{seat.user}:{tokens.seats[seat.number]}\n"
        assert file.stat().st_mode & 0o077 == 0
        assert file.parent.stat().st_mode & 0o077 == 0


def test_message_of_the_supervisor_brings_a_seats_channel() -> None:
    async def work(stage: Stage) -> None:
        here, there = channel.pair()
        seat = StandIn()
        socket.send_fds(here, [channel.packed({"seat": 2, "is_ready": True})], [seat.here.fileno()])
        seat.here.close()
        stage.page._hear(there, asyncio.Event())
        assert json.loads((await stage.ask("/seat/2/state", TEACHER)).body)["state"] == "running"
        assert len(seat.asked) == 1
        is_over = asyncio.Event()
        here.close()
        stage.page._hear(there, is_over)
        assert is_over.is_set()
        there.close()
        stage.page.views[2].gone("the test ends")
        seat.close()

    staged(work)
