"""A path of CoppeliaSim 4 as a list of numbers: configurations one after the other, and the lengths at which they lie.

A configuration is any numbers of the same count, such as positions, poses (x, y, z, then a quaternion x, y, z, w) or
joint angles. Types say what each number is; without types all are Cartesian.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise

from simx_server.errors import CommandError
from simx_server.scene.geometry.frames import wxyz_from_xyzw, xyzw_from_wxyz
from simx_server.scene.geometry.poses import blend, conjugate, multiply, rotation_vector

CARTESIAN, CYCLIC, QUATERNION = range(3)
"""Types of a number: as it is; an angle where whole turns are equal; one of four of a quaternion."""

LINEAR, BEZIER = "linear", "quadraticBezier"
"""Types of interpolation."""

MOST_NUMBERS = 100_000
"""Numbers of a path: some 14,000 poses. A number takes up to 2 us, one of a quaternion longer."""

Configuration = list[float]
Distance = Callable[[Configuration, Configuration], float]

_LEAST_STRENGTH = 0.05
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
        """Return the configuration at a length from the start; a length outside means the nearer end.

        Args:
            kind: LINEAR or BEZIER.
            strength: share of each way that the Bezier curves take up, 0 to 1.
            is_open: a path whose ends overlap is open too.
        """
        last = len(self.lengths) - 1
        index = min(max(bisect_right(self.lengths, position) - 1, 0), last - 1)
        span = self.lengths[index + 1] - self.lengths[index]
        share = min(max((position - self.lengths[index]) / span, 0.0), 1.0) if span > 0 else 0.0
        start, end = self.point(index), self.point(index + 1)
        half = min(max(strength, _LEAST_STRENGTH), 1.0) / 2
        if kind != BEZIER or half <= share <= 1 - half:
            return blended(start, end, share, self.types)
        is_closed = not is_open and distance(self.point(0), self.point(last), None, self.types) < _SAME
        if share < half:  # the second half of the curve around the start
            if index == 0 and not is_closed:
                return blended(start, end, share, self.types)
            before = self.point(index - 1 if index else last - 1)
            return self._bend(before, start, end, half, 0.5 + share / half / 2)
        if index + 1 == last and not is_closed:
            return blended(start, end, share, self.types)
        after = self.point(index + 2 if index + 1 < last else 1)
        return self._bend(start, end, after, half, (share - 1 + half) / half / 2)

    def _bend(
        self, before: Configuration, middle: Configuration, after: Configuration, half: float, share: float
    ) -> Configuration:
        """Return a point of the quadratic Bezier curve around `middle`, which takes up `half` of both ways."""
        first = blended(before, middle, 1 - half + half * share, self.types)
        second = blended(middle, after, half * share, self.types)
        return blended(first, second, share, self.types)

    def resampled(self, count: int, kind: str, strength: float, *, is_open: bool) -> list[float]:
        """Return the numbers of as many points, at equal lengths. Raises CommandError."""
        if count < 2:
            raise CommandError(f"a path has two points or more, not {count}")
        first, last = self.lengths[0], self.lengths[-1]
        places = [first + (last - first) * step / (count - 1) for step in range(count)]
        return [number for place in places for number in self.at(place, kind, strength, is_open=is_open)]


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
    points = [list(numbers[start : start + size]) for start in range(0, len(numbers), size)]
    found = [0.0]
    for before, point in pairwise(points):
        found.append(
            found[-1] + (math.dist(before[:3], point[:3]) if measure is None else measure(before, point))
        )
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
    first: Sequence[float], second: Sequence[float], share: float, types: Sequence[int]
) -> Configuration:
    """Return the configuration at a share of the way from the first to the second."""
    found: Configuration = []
    index = 0
    while index < len(first):
        if types[index] == QUATERNION:
            start_turn, end_turn = (wxyz_from_xyzw(each[index : index + 4]) for each in (first, second))
            found += xyzw_from_wxyz(blend(start_turn, end_turn, share))
            index += 4
            continue
        start, gap = first[index], second[index] - first[index]
        found.append(start + share * (math.remainder(gap, 2 * math.pi) if types[index] == CYCLIC else gap))
        index += 1
    return found


def checked_types(types: Sequence[int] | None, size: int) -> list[int]:
    """Return the types of a configuration's numbers; all are Cartesian without types. Raises CommandError."""
    if types is None:
        return [CARTESIAN] * size
    found = list(types)
    index = 0
    while index < len(found) and found[index] in (CARTESIAN, CYCLIC, QUATERNION):
        if found[index] == QUATERNION and found[index : index + 4] != [QUATERNION] * 4:
            break
        index += 4 if found[index] == QUATERNION else 1
    if index != len(found) or len(found) != size:
        raise CommandError(
            f"types are {size} numbers: 0 Cartesian, 1 cyclic, and 2 four times for a quaternion; not {found}"
        )
    return found


def _turn(first: Sequence[float], second: Sequence[float]) -> float:
    start, end = wxyz_from_xyzw(first), wxyz_from_xyzw(second)
    return math.hypot(*rotation_vector(multiply(conjugate(start), end)))
