"""Busy wait: poll for an answer for a moment before sleeping.

A sleeping thread is woken by the system, which takes as long as the rest of a short call. Between two polls
the thread offers its core to other processes, such as the server. Polling uses processor time, so it is done
only while it pays: an answer that takes longer (of a script, or on a machine with all cores busy) makes the
next waits sleep, twice as many each time. Images and triggered simulation steps are never polled for.
"""

from __future__ import annotations

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

# Windows has no sched_yield
_offer_core: Callable[[], object] = getattr(os, "sched_yield", partial(time.sleep, 0))


class BusyWait:
    """Busy wait of one connection."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._to_sleep_for = 0
        self._after_next_miss = 1

    def poll(self, take: Callable[[], T | None]) -> T | None:
        """Poll `take` for a moment; return its result, or None when the caller should sleep."""
        if self._to_sleep_for:
            self._to_sleep_for -= 1
            return None
        now = self._now
        until = now() + SPIN_TIME
        while (found := take()) is None:
            if now() > until:
                self._to_sleep_for = self._after_next_miss
                self._after_next_miss = min(2 * self._after_next_miss, MAX_SLEEPS)
                return None
            _offer_core()
        self._after_next_miss = 1
        return found
