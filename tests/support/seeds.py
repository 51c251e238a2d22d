"""Numbers of cases of random tests: few in the suite, more where somebody waits for them (`make sweep`)."""

from __future__ import annotations

import os

_FACTOR = int(os.environ.get("SWEEP", "1"))


def seeds(count: int) -> range:
    """Return the seeds of a random test."""
    return range(many(count))


def many(count: int) -> int:
    """Return how many cases a random test tries."""
    return count * _FACTOR
