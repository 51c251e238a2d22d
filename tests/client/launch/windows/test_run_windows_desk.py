"""The process that owns windows of cv2.imshow: layout, scaling, mouse, trackbars; the window system is the test's."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from simx_client.launch.windows import screen as s
from simx_client.launch.windows.desk import painting
from simx_client.launch.windows.desk.backend import Listener
from simx_client.launch.windows.desk.windows import EMPTY, Desk, key_code
from simx_client.launch.windows.outbox import Outbox

pytestmark = pytest.mark.slow

IMAGE = np.arange(20 * 30 * 3, dtype=np.uint16).astype(np.uint8).reshape(20, 30, 3)
ROW = painting.ROW


class Pane:
    """A window that notes what becomes of it."""

    def __init__(self, title: str, width: int, height: int, listener: Listener) -> None:
        self.title, self.size, self.listener = title, (width, height), listener
        self.picture: Any = None
        self.is_closed = self.is_full = False
        self.is_resizable = True
        self.place = (0, 0)

    def draw(self, rgb: Any) -> None:
        assert rgb.shape[1::-1] == self.size
        self.picture = rgb

    def set_title(self, title: str) -> None:
        self.title = title

    def set_size(self, width: int, height: int) -> None:
        self.size = width, height

    def set_resizable(self, is_resizable: bool) -> None:
        self.is_resizable = is_resizable

    def set_full(self, is_full: bool) -> None:
        self.is_full = is_full

    def move(self, x: int, y: int) -> None:
        self.place = x, y

    def close(self) -> None:
        self.is_closed = True
        self.listener.on_close()  # as Tk does


class Screen:
    """A window system and what was reported."""

    name = "test"

    def __init__(self) -> None:
        self.panes: list[Pane] = []
        self.reports: list[s.Message] = []
        self.desk = Desk(self, self.reports.append)

    def open(self, title: str, width: int, height: int, listener: Listener) -> Pane:
        self.panes.append(Pane(title, width, height, listener))
        return self.panes[-1]

    def pump(self) -> None:
        """Events come from the test."""

    def tell(self, *messages: s.Message) -> Pane:
        for message in messages:
            self.desk.do(message)
        self.desk.tick()
        return self.panes[-1]

    def mouse(self) -> list[list[Any]]:
        return [list(report[2:]) for report in self.reports if report[0] == s.MOUSE]


@pytest.fixture
def screen() -> Screen:
    return Screen()


def show(image: np.ndarray = IMAGE) -> s.Message:
    return (s.SHOW, 1, image.shape[1], image.shape[0], image.tobytes())


def opened(flags: int = cv2.WINDOW_AUTOSIZE) -> s.Message:
    return (s.OPEN, 1, "window", flags)


def test_window_follows_the_size_of_its_image(screen: Screen) -> None:
    pane = screen.tell(opened())
    assert (pane.title, pane.size) == ("window", EMPTY)
    screen.tell(show())
    assert pane.size == (30, 20)
    assert np.array_equal(pane.picture, IMAGE)
    assert not pane.is_resizable
    screen.tell(show(np.zeros((50, 60, 3), np.uint8)))
    assert pane.size == (60, 50)


def test_resizable_window_scales_its_image_and_the_mouse_with_it(screen: Screen) -> None:
    pane = screen.tell(opened(cv2.WINDOW_NORMAL), show())
    assert pane.size == (30, 20), "as large as the first image"
    pane.size = (300, 100)
    pane.listener.on_place(0, 0, 300, 100)
    screen.desk.tick()
    assert pane.size == (300, 100)
    assert pane.picture.shape == (100, 300, 3)
    assert np.unique(pane.picture[:, :70]).tolist() == [170], "the ratio is kept"
    pane.listener.on_motion(75 + 149, 99, 0)
    pane.listener.on_motion(10, 50, 0)  # beside the image
    assert screen.mouse() == [[cv2.EVENT_MOUSEMOVE, 29, 19, 0]]
    screen.tell(opened(cv2.WINDOW_NORMAL | cv2.WINDOW_FREERATIO))
    pane.listener.on_motion(10, 50, 0)
    assert screen.mouse()[-1] == [cv2.EVENT_MOUSEMOVE, 1, 10, 0]


def test_buttons_modifiers_double_click_and_wheel(screen: Screen) -> None:
    listener = screen.tell(opened(), show()).listener
    for is_down in (True, False, True, False):
        listener.on_button(0, is_down, 3, 4, 0)
    listener.on_button(1, True, 3, 4, cv2.EVENT_FLAG_CTRLKEY)
    listener.on_motion(-50, 500, cv2.EVENT_FLAG_SHIFTKEY)  # dragged out of the window
    listener.on_button(1, False, -50, 500, 0)
    listener.on_wheel(-2, False, 3, 4, 0)
    assert screen.mouse() == [
        [cv2.EVENT_LBUTTONDOWN, 3, 4, cv2.EVENT_FLAG_LBUTTON],
        [cv2.EVENT_LBUTTONUP, 3, 4, 0],
        [cv2.EVENT_LBUTTONDBLCLK, 3, 4, cv2.EVENT_FLAG_LBUTTON],
        [cv2.EVENT_LBUTTONUP, 3, 4, 0],
        [cv2.EVENT_RBUTTONDOWN, 3, 4, cv2.EVENT_FLAG_RBUTTON | cv2.EVENT_FLAG_CTRLKEY],
        [cv2.EVENT_MOUSEMOVE, 0, 19, cv2.EVENT_FLAG_RBUTTON | cv2.EVENT_FLAG_SHIFTKEY],
        [cv2.EVENT_RBUTTONUP, 0, 19, 0],
        [cv2.EVENT_MOUSEWHEEL, 3, 4, -240 << 16],
    ]


def test_trackbar_is_dragged_within_its_limits_and_the_image_lies_below(screen: Screen) -> None:
    pane = screen.tell(opened(), show(), (s.TRACKBAR, 1, "speed", 5, 0, 10), (s.TRACKBAR, 1, "a", 1, 1, 1))
    assert pane.size == (320, 20 + 2 * ROW)
    assert np.array_equal(pane.picture[2 * ROW :, :30], IMAGE)
    before = pane.picture.copy()
    begin, end = painting.rail(320)
    pane.listener.on_button(0, True, end, 5, 0)
    pane.listener.on_motion(begin - 100, 500, 0)
    pane.listener.on_button(0, False, begin, 5, 0)
    pane.listener.on_motion(end, 5, 0)
    dragged = [report for report in screen.reports if report[0] == s.DRAGGED]
    assert dragged == [(s.DRAGGED, 1, "speed", 10), (s.DRAGGED, 1, "speed", 0)]
    assert screen.mouse() == []
    screen.desk.tick()
    assert not np.array_equal(before[:ROW], pane.picture[:ROW])
    assert np.array_equal(before[ROW:], pane.picture[ROW:])
    pane.listener.on_motion(4, 2 * ROW + 3, 0)
    assert screen.mouse() == [[cv2.EVENT_MOUSEMOVE, 4, 3, 0]]


def test_window_of_trackbars_alone_shows_them(screen: Screen) -> None:
    pane = screen.tell(opened(), (s.TRACKBAR, 1, "a", 3, 0, 10), (s.TRACKBAR, 1, "b", 3, 0, 10))
    assert pane.size == (320, 2 * ROW)
    assert np.array_equal(pane.picture[:ROW, 150:], pane.picture[ROW:, 150:])
    assert not np.array_equal(pane.picture[:ROW], pane.picture[ROW:]), "labels differ"


def test_text_goes_after_its_time(screen: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("time.monotonic", lambda: now)
    pane = screen.tell(opened(), show(), (s.TEXT, 1, "hello", 500))
    assert pane.size == (320, 20 + ROW)
    now = 100.5
    screen.desk.tick()
    assert pane.size == (30, 20)


def test_person_and_script_close_once_each(screen: Screen) -> None:
    pane = screen.tell(opened(), show())
    pane.listener.on_close()
    assert pane.is_closed
    assert screen.reports == [(s.CLOSED, 1)]
    screen.tell(show(), (s.TITLE, 1, "late"), (s.CLOSE, 1))  # on their way when it was closed
    screen.tell((s.OPEN, 2, "window", 1), (s.CLOSE, 2))
    assert screen.panes[1].is_closed
    assert screen.reports == [(s.CLOSED, 1)], "what the script closes is not told to it"


def test_title_place_and_full_screen(screen: Screen) -> None:
    pane = screen.tell(
        opened(0), show(), (s.TITLE, 1, "T"), (s.MOVE, 1, 3, 4), (s.FULL, 1, True), (s.RESIZE, 1, 90, 60)
    )
    assert (pane.title, pane.place, pane.is_full, pane.size) == ("T", (3, 4), True, (90, 60))
    pane.listener.on_place(3, 4, 90, 60)
    assert screen.reports[-1] == (s.PLACED, 1, 3, 4, 90, 60)


@pytest.mark.parametrize(
    ("keysym", "code"),
    [
        (ord("q"), ord("q")), (ord("Q"), ord("Q")), (0xFF0D, 13), (0xFF8D, 13), (0xFF1B, 27), (0xFF08, 8), (0xFF09, 9),
        (0x20, 32), (0xFFB5, ord("5")), (0xFFAB, ord("+")), (0xFF51, 65361), (0xFFBE, 65470), (0xFFFF, 65535),
        (0xFFE1, None), (0xFFE3, None), (0xFE03, None), (0, None),
    ],
)  # fmt: skip
def test_key_codes_are_those_of_opencv_and_modifiers_alone_are_none(keysym: int, code: int | None) -> None:
    assert key_code(keysym) == code


def test_hasty_script_has_only_its_newest_image_drawn(screen: Screen) -> None:
    inbox = Outbox()
    inbox.put(opened())
    for brightness in range(50):
        inbox.put(show(np.full((2, 2, 3), brightness, np.uint8)))
    messages = inbox.take(0)
    assert len(messages) == 2
    assert screen.tell(*messages).picture[0, 0, 0] == 49
