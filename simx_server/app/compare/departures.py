"""Compare two runs: per quantity the first time at which they depart by more than a tolerance.

Runs are aligned by simulated time, at the times of the first one. Where the other one has no sample of such a time, its
neighbours are interpolated, if they are at most `WIDEST` of its usual intervals apart.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from .quantities import ANSWER, FORCE, JOINT, ORIENTATION, POSITION, VELOCITY
from .trajectories import SAME_TIME, Call, Floats, Quantity, Run, Series

WIDEST = 2.5
"""Usual intervals between two samples over which values are interpolated."""


class Tolerance(NamedTuple):
    """The difference up to which two values are equal."""

    absolute: float
    """In the unit of the quantity's difference."""

    share: float = 0.0
    """Of the range of the quantity in the first run, in addition."""


TOLERANCES: Mapping[str, Tolerance] = MappingProxyType(
    {
        POSITION: Tolerance(0.002),
        ORIENTATION: Tolerance(0.5),
        JOINT: Tolerance(0.005),
        VELOCITY: Tolerance(0.02, 0.02),
        FORCE: Tolerance(0.05, 0.05),
        ANSWER: Tolerance(0.002, 0.02),
    }
)
"""The tolerances that apply without others."""


class Departure(NamedTuple):
    """How far a quantity differs."""

    quantity: Quantity
    time: float | None
    """The first time of a difference above the tolerance in seconds; None: it stays within."""

    size: float
    """The difference then; 0 if it stays within."""

    one: tuple[float, ...]
    other: tuple[float, ...]
    """The values then."""

    largest: float
    largest_time: float
    samples: int
    """Times at which it was compared."""

    rms: float
    """Root mean square of the differences."""


class CallDeparture(NamedTuple):
    """The first call that changes something and differs."""

    number: int
    """Counted from 1 among the calls that change something."""

    one: Call | None
    other: Call | None
    """None: the program made no further call."""


@dataclass
class Comparison:
    """The result for two runs."""

    departures: list[Departure] = field(default_factory=list[Departure])
    """Quantities that depart, the first in time first."""

    equal: list[Departure] = field(default_factory=list[Departure])
    """Quantities that stay within their tolerances, the largest difference first."""

    only_one: list[str] = field(default_factory=list[str])
    only_other: list[str] = field(default_factory=list[str])
    """Objects that only one of the runs has."""

    not_aligned: list[Quantity] = field(default_factory=list[Quantity])
    """Quantities without a common time."""

    calls: CallDeparture | None = None
    ends: tuple[float, float] = (0.0, 0.0)
    """Last times of the two runs in seconds."""

    ends_early: bool = False
    """Whether the second run lacks the end of the first one."""

    tolerances: Mapping[str, Tolerance] = field(default_factory=lambda: TOLERANCES)

    @property
    def is_equal(self) -> bool:
        """Return whether everything that both have stays within the tolerances, up to the end, and something does."""
        return not self.departures and not self.ends_early and bool(self.equal)


def compare(
    one: Run, other: Run, tolerances: Mapping[str, Tolerance] = TOLERANCES, *, steps: bool = True
) -> Comparison:
    """Compare two runs; the first one is the reference.

    Args:
        steps: whether the program makes the simulation steps itself; runs of others end at different times.
    """
    found = Comparison(ends=(one.end, other.end), tolerances=tolerances)
    for quantity in sorted(one.series.keys() & other.series.keys()):
        departure = _departure(
            quantity, one.series[quantity], other.series[quantity], tolerances[quantity.name]
        )
        if departure is None:
            found.not_aligned.append(quantity)
        else:
            (found.equal if departure.time is None else found.departures).append(departure)
    found.departures.sort(key=lambda each: (each.time, each.quantity.name == ANSWER, -each.size))
    found.equal.sort(key=lambda each: -each.largest)
    is_shorter = other.end < one.end - max(SAME_TIME, WIDEST * _interval(one))
    found.ends_early = steps and is_shorter and bool(found.departures or found.equal)
    mine, its = _owners(one), _owners(other)
    found.only_one, found.only_other = sorted(mine - its), sorted(its - mine)
    found.calls = _calls(one.calls, other.calls)
    return found


def _interval(run: Run) -> float:
    """Return the usual interval between two samples in seconds; 0 for a run without steps."""
    times = max((each.times for each in run.series.values()), key=len, default=np.zeros(0))
    return float(np.median(np.diff(times))) if len(times) > 1 else 0.0


def _owners(run: Run) -> set[str]:
    return {quantity.owner for quantity in run.series if quantity.name != ANSWER}


def _departure(quantity: Quantity, one: Series, other: Series, tolerance: Tolerance) -> Departure | None:
    if one.values.shape[1] != other.values.shape[1]:
        return None
    places, theirs = aligned(one.times, other)
    if not len(places):
        return None
    mine = one.values[places]
    sizes = differences(quantity.name, mine, theirs)
    allowed = tolerance.absolute + tolerance.share * _range(one.values)
    largest = int(np.argmax(sizes))
    above = np.flatnonzero(sizes > allowed)
    first = int(above[0]) if len(above) else None
    times = one.times[places]
    return Departure(
        quantity,
        None if first is None else float(times[first]),
        0.0 if first is None else float(sizes[first]),
        () if first is None else tuple(map(float, mine[first])),
        () if first is None else tuple(map(float, theirs[first])),
        float(sizes[largest]),
        float(times[largest]),
        len(places),
        float(np.sqrt(np.mean(sizes**2))),
    )


def _range(values: Floats) -> float:
    return float(np.max(np.ptp(values, axis=0))) if len(values) else 0.0


def differences(name: str, one: Floats, other: Floats) -> Floats:
    """Return the size of the difference at each time, in the unit of the quantity.

    Args:
        name: of the quantity; orientations give an angle in degrees, joints are equal modulo a turn.
        one: values, shape (n, width).
        other: values of the same shape.
    """
    if name == ORIENTATION:
        norms = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        dots = np.abs(np.sum(one * other, axis=1)) / np.where(norms > 0, norms, 1.0)
        return np.degrees(2 * np.arccos(np.clip(dots, 0.0, 1.0)))
    sizes = np.abs(one - other)
    if name == JOINT:
        sizes = np.minimum(sizes, np.abs(sizes - 2 * math.pi))
    return np.linalg.norm(sizes, axis=1) if name == POSITION else np.max(sizes, axis=1, initial=0.0)


def aligned(times: Floats, other: Series) -> tuple[np.ndarray, Floats]:
    """Return the places among `times` for which another series has a value, and these values."""
    if len(other.times) == 0:
        return np.array([], dtype=int), other.values
    after = np.searchsorted(other.times, times - SAME_TIME)
    after_clipped = np.minimum(after, len(other.times) - 1)
    is_same = (after < len(other.times)) & (np.abs(other.times[after_clipped] - times) <= SAME_TIME)
    widest = WIDEST * float(np.median(np.diff(other.times))) if len(other.times) > 1 else 0.0
    before = np.maximum(after - 1, 0)
    gaps = other.times[after_clipped] - other.times[before]
    is_between = ~is_same & (after > 0) & (after < len(other.times)) & (gaps <= widest)
    shares = np.where(is_between, (times - other.times[before]) / np.where(gaps > 0, gaps, 1.0), 1.0)[:, None]
    low, high = other.values[before], other.values[after_clipped]
    low = np.where(np.sum(low * high, axis=1, keepdims=True) < 0, -low, low) if low.shape[1] == 4 else low
    values = np.where(is_same[:, None], high, low + shares * (high - low))
    places = np.flatnonzero(is_same | is_between)
    return places, values[places]


def _calls(one: Sequence[Call], other: Sequence[Call]) -> CallDeparture | None:
    if not one or not other:
        return None
    mine, its = ([call for call in calls if call.changes] for calls in (one, other))
    for number in range(max(len(mine), len(its))):
        a = mine[number] if number < len(mine) else None
        b = its[number] if number < len(its) else None
        if a is None or b is None or not _same(a, b):
            return CallDeparture(number + 1, a, b)
    return None


def _same(one: Call, other: Call) -> bool:
    return one.function == other.function and _same_values(one.arguments, other.arguments)


def _same_values(one: object, other: object) -> bool:
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=1e-6, abs_tol=1e-9)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        pairs: list[tuple[object, object]] = list(zip(one, other, strict=False))  # pyright: ignore[reportUnknownArgumentType]
        return len(one) == len(other) and all(_same_values(*pair) for pair in pairs)  # pyright: ignore[reportUnknownArgumentType]
    return one == other
