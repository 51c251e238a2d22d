"""Numbers of a file that may be anything, also not finite, as values that a scene accepts."""

from __future__ import annotations

import math


def within(value: float, least: float, greatest: float, default: float) -> float:
    """Return a number within limits; `default` for one that is not finite."""
    return min(max(value, least), greatest) if math.isfinite(value) else default


def finite(value: float) -> float | None:
    """Return a number; None for one that is not finite."""
    return value if math.isfinite(value) else None


def positive(value: float) -> float | None:
    """Return a number above 0; None for any other."""
    return value if math.isfinite(value) and value > 0 else None


def is_same(value: float, other: float) -> bool:
    """Return whether two numbers are the same in single precision."""
    return math.isclose(value, other, rel_tol=1e-6)


def unusual(size: float, usual: float) -> float | None:
    """Return a size in metres; None for the usual one, and for one that is not above 0."""
    value = positive(size)
    return None if value is None or is_same(value, usual) else min(value, _LARGEST)


_LARGEST = 1e3


def colour(values: tuple[float, float, float]) -> list[float]:
    """Return RGB within 0..1."""
    return [within(value, 0.0, 1.0, 0.0) for value in values]
