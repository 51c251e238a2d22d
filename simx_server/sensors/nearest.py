"""The nearest point of a set of triangles within a sensor's volume, seen from the sensor's origin.

The nearest point of one triangle in the volume is the foot of the perpendicular, or lies on an edge of the triangle, or
on a surface of the volume. All such points are listed in closed form and those outside are dropped; only for spherical
surfaces (and a disc with an offset) the list is a fan, narrowed until it is exact to about 1e-6 of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .volume import Array, Sweep, Volume

_FAN = 48
"""Lines over a curved surface in the first look."""
_NARROWINGS = 4
_NARROW_FAN = 17
_NEXT = [1, 2, 0]
_WORTH_IT = 1.2
"""A first look is narrowed unless its square is this many times that of a point known already."""


def cross(a: Array, b: Array) -> Array:
    """(..., 3); several times as fast as numpy's for a few hundred vectors."""
    found = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(a[..., j] * b[..., k], a[..., k] * b[..., j], out=found[..., i])
    return found


@dataclass(frozen=True, eq=False)
class Triangles:
    """Triangles in the sensor's frame, without degenerate ones."""

    corners: Array
    """(n, 3, 3)."""
    normals: Array
    """(n, 3) unit, outward."""
    heights: Array
    """(n,) normal . point of the plane: below 0 where the sensor sees the front."""

    @classmethod
    def of(cls, corners: Array) -> tuple[Triangles, NDArray[np.intp]]:
        """The triangles, and which of the given ones they are."""
        product = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.sqrt(np.einsum("ni,ni->n", product, product))
        kept = np.flatnonzero(length > 1e-16)
        corners = corners[kept]
        normals = product[kept] / length[kept, np.newaxis]
        return cls(corners, normals, np.einsum("ni,ni->n", normals, corners[:, 0])), kept

    def take(self, chosen: NDArray[np.intp]) -> Triangles:
        return Triangles(self.corners[chosen], self.normals[chosen], self.heights[chosen])

    @cached_property
    def edges(self) -> Array:
        """(n, 3, 3): from each corner to the next."""
        return self.corners[:, _NEXT] - self.corners

    @cached_property
    def _sides(self) -> tuple[Array, Array]:
        """Per edge the direction inwards, and the least product with it of a point inside."""
        inward = cross(self.normals[:, np.newaxis], self.edges)
        least = np.einsum("nei,nei->ne", inward, self.corners)
        slack = 1e-9 * np.sqrt(np.einsum("nei,nei->ne", inward, inward))
        return inward, least - slack

    def hold(self, points: Array, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(m,): whether points (m, 3), each of the plane of one triangle, lie within that triangle."""
        inward, least = self._sides
        return np.all(np.einsum("mi,mei->me", points, inward[rows]) >= least[rows], axis=1)

    @cached_property
    def along(self) -> Array:
        """(n, 3): how far along each edge (0..1) it is nearest to the origin."""
        squares = np.einsum("nei,nei->ne", self.edges, self.edges)
        return np.clip(-np.einsum("nei,nei->ne", self.corners, self.edges) / squares, 0.0, 1.0)

    @cached_property
    def distances(self) -> Array:
        """(n,) from the origin."""
        points = self.corners + self.along[..., np.newaxis] * self.edges
        distance = np.sqrt(np.einsum("nei,nei->ne", points, points).min(axis=1))
        feet = self.normals * self.heights[:, np.newaxis]
        return np.where(self.hold(feet, np.arange(len(feet))), np.abs(self.heights), distance)


def nearest_point(
    volume: Volume, triangles: Triangles, least_cosine: float = 0.0
) -> tuple[float, Array, int] | None:
    """(distance, point (3,), index of the triangle), or None when nothing lies within the volume.

    `least_cosine`: of the angle between the line of sight and the surface's normal, above which a surface is seen.
    """
    if len(triangles.heights) == 0:
        return None
    some, kept = triangles, np.arange(len(triangles.heights))
    if least_cosine <= 0:
        close = np.flatnonzero(some.distances <= _upper_bound(volume, some) + 1e-12)
        some, kept = some.take(close), kept[close]
    best = _Best(volume, some, least_cosine)
    best.offer(_edge_points(volume, some))
    best.offer((some.normals * some.heights[:, np.newaxis])[:, np.newaxis], inside=True)
    close = np.flatnonzero(some.distances**2 < best.square)
    if len(close):
        inner = _Best(volume, some.take(close), least_cosine)
        _look_inside(inner, volume)
        if inner.square < best.square:
            best, kept = inner, kept[close]
    if best.point is None:
        return None
    return math.sqrt(best.square), best.point, int(kept[best.index])


def _look_inside(best: _Best, volume: Volume) -> None:
    """Offer where the insides of the triangles meet the surfaces of the volume."""
    some = best.triangles
    for face in volume.faces:
        best.offer(_face_points(volume, some, face), inside=True)
    for height, radius in volume.spheres:
        _fan(best, lambda a, h=height, r=radius: _circle_points(some, h, r, a), 0.0, 2 * math.pi)
    for sweep in volume.sweeps:
        first, second = sweep.axes
        along = np.arctan2(some.normals[:, second], some.normals[:, first])
        best.offer(_line_points(some, sweep, np.stack([along, along + math.pi], axis=1)), inside=True)
        if not sweep.centred:
            _fan(best, lambda a, s=sweep: _line_points(some, s, a), sweep.least, sweep.greatest)


class _Best:
    """The nearest of all points offered so far that lie within the volume."""

    def __init__(self, volume: Volume, triangles: Triangles, least_cosine: float) -> None:
        self._volume = volume
        self.triangles = triangles
        self._least_cosine = least_cosine
        self.square = math.inf
        self.point: Array | None = None
        self.index = -1

    def fresh(self) -> _Best:
        """One that knows no point yet."""
        return _Best(self._volume, self.triangles, self._least_cosine)

    def merge(self, other: _Best) -> None:
        if other.square < self.square:
            self.square, self.point, self.index = other.square, other.point, other.index

    def offer(self, points: Array, *, inside: bool = False) -> int:
        """Points (n, m, 3) of the n triangles' planes, nan for none. `inside`: they may lie outside the triangle.

        Returns the column of the new best, or -1 when none is better.
        """
        squares = np.einsum("nmi,nmi->nm", points, points)
        rows, columns = np.nonzero(squares < self.square)
        if len(rows) == 0:
            return -1
        chosen = points[rows, columns]
        good = self._volume.contains(chosen)
        if self._least_cosine > 0:
            heights = np.abs(self.triangles.heights[rows])
            good &= heights >= self._least_cosine * np.sqrt(squares[rows, columns])
        rows, columns = rows[good], columns[good]
        if inside and len(rows):
            held = self.triangles.hold(points[rows, columns], rows)
            rows, columns = rows[held], columns[held]
        if len(rows) == 0:
            return -1
        first = int(np.argmin(squares[rows, columns]))
        self.index = int(rows[first])
        self.square = float(squares[rows[first], columns[first]])
        self.point = points[rows[first], columns[first]]
        return int(columns[first])


def _upper_bound(volume: Volume, triangles: Triangles) -> float:
    """No more than the distance of the nearest corner that is in the volume."""
    corners = triangles.corners.reshape(-1, 3)
    seen = volume.contains(corners)
    return math.sqrt(float((corners[seen] ** 2).sum(axis=1).min())) if seen.any() else math.inf


def _edge_points(volume: Volume, triangles: Triangles) -> Array:
    """(n, 3 m, 3): nearest points and ends of the edges, and where they cross the volume's surfaces."""
    corners, edges, along = triangles.corners, triangles.edges, triangles.along
    count = len(corners)
    crossings = volume.crossings(corners.reshape(-1, 3), edges.reshape(-1, 3)).reshape(count, 3, -1)
    crossings = np.where((crossings >= 0.0) & (crossings <= 1.0), crossings, np.nan)
    where = np.concatenate([along[..., np.newaxis], np.zeros((count, 3, 1)), crossings], axis=2)
    points = corners[:, :, np.newaxis] + where[..., np.newaxis] * edges[:, :, np.newaxis]
    return points.reshape(count, -1, 3)


def _face_points(volume: Volume, triangles: Triangles, face: Array) -> Array:
    """(n, m, 3): the line in which each plane cuts a face: its nearest point and its crossings with the surfaces."""
    normal, distance = face[:3], face[3]
    cosine = triangles.normals @ normal
    sine2 = 1.0 - cosine * cosine
    with np.errstate(divide="ignore", invalid="ignore"):
        own = (triangles.heights - distance * cosine) / sine2
        other = (distance - triangles.heights * cosine) / sine2
    parallel = sine2 < 1e-14
    own[parallel] = other[parallel] = np.nan
    closest = own[:, np.newaxis] * triangles.normals + other[:, np.newaxis] * normal
    direction = cross(triangles.normals, normal)
    where = volume.crossings(closest, direction)
    points = closest[:, np.newaxis] + where[..., np.newaxis] * direction[:, np.newaxis]
    return np.concatenate([closest[:, np.newaxis], points], axis=1)


def _circle_points(triangles: Triangles, height: float, radius: float, angles: Array) -> Array:
    """(n, m, 3): the circle in which each plane cuts a sphere; at angle 0 its point nearest to the origin."""
    centre = np.array([0.0, 0.0, height])
    away = triangles.heights - triangles.normals @ centre
    middle = centre + away[:, np.newaxis] * triangles.normals
    with np.errstate(invalid="ignore"):
        extent = np.sqrt(radius * radius - away * away)
    towards = triangles.heights[:, np.newaxis] * triangles.normals - middle
    length = np.sqrt(np.einsum("ni,ni->n", towards, towards))
    any_direction = triangles.corners[:, 1] - triangles.corners[:, 0]
    towards = np.where(length[:, np.newaxis] > 1e-9, towards, any_direction)
    towards /= np.sqrt(np.einsum("ni,ni->n", towards, towards))[:, np.newaxis]
    across = cross(triangles.normals, towards)
    turn = np.stack([np.cos(angles), np.sin(angles)])
    ring = np.einsum("dm,dni->nmi", turn, np.stack([towards, across]))
    return middle[:, np.newaxis] + extent[:, np.newaxis, np.newaxis] * ring


def _fan(best: _Best, points: Callable[[Array], Array], least: float, greatest: float) -> None:
    """Offer the points at angles from `least` to `greatest`, closer and closer about the nearest."""
    own = best.fresh()
    angles = np.linspace(least, greatest, _FAN + 1)
    column = own.offer(points(angles), inside=True)
    if column < 0 or own.square > _WORTH_IT * best.square:
        return
    angle, spread = angles[column], (greatest - least) / _FAN
    for _ in range(_NARROWINGS):
        angles = np.clip(np.linspace(angle - spread, angle + spread, _NARROW_FAN), least, greatest)
        column = own.offer(points(angles), inside=True)
        if column >= 0:
            angle = angles[column]
        spread *= 2.0 / (_NARROW_FAN - 1)
    best.merge(own)


def _line_points(triangles: Triangles, sweep: Sweep, angles: Array) -> Array:
    """(n, m, 3): where lines of a sweep cross each triangle's plane; angles (m,), or (n, m) for each its own."""
    starts, ends = sweep.lines(angles)
    directions = ends - starts
    normals = triangles.normals[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        where = (triangles.heights[:, np.newaxis] - (normals * starts).sum(axis=2)) / (
            normals * directions
        ).sum(axis=2)
    where = np.where((where >= 0.0) & (where <= 1.0), where, np.nan)
    return starts + where[..., np.newaxis] * directions
