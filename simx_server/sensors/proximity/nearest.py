"""The nearest points of triangles within a volume, for many sensors with the same volume at once.

The nearest point of one triangle in the volume is the foot of the perpendicular, or lies on an edge of the
triangle, or on a surface of the volume. All such points are listed in closed form and those outside are dropped;
only for spherical surfaces (and a disc with an offset) the list is a fan, narrowed until it is exact to about 1e-6
of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import candidates
from .seen import Triangles
from .volume import Array, Volume

_FAN = 48
"""Number of lines over a curved surface in the first round."""
_NARROWINGS = 4
_NARROW_FAN = 17
_WORTH_IT = 1.2
"""A first result is refined unless its square is this many times that of a point known already."""
_SAME = 1e-12
"""Squares that differ by less than this share belong to the same point; then the first triangle has it."""


class Nearest(NamedTuple):
    """Results per sensor (s,)."""

    squares: Array
    """Squared distances in metres^2; unchanged where nothing nearer lies within the volume."""
    points: Array
    """(s, 3) points."""
    rows: NDArray[np.intp]
    """Index of the triangle, -1 where nothing nearer lies within the volume."""


def nearest_points(
    volume: Volume, triangles: Triangles, squares: Array, least_cosine: float = 0.0
) -> Nearest:
    """Return for each sensor the nearest point within the volume that is nearer than the known one.

    Args:
        volume: the volume.
        triangles: the triangles in the sensors' frames.
        squares: (s,) squares of the known distances, infinity for none.
        least_cosine: minimum cosine of the angle between the line of sight and the surface's normal.
    """
    best = _Best(volume, triangles, squares, least_cosine)
    best.keep(volume.lower_bounds(triangles.normals, triangles.heights))
    some = best.triangles
    best.offer(np.concatenate([some.nearest[:, np.newaxis], some.corners], axis=1))
    best.keep(best.triangles.distances)
    if len(best.triangles.rows) == 0:
        return Nearest(best.squares, best.points, best.rows)
    best.offer(candidates.edge_points(volume, best.triangles))
    best.keep(best.triangles.distances)
    _look_inside(best, volume)
    return Nearest(best.squares, best.points, best.rows)


def _look_inside(best: _Best, volume: Volume) -> None:
    """Offer the points where the insides of the triangles meet the surfaces of the volume."""
    some = best.triangles
    if len(some.heights) == 0:
        return
    points = [candidates.face_points(volume, some)] if len(volume.faces) else []
    for sweep in volume.sweeps:
        first, second = sweep.axes
        along = np.arctan2(some.normals[:, second], some.normals[:, first])
        angles = np.stack([along, along + math.pi], axis=1)
        points.append(candidates.line_points(some, sweep, angles))
    if points:
        best.offer(np.concatenate(points, axis=1), inside=True)
    for height, radius in volume.spheres:
        _fan(best, lambda t, a, h=height, r=radius: candidates.circle_points(t, h, r, a), 0.0, 2 * math.pi)
    for sweep in volume.sweeps:
        if not sweep.centred:
            _fan(best, lambda t, a, s=sweep: candidates.line_points(t, s, a), sweep.least, sweep.greatest)


class _Best:
    """For each sensor the nearest of all points offered so far that lie within the volume."""

    def __init__(self, volume: Volume, triangles: Triangles, squares: Array, least_cosine: float) -> None:
        self._volume = volume
        self.triangles = triangles
        self._least_cosine = least_cosine
        self.squares = squares.copy()
        self.points = np.zeros((len(squares), 3))
        self.rows = np.full(len(squares), -1)

    def narrowing(self) -> _Best:
        """Return an empty copy that takes only points that are worth refining."""
        return _Best(self._volume, self.triangles, _WORTH_IT * self.squares, self._least_cosine)

    def merge(self, other: _Best) -> None:
        better = (other.rows >= 0) & (other.squares < self.squares)
        self.squares[better], self.points[better] = other.squares[better], other.points[better]
        self.rows[better] = other.rows[better]

    def keep(self, distances: Array) -> None:
        """Drop triangles that are not seen or, by their distances (n,), farther away than a known point."""
        some = self.triangles
        useful = distances * distances < self.squares[some.views] * (1.0 - _SAME)
        if self._least_cosine > 0:
            useful &= distances * self._least_cosine <= np.abs(some.heights) * (1.0 + _SAME)
        if not useful.all():
            self.triangles = some.take(np.flatnonzero(useful))

    def offer(self, points: Array, *, inside: bool = False) -> NDArray[np.intp]:
        """Offer points (n, m, 3) of the n triangles' planes, nan for none.

        Args:
            points: the points.
            inside: the points may lie outside the triangle.

        Returns:
            For each sensor the column of its new best, or -1 when none is better.
        """
        some = self.triangles
        columns_found = np.full(len(self.squares), -1)
        squares = np.einsum("nmi,nmi->nm", points, points)
        rows, columns = np.nonzero(squares < (self.squares * (1.0 - _SAME))[some.views, np.newaxis])
        if len(rows) == 0:
            return columns_found
        good = self._volume.contains(points[rows, columns])
        if self._least_cosine > 0:
            good &= np.abs(some.heights[rows]) >= self._least_cosine * np.sqrt(squares[rows, columns])
        rows, columns = rows[good], columns[good]
        if inside and len(rows):
            held = some.hold(points[rows, columns], rows)
            rows, columns = rows[held], columns[held]
        if len(rows) == 0:
            return columns_found
        own, views = squares[rows, columns], some.views[rows]
        least = np.full(len(self.squares), np.inf)
        np.minimum.at(least, views, own)
        first = np.flatnonzero(own <= least[views] * (1.0 + _SAME))[::-1]
        chosen = np.full(len(self.squares), -1)
        chosen[views[first]] = (
            first  # the last of several for one sensor counts, which is the first triangle's
        )
        better = np.flatnonzero(chosen >= 0)
        rows, columns = rows[chosen[better]], columns[chosen[better]]
        self.squares[better], self.points[better] = squares[rows, columns], points[rows, columns]
        self.rows[better] = some.rows[rows]
        columns_found[better] = columns
        return columns_found


def _fan(best: _Best, points: Callable[[Triangles, Array], Array], least: float, greatest: float) -> None:
    """Offer the points at angles from `least` to `greatest`, closer and closer around the nearest."""
    own = best.narrowing()
    angles = np.linspace(least, greatest, _FAN + 1)
    columns = own.offer(points(own.triangles, angles), inside=True)
    worth = (columns >= 0)[own.triangles.views]
    if not worth.any():
        return
    own.triangles = some = own.triangles.take(np.flatnonzero(worth))
    middles, spread = angles[columns], (greatest - least) / _FAN
    views = np.arange(len(middles))
    for _ in range(_NARROWINGS):
        offsets = np.linspace(-spread, spread, _NARROW_FAN)
        angles = np.clip(middles[:, np.newaxis] + offsets, least, greatest)
        columns = own.offer(points(some, angles[some.views]), inside=True)
        middles = np.where(columns >= 0, angles[views, columns], middles)
        spread *= 2.0 / (_NARROW_FAN - 1)
    best.merge(own)
