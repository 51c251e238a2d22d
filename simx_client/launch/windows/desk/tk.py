"""Windows with Tk, which comes with Python (on Debian and Ubuntu: python3-tk). Its keysyms are X's, on every
system."""

from __future__ import annotations

import contextlib
import sys
from typing import Any

from .backend import ALT, CONTROL, LEFT, MIDDLE, RIGHT, SHIFT, Backend, Listener, NoBackend

_BUTTONS = {1: LEFT, 2: MIDDLE, 3: RIGHT} if sys.platform != "darwin" else {1: LEFT, 2: RIGHT, 3: MIDDLE}
_WHEEL_BUTTONS = {4: (1, False), 5: (-1, False), 6: (1, True), 7: (-1, True)}
"""Wheel buttons on X: steps, and whether sideways."""

_ALT_BITS = 0x20000 if sys.platform == "win32" else 0x8


def open_tk() -> Backend:
    """Open Tk. Raises NoBackend."""
    try:
        import tkinter
    except ImportError:
        raise NoBackend("Python has no Tk (apt-get install python3-tk)") from None
    try:
        root = tkinter.Tk(className="simx")
    except tkinter.TclError as error:
        raise NoBackend(f"Tk cannot open the display: {error}") from None
    root.withdraw()
    return _Tk(tkinter, root)


class _Tk:
    name = "Tk"

    def __init__(self, tkinter: Any, root: Any) -> None:
        self._tkinter, self._root = tkinter, root

    def open(self, title: str, width: int, height: int, listener: Listener) -> _Pane:
        return _Pane(self._tkinter, self._root, title, (width, height), listener)

    def pump(self) -> None:
        self._root.update()


class _Pane:
    def __init__(
        self, tkinter: Any, root: Any, title: str, size: tuple[int, int], listener: Listener
    ) -> None:
        self._tkinter, self._listener = tkinter, listener
        self._top: Any = tkinter.Toplevel(root)
        self._top.title(title)
        self._canvas: Any = tkinter.Canvas(self._top, highlightthickness=0, borderwidth=0)
        self._canvas.pack(fill="both", expand=True)
        self._photo: Any = tkinter.PhotoImage(master=root)
        self._canvas.create_image(0, 0, image=self._photo, anchor="nw")
        self.set_size(*size)
        self._top.protocol("WM_DELETE_WINDOW", listener.on_close)
        self._top.bind("<Destroy>", self._destroyed)
        self._top.bind("<KeyPress>", self._key)
        self._canvas.bind("<Configure>", self._placed)
        self._canvas.bind("<Motion>", self._moved)
        self._canvas.bind("<ButtonPress>", self._pressed)
        self._canvas.bind("<ButtonRelease>", self._released)
        self._canvas.bind("<MouseWheel>", self._turned)
        self._canvas.bind("<Shift-MouseWheel>", self._turned_sideways)

    def draw(self, rgb: Any) -> None:
        height, width = rgb.shape[:2]
        head = b"P6 %d %d 255\n" % (width, height)
        self._photo.configure(data=head + rgb.tobytes(), format="PPM", width=width, height=height)

    def set_title(self, title: str) -> None:
        self._top.title(title)

    def set_size(self, width: int, height: int) -> None:
        self._canvas.configure(width=width, height=height)
        self._top.geometry(f"{width}x{height}")

    def set_resizable(self, is_resizable: bool) -> None:
        self._top.resizable(is_resizable, is_resizable)

    def set_full(self, is_full: bool) -> None:
        self._top.attributes("-fullscreen", is_full)

    def move(self, x: int, y: int) -> None:
        self._top.geometry(f"{x:+d}{y:+d}")

    def close(self) -> None:
        with contextlib.suppress(self._tkinter.TclError):  # it is closed already
            self._top.destroy()

    def _destroyed(self, event: Any) -> None:
        if event.widget is self._top:
            self._listener.on_close()

    def _placed(self, event: Any) -> None:
        self._listener.on_place(
            self._canvas.winfo_rootx(), self._canvas.winfo_rooty(), event.width, event.height
        )

    def _pressed(self, event: Any) -> None:
        if event.num in _WHEEL_BUTTONS:
            steps, is_horizontal = _WHEEL_BUTTONS[event.num]
            self._listener.on_wheel(steps, is_horizontal, event.x, event.y, _modifiers(event))
        else:
            self._button(event, is_down=True)

    def _released(self, event: Any) -> None:
        self._button(event, is_down=False)

    def _button(self, event: Any, *, is_down: bool) -> None:
        if event.num in _BUTTONS:
            self._listener.on_button(_BUTTONS[event.num], is_down, event.x, event.y, _modifiers(event))

    def _key(self, event: Any) -> None:
        self._listener.on_key(event.keysym_num)

    def _moved(self, event: Any) -> None:
        self._listener.on_motion(event.x, event.y, _modifiers(event))

    def _turned_sideways(self, event: Any) -> None:
        self._turned(event, is_horizontal=True)

    def _turned(self, event: Any, *, is_horizontal: bool = False) -> None:
        """Handle the wheel on Windows and macOS."""
        delta = event.delta
        steps = delta if sys.platform == "darwin" else round(delta / 120) or (1 if delta > 0 else -1)
        self._listener.on_wheel(steps, is_horizontal, event.x, event.y, _modifiers(event))


def _modifiers(event: Any) -> int:
    state = event.state if isinstance(event.state, int) else 0
    return (SHIFT if state & 0x1 else 0) | (CONTROL if state & 0x4 else 0) | (ALT if state & _ALT_BITS else 0)
