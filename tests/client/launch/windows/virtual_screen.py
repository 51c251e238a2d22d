"""A virtual screen of its own (Xvfb), and a person at it: real keys and a real mouse (xdotool, X's own library)."""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from processes import wait_until

TOOLS = ("Xvfb", "xdotool")
missing = [tool for tool in TOOLS if shutil.which(tool) is None]
needs_screen = pytest.mark.skipif(bool(missing), reason=f"{missing} missing: apt-get install xvfb xdotool")


@contextlib.contextmanager
def virtual_screen(folder: Path) -> Iterator[PersonAt]:
    """Somebody before it; the test is skipped where it cannot be had. `folder` holds its memory."""
    read, write = os.pipe()
    command = ["Xvfb", "-displayfd", str(write), "-screen", "0", "800x600x24", "-nolisten", "tcp"]
    command += ["-noreset"]  # when its last client goes, it begins anew, and is not there for a moment
    command += ["-fbdir", str(folder)]
    with subprocess.Popen(command, pass_fds=[write], stderr=subprocess.PIPE, text=True) as screen:
        os.close(write)
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            pytest.skip(f"Xvfb does not start here: {screen.communicate()[1].strip()}")
        yield PersonAt(f":{number}", folder / "Xvfb_screen0")
        screen.terminate()


class PersonAt:
    """Somebody before a virtual screen."""

    def __init__(self, display: str, memory: Path) -> None:
        self.display = display
        self._memory = memory

    def xdotool(self, *arguments: object) -> str:
        done = subprocess.run(
            ["xdotool", *map(str, arguments)],
            env={**os.environ, "DISPLAY": self.display},
            capture_output=True,
            text=True,
            timeout=20,
        )
        return done.stdout.strip()

    def find(self, title: str) -> int:
        """The window of this title, which the keys go to from now on."""
        found: list[int] = []

        def has_focus() -> bool:
            """A window that is being made comes and goes, and takes no focus before it can be seen."""
            window = self.windows().get(title)
            if window is None:
                return False
            self.xdotool("windowfocus", window)
            focused = self.xdotool("getwindowfocus", "-f")
            found[:] = [window]
            return focused == str(window) and self.windows().get(title) == window

        assert wait_until(has_focus, 60.0), f"no window {title!r} takes the keys; there are {self.windows()}"
        return found[0]

    def windows(self) -> dict[str, int]:
        """Those that are to be seen, by title; xdotool's own search misses SDL's."""
        found: dict[str, int] = {}
        with self._x11() as (x11, display):
            root, parent = ctypes.c_ulong(), ctypes.c_ulong()
            children, count = ctypes.POINTER(ctypes.c_ulong)(), ctypes.c_uint()
            x11.XQueryTree(
                display,
                ctypes.c_ulong(x11.XDefaultRootWindow(display)),
                *map(ctypes.byref, (root, parent, children, count)),
            )
            for number in children[: count.value]:
                if (title := _title(x11, display, number)) and self.xdotool("getwindowgeometry", number):
                    found[title] = number
        return found

    @contextlib.contextmanager
    def _x11(self) -> Iterator[tuple[ctypes.CDLL, ctypes.c_void_p]]:
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XSetErrorHandler(
            _no_matter
        )  # a window may go while it is asked; by default that ends the process
        x11.XOpenDisplay.restype = ctypes.c_void_p
        x11.XInternAtom.restype = x11.XDefaultRootWindow.restype = ctypes.c_ulong
        display = ctypes.c_void_p(x11.XOpenDisplay(self.display.encode()))
        assert display, f"the screen {self.display} is gone"
        try:
            yield x11, display
        finally:
            x11.XCloseDisplay(display)

    def pixels(self) -> np.ndarray:
        """What is to be seen, (height, width, 3), red first. Source of the layout: X11's XWDFile.h."""
        raw = self._memory.read_bytes()
        head = np.frombuffer(raw[:100], ">u4").astype(int)
        header, width, height, bits, stride, colours = head[[0, 4, 5, 11, 12, 19]]
        assert bits == 32
        body = np.frombuffer(raw, np.uint8, height * stride, header + 12 * colours)
        return body.reshape(height, -1, 4)[:, :width, 2::-1]

    def close(self, window: int) -> None:
        """As a window manager does when somebody clicks its cross: asks the program to."""
        with self._x11() as (x11, display):
            protocols, delete = (
                x11.XInternAtom(display, name, False) for name in (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW")
            )
            event = _ClientMessage(type=33, window=window, message_type=protocols, format=32)
            event.data[0] = delete
            x11.XSendEvent(display, ctypes.c_ulong(window), False, ctypes.c_long(0), ctypes.byref(event))
            x11.XSync(display, False)


def _title(x11: ctypes.CDLL, display: ctypes.c_void_p, window: int) -> str:
    """WM_NAME, of whatever encoding: XFetchName knows one only, and SDL takes another."""
    kind, size, rest = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_ulong()
    bits, text = ctypes.c_int(), ctypes.c_char_p()
    x11.XGetWindowProperty(
        display,
        *map(ctypes.c_ulong, (window, _WM_NAME)),
        *map(ctypes.c_long, (0, 64)),
        False,
        ctypes.c_ulong(0),
        *map(ctypes.byref, (kind, bits, size, rest, text)),
    )
    return (text.value or b"").decode()


_WM_NAME = 39


@ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
def _no_matter(display: int, error: int) -> int:
    return 0


class _ClientMessage(ctypes.Structure):
    _fields_ = (
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
        ("rest", ctypes.c_long * 24),  # an XEvent is larger
    )
