"""A time-out for waits that have none.

Zenoh's channels wake the waiting thread directly, without a detour through Python, but their ``recv`` takes
no time-out. An alarm's thread ends such a wait from outside when the time-out has passed.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable


class Alarm:
    """Calls a function from its thread when a deadline has passed.

    Setting a deadline costs two attribute accesses while it is not earlier than the one the thread sleeps
    for. Deadlines of successive waits increase, so the thread wakes once per time-out and not once per wait.
    The function may also be called for a wait that ended just in time: it must be harmless then.
    """

    def __init__(self, ring: Callable[[], None]) -> None:
        """Start the alarm's thread. It starts here since no thread can be started at exit, where the first
        wait may be."""
        self._ring = ring
        self._deadline = math.inf
        self._sleeps_until = math.inf
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="simx-alarm", daemon=True)
        self._thread.start()

    def set(self, deadline: float) -> None:
        """Ring at this time of the monotonic clock, unless the deadline is set again or cleared before."""
        self._deadline = deadline
        # The thread writes _sleeps_until before it reads _deadline, so one of the two reads the other's
        # value.
        if deadline < self._sleeps_until:
            with self._changed:
                self._changed.notify()

    def clear(self) -> None:
        """Clear the deadline: no wait is in progress."""
        self._deadline = math.inf

    def close(self) -> None:
        """Stop the thread. Idempotent."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                if self._is_closed:
                    return
                self._sleeps_until = math.inf
                self._sleeps_until = deadline = self._deadline
                left = deadline - time.monotonic()
                if left > 0:
                    self._changed.wait(None if math.isinf(left) else left)
                    continue
                self._deadline = math.inf
            self._ring()  # without the lock: the function may wait for a thread that is setting the alarm
