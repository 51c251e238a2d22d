"""Slow down a link on which more arrives than the server executes.

Zenoh does not read further from a link while it hands over one of its messages. A short wait at that point keeps a
flood with its sender (TCP's flow control), where it costs this process neither memory nor the interpreter.
"""

from __future__ import annotations

import threading
import time

PAUSE = 0.002
"""Seconds for each message, and for each piece of it, multiplied by the number of links that are slowed down. Together,
slow links take the interpreter from the physics thread no more often than one.
"""

PIECE = 1 << 16
"""Bytes."""

LONGEST = 0.1
"""Most seconds for one message."""

KEPT_FREE = 8
"""Zenoh threads that never wait: they serve all other clients."""


class Throttle:
    """Makes some of Zenoh's threads wait, but never all of them. Any thread."""

    def __init__(self, threads: int) -> None:
        """Make a throttle for a pool of this many threads; in a pool that is too small, no thread waits."""
        self._most = max(0, threads - KEPT_FREE)
        self._lock = threading.Lock()
        self._waiting = 0

    def slow_down(self, size: int) -> None:
        """Wait before Zenoh reads the next message of this thread's link; longer for more bytes."""
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
