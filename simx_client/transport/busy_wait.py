"""Looking for an answer again and again, for a moment, before sleeping until it is there.

A thread that sleeps is woken through the system, which takes as long as the rest of a short call. Between two looks the
core is offered to whoever wants it, such as the server. Looking costs the processor what sleeping would have spared,
so it is done only as long as it pays: an answer that takes longer (a script's, or one of a machine whose cores are all
busy) makes the next ones be slept for, twice as many each time. For pictures and triggered passes nobody looks at all.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from typing import TypeVar

T = TypeVar("T")

LOOKING = 200e-6
"""Seconds; a read of a server on the same machine is answered in about half of that."""

MOST_SLEPT_FOR = 256
"""Answers that are slept for before looking is tried again."""

# Windows has no sched_yield.
_offer_core: Callable[[], object] = getattr(os, "sched_yield", partial(time.sleep, 0))


class Spinning:
    """Of one connection."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._to_sleep_for = 0
        self._after_next_miss = 1

    def look(self, take: Callable[[], T | None]) -> T | None:
        """What `take` gives within a moment; None when the caller had better sleep."""
        if self._to_sleep_for:
            self._to_sleep_for -= 1
            return None
        now = self._now
        until = now() + LOOKING
        while (found := take()) is None:
            if now() > until:
                self._to_sleep_for = self._after_next_miss
                self._after_next_miss = min(2 * self._after_next_miss, MOST_SLEPT_FOR)
                return None
            _offer_core()
        self._after_next_miss = 1
        return found
