"""The messages of V-REP's status bar: the last ones are kept for programs that show them, and all are logged."""

from __future__ import annotations

import logging
from collections import deque

logger = logging.getLogger(__name__)

KEPT = 200
"""Number of messages kept; older ones are in the log only."""

_LONGEST_KEPT = 10_000
_LONGEST_LOGGED = 500


class StatusBar:
    """The recent messages of clients, scripts and the simulator itself."""

    def __init__(self) -> None:
        self._messages: deque[str] = deque(maxlen=KEPT)
        self.count = 0
        """Number of messages ever added."""

    def add(self, message: str, level: int = logging.INFO) -> None:
        """Add a message, which may have several lines; `level`: its level in the log."""
        self._messages.append(message[:_LONGEST_KEPT])
        self.count += 1
        logger.log(level, "%s", as_log_line(message))

    @property
    def messages(self) -> list[str]:
        """Return the kept messages, oldest first."""
        return list(self._messages)


def as_log_line(text: str) -> str:
    """Return a client's text as one line of the log: shortened, and without terminal control characters."""
    shown = text if len(text) <= _LONGEST_LOGGED else text[: _LONGEST_LOGGED - 3] + "..."
    return "".join(letter if letter.isprintable() else " " for letter in shown)
