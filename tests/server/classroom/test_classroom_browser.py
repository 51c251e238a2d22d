"""A class of five without an editor in a real browser: tiles, images, programs, resets, tokens, and a killed seat."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsers import Watched, pictures
from class_rooms import Room
from launching import write_script
from processes import running

pytestmark = [pytest.mark.slow, pytest.mark.browser, pytest.mark.gl]


if sys.platform != "linux":
    pytest.skip("classes run on Linux", allow_module_level=True)
pictures()

if TYPE_CHECKING:
    from playwright.sync_api import Locator

SEATS = 5
SOON = 60.0
PROGRAM = """
import sys, time, vrep
client = vrep.simxStart("127.0.0.1", 19999, True, True, 20000, 5)
print("client", client, flush=True)
if client != -1:
    vrep.simxGetObjectHandle(client, "hinges", vrep.simx_opmode_blocking)
    sys.stdin.read()
"""
PIXELS = """image => {
    const canvas = document.createElement("canvas");
    canvas.width = image.naturalWidth;
    canvas.height = image.naturalHeight;
    canvas.getContext("2d").drawImage(image, 0, 0);
    return canvas.toDataURL();
}"""
TWICE = "button => { button.click(); button.click(); }"


class TeachersRoom(Room, Watched):
    """The class, and the teacher's page."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.script = write_script(folder, PROGRAM, "swing.py")
        Room.__init__(self, folder, stack, "--seats", SEATS, "--no-editor")
        Watched.__init__(self, self.browser.new_page(viewport={"width": 1200, "height": 900}), SOON)
        self.page.goto(self.simx.url)

    def tile(self, seat: int) -> Locator:
        return self.page.locator(f"#seat-{seat}")

    def image(self, seat: int) -> Locator:
        return self.tile(seat).locator("img.shown")

    def says(self, seat: int, what: str, text: str) -> Callable[[], bool]:
        return lambda: text in (self.tile(seat).locator(what).text_content() or "")


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TeachersRoom]:
    with ExitStack() as stack:
        yield TeachersRoom(tmp_path_factory.mktemp("class"), stack)


@pytest.fixture
def room(opened: TeachersRoom) -> Iterator[TeachersRoom]:
    yield opened
    assert not opened.faults


def test_each_seat_has_a_tile_with_an_image(room: TeachersRoom) -> None:
    for seat in range(1, SEATS + 1):
        room.image(seat).wait_for()
        assert room.image(seat).evaluate("image => image.naturalWidth") == 400
    assert room.page.locator(".seat").count() == SEATS
    assert room.page.locator("#counts").text_content() == f"{SEATS} seats · 0 connected · 0 running"
    assert "token" not in room.page.url


def test_student_connects_with_the_pasted_lines_and_the_image_moves(room: TeachersRoom) -> None:
    room.image(2).wait_for()
    before = room.image(2).evaluate(PIXELS)
    with running(room.simx.run(2, room.script)) as program:
        assert room.until(room.says(2, ".clients", "swing.py"))
        assert room.until(room.says(2, ".state", "running"))
        assert room.until(room.says(2, ".problem", "no object named 'hinges'"))
        assert room.until(lambda: room.image(2).evaluate(PIXELS) != before)
        assert room.says(1, ".clients", "no program connected")()
        program.communicate("")
    assert room.until(room.says(2, ".clients", "no program connected"))


def test_token_of_another_seat_is_refused(room: TeachersRoom) -> None:
    with running(room.simx.run(1, room.script, token_of=2)) as program:
        said = program.communicate(timeout=SOON)[0]
    assert "client -1" in said
    assert "refused the login" in said


def test_reset_gives_a_seat_its_scene_again(room: TeachersRoom) -> None:
    with running(room.simx.run(3, room.script)) as program:
        assert room.until(room.says(3, ".state", "running"))
        button = room.tile(3).locator(".reset")
        assert button.evaluate("button => { button.click(); return button.textContent; }") == "Reset it?"
        assert room.until(
            lambda: button.text_content() == "Reset"
        )  # after a while a single click has no effect
        assert room.says(3, ".state", "running")()
        button.evaluate(TWICE)
        assert room.until(room.says(3, ".problem", "the seat was reset"))
        assert room.until(room.says(3, ".state", "stopped"))
        assert room.until(room.says(3, ".clients", "no program connected"))
        program.communicate("")


def test_all_seats_are_reset_at_once(room: TeachersRoom) -> None:
    children = set(room.simx.children())
    room.page.locator("#reset-all").evaluate(TWICE)
    assert room.until(lambda: len(set(room.simx.children()) - children) == SEATS)
    for seat in range(1, SEATS + 1):
        assert room.until(lambda seat=seat: room.simx.state(seat)["note"] == "the seat was reset")
        assert room.until(room.says(seat, ".state", "stopped"))


def test_killed_seat_comes_back_at_the_same_port(room: TeachersRoom) -> None:
    before = room.simx.children()
    with running(room.simx.run(5, room.script)) as program:
        assert room.until(room.says(5, ".clients", "swing.py"))
        os.kill(owner_of(room.simx.variables(5)["SIMX_CONNECT"], before), signal.SIGKILL)
        assert room.until(room.says(5, ".problem", "ended by signal 9 (SIGKILL) and was started again"))
        program.communicate("")
    assert room.until(room.says(5, ".state", "running"))
    with running(room.simx.run(5, room.script)) as program:
        assert room.until(room.says(5, ".clients", "swing.py"))
        program.communicate("")


def owner_of(endpoint: str, processes: list[int]) -> int:
    """The process that listens at a port, by the system's table of sockets."""
    port = f":{int(endpoint.rpartition(':')[2]):04X}"
    rows = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()]
    [inode] = [row[9] for row in rows if row[1].endswith(port) and row[3] == "0A"]
    for process in processes:
        for link in Path(f"/proc/{process}/fd").iterdir():
            if os.readlink(link) == f"socket:[{inode}]":
                return process
    raise AssertionError("no child listens there")


def test_students_page_has_the_lines_and_no_other_seat(room: TeachersRoom) -> None:
    context = room.browser.new_context()
    try:
        page = context.new_page()
        page.set_default_timeout(1000 * SOON)
        page.goto(room.simx.links[3]["link"])
        page.locator("img.shown").wait_for()
        assert "token" not in page.url
        assert page.locator("#lines code").all_text_contents() == room.simx.lines(4)["Linux, macOS"]
        page.get_by_role("tab", name="Windows").click()
        assert page.locator("#lines code").all_text_contents() == room.simx.lines(4)["Windows"]
        for path in ("/", "/class", "/links", "/seat/5", "/seat/5/image"):
            answer = page.request.get(room.simx.base + path)
            assert answer.status == 401, path
    finally:
        context.close()


def test_button_that_fails_says_why_until_the_next_press(room: TeachersRoom) -> None:
    room.page.reload()  # the page has no links yet
    room.page.route("**/links", lambda route: route.fulfill(status=503, body="The class is busy."))
    room.tile(1).locator(".copy").click()
    trouble = room.page.locator("#trouble")
    assert room.until(lambda: trouble.text_content() == "The class is busy.")
    for _ in range(2):  # the page looks at the seats meanwhile
        with room.page.expect_response("**/class"):
            pass
    assert trouble.is_visible()
    room.page.unroute("**/links")
    room.tile(1).locator(".copy").click()
    assert room.until(trouble.is_hidden)


def test_teacher_copies_the_links(room: TeachersRoom) -> None:
    room.page.locator("#links").click()
    room.page.locator("#list").wait_for()
    lines = room.page.locator("#list").input_value().splitlines()
    assert [line.split("\t")[-1] for line in lines] == [each["link"] for each in room.simx.links]
    room.page.locator("#close").click()
