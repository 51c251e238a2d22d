"""Send payloads that may have to wait for room in a queue, from a separate thread.

Zenoh's ``put`` waits while its queue is full and has no time-out; callers have one.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

_JOIN_TIMEOUT = 2.0
"""Time-out for the thread's end in seconds. A put ends before, see ``FULL_QUEUE_US``."""


class Writer:
    """Puts payloads in their order. For one thread at a time."""

    def __init__(self, put: Callable[[bytes], None]) -> None:
        """Make a writer; its thread starts with the first payload."""
        self._put = put
        self._changed = threading.Condition()
        self.unsent: deque[bytes] = deque()
        """Payloads to put; the first is being put. Only the writer changes them."""

        self._is_closed = False
        self._thread: threading.Thread | None = None

    def send(self, payload: bytes, deadline: float) -> None:
        """Put a payload after all before it; wait until that is done, or until a deadline on the monotonic
        clock.

        A payload that is not put by then is put later, when the queue has room.
        """
        with self._changed:
            if self._is_closed:
                return
            self.unsent.append(payload)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="simx-writer", daemon=True)
                self._thread.start()
            self._changed.notify_all()
            left = min(deadline - time.monotonic(), threading.TIMEOUT_MAX)
            self._changed.wait_for(lambda: not self.unsent or self._is_closed, left)

    def close(self) -> None:
        """Drop unsent payloads and stop the thread: it must not return into an interpreter that has ended."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(_JOIN_TIMEOUT)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self.unsent or self._is_closed)
                if self._is_closed:
                    return
                payload = self.unsent[0]
            self._put(payload)
            with self._changed:
                self.unsent.popleft()
                self._changed.notify_all()
