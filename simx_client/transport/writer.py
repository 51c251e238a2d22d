"""Sends what may have to wait for room on the network, from a thread of its own.

Zenoh's ``put`` waits while its queue is full and knows no time-out; a caller has one.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

_JOIN_TIMEOUT = 2.0
"""Seconds; a put gives up before that, see ``FULL_QUEUE_US``."""


class Writer:
    """Puts payloads in the order they come. Used by one thread at a time."""

    def __init__(self, put: Callable[[bytes], None]) -> None:
        """Make a writer; its thread begins with the first payload."""
        self._put = put
        self._changed = threading.Condition()
        self._unsent: deque[bytes] = deque()
        """The first is being put."""

        self._is_closed = False
        self._thread: threading.Thread | None = None

    @property
    def is_idle(self) -> bool:
        return not self._unsent

    def send(self, payload: bytes, deadline: float) -> None:
        """Put after all before it; waits until that is done, or until a time on the monotonic clock.

        What is not put by then will be when there is room.
        """
        with self._changed:
            if self._is_closed:
                return
            self._unsent.append(payload)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="simx-writer", daemon=True)
                self._thread.start()
            self._changed.notify_all()
            left = min(deadline - time.monotonic(), threading.TIMEOUT_MAX)
            self._changed.wait_for(lambda: not self._unsent or self._is_closed, left)

    def close(self) -> None:
        """Drop what has not gone out and end the thread: it must not come back into an interpreter that has ended."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(_JOIN_TIMEOUT)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._unsent or self._is_closed)
                if self._is_closed:
                    return
                payload = self._unsent[0]
            self._put(payload)
            with self._changed:
                self._unsent.popleft()
                self._changed.notify_all()
