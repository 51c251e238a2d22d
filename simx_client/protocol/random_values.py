"""Random values of properties, by name: what clients draw, and a server that grades. Needs NumPy.

Equal generators give equal numbers, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, cast, runtime_checkable

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
        limits = [each for each in (self.low, self.high) if each is not None]
        _, deviation, *found = _arrays("Normal", self.mean, self.deviation, *limits)
        if (deviation < 0).any():
            raise ValueError(f"Normal needs a deviation of 0 or more, not {self.deviation!r}")
        if len(found) == 2 and (found[0] > found[1]).any():
            raise ValueError(f"Normal needs low <= high, not {self.low!r} and {self.high!r}")

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
        if len({each.shape for each in _arrays("Choice", *values)}) > 1:
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


Value = Distribution | Numbers | Scale | Shift | Callable[[np.random.Generator], Any]


class PropertyName(NamedTuple):
    """A name in two parts."""

    object: str
    property: str


def read_name(text: str) -> PropertyName:
    """Return the parts of ``OBJECT.PROPERTY``. Raises ValueError."""
    # An object's name or path has no dots; names of properties may have them.
    name, dot, attribute = text.partition(".")
    if name.strip() and dot and attribute.strip():
        return PropertyName(name.strip(), attribute.strip())
    raise ValueError(f"{text!r} is not the name of a property; write OBJECT.PROPERTY, such as 'Cube.mass'")


def check_value(text: str, value: object) -> None:
    """Raise ValueError unless a value can be drawn for the property with this name."""
    read_name(text)
    part = value.factor if isinstance(value, Scale) else value.by if isinstance(value, Shift) else value
    if isinstance(part, Distribution) or callable(part):
        return
    try:
        found = np.asarray(cast(Sequence[float], part), np.float64)
        is_valid = found.ndim <= 1 and bool(np.isfinite(found).all())
    except (TypeError, ValueError):
        is_valid = False
    if not is_valid:
        raise ValueError(
            f"{text!r}: {value!r} is no value; valid are numbers, vectors, Uniform, LogUniform, Normal, Choice, "
            "Scale, Shift and functions of a random generator"
        )


def draw_numbers(text: str, value: Value, present: Array, random: np.random.Generator) -> list[float]:
    """Return the numbers for a property.

    Args:
        text: its name, for messages.
        present: its numbers in the scene.

    Raises:
        ValueError: the value has another number of numbers.
    """
    if isinstance(value, Scale):
        numbers = present * _drawn(value.factor, random)
    elif isinstance(value, Shift):
        numbers = present + _drawn(value.by, random)
    else:
        numbers = _drawn(value, random)
    if numbers.shape != present.shape:
        raise ValueError(
            f"{text!r} has {present.size} {'number' if present.size == 1 else 'numbers'}, and "
            f"{value!r} gives {numbers.size}"
        )
    return numbers.tolist()


def _drawn(
    value: Distribution | Numbers | Callable[[np.random.Generator], Any], random: np.random.Generator
) -> Array:
    if isinstance(value, Distribution):
        found = value.draw(random)
    else:
        found = value(random) if callable(value) else value
    return np.atleast_1d(np.asarray(found, np.float64))


def _check_range(name: str, low: Numbers, high: Numbers) -> None:
    """Raise ValueError unless the numbers are a range."""
    below, above = _arrays(name, low, high)
    if (below > above).any():
        raise ValueError(f"{name} needs low <= high, not {low!r} and {high!r}")


def _arrays(name: str, *values: object) -> list[Array]:
    """Return numbers and vectors as arrays. Raises ValueError unless they are finite, and vectors of one length."""
    try:
        found = [np.asarray(cast(Sequence[float], each), np.float64) for each in values]
        lengths = {each.shape for each in found if each.ndim}
        is_valid = all(each.ndim <= 1 and np.isfinite(each).all() for each in found) and len(lengths) <= 1
    except (TypeError, ValueError):
        is_valid, found = False, []
    if not is_valid:
        given = ", ".join(map(repr, values))
        raise ValueError(f"{name} needs finite numbers, or vectors of one length, not {given}")
    return found
