"""Busy wait: poll for an answer for a moment before sleeping.

A sleeping thread is woken by the system, which takes as long as the rest of a short call. Between two polls
the thread offers its core to other processes, such as the server. Polling uses processor time, so it is done
only while it pays: an answer that takes longer (of a script, or on a machine with all cores busy) makes the
next waits sleep, twice as many each time. When another program has kept the core after a poll, all cores are
busy: then waits sleep for a while, since a sleeping thread gets a core before a polling one. Images and
triggered simulation steps are never polled for.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from functools import partial
from typing import TypeVar

T = TypeVar("T")

SPIN_TIME = 200e-6
"""Duration of the busy wait in seconds; a server on the same machine answers a read in about half of it."""

MAX_SLEEPS = 256
"""Maximum number of waits that sleep before polling is tried again."""

LATE = 0.001
"""Seconds between two polls from which other programs have had the core meanwhile."""

PAUSE = 1.0
"""Seconds without polling from then on."""

# Windows has no sched_yield
_offer_core: Callable[[], object] = getattr(os, "sched_yield", partial(time.sleep, 0))


class BusyWait:
    """Busy wait of one connection."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._to_sleep_for = 0
        self._after_next_miss = 1
        self._next_poll = -math.inf

    def poll(self, take: Callable[[], T | None]) -> T | None:
        """Poll `take` for a moment; return its result, or None when the caller should sleep."""
        if self._to_sleep_for:
            self._to_sleep_for -= 1
            return None
        now = self._now
        last = now()
        if last < self._next_poll:
            return None
        until = last + SPIN_TIME
        while (found := take()) is None:
            before, last = last, now()
            if last - before > LATE:
                self._next_poll = last + PAUSE
                return None
            if last > until:
                self._to_sleep_for = self._after_next_miss
                self._after_next_miss = min(2 * self._after_next_miss, MAX_SLEEPS)
                return None
            _offer_core()
        self._after_next_miss = 1
        return found
