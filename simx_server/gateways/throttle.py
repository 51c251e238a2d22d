"""How a link is slowed down on which more arrives than is executed.

Zenoh reads a link no further while a message of it is handed over. So a short wait there keeps a flood with its sender
(TCP's flow control), where it costs this process neither memory nor the interpreter.
"""

from __future__ import annotations

import threading
import time

PAUSE = 0.002
"""Seconds for each message, and for each piece of it, times the links that are slowed down: however many these are,
they take the interpreter from the physics thread no more often than one."""

PIECE = 1 << 16
"""Bytes."""

LONGEST = 0.1
"""Seconds at most for one message."""

KEPT_FREE = 8
"""Of Zenoh's threads: they serve everybody else."""


class Throttle:
    """Lets threads of Zenoh's wait, but never all of them. Any thread."""

    def __init__(self, threads: int) -> None:
        """Make a throttle for a pool of so many threads; with too few of them nobody waits."""
        self._most = max(0, threads - KEPT_FREE)
        self._lock = threading.Lock()
        self._waiting = 0

    def slow_down(self, size: int) -> None:
        """Wait before the next message on this thread's link is read, as long as fits a message of so many bytes."""
        with self._lock:
            if self._waiting >= self._most:
                return
            self._waiting += 1
            waiting = self._waiting
        try:
            time.sleep(min(LONGEST, PAUSE * waiting * (1 + size // PIECE)))
        finally:
            with self._lock:
                self._waiting -= 1
