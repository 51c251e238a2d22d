"""Eight students with a browser each and nothing else: they write, run and stop programs, and see what moves."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from classes import Class, running_class
from processes import ROOT, wait_until

from simx_server.classroom.editor.component import PACKAGE
from simx_server.confined.walls import lacking
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.browser, pytest.mark.gl, pytest.mark.timeout(600)]

if find_spec("playwright") is None:
    pytest.skip("needs playwright, of the extra dev", allow_module_level=True)
if reason := lacking() or missing():
    pytest.skip(reason, allow_module_level=True)
sys.path.insert(0, str(ROOT / "docs"))
try:
    pictures: Any = import_module("view_pictures")
finally:
    sys.path.pop(0)
if pictures.find_chromium() is None:
    pytest.skip("needs Chromium: apt-get install chromium", allow_module_level=True)

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

SEATS = 8
SOON = 120.0
"""Seconds: all of it is drawn by software."""

ROOM = """
<mujoco model="swing">
  <statistic center="0 0 0.6" extent="0.8"/>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="2 2 0.1" rgba="0.3 0.5 0.7 1"/>
    <body name="arm" pos="0 0 0.6">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="1 0.2 0.1 1"/>
    </body>
  </worldbody>
</mujoco>
"""
SWING = """import time
import sim
client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
sim.simxStartSimulation(client, sim.simx_opmode_blocking)
print("<b>seat", {seat}, "runs</b>", flush=True)
time.sleep(600)
"""
EDIT = """text => {
    const editor = monaco.editor.getEditors()[0];
    editor.focus();
    editor.executeEdits("test", [{ range: editor.getModel().getFullModelRange(), text }]);
}"""


FEW_FRAMES = """
if (window !== window.top) {
    const frame = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = draw => setTimeout(() => frame(draw), 1000);
    window.cancelAnimationFrame = clearTimeout;
}
"""
"""One frame a second in the 3-D views: eight that are drawn by software would take all of the processor, from other
tests too.
"""


class Student:
    """One seat in a separate browser."""

    def __init__(self, context: BrowserContext, simx: Class, seat: int) -> None:
        self.seat, self.simx = seat, simx
        context.add_init_script(FEW_FRAMES)
        self.page: Page = context.new_page()
        self.page.set_default_timeout(1000 * SOON)
        self.faults: list[str] = []
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.goto(simx.links[seat - 1]["link"])

    def until(self, condition) -> bool:
        return wait_until(condition, SOON, lambda: self.page.wait_for_timeout(100))

    def is_ready(self) -> None:
        self.page.locator("#run:enabled").wait_for()

    def write(self, text: str) -> None:
        """Replace the program in one edit: Monaco would indent lines that are typed."""
        if (field := self.page.locator("#text textarea.plain")).count():
            field.fill(text)
        else:
            self.page.evaluate(EDIT, text)

    def run(self) -> None:
        self.page.keyboard.press("Control+Enter")

    def shows(self, place: str, text: str) -> bool:
        return self.until(lambda: text in (self.page.locator(place).text_content() or ""))

    def program(self) -> str:
        """The text that the editor shows."""
        if (field := self.page.locator("#text textarea.plain")).count():
            return field.input_value()
        return (self.page.locator("#text .view-lines").text_content() or "").replace("\xa0", " ")

    def simulated(self) -> float:
        """Seconds that the 3-D view shows; 0 before it is there."""
        text = self.page.frame_locator("#view").locator("body").text_content() or ""
        found = re.search(r"running, ([0-9.]+) s, step", text)
        return float(found[1]) if found else 0.0


class Room:
    def __init__(self, folder: Path, stack: ExitStack) -> None:
        (folder / "swing.xml").write_text(ROOM)
        (folder / "square.py").write_text("print('the start of all seats')\n")
        self.simx = stack.enter_context(
            running_class(folder / "swing.xml", "--seats", SEATS, "--program", folder / "square.py")
        )
        self.browser: Browser = stack.enter_context(pictures.chromium())

    def student(self, seat: int) -> Student:
        return Student(self.browser.new_context(viewport={"width": 1000, "height": 600}), self.simx, seat)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Room]:
    with ExitStack() as stack:
        yield Room(tmp_path_factory.mktemp("class"), stack)


@pytest.fixture
def alone(room: Room) -> Iterator[Student]:
    """The student of the first seat, with the image instead of the 3-D view, which costs less here."""
    student = room.student(1)
    student.is_ready()
    student.page.locator("#show-image").click()
    yield student
    assert not student.faults
    room.simx.ask("POST", "/seat/1/stop")
    student.page.context.close()


def test_eight_seats_run_their_programs_and_see_what_moves(room: Room) -> None:
    students = [room.student(seat) for seat in range(1, SEATS + 1)]
    for each in students:
        each.is_ready()
        assert each.page.locator("#name").text_content() == "square.py"
        each.write(SWING.format(seat=each.seat))
        each.run()
    for each in students:
        assert each.shows("#output", f"<b>seat {each.seat} runs</b>")  # as text
        assert each.page.locator("#output b").count() == 0
        assert each.shows("#how", "runs for")
    teacher = room.browser.new_page(viewport={"width": 1200, "height": 900})
    teacher.goto(room.simx.url)
    for each in students:
        tile = teacher.locator(f"#seat-{each.seat}")
        assert each.until(
            lambda tile=tile: (tile.locator(".clients").text_content() or "").startswith(
                "editor: square.py runs"
            )
        )
        assert "simx-page" not in (tile.locator(".clients").text_content() or "")
    for each in students:
        assert each.until(lambda each=each: each.simulated() > 0), each.seat
        before = each.simulated()
        assert each.until(lambda each=each, before=before: each.simulated() > before), each.seat
        frame = each.page.frame_locator("#view")
        assert frame.get_by_role("slider").count() >= 1
    for each in students:
        each.page.locator("#stop").click()
        assert each.shows("#how", "it was stopped")
        assert not each.faults
        each.page.context.close()
    assert wait_until(
        lambda: "editor:" not in "".join(teacher.locator(".clients").all_text_contents()),
        SOON,
        lambda: teacher.wait_for_timeout(100),
    )
    teacher.close()


def test_error_marks_its_line_and_the_next_change_removes_the_mark(alone: Student) -> None:
    alone.write("import sim\n\ndef half(x):\n    return x / 0\n\nhalf(3)\n")
    alone.page.locator("#run").click()
    assert alone.shows("#how", "line 4: ZeroDivisionError: division by zero")
    assert alone.shows("#output", "it ended with exit code 1")
    assert 'File "square.py", line 4, in half' in (alone.page.locator("#output").text_content() or "")
    if find_spec(PACKAGE) is not None:
        mark = alone.page.locator(".error-line")
        assert mark.count() == 1
        alone.write("print('good')\n")
        assert alone.until(lambda: mark.count() == 0)
    else:
        field = "field => field.value.slice(field.selectionStart, field.selectionEnd)"
        assert alone.page.locator("#text textarea.plain").evaluate(field) == "    return x / 0"
        alone.write("print('good')\n")
    alone.run()
    assert alone.shows("#how", "it ended after")
    assert alone.shows("#output", "good")


def test_text_and_output_are_there_after_a_reload(alone: Student) -> None:
    alone.write("print('once')\n# the last words")
    alone.run()
    assert alone.shows("#output", "it ended")
    alone.page.keyboard.press("Control+End")
    alone.page.keyboard.insert_text(" and more")
    alone.page.reload()
    alone.is_ready()
    assert alone.until(lambda: "last words and more" in alone.program())
    assert alone.shows("#output", "once")


def test_two_windows_of_a_seat_follow_each_other(room: Room, alone: Student) -> None:
    other = room.student(1)
    other.is_ready()
    alone.write("print('from the first window')\n")
    assert alone.shows("#saved", "saved")
    assert other.shows("#saved", "Another window changed the program")
    other.page.locator("#run").click()
    assert alone.shows("#output", "from the first window")
    assert alone.shows("#how", "it ended after")
    other.page.context.close()


def test_page_says_what_cannot_be_done(room: Room, alone: Student) -> None:
    alone.write("x = '" + "y" * 250_000 + "'\n")
    alone.page.locator("#run").click()
    assert alone.shows("#trouble", "The program is too long: it has 250007 bytes")
    alone.write("print('short')\n")
    alone.page.locator("#run").click()
    assert alone.shows("#output", "short")
    assert alone.until(alone.page.locator("#trouble").is_hidden)
