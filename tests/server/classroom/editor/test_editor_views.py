"""The 3-D views of the seats: started for a browser, with a separate token, and ended without one."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from classes import Class, running_class
from processes import wait_until

from simx_server.classroom.addresses import claim
from simx_server.classroom.editor.plan import LIMITS, EditorPlan
from simx_server.classroom.editor.views import KEPT, NoView, Views
from simx_server.classroom.plan import ClassPlan, Seat
from simx_server.confined.walls import lacking
from simx_server.settings.settings import Settings
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.timeout(400)]

if sys.platform != "linux":
    pytest.skip("classes run on Linux", allow_module_level=True)
if reason := lacking() or missing():
    pytest.skip(reason, allow_module_level=True)

SOON = 90.0


@pytest.fixture(scope="module")
def opened(scene: Path) -> Iterator[Class]:
    with running_class(scene, "--seats", 2) as started:
        yield started


def view(opened: Class, seat: int) -> dict[str, Any]:
    status, answer = opened.ask("POST", f"/seat/{seat}/view")
    assert status == 200, answer
    return json.loads(answer)


def status(place: dict[str, Any], path: str, cookie: str = "") -> tuple[int, str]:
    """Status of an answer of a view, and the cookie that it sets."""
    connection = http.client.HTTPConnection("127.0.0.1", place["port"], timeout=SOON)
    with contextlib.closing(connection):
        connection.request("GET", path, headers={"Cookie": cookie})
        answer = connection.getresponse()
        return answer.status, answer.headers.get("Set-Cookie", "").partition(";")[0]


def nursery(opened: Class) -> int:
    """The process that forks the views."""
    for child in opened.children():
        for each in Path(f"/proc/{child}/task/{child}/children").read_text().split():
            if b"classroom.editor.nursery" in Path(f"/proc/{each}/cmdline").read_bytes():
                return int(each)
    raise AssertionError("no view was started")


def looks(opened: Class, seat: int) -> bool:
    return json.loads(opened.ask("GET", f"/seat/{seat}/output?view=1")[1])["view"]


def test_view_shows_the_seat_to_whoever_has_its_token(opened: Class) -> None:
    place = view(opened, 1)
    assert view(opened, 1) == place  # a second window has the same one
    assert status(place, "/")[0] == 401
    assert status(place, "/?token=wrong")[0] == 401
    found, cookie = status(place, f"/?token={place['token']}")
    assert found == 303
    assert status(place, "/", cookie)[0] == 200
    other = view(opened, 2)
    assert other["token"] != place["token"]
    assert status(other, "/", cookie)[0] == 401
    assert place["token"] not in Path(f"/proc/{nursery(opened)}/cmdline").read_text()


def test_there_are_as_many_views_as_the_class_allows_and_unseen_ones_end(tmp_path: Path) -> None:
    seats = tuple(Seat(n, "", f"seat-{n:02d}", f"token-{n}", 20_000 + n, Settings()) for n in (1, 2, 3))
    ports = tuple(claim("127.0.0.1", 0, 3, "--view-port"))
    editor = EditorPlan("program.py", "", LIMITS, tmp_path, tmp_path, ports, views=2)

    async def work() -> None:
        shown = Views(ClassPlan(seats, "token", "127.0.0.1", None), editor)
        try:
            for seat in seats[:2]:
                shown.open(seat)
            with pytest.raises(NoView, match="2 seats show their 3-D view"):
                shown.open(seats[2])
            shown._views[2].seen -= 10 * KEPT  # its browser has left
            with pytest.raises(NoView):  # it ends now
                shown.open(seats[2])
            while shown._views.keys() != {1}:
                await asyncio.sleep(0.01)
            assert shown.open(seats[2])["port"] == ports[2]
            assert shown.look(1)
            assert not shown.look(2)
        finally:
            shown.close()

    asyncio.run(asyncio.wait_for(work(), SOON))


def test_view_that_is_killed_comes_back(opened: Class) -> None:
    place = view(opened, 1)
    status(place, "/")
    parent = nursery(opened)
    for child in Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
        os.kill(int(child), signal.SIGKILL)
    assert wait_until(lambda: not looks(opened, 1), SOON)
    newer = view(opened, 1)
    assert newer["token"] != place["token"]
    assert status(newer, "/")[0] == 401
    os.kill(parent, signal.SIGKILL)
    assert wait_until(lambda: not looks(opened, 1), SOON)
    # The views of the killed process end soon after it, and then the port is free.
    assert wait_until(lambda: opened.ask("POST", "/seat/1/view")[0] == 200, SOON)
    assert status(view(opened, 1), "/")[0] == 401
    last = nursery(opened)
    opened.end()
    assert wait_until(lambda: not Path(f"/proc/{last}").exists(), SOON)
