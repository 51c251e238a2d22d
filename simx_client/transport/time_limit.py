"""A time limit for waits that have none of their own.

Zenoh's channels wake the waiting thread straight from their own, without a detour through Python, but
their ``recv`` takes no time-out. An alarm's thread ends such a wait from outside when its time is up.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable


class Alarm:
    """Rings from its own thread once a deadline has passed.

    Setting a deadline costs two attribute accesses as long as it is not earlier than the one the thread
    sleeps for; deadlines of successive waits come later and later, so the thread wakes once per time-out
    and not once per wait. A wait that ended just in time may still be rung for: bells must be harmless.
    """

    def __init__(self, ring: Callable[[], None]) -> None:
        """Make an alarm and start its thread: the first wait may be at exit, where no thread can start any more."""
        self._ring = ring
        self._deadline = math.inf
        self._sleeps_until = math.inf
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="simx-alarm", daemon=True)
        self._thread.start()

    def set(self, deadline: float) -> None:
        """Ring at this time of the monotonic clock, unless set anew or cleared before."""
        self._deadline = deadline
        # The thread writes _sleeps_until before it reads _deadline, so one of the two sees the other.
        if deadline < self._sleeps_until:
            with self._changed:
                self._changed.notify()

    def clear(self) -> None:
        """Nobody waits any more."""
        self._deadline = math.inf

    def close(self) -> None:
        """End the thread. Idempotent."""
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
            self._ring()  # without the lock: a bell may wait for somebody who is just setting the alarm
