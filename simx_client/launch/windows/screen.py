"""What a screen is told, and what it reports. A window is known by a number that is never used again: what is still
reported of a closed window does not concern its successor of the same name."""

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
"""number, label, value, minimum, maximum: a new one, or another value."""

TEXT = "text"
"""number, text, milliseconds (0: until the next text): a line above the image."""

KEY = "key"
"""X keysym: reported."""

MOUSE = "mouse"
"""number, cv2.EVENT_..., x, y in pixels of the image, flags: reported."""

DRAGGED = "dragged"
"""number, label, value of a trackbar: reported."""

CLOSED = "closed"
"""number: a person has closed the window. Reported."""

PLACED = "placed"
"""number, x, y, width, height of the image area on the screen: reported."""

Message = Sequence[Any]
"""One of the words above and what belongs to it."""

Report = Callable[[Message], None]
"""Takes what a screen reports, on any thread."""

Lost = Callable[[str], None]
"""Called when a screen is gone, with the reason; on any thread."""


class NoScreen(Exception):
    """There is no such screen; the text says why, and what to do about it."""


class Screen(Protocol):
    """Shows windows."""

    name: str
    """Where windows are to be seen, for people."""

    def tell(self, message: Message) -> None:
        """Have this done soon; never waits. Of the images of a window that wait only the newest is shown."""
        ...

    def close(self) -> None:
        """Leave; windows disappear."""
        ...

    def forget(self) -> None:
        """In a forked child: the screen is the parent's. Free what was inherited, disturb nothing."""
        ...
