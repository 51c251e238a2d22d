"""Cases of tests: few in the suite, more where somebody waits for them (`make sweep`)."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from typing import TypeVar

_Case = TypeVar("_Case")

_FACTOR = int(os.environ.get("SWEEP", "1"))


def seeds(count: int) -> range:
    """Return the seeds of a random test."""
    return range(many(count))


def many(count: int) -> int:
    """Return how many cases a random test tries."""
    return count * _FACTOR


def chosen(cases: Sequence[_Case], some: Collection[_Case]) -> list[_Case]:
    """Return some of the cases, which stand for all of them; in a sweep all."""
    return [case for case in cases if _FACTOR > 1 or case in some]
