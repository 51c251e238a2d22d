"""The cost of work: processor time of this thread, so that other programs of the machine count little.

The least of several tries counts, and more are made only while it is above the bound.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

BUDGET = 0.25
"""Seconds of processor time that a call, or the reading of a message, may take."""

SLACK = 2.0
"""Times the budget that a test allows."""

TRIES = 6

_WORK = 100_000
"""Turns of a loop whose time tells how fast a processor is."""

_REFERENCE = 0.005
"""Seconds that this loop takes on the processor for which the budgets were chosen."""


def least_seconds(work: Callable[[], object], enough: float = 0.0) -> float:
    """Return the least processor time of several tries, of the first that takes at most `enough`."""
    least = float("inf")
    with only_own_garbage():
        for _ in range(TRIES):
            began = time.thread_time()
            work()
            least = min(least, time.thread_time() - began)
            if least <= enough:
                break
    return least


@contextmanager
def only_own_garbage() -> Iterator[None]:
    """Have garbage collections look at new objects only.

    Those that other tests keep in this process would count several times where some work makes very many lists. A
    server sets its own aside once it has started.
    """
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def slowness() -> float:
    """Return how many times slower than the reference this processor is now; at least 1.

    Other guests of the host change that from one second to the next, so it is measured for each doubtful case.
    """
    numbers = range(_WORK)

    def loop() -> None:
        found: list[int] = []
        for number in numbers:
            if type(number) is int and number >= 0:
                found.append(number)

    return max(1.0, least_seconds(loop) / _REFERENCE)


def is_within(seconds: float, allowed: float) -> bool:
    """Return whether some work kept its bound, on a processor that may be slow at present."""
    return seconds <= allowed or seconds <= allowed * slowness()


@contextmanager
def peak_megabytes() -> Iterator[Callable[[], float]]:
    """Yield a function that returns by how much this process has grown at most; 0 if the system does not tell."""
    before = _start_of_peak()
    yield lambda: (_size("VmHWM") - before) / 1024 if before else 0.0


def _start_of_peak() -> int:
    """Have the system measure the peak from now on; return the present size in KB, 0 if it cannot."""
    try:
        with open("/proc/self/clear_refs", "w") as peak:
            peak.write("5")
    except OSError:
        return 0
    return _size("VmRSS")


def _size(name: str) -> int:
    """Return a size of this process in KB, as the system tells it."""
    with open("/proc/self/status") as status:
        return int(status.read().partition(f"{name}:")[2].split(maxsplit=1)[0])
