"""Messages to and from a screen.

A window has a number that is never used again: reports of a closed window do not apply to a new one of the
same name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

SHOW = "show"
"""number, width, height, RGB bytes, top row first."""

OPEN = "open"
"""number, title, flags (cv2.WINDOW_...)."""

CLOSE = "close"
"""number."""

TITLE = "title"
"""number, text."""

MOVE = "move"
"""number, x, y: pixels of the screen."""

RESIZE = "resize"
"""number, width, height of the image area in pixels."""

FULL = "full"
"""number, whether it fills the screen."""

TRACKBAR = "trackbar"
"""number, label, value, minimum, maximum: a new trackbar, or a new value."""

TEXT = "text"
"""number, text, milliseconds (0: until the next text): a line above the image."""

KEY = "key"
"""X keysym: reported."""

MOUSE = "mouse"
"""number, cv2.EVENT_..., x, y in pixels of the image, flags: reported."""

DRAGGED = "dragged"
"""number, label, value of a trackbar: reported."""

CLOSED = "closed"
"""number: the user has closed the window. Reported."""

PLACED = "placed"
"""number, x, y, width, height of the image area on the screen: reported."""

Message = Sequence[Any]
"""One of the words above and its values."""

Report = Callable[[Message], None]
"""Receives the reports of a screen, on any thread."""

Lost = Callable[[str], None]
"""Called with the reason when a screen is lost; on any thread."""


class NoScreen(Exception):
    """The screen is not available; the text says why, and what to do."""


class Screen(Protocol):
    """Shows windows."""

    name: str
    """Location of the windows, for messages."""

    def tell(self, message: Message) -> None:
        """Queue a message; never waits. Only the newest waiting image of a window is shown."""
        ...

    def close(self) -> None:
        """Close the screen with its windows."""
        ...

    def forget(self) -> None:
        """Free inherited resources in a forked child; the screen belongs to the parent."""
        ...
