"""What work costs: processor time of this thread, so that other programs of the machine count little.

The least of several tries counts, and more are made only while it is above the bound.
"""

from __future__ import annotations

import time
from collections.abc import Callable

BUDGET = 0.25
"""Seconds of processor time that a call, or the reading of a message, may take."""

SLACK = 2.0
"""How much slower a processor may be than the one for which a budget was chosen, while others use it too."""

TRIES = 6


def least_seconds(work: Callable[[], object], enough: float = 0.0) -> float:
    """Return the least processor time of several tries, of the first that takes at most `enough`."""
    least = float("inf")
    for _ in range(TRIES):
        began = time.thread_time()
        work()
        least = min(least, time.thread_time() - began)
        if least <= enough:
            break
    return least
