"""Configurations: points of several coordinates, which are lengths, angles and quaternions; distance and interpolation.

A configuration is a row of numbers. A quaternion x, y, z, w takes four coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

Array = NDArray[np.float64]

MOST_COORDINATES = 100

_NEARLY_EQUAL = 0.9995
"""Scalar product of quaternions above which their interpolation is a straight line."""


class Coordinate(IntEnum):
    """The kinds of numbers of a configuration."""

    LINEAR = 0
    ANGLE = 1
    """Without bounds it is cyclic: the shorter way counts."""
    QUATERNION = 2
    """One of four consecutive numbers."""


POSE = (Coordinate.LINEAR,) * 3 + (Coordinate.QUATERNION,) * 4

Bounds = tuple[float, float]


@dataclass(frozen=True)
class Space:
    """The coordinates of configurations."""

    kinds: tuple[Coordinate, ...]
    metric: tuple[float, ...]
    """A weight of each coordinate; of a quaternion the first one counts."""
    bounds: tuple[Bounds | None, ...]

    @staticmethod
    def of(
        kinds: Sequence[Coordinate], metric: Sequence[float] | None, bounds: Sequence[Bounds | None] | None
    ) -> Space:
        """Return a space. Raises CommandError: the lists do not fit."""
        count = len(kinds)
        if not 1 <= count <= MOST_COORDINATES:
            raise CommandError(f"a path has 1 to {MOST_COORDINATES} coordinates, not {count}")
        weights = [1.0] * count if metric is None else metric
        limits = [None] * count if bounds is None else bounds
        if len(weights) != count or len(limits) != count:
            raise CommandError(f"'metric' and 'bounds' have an item for each of the {count} coordinates")
        place = 0
        while place < count:
            if kinds[place] != Coordinate.QUATERNION:
                place += 1
                continue
            if list(kinds[place : place + 4]) != [Coordinate.QUATERNION] * 4:
                raise CommandError("a quaternion is four consecutive coordinates of type 'quat'")
            place += 4
        limits = [
            None if kind == Coordinate.QUATERNION else each for kind, each in zip(kinds, limits, strict=True)
        ]
        return Space(tuple(kinds), tuple(weights), tuple(limits))

    def __len__(self) -> int:
        return len(self.kinds)

    @cached_property
    def _cyclic(self) -> NDArray[np.bool_]:
        pairs = zip(self.kinds, self.bounds, strict=True)
        return np.array([kind == Coordinate.ANGLE and bounds is None for kind, bounds in pairs], dtype=bool)

    @cached_property
    def _plain(self) -> NDArray[np.bool_]:
        """Return which coordinates belong to no quaternion."""
        return np.array([kind != Coordinate.QUATERNION for kind in self.kinds], dtype=bool)

    @cached_property
    def _quaternions(self) -> list[int]:
        """Return the first coordinate of each quaternion."""
        places, found, place = self.kinds, list[int](), 0
        while place < len(places):
            if places[place] == Coordinate.QUATERNION:
                found.append(place)
                place += 3
            place += 1
        return found

    @cached_property
    def _weights(self) -> Array:
        return np.array(self.metric, dtype=float)

    def checked(self, points: Array) -> Array:
        """Return configurations (n, d) with quaternions of length 1. Raises CommandError: others."""
        if points.ndim != 2 or points.shape[1] != len(self):
            raise CommandError(f"a point of this path has {len(self)} coordinates")
        points = np.array(points, dtype=float)
        for place in self._quaternions:
            part = points[:, place : place + 4]
            lengths = np.linalg.norm(part, axis=1, keepdims=True)
            if not np.all(np.isfinite(lengths)) or np.any(lengths < 1e-12):
                raise CommandError("a quaternion of a point has the length 0")
            part /= lengths
        return points

    def differences(self, first: Array, second: Array) -> Array:
        """Return second minus first (n, d), of cyclic angles along the shorter way; those of quaternions are 0."""
        found = np.where(self._plain, second - first, 0.0)
        turns = found[..., self._cyclic]
        found[..., self._cyclic] = np.arctan2(np.sin(turns), np.cos(turns))
        return found

    def distances(self, first: Array, second: Array) -> Array:
        """Return the distances (n,) between configurations (n, d)."""
        squares = np.sum((self.differences(first, second) * self._weights) ** 2, axis=-1)
        for place in self._quaternions:
            part = slice(place, place + 4)
            product = np.abs(np.sum(first[..., part] * second[..., part], axis=-1))
            squares = squares + (2 * np.arccos(np.minimum(product, 1.0)) * self.metric[place]) ** 2
        return np.sqrt(squares)

    def distance(self, first: Array, second: Array) -> float:
        """Return the distance between two configurations (d,)."""
        return float(self.distances(first, second))

    def between(self, first: Array, second: Array, share: Array | float) -> Array:
        """Return configurations (n, d) on the way from `first` (share 0) to `second` (1), which may lie beyond."""
        shares = np.asarray(share, dtype=float)[..., None]
        found = first + self.differences(first, second) * shares
        turns = found[..., self._cyclic]
        found[..., self._cyclic] = np.arctan2(np.sin(turns), np.cos(turns))
        for place in self._quaternions:
            part = slice(place, place + 4)
            found[..., part] = _slerp(first[..., part], second[..., part], shares)
        return found


def _slerp(first: Array, second: Array, share: Array) -> Array:
    product = np.sum(first * second, axis=-1, keepdims=True)
    second = np.where(product < 0, -second, second)
    product = np.abs(product)
    angle = np.arccos(np.minimum(product, 1.0))
    sine = np.where(product > _NEARLY_EQUAL, 1.0, np.sin(angle))
    straight = product > _NEARLY_EQUAL
    left = np.where(straight, 1 - share, np.sin((1 - share) * angle) / sine)
    right = np.where(straight, share, np.sin(share * angle) / sine)
    found = left * first + right * second
    return found / np.maximum(np.linalg.norm(found, axis=-1, keepdims=True), 1e-12)


def limits_that_turn(space: Space) -> list[tuple[float, float] | None]:
    """Return least value and range of the angles that can turn further than once; None for other coordinates."""
    return [
        (bounds[0], bounds[1] - bounds[0])
        if kind == Coordinate.ANGLE and bounds is not None and bounds[1] - bounds[0] > math.tau
        else None
        for kind, bounds in zip(space.kinds, space.bounds, strict=True)
    ]
