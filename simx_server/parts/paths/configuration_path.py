"""A path through configurations: control points, the points of a smooth way along them, and places on it.

Control points that are nearly equal are merged, and those in a straight line are left out, as in CoppeliaSim 4.11.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simx_server.errors import CommandError

from .configurations import Array, Space

MOST_CONTROL_POINTS, MOST_POINTS = 2000, 10_000
"""Control points, and points of the way."""

_SMOOTHEST = 0.999
_SHARES = np.linspace(0.0, 1.0, 9)
_REFINED, _CANDIDATES = 40, 16
"""Rounds of a search for the nearest point, and the segments in which it goes on."""


@dataclass(frozen=True)
class Rules:
    """How points become a path."""

    is_closed: bool = False
    merged_below: float = 0.02
    """Control points that are nearer to each other are merged; 0: none."""
    straight_below: float = 0.001
    """A control point is left out if it is nearer to the line between its neighbours, as a part of their distance."""
    sampling: float = 0.02
    """Greatest distance between points of the way."""
    smoothing: float = 1.0
    """Strength of the curve at a control point, 0.05 to 1."""
    is_curved: bool = True
    """Whether the way is a curve, and no line from point to point."""
    only_control_points: bool = False


@dataclass(frozen=True)
class Way:
    """Points (n, d) with the distances between them."""

    points: Array
    lengths: Array
    """Of the segments; the last one of a closed way leads back to the first point."""
    is_closed: bool

    @staticmethod
    def of(space: Space, points: Array, *, is_closed: bool) -> Way:
        """Measure the segments."""
        if len(points) < 2:
            return Way(points, np.zeros(0), is_closed)
        second = np.roll(points, -1, axis=0) if is_closed else points[1:]
        return Way(points, space.distances(points if is_closed else points[:-1], second), is_closed)

    @property
    def along(self) -> Array:
        """Return the distance of each point from the first one along the way."""
        sums = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return sums[: len(self.points)]

    @property
    def length(self) -> float:
        """Return the length of the way."""
        return float(np.sum(self.lengths))

    @property
    def ring(self) -> Array:
        """Return the points, of a closed way with the first one at the end."""
        return (
            np.vstack([self.points, self.points[:1]]) if self.is_closed and len(self.points) else self.points
        )


class ConfigurationPath:
    """A path; `control` and `way` are what its points make."""

    def __init__(self, space: Space, rules: Rules) -> None:
        self.space, self.rules = space, rules
        self.control = self.way = self._measured(np.zeros((0, len(space))))
        self._pending: list[Array] = []

    def set_points(self, points: Array) -> None:
        """Replace the control points (n, d). Raises CommandError."""
        self._pending = []
        points = self.space.checked(points)
        _check_control(len(points))
        if len(points) > 1 and self.rules.merged_below > 0:
            points = _repeated(points, self._merged)
        if len(points) > 1 and self.rules.straight_below > 0:
            points = _repeated(points, self._straightened)
        self.keep(points)

    def keep(self, points: Array) -> None:
        """Take over control points that are merged already, and make the way."""
        self.control = self._measured(points)
        if self.rules.only_control_points or len(points) < 2:
            self.way = self.control
        else:
            self.way = self._measured(self._sampled(points))

    def append(self, points: Array, *, update: bool) -> None:
        """Add control points (n, d). `update`: at once; otherwise with the next update."""
        points = self.space.checked(points)
        _check_control(len(self.control.points) + len(self._pending) + len(points))
        self._pending += list(points)
        if update:
            self.update()

    def append_moved(self, point: Array, *, update: bool) -> None:
        """Add a control point (d,), unless it is where the last one is."""
        (point,) = self.space.checked(point[None])
        last = (
            self._pending[-1]
            if self._pending
            else self.control.points[-1]
            if len(self.control.points)
            else None
        )
        if last is None or self.space.distance(last, point) >= self.rules.merged_below:
            self.append(point[None], update=update)

    def update(self) -> bool:
        """Take over points that were added without an update; return whether there were some."""
        if not self._pending:
            return False
        self.set_points(np.vstack([self.control.points, *self._pending]))
        return True

    def at(self, share: float) -> Array:
        """Return the point at a share of the length, 0 to 1. Raises CommandError: the path is empty."""
        way = self._not_empty()
        if len(way.points) == 1:
            return way.points[0]
        wanted = min(max(share, 0.0), 1.0) * way.length
        ends = np.cumsum(way.lengths)
        index = int(np.searchsorted(ends, wanted, side="right"))
        ring = way.ring
        if index >= len(way.lengths):
            return ring[-1]
        begin = ends[index] - way.lengths[index]
        return self.space.between(ring[index], ring[index + 1], float((wanted - begin) / way.lengths[index]))

    def nearest(self, point: Array) -> tuple[Array, float]:
        """Return the nearest point of the way, and its share of the length. Raises CommandError: the path is empty."""
        (point,) = self.space.checked(point[None])
        way = self._not_empty()
        if len(way.points) == 1:
            return way.points[0], 0.0
        ring, count = way.ring, len(way.lengths)
        rough = [
            self._from(point, ring[:count], ring[1 : count + 1], np.full(count, each)) for each in _SHARES
        ]
        near = np.argsort(np.min(rough, axis=0), kind="stable")[:_CANDIDATES]
        first, second = ring[near], ring[near + 1]
        low, high = np.zeros(len(near)), np.ones(len(near))
        for _ in range(_REFINED):  # by thirds
            left, right = low + (high - low) / 3, high - (high - low) / 3
            is_left = self._from(point, first, second, left) <= self._from(point, first, second, right)
            low, high = np.where(is_left, low, left), np.where(is_left, right, high)
        shares = np.array([np.zeros(len(near)), (low + high) / 2, np.ones(len(near))])
        distances = np.array([self._from(point, first, second, each) for each in shares])
        row, place = divmod(int(np.argmin(distances)), len(near))
        index, share = int(near[place]), float(shares[row][place])
        passed = float(np.sum(way.lengths[:index])) + share * float(way.lengths[index])
        found = self.space.between(ring[index], ring[index + 1], share)
        return found, passed / way.length if way.length else 0.0

    def _from(self, point: Array, first: Array, second: Array, shares: Array) -> Array:
        places = self.space.between(first, second, shares)
        return self.space.distances(np.broadcast_to(point, places.shape), places)

    def _not_empty(self) -> Way:
        self.update()
        if not len(self.way.points):
            raise CommandError("the path is empty: give it points with setPoints")
        return self.way

    def _measured(self, points: Array) -> Way:
        return Way.of(self.space, points, is_closed=self.rules.is_closed)

    # --- control points --------------------------------------------------------------------------

    def _merged(self, points: Array) -> Array:
        """Return control points after one round of merging."""
        least, far = (3 if self.rules.is_closed else 2), self.rules.merged_below
        found = list(np.vstack([points, points[:1]])) if self.rules.is_closed else list(points)
        distance = self.space.distance
        if len(found) > least:
            while len(found) > 2 and distance(found[0], found[1]) < far:
                del found[1]
        if len(found) > least:
            while len(found) > 2 and distance(found[-1], found[-2]) < far:
                del found[-2]
        if len(found) > least:
            inner, place = [found[0]], 1
            while place < len(found) - 2:
                if distance(found[place], found[place + 1]) >= far:
                    inner.append(found[place])
                else:
                    inner.append(self.space.between(found[place], found[place + 1], 0.5))
                    place += 1
                place += 1
            found = [*inner, *found[place:]]
        return np.array(found[:-1] if self.rules.is_closed else found)

    def _straightened(self, points: Array) -> Array:
        """Return control points after one round of leaving out those in straight lines."""
        ring = np.vstack([points, points[:1]]) if self.rules.is_closed else points
        count = len(ring) - 3
        if count <= 0:
            return points
        first, middle, last = ring[:count], ring[1 : count + 1], ring[2 : count + 2]
        before, after = self.space.distances(first, middle), self.space.distances(middle, last)
        across = self.space.distances(first, last)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.nan_to_num(before / (before + after))
            off = self.space.distances(self.space.between(first, last, share), middle) / across
        is_straight = np.flatnonzero(off < self.rules.straight_below)
        gone: set[int] = set()
        for place in sorted(is_straight.tolist(), key=lambda each: (off[each], each)):
            if place - 1 not in gone and place + 1 not in gone:  # those were judged with this point
                gone.add(place)
        kept = [place for place in range(len(ring)) if place - 1 not in gone]
        return ring[kept[:-1]] if self.rules.is_closed else ring[kept]

    # --- the way ---------------------------------------------------------------------------------

    def _sampled(self, points: Array) -> Array:
        if self.rules.is_curved:
            points = self._curved(points)
        return self._evenly(points)

    def _evenly(self, points: Array) -> Array:
        """Return points at equal distances along lines."""
        way = self._measured(points)
        ring, lengths = way.ring, way.lengths
        _check_count(way.length / self.rules.sampling)
        pieces = math.floor(way.length / self.rules.sampling) + 1
        wanted = way.length / pieces * np.arange(1.0, pieces)
        found = np.vstack([ring[:1], self._at(ring, lengths, wanted)])
        return found if self.rules.is_closed else np.vstack([found, ring[-1:]])

    def _at(self, ring: Array, lengths: Array, wanted: Array) -> Array:
        index, share = _places(lengths, wanted)
        return self.space.between(ring[index], ring[index + 1], share)

    def _curved(self, points: Array) -> Array:
        """Return points of quadratic Bezier curves: each leads from the middle of a segment to that of the next."""
        way, between = self._measured(points), self.space.between
        ring, lengths = way.ring, way.lengths
        if self.rules.is_closed:
            before, after = ring[-2], ring[1]
        else:
            before, after = between(ring[1], ring[0], 2.0), between(ring[-2], ring[-1], 2.0)
        extended = np.vstack([before[None], ring, after[None]])
        _check_count(2 * way.length / self.rules.sampling)
        pieces = math.floor(2 * way.length / self.rules.sampling) + 1
        index, share = _places(lengths, way.length / pieces * np.arange(pieces + 1.0))
        is_late = share >= 0.5
        corner = index + 1 + is_late
        along = np.where(is_late, share - 0.5, share + 0.5)
        middle = extended[corner]
        first = between(extended[corner - 1], middle, np.full(len(corner), 0.5))
        last = between(middle, extended[corner + 1], np.full(len(corner), 0.5))
        if self.rules.smoothing < _SMOOTHEST:
            strength = np.full(len(corner), self.rules.smoothing)
            first, last = between(middle, first, strength), between(middle, last, strength)
        found = between(between(first, middle, along), between(middle, last, along), along)
        return found if self.rules.is_closed else np.vstack([found, ring[-1:]])


def _places(lengths: Array, wanted: Array) -> tuple[np.ndarray, Array]:
    """Return the segments and the shares of them at which distances along a way end."""
    ends = np.cumsum(lengths)
    index = np.minimum(np.searchsorted(ends, wanted, side="left"), len(lengths) - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.nan_to_num((wanted - (ends[index] - lengths[index])) / lengths[index])
    return index, np.clip(share, 0.0, 1.0)


def _repeated(points: Array, once: Callable[[Array], Array]) -> Array:
    """Return points after as many rounds as change something."""
    while True:
        fewer = once(points)
        if len(fewer) == len(points):
            return points
        points = fewer


def _check_control(count: int) -> None:
    if count > MOST_CONTROL_POINTS:
        raise CommandError(f"a path has at most {MOST_CONTROL_POINTS} control points, not {count}")


def _check_count(count: float) -> None:
    if count > MOST_POINTS:
        raise CommandError(
            f"a path has at most {MOST_POINTS} points; give fewer, or a greater samplingDistance"
        )
