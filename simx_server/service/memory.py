"""Return memory to the system, after much has waited, a client has left or much has become unused."""

from __future__ import annotations

import time

from simx_server.processes.heap import Unused, give_back

from .queue.inbox import Inbox
from .watcher import Watcher

GIVING_PAUSE = 5.0
"""Seconds between two times that memory is returned to the system."""

GIVINGS = 3
"""How often it is returned after much has waited: answers may still be on their way when nothing waits any more."""


class Memory(Watcher):
    """Looks now and then whether there is something to return."""

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox
        self._unused = Unused()
        self._next_giving = 0.0
        self._givings = 0

    def left(self, client: str) -> None:
        """Return memory soon: the client may have had much."""
        self._givings = GIVINGS

    def look(self) -> None:
        """Return memory, if that is due and nothing waits."""
        if self._inbox.take_had_much():
            self._givings = GIVINGS
        if (now := time.monotonic()) <= self._next_giving or len(self._inbox):
            return
        self._next_giving = now + GIVING_PAUSE
        if self._givings or self._unused.has_grown():
            self._givings = max(0, self._givings - 1)
            give_back()
