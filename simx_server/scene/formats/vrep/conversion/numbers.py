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


def colour(values: tuple[float, float, float]) -> list[float]:
    """Return RGB within 0..1."""
    return [within(value, 0.0, 1.0, 0.0) for value in values]
