"""simx-run gives cv2.imshow, waitKey and the like to an OpenCV without windows: what they return, raise and call."""

from __future__ import annotations

import re
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from launching import output_of, simx_run

from simx_client.launch.windows import patch
from simx_client.launch.windows import screen as s
from simx_client.launch.windows.highgui import HighGui
from simx_client.launch.windows.outbox import Outbox
from simx_client.launch.windows.regions import NOTHING, Regions

pytestmark = pytest.mark.slow

GREY = np.full((30, 40), 128, np.uint8)


class Person:
    """A screen that notes what it is told, and on which a person acts."""

    name = "before a test"

    def __init__(self) -> None:
        self.told: list[s.Message] = []
        self.report: s.Report = lambda report: None
        self.lost: s.Lost = lambda reason: None
        self.is_closed = False

    def tell(self, message: s.Message) -> None:
        self.told.append(message)

    def close(self) -> None:
        self.is_closed = True

    def forget(self) -> None:
        """Nothing is shared."""

    def numbers(self) -> list[int]:
        return [message[1] for message in self.told if message[0] == s.OPEN]

    def last(self, word: str) -> list[Any]:
        return list(next(message for message in reversed(self.told) if message[0] == word)[2:])


@pytest.fixture
def person() -> Person:
    return Person()


@pytest.fixture
def gui(person: Person) -> HighGui:
    def find(report: s.Report, lost: s.Lost) -> s.Screen:
        person.report, person.lost = report, lost
        return person

    return HighGui(cv2, find)


@pytest.fixture
def blind() -> HighGui:
    def find(report: s.Report, lost: s.Lost) -> s.Screen:
        raise s.NoScreen("")

    return HighGui(cv2, find)


# --- images --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("image", "rgb"),
    [
        (np.full((2, 2, 3), (10, 20, 30), np.uint8), (30, 20, 10)),
        (np.full((2, 2, 4), (10, 20, 30, 0), np.uint8), (30, 20, 10)),
        (np.full((2, 2), 77, np.uint8), (77, 77, 77)),
        (np.full((2, 2, 1), 77, np.uint8), (77, 77, 77)),
        (np.full((2, 2), 0x4D00, np.uint16), (77, 77, 77)),
        (np.full((2, 2), 65535, np.uint16), (255, 255, 255)),
        (np.full((2, 2), 0.5, np.float32), (128, 128, 128)),
        (np.full((2, 2, 3), (-1.0, 0.2, 7.0), np.float64), (255, 51, 0)),
        (np.full((2, 2), np.nan), (0, 0, 0)),
        (np.full((2, 2), -27, np.int8), (100, 100, 100)),
        (np.full((2, 4, 3), (10, 20, 30), np.uint8)[:, ::-2], (30, 20, 10)),
    ],
)
def test_images_of_every_depth_are_shown_as_opencv_does(
    gui: HighGui, person: Person, image: np.ndarray, rgb: tuple[int, ...]
) -> None:
    gui.imshow("window", image)
    width, height, pixels = person.last(s.SHOW)
    assert (width, height) == (2, 2)
    assert tuple(pixels[:3]) == rgb


@pytest.mark.parametrize(
    "image",
    [None, np.empty((0, 0, 3), np.uint8), GREY.astype(np.int32), np.zeros((4, 4, 2), np.uint8), [[1]], "x"],
)
def test_what_cannot_be_shown_raises_opencvs_error(gui: HighGui, image: object) -> None:
    with pytest.raises(cv2.error, match=r"in function 'imshow'"):
        gui.imshow("window", image)


def test_callers_image_may_change_afterwards(gui: HighGui, person: Person) -> None:
    image = np.zeros((2, 2, 3), np.uint8)
    gui.imshow("window", image)
    image[:] = 255
    assert max(person.last(s.SHOW)[2]) == 0


# --- keys ----------------------------------------------------------------------------------------


def test_wait_key_returns_the_key_and_its_lowest_byte(gui: HighGui, person: Person) -> None:
    gui.imshow("window", GREY)
    for code in (ord("q"), 27, 0xFF51, 0xFF51):
        person.report((s.KEY, code))
    assert [gui.waitKey(0), gui.waitKey(1), gui.waitKey(1), gui.waitKeyEx(1)] == [113, 27, 0x51, 65361]
    assert gui.pollKey() == -1


def test_wait_key_takes_its_time_without_a_key(gui: HighGui, blind: HighGui) -> None:
    """A loop around waitKey(1000 // 30) is paced by it, whether something is shown or not."""
    for each in (gui, blind):
        each.imshow("window", GREY)
        began = time.monotonic()
        assert each.waitKey(30) == -1
        assert time.monotonic() - began >= 0.03


def test_wait_key_waits_for_a_key_that_comes_later(gui: HighGui, person: Person) -> None:
    gui.imshow("window", GREY)
    threading.Timer(0.05, person.report, ((s.KEY, 32),)).start()
    assert gui.waitKey(0) == 32


def test_wait_key_without_an_end_returns_when_the_last_window_is_closed(gui: HighGui, person: Person) -> None:
    gui.imshow("one", GREY)
    gui.imshow("two", GREY)
    one, two = person.numbers()
    person.report((s.CLOSED, one))
    threading.Timer(0.05, person.report, ((s.CLOSED, two),)).start()
    assert gui.waitKey() == -1
    assert gui.getWindowProperty("two", cv2.WND_PROP_VISIBLE) < 1


def test_wait_key_without_an_end_does_not_hang_where_no_key_can_come(gui: HighGui, blind: HighGui) -> None:
    assert gui.waitKey(0) == -1, "there is no window"
    blind.imshow("window", GREY)
    assert blind.waitKey(0) == -1


# --- windows -------------------------------------------------------------------------------------


def test_closed_window_opens_again_with_the_next_image(gui: HighGui, person: Person) -> None:
    gui.imshow("window", GREY)
    first = person.numbers()[0]
    person.report((s.CLOSED, first))
    gui.imshow("window", GREY)
    person.report((s.CLOSED, first))  # of the old one, late
    assert len(person.numbers()) == 2
    assert gui.getWindowProperty("window", cv2.WND_PROP_VISIBLE) == 1.0


def test_properties_and_place(gui: HighGui, person: Person) -> None:
    gui.namedWindow("window", cv2.WINDOW_NORMAL)
    gui.resizeWindow("window", (200, 100))
    assert person.last(s.RESIZE) == [200, 100]
    gui.resizeWindow("window", 300, 200)
    gui.resizeWindow("window", width=310, height=210)
    assert person.last(s.RESIZE) == [310, 210]
    gui.setWindowProperty("window", cv2.WND_PROP_FULLSCREEN, cv2.WINDOW_FULLSCREEN)
    assert person.last(s.FULL) == [True]
    assert gui.getWindowProperty("window", cv2.WND_PROP_FULLSCREEN) == 1.0
    assert gui.getWindowProperty("window", cv2.WND_PROP_AUTOSIZE) == 0.0
    assert gui.getWindowProperty("none", cv2.WND_PROP_AUTOSIZE) == -1.0
    person.report((s.PLACED, person.numbers()[0], 5, 6, 310, 210))
    assert gui.getWindowImageRect("window") == (5, 6, 310, 210)
    gui.setWindowTitle("window", "Title")
    gui.moveWindow("window", 7, 8)
    assert (person.last(s.TITLE), person.last(s.MOVE)) == (["Title"], [7, 8])
    gui.destroyAllWindows()
    assert person.told[-1][0] == s.CLOSE


def test_functions_of_a_window_that_is_not_there_do_nothing_or_raise_as_opencv(gui: HighGui) -> None:
    gui.destroyWindow("none")
    gui.moveWindow("none", 1, 1)
    gui.createTrackbar("bar", "none", 0, 10, print)
    assert gui.getWindowImageRect("none") == (-1, -1, -1, -1)
    for function in (gui.setMouseCallback, lambda name, _: gui.getTrackbarPos("bar", name)):
        with pytest.raises(cv2.error, match=r"-27:Null pointer.*NULL window handler"):
            function("none", print)


# --- mouse and trackbars -------------------------------------------------------------------------


def test_mouse_calls_back_within_wait_key(gui: HighGui, person: Person) -> None:
    seen: list[tuple[Any, ...]] = []
    gui.imshow("window", GREY)
    gui.setMouseCallback(
        "window", lambda *arguments: seen.append((*arguments, threading.get_ident())), "mine"
    )
    number = person.numbers()[0]
    for event in (
        (cv2.EVENT_LBUTTONDOWN, 3, 4, 1),
        (0, 5, 6, 1),
        (0, 7, 8, 1),
        (cv2.EVENT_LBUTTONUP, 9, 9, 0),
    ):
        person.report((s.MOUSE, number, *event))
    assert seen == []
    assert gui.waitKey(1) == -1
    me = threading.get_ident()
    assert seen == [(1, 3, 4, 1, "mine", me), (0, 7, 8, 1, "mine", me), (4, 9, 9, 0, "mine", me)]


def test_trackbar_is_dragged_and_set(
    gui: HighGui, person: Person, capsys: pytest.CaptureFixture[str]
) -> None:
    values: list[int] = []
    gui.namedWindow("window")
    gui.createTrackbar("speed", "window", 3, 10, values.append)
    assert gui.getTrackbarPos("speed", "window") == 3
    person.report((s.DRAGGED, person.numbers()[0], "speed", 7))
    assert gui.getTrackbarPos("speed", "window") == 7, "also without waitKey"
    gui.waitKey(1)
    gui.setTrackbarPos("speed", "window", 99)
    gui.setTrackbarMax("speed", "window", 5)
    gui.setTrackbarMin("speed", "window", 2)
    assert values == [7, 10, 5]
    assert person.last(s.TRACKBAR) == ["speed", 5, 2, 5]
    gui.createTrackbar("broken", "window", 0, 10, lambda value: 1 / 0)
    gui.setTrackbarPos("broken", "window", 1)
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert gui.getTrackbarPos("none", "window") == -1


def test_region_is_selected_with_mouse_and_space(gui: HighGui, person: Person) -> None:
    def act() -> None:
        while not person.numbers() or gui._windows["pick"].on_mouse is None:
            time.sleep(0.001)
        number = person.numbers()[0]
        for event in ((cv2.EVENT_LBUTTONDOWN, 30, 20, 1), (0, 10, 5, 1), (cv2.EVENT_LBUTTONUP, 10, 5, 0)):
            person.report((s.MOUSE, number, *event))
        person.report((s.KEY, 32))

    thread = threading.Thread(target=act)
    thread.start()
    assert Regions(cv2, gui).selectROI("pick", cv2.merge([GREY] * 3), printNotice=False) == (10, 5, 20, 15)
    thread.join()


def test_region_is_empty_where_no_mouse_is(blind: HighGui, capsys: pytest.CaptureFixture[str]) -> None:
    assert Regions(cv2, blind).selectROI(GREY) == NOTHING
    assert Regions(cv2, blind).selectROIs("pick", GREY, True) == ()
    assert "SPACE or ENTER" in capsys.readouterr().out


# --- screens -------------------------------------------------------------------------------------


def test_lost_screen_closes_the_windows_and_the_script_goes_on(gui: HighGui, person: Person) -> None:
    gui.imshow("window", GREY)
    threading.Timer(0.05, person.lost, ("it broke",)).start()
    assert gui.waitKey(0) == -1
    assert gui.getWindowProperty("window", cv2.WND_PROP_VISIBLE) == 0.0


def test_windows_made_before_there_was_a_screen_appear_on_it(person: Person) -> None:
    screens: list[Person] = []

    def find(report: s.Report, lost: s.Lost) -> s.Screen:
        if not screens:
            raise s.NoScreen("")
        return screens[0]

    gui = HighGui(cv2, find)
    gui.namedWindow("window")
    gui.createTrackbar("bar", "window", 1, 5, None)
    screens.append(person)
    gui.imshow("window", GREY)
    assert [message[0] for message in person.told] == [s.OPEN, s.TRACKBAR, s.SHOW]


def test_of_waiting_images_the_newest_is_kept() -> None:
    outbox = Outbox()
    images = [(s.SHOW, 1, "d"), (s.SHOW, 1, "e")]
    for message in ((s.SHOW, 1, "a"), (s.SHOW, 2, "b"), (s.SHOW, 1, "c"), (s.CLOSE, 1), (s.OPEN, 1), *images):
        outbox.put(message)
    assert outbox.take(0) == [(s.SHOW, 1, "c"), (s.SHOW, 2, "b"), (s.CLOSE, 1), (s.OPEN, 1), (s.SHOW, 1, "e")]
    assert outbox.take(0) == []


# --- which OpenCV is given windows ---------------------------------------------------------------

HEADLESS = "\n  GUI:                           NONE\n    VTK support:   NO\n\n  Media I/O: \n"
QT = "\n  GUI:                           QT5\n    QT:            YES (ver 5.15.16 )\n\n  Media I/O: \n"
OLD_GTK = "\n  GUI: \n    GTK+:          YES (ver 3.22.30)\n    VTK support:   NO\n\n  Media I/O: \n"
OLD_NONE = "\n  GUI: \n    GTK+:          NO\n    VTK support:   NO\n\n  Media I/O: \n"
"""As in cv2.getBuildInformation of several versions."""


def opencv(build: str, framework: str | None = None) -> Any:
    module = SimpleNamespace(getBuildInformation=lambda: build, error=cv2.error)
    if framework is not None:
        module.currentUIFramework = lambda: framework
    return module


@pytest.mark.parametrize(
    ("module", "has_windows"),
    [
        (opencv(HEADLESS), False),
        (opencv(OLD_NONE), False),
        (opencv(QT), True),
        (opencv(OLD_GTK), True),
        (opencv(QT, ""), False),
        (opencv(HEADLESS, "GTK3"), True),
    ],
)
def test_build_tells_whether_there_are_windows(module: Any, has_windows: bool) -> None:
    assert patch.is_built_with_windows(module) is has_windows


@pytest.mark.skipif(not hasattr(patch.os, "fork"), reason="on Windows and macOS there is always a display")
def test_opencv_with_windows_is_left_alone_where_it_can_open_them() -> None:
    qt = opencv(QT, "QT5")
    assert patch.works_by_itself(qt, {"DISPLAY": ":0"})
    assert patch.works_by_itself(qt, {"QT_QPA_PLATFORM": "offscreen"})
    assert not patch.works_by_itself(qt, {}), "Qt would end the process"


def test_file_of_the_script_called_cv2_is_left_alone() -> None:
    module: Any = SimpleNamespace(imshow=print)
    patch.patch_cv2(module)
    assert vars(module) == {"imshow": print}


# --- whole scripts -------------------------------------------------------------------------------


@pytest.fixture
def no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


def test_script_without_a_display_goes_on_and_is_told_once(no_display: None, tmp_path: Path) -> None:
    text = """
        import cv2, threading
        import numpy as np
        from cv2 import imshow, waitKey as wait
        from cv2 import cv2 as same
        image = np.zeros((20, 30, 3), np.uint8)
        cv2.namedWindow("trackbars", cv2.WINDOW_NORMAL)
        cv2.createTrackbar("a", "trackbars", 3, 10, print)
        worker = threading.Thread(target=imshow, args=("thread", image))
        worker.start(); worker.join()
        keys = set()
        for _ in range(3):
            imshow("window", image)
            keys.add(wait(1) & 0xFF)
        print(keys, cv2.waitKey(0), same is cv2, cv2.getTrackbarPos("a", "trackbars"))
        print(cv2.getWindowProperty("window", cv2.WND_PROP_VISIBLE), cv2.selectROI("window", image, False))
        cv2.destroyAllWindows()
    """
    finished = simx_run(tmp_path, text)
    assert finished.returncode == 0, finished.stderr
    lines = finished.stdout.splitlines()
    assert lines[0] == "{255} -1 True 3"
    assert lines[-1] == "1.0 (0, 0, 0, 0)"
    assert finished.stderr.count("there is no display") == 1
    assert "--view" in finished.stderr
    assert len(re.findall("\n", finished.stderr)) == 1


@pytest.mark.parametrize("flag", ["--no-windows", "--plain"])
def test_windows_can_be_turned_off(no_display: None, tmp_path: Path, flag: str) -> None:
    text = "import cv2\nprint(cv2.imshow.__module__, hasattr(cv2, 'cv2'))"
    here = output_of(tmp_path, text)
    assert here.startswith("simx_client."), here
    assert not output_of(tmp_path, text, flags=(flag,)).startswith("simx_client.")


def test_windows_are_only_given_to_scripts_that_import_opencv(tmp_path: Path) -> None:
    text = "import sys\nimport vrep\nprint([m for m in sys.modules if 'highgui' in m or 'tkinter' in m])"
    assert output_of(tmp_path, text) == "[]"


@pytest.mark.skipif(not hasattr(patch.os, "fork"), reason="this system cannot fork")
def test_forked_worker_shows_images_too(no_display: None, tmp_path: Path) -> None:
    text = """
        import multiprocessing, sys
        import cv2
        import numpy as np
        def work(image):
            cv2.imshow("worker", image)
            print(cv2.waitKey(1), flush=True)
        image = np.zeros((20, 30, 3), np.uint8)
        cv2.imshow("parent", image)
        worker = multiprocessing.get_context("fork").Process(target=work, args=(image,))
        worker.start()
        worker.join()
        print(worker.exitcode, cv2.waitKey(1))
    """
    finished = simx_run(tmp_path, text)
    assert finished.stdout.split() == ["-1", "0", "-1"], finished.stderr
