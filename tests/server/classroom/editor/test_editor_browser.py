"""Students with a browser and nothing else write, run and stop programs, and see what moves; several at a time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsers import Watched, few_frames, pictures
from class_rooms import Room

from simx_server.classroom.editor.component import PACKAGE
from simx_server.confined.walls import lacking
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.browser, pytest.mark.gl, pytest.mark.timeout(600)]

if reason := lacking() or missing():
    pytest.skip(reason, allow_module_level=True)
pictures()

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

SEATS = 4
WITH_BROWSER = (1, 4)
"""The others' programs are started over HTTP: each browser shows two pages that software draws."""

SOON = 120.0
"""Seconds: all of it is drawn by software."""

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


FEW_VIEWS = few_frames(2000, "window !== window.top")
"""The 3-D views, which are in frames, would take the processor from the programs."""


class Student(Watched):
    """One seat in a separate browser."""

    def __init__(self, context: BrowserContext, link: str, seat: int, *, sees_3d: bool) -> None:
        context.add_init_script(FEW_VIEWS)
        super().__init__(context.new_page(), SOON)
        if not sees_3d:
            self.page.route("**/view", lambda route: route.abort())  # the page shows the image instead
        self.seat = seat
        self.page.goto(link)

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


class EditorRoom(Room):
    """A class whose students write programs."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        (folder / "square.py").write_text("print('the start of all seats')\n")
        super().__init__(folder, stack, "--seats", SEATS, "--program", folder / "square.py")

    def student(self, seat: int, *, sees_3d: bool = False) -> Student:
        context = self.browser.new_context(viewport={"width": 1000, "height": 600})
        return Student(context, self.simx.links[seat - 1]["link"], seat, sees_3d=sees_3d)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[EditorRoom]:
    with ExitStack() as stack:
        yield EditorRoom(tmp_path_factory.mktemp("class"), stack)


@pytest.fixture(scope="module")
def first(room: EditorRoom) -> Student:
    """The student of the first seat, with the image instead of the 3-D view, which costs less here."""
    student = room.student(1)
    student.is_ready()
    return student


@pytest.fixture
def alone(room: EditorRoom, first: Student) -> Iterator[Student]:
    """That student, whose programs have ended after each test."""
    yield first
    assert not first.faults
    room.simx.ask("POST", "/seat/1/stop")


def test_seats_run_their_programs_at_a_time_and_see_what_moves(room: EditorRoom) -> None:
    students = [room.student(seat, sees_3d=True) for seat in WITH_BROWSER]
    for seat in range(1, SEATS + 1):
        if seat not in WITH_BROWSER:
            room.simx.start(seat, SWING.format(seat=seat))
    for each in students:
        each.is_ready()
        assert each.page.locator("#name").text_content() == "square.py"
        each.write(SWING.format(seat=each.seat))
        each.run()
    for each in students:
        assert each.shows("#output", f"<b>seat {each.seat} runs</b>")  # as text
        assert each.page.locator("#output b").count() == 0
        assert each.shows("#how", "runs for")
    teacher = Watched(room.browser.new_page(viewport={"width": 1200, "height": 900}), SOON)
    teacher.page.route("**/image?*", lambda route: route.abort())  # of each seat; software would draw them
    teacher.page.goto(room.simx.url)

    def clients(seat: int) -> str:
        return teacher.page.locator(f"#seat-{seat} .clients").text_content() or ""

    for seat in range(1, SEATS + 1):
        assert teacher.until(lambda seat=seat: clients(seat).startswith("editor: square.py runs")), seat
        assert "simx-page" not in clients(seat)
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
    for seat in range(1, SEATS + 1):
        room.simx.ask("POST", f"/seat/{seat}/stop")
    assert teacher.until(lambda: not any("editor:" in clients(seat) for seat in range(1, SEATS + 1)))
    teacher.page.close()


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


def test_two_windows_of_a_seat_follow_each_other(room: EditorRoom, alone: Student) -> None:
    other = room.student(1)
    other.is_ready()
    alone.write("print('from the first window')\n")
    assert alone.shows("#saved", "saved")
    assert other.shows("#saved", "Another window changed the program")
    other.page.locator("#run").click()
    assert alone.shows("#output", "from the first window")
    assert alone.shows("#how", "it ended after")
    other.page.context.close()


def test_page_says_what_cannot_be_done(room: EditorRoom, alone: Student) -> None:
    alone.write("x = '" + "y" * 250_000 + "'\n")
    alone.page.locator("#run").click()
    assert alone.shows("#trouble", "The program is too long: it has 250007 bytes")
    alone.write("print('short')\n")
    alone.page.locator("#run").click()
    assert alone.shows("#output", "short")
    assert alone.until(alone.page.locator("#trouble").is_hidden)
