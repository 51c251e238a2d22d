"""The interface of a window system, and the user's events. Pixels are those of the window's inside."""

from __future__ import annotations

from typing import Any, Protocol

SHIFT, CONTROL, ALT = 16, 8, 32
"""cv2.EVENT_FLAG_SHIFTKEY, CTRLKEY, ALTKEY: modifiers are passed as their sum."""

LEFT, RIGHT, MIDDLE = 0, 1, 2
"""Mouse buttons in cv2's order."""


class NoBackend(Exception):
    """The window system is not installed, or the display cannot be opened; the text says which."""


class Listener(Protocol):
    """A window that receives events."""

    def on_key(self, keysym: int) -> None: ...
    def on_motion(self, x: int, y: int, modifiers: int) -> None: ...
    def on_button(self, button: int, is_down: bool, x: int, y: int, modifiers: int) -> None: ...
    def on_wheel(self, steps: int, is_horizontal: bool, x: int, y: int, modifiers: int) -> None: ...
    def on_close(self) -> None: ...
    def on_place(self, x: int, y: int, width: int, height: int) -> None:
        """Handle a new position or size of the window's inside on the screen."""
        ...

    def on_exposed(self) -> None:
        """Handle the loss of the drawn pixels; a system that keeps them does not call this."""
        ...


class Pane(Protocol):
    """A window of the system."""

    def draw(self, rgb: Any) -> None:
        """Show pixels, uint8 (height, width, 3), from the upper left corner."""
        ...

    def set_title(self, title: str) -> None: ...
    def set_size(self, width: int, height: int) -> None: ...
    def set_resizable(self, is_resizable: bool) -> None: ...
    def set_full(self, is_full: bool) -> None: ...
    def move(self, x: int, y: int) -> None: ...
    def close(self) -> None: ...


class Backend(Protocol):
    """A window system."""

    name: str

    def open(self, title: str, width: int, height: int, listener: Listener) -> Pane: ...
    def pump(self) -> None:
        """Deliver the pending events; do not wait."""
        ...
