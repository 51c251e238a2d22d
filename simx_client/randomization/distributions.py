"""Distributions of numbers and vectors. Equal generators give equal numbers, bit for bit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Numbers = float | Sequence[float]
"""A number, or a number for each component of a vector."""

Array = NDArray[np.float64]


@runtime_checkable
class Distribution(Protocol):
    """Draws numbers."""

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector."""
        ...


@dataclass(frozen=True)
class Uniform:
    """A number or vector drawn uniformly from ``low`` to ``high``."""

    low: Numbers
    high: Numbers

    def __post_init__(self) -> None:
        _check_range("Uniform", self.low, self.high)

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector."""
        return random.uniform(self.low, self.high)


@dataclass(frozen=True)
class LogUniform:
    """A number or vector above 0 whose logarithm is uniform: factors of equal size are equally likely."""

    low: Numbers
    high: Numbers

    def __post_init__(self) -> None:
        _check_range("LogUniform", self.low, self.high)
        if not (np.asarray(self.low) > 0).all():
            raise ValueError(f"LogUniform needs numbers above 0, not {self.low!r}")

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector."""
        drawn = np.exp(random.uniform(np.log(self.low), np.log(self.high)))
        return np.clip(drawn, self.low, self.high)  # rounding of the logarithms


@dataclass(frozen=True)
class Normal:
    """A number or vector of a normal distribution; cut off at ``low`` and ``high``, if there are any."""

    mean: Numbers
    deviation: Numbers
    low: Numbers | None = None
    high: Numbers | None = None

    def __post_init__(self) -> None:
        numbers = np.asarray(self.mean, np.float64), np.asarray(self.deviation, np.float64)
        if not (np.isfinite(numbers[0]).all() and np.isfinite(numbers[1]).all() and (numbers[1] >= 0).all()):
            raise ValueError(
                f"Normal needs a finite mean and a deviation of 0 or more, not {self.mean!r} and {self.deviation!r}"
            )
        if self.low is not None and self.high is not None:
            _check_range("Normal", self.low, self.high)

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector; numbers beyond the limits become the limits."""
        drawn = random.normal(self.mean, self.deviation)
        return drawn if self.low is None and self.high is None else np.clip(drawn, self.low, self.high)


@dataclass(frozen=True, init=False)
class Choice:
    """One of several numbers or vectors, each equally likely."""

    values: tuple[Numbers, ...]

    def __init__(self, *values: Numbers) -> None:
        if not values:
            raise ValueError("Choice needs values to choose from")
        if len({np.shape(each) for each in values}) > 1:
            raise ValueError(f"Choice needs values of one length, not {values!r}")
        object.__setattr__(self, "values", values)

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector."""
        return self.values[int(random.integers(len(self.values)))]


@dataclass(frozen=True)
class Scale:
    """The scene's value times a drawn factor, or factors."""

    factor: Distribution | Numbers


@dataclass(frozen=True)
class Shift:
    """The scene's value and a drawn number or vector added to it."""

    by: Distribution | Numbers


def _check_range(name: str, low: Numbers, high: Numbers) -> None:
    """Raise ValueError unless the numbers are a range."""
    below, above = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if not (np.isfinite(below).all() and np.isfinite(above).all() and (below <= above).all()):
        raise ValueError(f"{name} needs finite low <= high, not {low!r} and {high!r}")
