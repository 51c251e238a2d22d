"""The convex polygons of a mesh's surface: neighbouring triangles in one plane, joined as far as they stay convex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.geometry.topology import Faces, Points, area_vectors, welded

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

_PLANAR = 1e-4
"""Distance from a plane, in sizes of a mesh, up to which a point lies in it."""

_STRAIGHT = 1e-6
"""Sine of an angle up to which an edge goes on straight ahead."""


_SHARP = 1e-3
"""Cosine of the angle between normals from which on a face looks to the back."""


@dataclass
class Facet:
    """A convex polygon."""

    corners: Array
    """(n, 3), counter-clockwise seen from the front."""
    normal: Array
    """(3,), a unit vector to the front."""
    limits: list[tuple[Array, float]]
    """Planes of faces at its corners that bend back by more than a right angle, with this facet behind them: the unit
    normal, and how far along it the plane lies.
    """


def facets_of(points: Points, faces: Faces) -> list[Facet]:
    """Return the surface of a mesh as convex polygons, the same ones each time."""
    points, faces = welded(points, faces)
    faces = faces[(faces != faces[:, [1, 2, 0]]).all(axis=1)]
    if not len(faces):
        return []
    return _Joining(points.astype(np.float64), faces).run()


class _Joining:
    """Joins triangles over their common edges, the longest first."""

    def __init__(self, points: Array, faces: Faces) -> None:
        vectors = area_vectors(points, faces)
        areas = np.linalg.norm(vectors, axis=1)
        self._points, self._normals = points, vectors / areas[:, np.newaxis]
        self._areas: list[float] = areas.tolist()
        self._at: list[Vector] = [(x, y, z) for x, y, z in points.tolist()]
        self._loops: list[list[int]] = faces.tolist()
        self._tolerance = _PLANAR * float(np.ptp(points[faces.ravel()], axis=0).max())
        self._polygon = list(range(len(faces)))
        """For each face its polygon, or a face that leads there."""
        self._face_at: dict[tuple[int, int], int] = {}
        """Face at each directed edge; an edge of several faces is left out."""
        self._faces_at: list[list[int]] = [[] for _ in points]
        for face, loop in enumerate(self._loops):
            for at in loop:
                self._faces_at[at].append(face)
        crowded: set[tuple[int, int]] = set()
        for face, loop in enumerate(self._loops):
            for edge in _edges(loop):
                if edge in self._face_at:
                    crowded.add(edge)
                self._face_at[edge] = face
        for edge in crowded:
            del self._face_at[edge]

    def run(self) -> list[Facet]:
        inner = [(a, b) for a, b in self._face_at if a < b and (b, a) in self._face_at]
        ends = np.array(inner, np.int64).reshape(-1, 2)
        lengths = np.linalg.norm(self._points[ends[:, 1]] - self._points[ends[:, 0]], axis=1)
        order: list[int] = np.argsort(-lengths, kind="stable").tolist()
        for place in order:
            self._join(*inner[place])
        return [
            self._facet(face, loop)
            for face, loop in enumerate(self._loops)
            if loop and self._polygon[face] == face
        ]

    def _owner(self, edge: tuple[int, int]) -> int | None:
        face = self._face_at.get(edge)
        if face is None:
            return None
        while self._polygon[face] != face:
            self._polygon[face] = face = self._polygon[self._polygon[face]]
        return face

    def _join(self, a: int, b: int) -> None:
        one, other = self._owner((a, b)), self._owner((b, a))
        if one is None or other is None or one == other:
            return
        if self._areas[one] < self._areas[other]:  # a sliver does not know its plane well
            one, other, a, b = other, one, b, a
        normal = _vector(self._normals[one])
        if not self._is_in_plane(self._loops[other], self._at[a], normal):
            return
        if float(self._normals[one] @ self._normals[other]) <= 0:
            return
        first, second = self._loops[one], self._loops[other]
        here, there = first.index(b), second.index(a)
        joined = _without_spikes(first[here:] + first[:here] + (second[there:] + second[:there])[1:-1])
        if self._is_convex(joined, normal):
            self._loops[one], self._loops[other] = joined, []
            self._polygon[other] = one

    def _is_in_plane(self, loop: list[int], origin: Vector, normal: Vector) -> bool:
        level = _dot(origin, normal)
        return all(abs(_dot(self._at[each], normal) - level) <= self._tolerance for each in loop)

    def _is_convex(self, loop: list[int], normal: Vector) -> bool:
        if len(loop) < 3 or len(set(loop)) < len(loop):
            return False
        at = [self._at[each] for each in loop]
        sides = [_minus(after, before) for before, after in zip(at, at[1:] + at[:1], strict=True)]
        for side, following in zip(sides, sides[1:] + sides[:1], strict=True):
            turn, least = _dot(_cross(side, following), normal), _STRAIGHT * _product(side, following)
            if turn < -least or (turn <= least and _dot(side, following) < 0):
                return False
        return True

    def _facet(self, face: int, loop: list[int]) -> Facet:
        """Return a polygon without the corners at which it goes on straight ahead."""
        normal = _vector(self._normals[face])
        bends = [place for place in range(len(loop)) if self._bends(loop, place, normal)]
        corners = self._points[[loop[place] for place in (bends if len(bends) >= 3 else range(len(loop)))]]
        return Facet(corners, self._normals[face], self._limits(face, loop, corners))

    def _bends(self, loop: list[int], place: int, normal: Vector) -> bool:
        before, at, after = (self._at[loop[(place + step) % len(loop)]] for step in (-1, 0, 1))
        side, following = _minus(at, before), _minus(after, at)
        return _dot(_cross(side, following), normal) > _STRAIGHT * _product(side, following)

    def _limits(self, face: int, loop: list[int], corners: Array) -> list[tuple[Array, float]]:
        around = {(other, at) for at in loop for other in self._faces_at[at]}
        found: list[tuple[Array, float]] = []
        for other, at in sorted(around):
            normal = self._normals[other]
            level = float(normal @ self._points[at])
            is_back = float(normal @ self._normals[face]) < -_SHARP
            if is_back and float((corners @ normal).max()) <= level + self._tolerance:
                found.append((normal, level))
        return found


def _edges(loop: list[int]) -> list[tuple[int, int]]:
    return list(zip(loop, loop[1:] + loop[:1], strict=True))


def _without_spikes(loop: list[int]) -> list[int]:
    """Return a loop without the edges that it goes there and back."""
    place = 0
    while len(loop) > 2 and place < len(loop):
        if loop[place - 1] == loop[(place + 1) % len(loop)]:
            doomed = {place, (place + 1) % len(loop)}
            loop = [each for number, each in enumerate(loop) if number not in doomed]
            place = 0
        else:
            place += 1
    return loop


def _vector(row: Array) -> Vector:
    x, y, z = row.tolist()
    return x, y, z


def _product(a: Vector, b: Vector) -> float:
    """Return the product of two lengths."""
    return (_dot(a, a) * _dot(b, b)) ** 0.5


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
