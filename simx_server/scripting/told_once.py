"""Lines that the scripts of a scene cause again and again, and that are printed once: about stand-ins."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar

_MOST, _LONGEST = 10_000, 500
"""Lines that are known, and their characters."""


class ToldOnce:
    """The lines that the scripts of a scene have caused already."""

    def __init__(self, status_bar: StatusBar) -> None:
        self._status_bar = status_bar
        self._known: set[str] = set()

    def tell(self, text: str, *, about: str = "") -> None:
        """Print a line to the status bar, and so to the log, unless a script of this scene has caused it before.

        Args:
            about: what the line is about, where it contains values that change; there is one line about each.
        """
        if self.is_first(about or text):
            self._status_bar.add(text)

    def is_first(self, note: str) -> bool:
        """Return whether no script of this scene has caused a note before, and keep its first characters; false from a
        number of notes on that only a faulty script causes.
        """
        note = note[:_LONGEST]
        if note in self._known or len(self._known) >= _MOST:
            return False
        self._known.add(note)
        return True

    def forget(self) -> None:
        """Forget all lines: the scene is closed."""
        self._known.clear()
