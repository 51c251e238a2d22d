"""The windows of the process: the script's settings of each, its layout, and the user's actions."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import screen as s
from . import painting
from .backend import Backend, Pane

AUTOSIZE, FREE_RATIO = 1, 0x100
EMPTY = (320, 240)
"""Width and height of a window without an image."""

LEAST_WIDTH = 320
"""Minimum width in pixels of a window with trackbars or text, so that they can be read."""

MOVE, DOWN, UP, DOUBLE, WHEEL, SIDE_WHEEL = 0, 1, 4, 7, 10, 11
"""cv2.EVENT_...; DOWN, UP and DOUBLE plus the button."""

BUTTON_FLAGS = (1, 2, 4)
"""cv2.EVENT_FLAG_LBUTTON, RBUTTON, MBUTTON."""

DOUBLE_TIME, DOUBLE_WAY = 0.4, 4
"""Maximum seconds and pixels between the two clicks of a double click."""

WHEEL_STEP = 120
"""cv2.getMouseWheelDelta for one notch."""

ASCII = {
    0xFF08: 8,
    0xFF09: 9,
    0xFF0A: 10,
    0xFF0D: 13,
    0xFF1B: 27,
    0xFF80: 32,
    0xFF89: 9,
    0xFF8D: 13,
    0xFFBD: ord("="),
}
"""X keysyms that HighGUI returns as ASCII. Source: X11's keysymdef.h; measured with opencv-python 4.10."""


def key_code(keysym: int) -> int | None:
    """Return the code of waitKeyEx for an X keysym; None for a modifier alone, which HighGUI does not report."""
    if 0xFFE1 <= keysym <= 0xFFEE or 0xFE01 <= keysym <= 0xFE0F or keysym in (0, 0xFF7E, 0xFF7F, 0xFF14):
        return None
    if 0xFFAA <= keysym <= 0xFFB9:  # operators and digits of the keypad
        return keysym - 0xFF80
    return ASCII.get(keysym, keysym)


@dataclass
class Bar:
    """A trackbar to be drawn."""

    value: int
    minimum: int
    maximum: int


class Desk:
    """All windows. Used by one thread."""

    def __init__(self, backend: Backend, report: s.Report) -> None:
        self._backend, self._report = backend, report
        self._windows: dict[int, ShownWindow] = {}

    def do(self, message: s.Message) -> None:
        """Execute a message of the script."""
        word, number, *rest = message
        window = self._windows.get(number)
        if word == s.OPEN:
            if window is None:
                window = ShownWindow(self._backend, number, rest[0], self._reported)
                self._windows[number] = window
            window.set_flags(rest[1])
        elif window is None:
            return  # the user has closed it meanwhile
        elif word == s.CLOSE:
            del self._windows[number]
            window.pane.close()
        else:
            window.do(word, rest)

    def tick(self) -> None:
        """Draw changed windows, and remove closed ones."""
        now = time.monotonic()
        for window in list(self._windows.values()):
            window.tick(now)

    def _reported(self, report: s.Message) -> None:
        if report[0] == s.CLOSED:
            window = self._windows.pop(report[1], None)
            if window is None:
                return  # the script has closed it
            window.pane.close()
        self._report(report)


class ShownWindow:
    """One window. The trackbars and a line of text are rows above the image."""

    def __init__(
        self, backend: Backend, number: int, title: str, report: Callable[[s.Message], None]
    ) -> None:
        self._number, self._report = number, report
        self._flags = AUTOSIZE
        self._image: Any = None
        self._bars: dict[str, Bar] = {}
        self._text, self._text_until = "", 0.0
        self._size = EMPTY
        """Size of the inside, as reported by the system or requested."""

        self._area = (0, 0, *EMPTY)
        """Position of the image in the window: x, y, width, height."""

        self._pressed = 0
        self._dragged: str | None = None
        self._last_down = (0.0, -1, 0, 0)
        """Time, button and position."""

        self._is_stale = True
        self._is_closed = False
        self.pane: Pane = backend.open(title, *self._size, self)

    # --- what the script tells -------------------------------------------------------------------

    def set_flags(self, flags: int) -> None:
        self._flags = flags
        self.pane.set_resizable(not flags & AUTOSIZE)
        self._is_stale = True

    def do(self, word: str, rest: list[Any]) -> None:
        """Execute a message other than opening and closing."""
        if word == s.SHOW:
            width, height, pixels = rest
            is_first = self._image is None
            self._image = np.frombuffer(pixels, np.uint8).reshape(height, width, 3)
            if is_first and not self._flags & AUTOSIZE and self._size == EMPTY:
                self._fit(width, height)
        elif word == s.TITLE:
            self.pane.set_title(rest[0])
        elif word == s.MOVE:
            self.pane.move(*rest)
        elif word == s.RESIZE:
            self._fit(*rest)
        elif word == s.FULL:
            self.pane.set_full(rest[0])
        elif word == s.TRACKBAR:
            label, value, minimum, maximum = rest
            self._bars[label] = Bar(value, minimum, maximum)
            if not self._flags & AUTOSIZE and self._image is not None:
                self._fit(*self._area[2:])
        elif word == s.TEXT:
            text, milliseconds = rest
            self._text = text
            self._text_until = time.monotonic() + milliseconds / 1000 if milliseconds > 0 else float("inf")
        self._is_stale = True

    def _fit(self, width: int, height: int) -> None:
        """Resize the window for an image area of this size."""
        self._resize(width, height + self._head())

    def _head(self) -> int:
        return painting.ROW * (len(self._bars) + bool(self._text))

    def _resize(self, width: int, height: int) -> None:
        if (width, height) != self._size:
            self._size = width, height
            self.pane.set_size(width, height)

    # --- drawing ---------------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        if self._text and now >= self._text_until:
            self._text, self._is_stale = "", True
        if self._is_stale and not self._is_closed:
            self._is_stale = False
            self._draw()

    def _draw(self) -> None:
        image, head = self._image, self._head()
        if self._flags & AUTOSIZE:
            columns, rows = (EMPTY[0], 0 if head else EMPTY[1]) if image is None else image.shape[1::-1]
            self._resize(max(columns, LEAST_WIDTH) if head else columns, rows + head)
        width, height = self._size
        rows = [
            painting.trackbar_row(width, label, bar.value, bar.minimum, bar.maximum)
            for label, bar in self._bars.items()
        ]
        if self._text:
            rows.append(painting.text_row(width, self._text))
        below = height - head
        if below > 0:
            empty = np.zeros((1, 1, 3), np.uint8)
            if self._flags & AUTOSIZE and image is not None:
                area, place = _at_corner(image, width, below)
            else:
                keeps_ratio = image is not None and not self._flags & FREE_RATIO
                source = empty if image is None else image
                area, place = painting.fitted(source, width, below, keeps_ratio=keeps_ratio)
            rows.append(area)
            self._area = place[0], place[1] + head, place[2], place[3]
        self.pane.draw(np.ascontiguousarray(np.vstack(rows)[:height]))

    # --- what people do --------------------------------------------------------------------------

    def on_key(self, keysym: int) -> None:
        if (code := key_code(keysym)) is not None:
            self._report((s.KEY, code))

    def on_close(self) -> None:
        if not self._is_closed:
            self._is_closed = True
            self._report((s.CLOSED, self._number))

    def on_place(self, x: int, y: int, width: int, height: int) -> None:
        if (width, height) != self._size and not self._flags & AUTOSIZE:
            self._size, self._is_stale = (width, height), True
        left, top, columns, rows = self._area
        self._report((s.PLACED, self._number, x + left, y + top, columns, rows))

    def on_exposed(self) -> None:
        self._is_stale = True

    def on_motion(self, x: int, y: int, modifiers: int) -> None:
        if self._dragged is not None:
            self._drag(x)
        else:
            self._mouse(MOVE, x, y, modifiers)

    def on_button(self, button: int, is_down: bool, x: int, y: int, modifiers: int) -> None:
        if is_down and button == 0 and 0 <= y < painting.ROW * len(self._bars):
            self._dragged = list(self._bars)[y // painting.ROW]
            self._drag(x)
            return
        if not is_down and button == 0 and self._dragged is not None:
            self._dragged = None
            return
        flag, event = BUTTON_FLAGS[button], DOWN if is_down else UP
        self._pressed = self._pressed | flag if is_down else self._pressed & ~flag
        if is_down:
            now = time.monotonic()
            when, which, last_x, last_y = self._last_down
            if (
                which == button
                and now - when < DOUBLE_TIME
                and abs(x - last_x) + abs(y - last_y) < DOUBLE_WAY
            ):
                event, button_then = DOUBLE, -1  # a third click starts again
            else:
                button_then = button
            self._last_down = now, button_then, x, y
        self._mouse(event + button, x, y, modifiers)

    def on_wheel(self, steps: int, is_horizontal: bool, x: int, y: int, modifiers: int) -> None:
        delta = max(-32768, min(32767, steps * WHEEL_STEP))
        self._mouse(SIDE_WHEEL if is_horizontal else WHEEL, x, y, modifiers, delta)

    def _drag(self, x: int) -> None:
        bar = self._bars[self._dragged or ""]
        value = painting.value_at(x, self._size[0], bar.minimum, bar.maximum)
        if value != bar.value:
            bar.value, self._is_stale = value, True
            self._report((s.DRAGGED, self._number, self._dragged, value))

    def _mouse(self, event: int, x: int, y: int, modifiers: int, delta: int = 0) -> None:
        """Report a mouse event in pixels of the image; outside only while a button is held, at the nearest
        pixel."""
        if self._image is None:
            return
        left, top, columns, rows = self._area
        is_inside = left <= x < left + columns and top <= y < top + rows
        if not is_inside and not self._pressed and event not in (UP, UP + 1, UP + 2):
            return
        height, width = self._image.shape[:2]
        column = min(max((x - left) * width // max(1, columns), 0), width - 1)
        row = min(max((y - top) * height // max(1, rows), 0), height - 1)
        self._report((s.MOUSE, self._number, event, column, row, delta << 16 | self._pressed | modifiers))


def _at_corner(image: Any, width: int, height: int) -> tuple[Any, tuple[int, int, int, int]]:
    """Return an image unscaled, with grey at the right and below if the window is larger."""
    rows, columns = image.shape[:2]
    if (columns, rows) != (width, height):
        area = np.full((height, width, 3), 170, np.uint8)
        area[:rows, :columns] = image[:height, :width]
        image, rows, columns = area, min(rows, height), min(columns, width)
    return image, (0, 0, columns, rows)
