"""A path of CoppeliaSim 4 as a list of numbers: configurations one after the other, and the lengths at which they lie.

A configuration is any numbers of the same count, such as positions, poses (x, y, z, then a quaternion x, y, z, w) or
joint angles. Types say what each number is; without types all are Cartesian.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import wxyz_from_xyzw
from simx_server.scene.poses.poses import conjugate, multiply, rotation_vector

CARTESIAN, CYCLIC, QUATERNION = range(3)
"""Types of a number: as it is; an angle where whole turns are equal; one of four of a quaternion."""

LINEAR, BEZIER = "linear", "quadraticBezier"
"""Types of interpolation."""

MOST_NUMBERS = 100_000
"""Numbers of a path: some 14,000 poses. A number takes up to 2 us, one of a quaternion longer."""

Configuration = list[float]
Distance = Callable[[Configuration, Configuration], float]

_LEAST_STRENGTH = 0.05
_NO_TURN = 1e-15
"""Sine of half of an angle, below which two rotations are the same."""

_SAME = 1e-4
"""Distance below which the ends of a path overlap."""


class FlatPath:
    """A path with its lengths."""

    def __init__(
        self, numbers: Sequence[float], lengths: Sequence[float], types: Sequence[int] | None = None
    ) -> None:
        """Check and split the numbers. Raises CommandError."""
        count = len(lengths)
        if count < 2 or not numbers or len(numbers) % count:
            raise CommandError(
                f"a path has two points or more, and a length for each; {len(numbers)} numbers do not divide among "
                f"{count} lengths"
            )
        self.size = len(numbers) // count
        self.numbers, self.lengths = numbers, lengths
        self.types = checked_types(types, self.size)

    def point(self, index: int) -> Configuration:
        """Return the configuration at an index from 0."""
        return list(self.numbers[index * self.size : (index + 1) * self.size])

    def at(self, position: float, kind: str, strength: float, *, is_open: bool) -> Configuration:
        """Return the configuration at a length from the start; see `sampled`."""
        found: Configuration = self.sampled(np.array([position]), kind, strength, is_open=is_open)[0].tolist()
        return found

    def sampled(
        self, places: NDArray[np.float64], kind: str, strength: float, *, is_open: bool
    ) -> NDArray[np.float64]:
        """Return a configuration for each length from the start; a length outside means the nearer end.

        Args:
            kind: LINEAR or BEZIER.
            strength: share of each way that the Bezier curves take up, 0 to 1.
            is_open: a path whose ends overlap is open too.
        """
        lengths = np.asarray(self.lengths, np.float64)
        points = np.asarray(self.numbers, np.float64).reshape(len(lengths), self.size)
        last = len(lengths) - 1
        index = np.clip(np.searchsorted(lengths, places, "right") - 1, 0, last - 1)
        span = lengths[index + 1] - lengths[index]
        share = np.clip((places - lengths[index]) / np.where(span > 0, span, np.inf), 0.0, 1.0)
        found = blended(points[index], points[index + 1], share, self.types)
        if kind != BEZIER:
            return found
        half = min(max(strength, _LEAST_STRENGTH), 1.0) / 2
        is_behind = share < half
        corner = np.where(is_behind, index, index + 1)
        bends = is_behind | (share > 1 - half)
        if is_open or distance(self.point(0), self.point(last), None, self.types) >= _SAME:
            bends &= (corner > 0) & (corner < last)
        corner, share = corner[bends], share[bends]
        along = np.where(is_behind[bends], 0.5 + share / half / 2, (share - 1 + half) / half / 2)
        before = points[np.where(corner > 0, corner - 1, last - 1)]
        after = points[np.where(corner < last, corner + 1, 1)]
        # A quadratic Bezier curve around the corner takes up `half` of both ways.
        first = blended(before, points[corner], 1 - half + half * along, self.types)
        second = blended(points[corner], after, half * along, self.types)
        found[bends] = blended(first, second, along, self.types)
        return found

    def resampled(self, count: int, kind: str, strength: float, *, is_open: bool) -> list[float]:
        """Return the numbers of as many points, at equal lengths. Raises CommandError."""
        if count < 2:
            raise CommandError(f"a path has two points or more, not {count}")
        first, last = self.lengths[0], self.lengths[-1]
        places = first + (last - first) * np.arange(count) / (count - 1)
        found: list[float] = self.sampled(places, kind, strength, is_open=is_open).ravel().tolist()
        return found


def lengths_of(numbers: Sequence[float], size: int, measure: Distance | None = None) -> list[float]:
    """Return the length at which each point lies, from 0 for the first one.

    Args:
        size: numbers of a point; without `measure` the first three count, as x, y, z.
        measure: distance between two points.

    Raises:
        CommandError: the numbers do not divide among points.
    """
    if size < 1 or not numbers or len(numbers) % size:
        raise CommandError(f"{len(numbers)} numbers do not divide among points of {size}")
    if measure is None:
        places = np.asarray(numbers, np.float64).reshape(-1, size)[:, :3]
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        return [0.0, *np.cumsum(steps).tolist()]
    points = [list(numbers[start : start + size]) for start in range(0, len(numbers), size)]
    found = [0.0]
    for before, point in pairwise(points):
        found.append(found[-1] + measure(before, point))
    return found


def nearest(path: FlatPath, place: Sequence[float]) -> float:
    """Return the length at which a path of positions is nearest to a place."""
    best, found = math.inf, 0.0
    for index in range(len(path.lengths) - 1):
        start, end = path.point(index)[:3], path.point(index + 1)[:3]
        way = [b - a for a, b in zip(start, end, strict=True)]
        squared = sum(each * each for each in way)
        along = sum(each * (p - a) for each, p, a in zip(way, place, start, strict=True))
        share = min(max(along / squared, 0.0), 1.0) if squared > 0 else 0.0
        gap = math.dist([a + each * share for a, each in zip(start, way, strict=True)], place)
        if gap < best:
            best = gap
            found = path.lengths[index] + share * (path.lengths[index + 1] - path.lengths[index])
    return found


def distance(
    first: Sequence[float],
    second: Sequence[float],
    metric: Sequence[float] | None = None,
    types: Sequence[int] | None = None,
) -> float:
    """Return the distance between two configurations: the root of the squares, each with its factor of `metric`.

    A quaternion counts once, with the angle in radians and the factor of its first number. Raises CommandError.
    """
    size = len(first)
    if len(second) != size or (metric is not None and len(metric) < size):
        raise CommandError("two configurations and the metric must have the same count of numbers")
    kinds = checked_types(types, size)
    total, index = 0.0, 0
    while index < size:
        factor = 1.0 if metric is None else metric[index]
        if kinds[index] == QUATERNION:
            gap = _turn(first[index : index + 4], second[index : index + 4])
            index += 4
        else:
            gap = second[index] - first[index]
            gap = math.remainder(gap, 2 * math.pi) if kinds[index] == CYCLIC else gap
            index += 1
        total += gap * gap * factor
    return math.sqrt(max(0.0, total))


def blended(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    share: NDArray[np.float64],
    types: Sequence[int],
) -> NDArray[np.float64]:
    """Return configurations at shares of the ways from the first ones to the second ones.

    Args:
        first: a configuration in each row.
        second: the same.
        share: a number for each row.
        types: of the numbers of a configuration.
    """
    gap = second - first
    cyclic = [index for index, kind in enumerate(types) if kind == CYCLIC]
    gap[:, cyclic] -= 2 * math.pi * np.rint(gap[:, cyclic] / (2 * math.pi))
    found = first + share[:, None] * gap
    index = 0
    while index < len(types):
        if types[index] == QUATERNION:
            turns = slice(index, index + 4)
            found[:, turns] = _turned(first[:, turns], second[:, turns], share)
            index += 3
        index += 1
    return found


def _turned(
    first: NDArray[np.float64], second: NDArray[np.float64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return rotations x, y, z, w on the shorter ways, of length 1 and w not negative. Raises CommandError."""
    first, second = _normalised(first), _normalised(second)
    start, scalar = first[:, :3], first[:, 3:]
    between = scalar * second[:, :3] - second[:, 3:] * start - np.cross(start, second[:, :3])
    cosine = np.sum(first * second, axis=1)
    sine = np.linalg.norm(between, axis=1)
    angle = np.arctan2(sine, np.abs(cosine)) * share
    axis = between * (np.where(cosine < 0, -1.0, 1.0) / np.where(sine > _NO_TURN, sine, np.inf))[:, None]
    turn, rest = axis * np.sin(angle)[:, None], np.where(sine > _NO_TURN, np.cos(angle), 1.0)[:, None]
    vector = scalar * turn + rest * start + np.cross(start, turn)
    found = np.hstack([vector, scalar * rest - np.sum(start * turn, axis=1, keepdims=True)])
    return np.where(found[:, 3:] < 0, -found, found)


def _normalised(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(turns, axis=1, keepdims=True)
    if not lengths.all() or not np.isfinite(lengths).all():
        raise CommandError("a quaternion is four finite numbers, not all of them 0")
    return turns / lengths


def checked_types(types: Sequence[int] | None, size: int) -> list[int]:
    """Return the types of a configuration's numbers; all are Cartesian without types. Raises CommandError."""
    if types is None:
        return [CARTESIAN] * size
    wanted = f"types are {size} numbers: 0 Cartesian, 1 cyclic, and 2 four times for a quaternion"
    if len(types) != size:
        raise CommandError(f"{wanted}; not {len(types)} numbers")
    found = list(types)
    index = 0
    while index < len(found) and found[index] in (CARTESIAN, CYCLIC, QUATERNION):
        if found[index] == QUATERNION and found[index : index + 4] != [QUATERNION] * 4:
            break
        index += 4 if found[index] == QUATERNION else 1
    if index != len(found):
        raise CommandError(f"{wanted}; not {found}")
    return found


def _turn(first: Sequence[float], second: Sequence[float]) -> float:
    start, end = wxyz_from_xyzw(first), wxyz_from_xyzw(second)
    return math.hypot(*rotation_vector(multiply(conjugate(start), end)))
