"""OpenCV's HighGUI as methods of one object: windows by name, keys, mouse, trackbars. Thread-safe.

The behaviour is that of OpenCV's documentation, and otherwise of the Qt build (opencv-python 4.10 for Linux,
measured) with two exceptions where GTK and Windows agree: letters keep their case, and a new trackbar does not call
its function. Call-backs run in the thread that calls waitKey, as there.
"""

from __future__ import annotations

import logging
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from . import screen as s
from .images import to_rgb

logger = logging.getLogger(__name__)

PROPERTIES = ("fullscreen", "autosize", "aspect ratio", "opengl", "visible", "topmost", "vsync")
"""cv2.WND_PROP_... by number."""

_FULLSCREEN, _AUTOSIZE, _RATIO, _OPENGL, _VISIBLE = range(5)
AUTOSIZE, FREE_RATIO = 1, 0x100
MOUSE_MOVE = 0
_WORKING, _WAITS = 0.25, 1000
"""Seconds after which a waiting thread wakes, so that Ctrl-C works on every system; maximum number of stored
reports."""

_NO_RECT = (-1, -1, -1, -1)


@dataclass
class Trackbar:
    """A trackbar of a window."""

    value: int
    maximum: int
    on_change: Callable[[int], object] | None
    minimum: int = 0

    def clipped(self, value: int) -> int:
        return min(max(value, self.minimum), self.maximum)


@dataclass
class Window:
    """Settings of the script for one window name."""

    number: int
    flags: int
    trackbars: dict[str, Trackbar] = field(default_factory=dict[str, Trackbar])
    on_mouse: Callable[..., object] | None = None
    parameter: Any = None
    is_full: bool = False
    rect: tuple[int, int, int, int] | None = None
    """As reported by the screen."""

    size: tuple[int, int] = (0, 0)
    """Size of the newest image."""


class HighGui:
    """The state, and the functions under their own names.

    Args:
        cv2: the script's module: it converts images, and its ``error`` is raised.
        find_screen: returns a screen for the first window, and again for later ones while there is none;
            raises NoScreen with a sentence for the log, or "" if nothing has changed.
    """

    def __init__(self, cv2: Any, find_screen: Callable[[s.Report, s.Lost], s.Screen]) -> None:
        self._cv2, self._find_screen = cv2, find_screen
        self._screen: s.Screen | None = None
        self._numbers = count(1)
        self._start()

    def _start(self) -> None:
        self._state = threading.Condition(threading.RLock())
        """Lock for everything below; notified when something is reported."""

        self._windows: dict[str, Window] = {}
        self._reports: deque[s.Message] = deque(maxlen=_WAITS)
        """Keys, and pending call-backs, in order."""

    # --- windows ---------------------------------------------------------------------------------

    def imshow(self, winname: str, mat: Any) -> None:
        """Show an image in the window of this name; make the window if needed. Raises cv2.error."""
        rgb = to_rgb(self._cv2, mat)
        height, width = rgb.shape[:2]
        with self._state:
            window = self._windows.get(winname) or self._open(winname, AUTOSIZE)
            self._need_screen()
            window.size = width, height
            if self._screen is not None:
                self._tell(s.SHOW, window.number, width, height, rgb.tobytes())

    def namedWindow(self, winname: str, flags: int = AUTOSIZE) -> None:
        """Make a window; an existing one of that name stays unchanged."""
        with self._state:
            if winname not in self._windows:
                self._open(winname, int(flags))

    def _open(self, name: str, flags: int) -> Window:
        self._need_screen()
        window = self._windows[name] = Window(next(self._numbers), flags)
        self._tell(s.OPEN, window.number, name, flags)
        return window

    def _need_screen(self) -> None:
        if self._screen is None:
            try:
                self._screen = self._find_screen(self._report, self._lose)
            except s.NoScreen as reason:
                if str(reason):
                    logger.warning("cv2.imshow and other windows: %s", reason)
                return
            logger.info("windows of cv2 are shown %s", self._screen.name)
            for name, window in self._windows.items():  # made before the screen
                self._tell(s.OPEN, window.number, name, window.flags)
                for label in window.trackbars:
                    self._tell_trackbar(window, label)

    def destroyWindow(self, winname: str) -> None:
        """Close a window; no effect for an unknown name."""
        with self._state:
            window = self._windows.pop(winname, None)
            if window is not None:
                self._tell(s.CLOSE, window.number)

    def destroyAllWindows(self) -> None:
        """Close all windows."""
        with self._state:
            for name in list(self._windows):
                self.destroyWindow(name)

    def moveWindow(self, winname: str, x: int, y: int) -> None:
        """Move the upper left corner to this pixel of the screen."""
        with self._on(winname) as window:
            self._tell(s.MOVE, window.number, int(x), int(y))

    def resizeWindow(self, winname: str, *size: Any, **keywords: Any) -> None:
        """Set the size of the image area, ``width, height`` or ``(width, height)``, unless it follows the
        image."""
        width, height = size if len(size) == 2 else size[0] if size else _size_of(keywords)
        with self._on(winname) as window:
            if not window.flags & AUTOSIZE:
                self._tell(s.RESIZE, window.number, max(1, int(width)), max(1, int(height)))

    def setWindowTitle(self, winname: str, title: str) -> None:
        """Change the title; the name stays."""
        with self._on(winname) as window:
            self._tell(s.TITLE, window.number, str(title))

    def getWindowImageRect(self, winname: str) -> tuple[int, int, int, int]:
        """Return x, y, width, height of the image on the screen; -1 each for an unknown window."""
        with self._state:
            window = self._windows.get(winname)
            if window is None:
                return _NO_RECT
            return window.rect or (0, 0, *window.size)

    def getWindowProperty(self, winname: str, prop_id: int) -> float:
        """Return a property cv2.WND_PROP_...; -1 for unknown ones; for an unknown window VISIBLE is 0, the
        others -1."""
        with self._state:
            window = self._windows.get(winname)
            if window is None:
                return 0.0 if prop_id == _VISIBLE else -1.0
            known = {
                _FULLSCREEN: float(window.is_full),
                _AUTOSIZE: float(window.flags & AUTOSIZE),
                _RATIO: float(window.flags & FREE_RATIO),
                _OPENGL: 0.0,
                _VISIBLE: 1.0,  # also without a screen: the user has not closed it
            }
            return known.get(prop_id, -1.0)

    def setWindowProperty(self, winname: str, prop_id: int, prop_value: float) -> None:
        """Set full screen, fixed to the image, or keep the ratio; the other properties cannot be set."""
        with self._on(winname) as window:
            value = int(prop_value)
            if prop_id == _FULLSCREEN:
                window.is_full = bool(value)
                self._tell(s.FULL, window.number, window.is_full)
            elif prop_id in (_AUTOSIZE, _RATIO):
                bit = AUTOSIZE if prop_id == _AUTOSIZE else FREE_RATIO
                window.flags = window.flags & ~bit | value & bit
                self._tell(s.OPEN, window.number, winname, window.flags)
            else:
                name = PROPERTIES[prop_id] if 0 <= prop_id < len(PROPERTIES) else prop_id
                logger.warning("the window property %s cannot be set; it stays as it is", name)

    def displayOverlay(self, winname: str, text: str, delayms: int = 0) -> None:
        """Show a line of text with the image for this many milliseconds; 0: until the next text."""
        with self._on(winname) as window:
            self._tell(s.TEXT, window.number, str(text), int(delayms))

    displayStatusBar = displayOverlay

    def startWindowThread(self) -> int:
        """Return 0: windows always have a separate thread here."""
        return 0

    @contextmanager
    def _on(self, name: str) -> Generator[Window]:
        """Yield the window of this name, locked; a temporary one for an unknown name, for which OpenCV does not raise
        either."""
        with self._state:
            yield self._windows.get(name) or Window(0, AUTOSIZE)

    # --- trackbars and mouse ---------------------------------------------------------------------

    def createTrackbar(
        self,
        trackbarName: str,
        windowName: str,
        value: int,
        count: int,
        onChange: Callable[[int], object] | None = None,
    ) -> None:
        """Add a trackbar of 0..count to a window. `onChange` is called with each new value."""
        with self._state:
            window = self._windows.get(windowName)
            if window is None:
                logger.warning("no window %r for the trackbar %r; make it first", windowName, trackbarName)
                return
            bar = Trackbar(0, max(0, int(count)), onChange)
            bar.value = bar.clipped(int(value))
            window.trackbars[trackbarName] = bar
            self._tell_trackbar(window, trackbarName)

    def getTrackbarPos(self, trackbarname: str, winname: str) -> int:
        """Return the value; -1 for an unknown trackbar. Raises cv2.error for an unknown window."""
        with self._state:
            bar = self._window(winname, "getTrackbarPos").trackbars.get(trackbarname)
            return -1 if bar is None else bar.value

    def setTrackbarPos(self, trackbarname: str, winname: str, pos: int) -> None:
        """Set the value, within the limits; a changed value calls the trackbar's function at once."""
        with self._state:
            window = self._window(winname, "setTrackbarPos")
            bar = window.trackbars.get(trackbarname)
            if bar is None or bar.clipped(int(pos)) == bar.value:
                return
            bar.value = value = bar.clipped(int(pos))
            self._tell_trackbar(window, trackbarname)
        _call(bar.on_change, value)

    def setTrackbarMin(self, trackbarname: str, winname: str, minval: int) -> None:
        """Set the lower limit."""
        self._set_limits(trackbarname, winname, minimum=int(minval))

    def setTrackbarMax(self, trackbarname: str, winname: str, maxval: int) -> None:
        """Set the upper limit."""
        self._set_limits(trackbarname, winname, maximum=int(maxval))

    def _set_limits(self, label: str, name: str, **limits: int) -> None:
        with self._state:
            window = self._window(name, "setTrackbarMax")
            bar = window.trackbars.get(label)
            if bar is None:
                return
            vars(bar).update(limits)
            if bar.minimum > bar.maximum:  # the limit set before is replaced
                bar.minimum = bar.maximum = next(iter(limits.values()))
            self._tell_trackbar(window, label)
        self.setTrackbarPos(label, name, bar.value)

    def setMouseCallback(
        self, windowName: str, onMouse: Callable[..., object] | None, param: Any = None
    ) -> None:
        """Call ``onMouse(event, x, y, flags, param)`` in waitKey. Raises cv2.error for an unknown window."""
        with self._state:
            window = self._window(windowName, "setMouseCallback")
            window.on_mouse, window.parameter = onMouse, param

    def _tell_trackbar(self, window: Window, label: str) -> None:
        bar = window.trackbars[label]
        self._tell(s.TRACKBAR, window.number, label, bar.value, bar.minimum, bar.maximum)

    def _window(self, name: str, function: str) -> Window:
        """Return the window of this name. Raises cv2.error."""
        window = self._windows.get(name)
        if window is None:
            there = ", ".join(map(repr, self._windows)) or "none"
            raise self._cv2.error(
                f"OpenCV({self._cv2.__version__}) error: (-27:Null pointer) NULL window handler: there is no window "
                f"{name!r}, windows: {there} in function '{function}'\n"
            )
        return window

    # --- keys ------------------------------------------------------------------------------------

    def waitKey(self, delay: int = 0) -> int:
        """Return the lowest byte of waitKeyEx's code, or -1."""
        code = self.waitKeyEx(delay)
        return code if code == -1 else code & 0xFF

    def waitKeyEx(self, delay: int = 0) -> int:
        """Wait for a key in any window, and call the pending functions of mouse and trackbars.

        Args:
            delay: milliseconds; 0 or less: until a key is pressed or no window is left.

        Returns:
            The key: ASCII for letters, digits, 8 back space, 9 tab, 13 return, 27 escape; else the X keysym,
                as 65361 for the left arrow. -1 without a key in this time.
        """
        return self._wait(None if delay <= 0 else time.monotonic() + delay / 1000.0)

    def pollKey(self) -> int:
        """Return a key as waitKey does, without waiting."""
        code = self._wait(time.monotonic())
        return code if code == -1 else code & 0xFF

    def _wait(self, deadline: float | None) -> int:
        with self._state:
            due = len(self._reports)
        while True:
            with self._state:
                is_over = deadline is not None and time.monotonic() >= deadline
                if not self._reports or (is_over and due <= 0):
                    if is_over or (deadline is None and not self._may_come()):
                        return -1
                    left = _WORKING if deadline is None else deadline - time.monotonic()
                    self._state.wait(min(max(left, 0.0), _WORKING))
                    continue
                report = self._reports.popleft()
                due -= 1
                window = next((each for each in self._windows.values() if each.number == report[1]), None)
            if report[0] == s.KEY:
                return int(report[1])
            if window is None:
                continue
            if report[0] == s.MOUSE:
                _call(window.on_mouse, *report[2:], window.parameter)
            elif report[2] in window.trackbars:
                _call(window.trackbars[report[2]].on_change, report[3])

    def _may_come(self) -> bool:
        """Return whether a key can still be pressed."""
        self._need_screen()
        return self._screen is not None and bool(self._windows)

    # --- the screen ------------------------------------------------------------------------------

    def _tell(self, *message: Any) -> None:
        if self._screen is not None and message[1]:
            self._screen.tell(message)

    def _report(self, report: s.Message) -> None:
        with self._state:
            name, window = next(
                ((name, each) for name, each in self._windows.items() if each.number == report[1]),
                ("", None),
            )
            if report[0] == s.KEY:
                self._reports.append(report)
            elif window is None:
                return
            elif report[0] == s.CLOSED:
                del self._windows[name]
            elif report[0] == s.PLACED:
                x, y, width, height = report[2:]
                window.rect = x, y, width, height
            elif report[0] == s.DRAGGED and report[2] in window.trackbars:
                window.trackbars[report[2]].value = report[3]
                self._reports.append(report)
            elif report[0] == s.MOUSE and window.on_mouse is not None:
                if self._reports and _is_move(self._reports[-1]) and _is_move(report):
                    self._reports.pop()  # a slow function gets the newest position, not a backlog
                self._reports.append(report)
            self._state.notify_all()

    def _lose(self, reason: str) -> None:
        with self._state:
            if self._screen is None:
                return
            logger.warning("windows of cv2 cannot be shown any more %s: %s", self._screen.name, reason)
            self._screen = None
            self._windows.clear()
            self._state.notify_all()

    def close(self) -> None:
        """Close the screen."""
        with self._state:
            screen, self._screen = self._screen, None
            self._windows.clear()
        if screen is not None:
            screen.close()

    def forget(self) -> None:
        """Drop the parent's windows in a forked child; windows of the child get a new screen."""
        if self._screen is not None:
            self._screen.forget()
        self._screen = None
        self._start()


def _is_move(report: s.Message) -> bool:
    return report[0] == s.MOUSE and report[2] == MOUSE_MOVE


def _size_of(keywords: dict[str, Any]) -> tuple[int, int]:
    return keywords["size"] if "size" in keywords else (keywords["width"], keywords["height"])


def _call(function: Callable[..., object] | None, *arguments: Any) -> None:
    """Call a function of the script; print its exception, as OpenCV does."""
    if function is not None:
        try:
            function(*arguments)
        except Exception:
            traceback.print_exc()
