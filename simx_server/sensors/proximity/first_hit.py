"""The first surface that one ray meets, for sensors that are read one at a time, as a turning scanner does.

The geoms and triangles are the same as in `detection.py`, which examines many sensors together, and so are the numbers
to the last bit: here only more of what the ray misses is left out before it is computed exactly, by
`native/_first_hit.c` or, where that is not compiled, here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import CURVED, Array, true_surface
from simx_server.scene.poses.poses import Vector
from simx_server.sensors.instant import Instant

from .optics import Optics

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
MET_BY_RAYS = frozenset((*CURVED, _PLANE))
"""Types of geoms whose surfaces MuJoCo's rays meet as sensors do; rays do not meet the back of a box."""

_SLACK = 1e-6
"""Metres, and a share of lengths: more than rounding, so nothing that the ray meets is left out."""

_THIN = 1e-16
"""Twice the area in square metres up to which a triangle has no normal, as in `seen.Triangles`."""

_BOX = int(mujoco.mjtGeom.mjGEOM_BOX)
_VERY_FEW = 6
"""Triangles that are quicker examined one after the other."""

_AXES = (0, 1, 2), (1, 2, 0), (2, 0, 1)


FACES = {"both": 0, "front": 1, "back": 2}
"""The sides of surfaces that a sensor sees, by the numbers of the compiled form."""


class Hit(NamedTuple):
    """Where a ray meets a surface."""

    distance: float
    """Metres from the sensor's origin."""
    normal: Vector
    """Unit vector in the sensor's frame, outward from the surface."""
    geom: int


class _View(NamedTuple):
    """A geom and the ray."""

    turn: Array
    """(3, 3): rows are the geom's axes in the sensor's frame."""
    place: Array
    """(3,): the geom's origin in the sensor's frame."""
    start: list[float]
    direction: list[float]
    """The sensor's origin and z axis in the geom's frame."""
    faces: list[tuple[float, int]]
    """Where the ray's line meets the faces of the box around the geom: height and number of the face."""


def first_hit(
    instant: Instant, looks: Optics, origin: Array, rotation: Array, wanted: NDArray[np.bool_]
) -> Hit | None:
    """Return the first surface on the segment of a sensor's z axis that the sensor sees.

    Args:
        instant: the world.
        looks: the sensor's optics, a ray.
        origin: (3,) position of the sensor in the world.
        rotation: (3, 3) in the world; the columns are the sensor's axes.
        wanted: (ngeom,) the geoms to detect.
    """
    places = (instant.geom_xpos - origin).dot(rotation)  # as `@` does, in half the time
    compiled = instant.surroundings.for_rays
    if compiled is None:
        ray = _Ray(instant, looks, origin, rotation, places)
        ray.search(wanted)
        return ray.best
    geom, row, distance, normal, others = compiled.first(
        places, instant.geom_xmat, rotation, wanted,
        looks.offset, looks.reach, FACES[looks.faces], looks.least_cosine,
    )  # fmt: skip
    best = Hit(looks.offset + distance, normal, geom) if geom >= 0 else None
    if not others:
        return best
    ray = _Ray(instant, looks, origin, rotation, places)
    if best is not None:
        ray.best, ray.reach, ray.order = best, distance, (geom, row)
    for other in others:
        ray.offer_true_surface(other)
    return ray.best


class _Ray:
    def __init__(
        self, instant: Instant, looks: Optics, origin: Array, rotation: Array, places: Array
    ) -> None:
        self._instant = instant
        self._looks = looks
        self._origin, self._rotation = origin, rotation
        self._places = places
        self._axis: Array | None = None
        self._start = origin
        """Direction and start of the ray in the world, from the first true surface on."""
        self.best: Hit | None = None
        self.reach = looks.reach
        """Where the best hit is, or the ray ends."""
        self.order = -1, -1

    def search(self, wanted: NDArray[np.bool_]) -> None:
        """Offer all surfaces that the ray may meet first."""
        kinds = self._instant.surroundings.kinds
        entered: list[tuple[float, int, _View]] = []
        for geom in self._near(wanted):
            if kinds[geom] in MET_BY_RAYS:
                self.offer_true_surface(geom)
                continue
            view = self._view(geom)
            heights = [height for height, _ in view.faces]
            if heights and max(heights) >= self._looks.offset - _SLACK:
                entered.append((min(heights), geom, view))
        entered.sort()
        for height, geom, view in entered:
            if height - self._looks.offset > self.reach + _SLACK:
                break
            if kinds[geom] == _BOX:
                self._offer_box(geom, view)
            else:
                self._offer_mesh(geom, view)

    def _near(self, wanted: NDArray[np.bool_]) -> list[int]:
        """Return the geoms whose balls the segment meets, and the planes, which have none."""
        offset, reach, around = self._looks.offset, self._looks.reach, self._instant.surroundings
        x, y, z = self._places.T
        near = x * x + y * y <= around.radii_squared
        near &= np.abs(z - (offset + reach / 2)) <= around.radii + (reach / 2 + _SLACK)
        near &= wanted
        return near.nonzero()[0].tolist()

    def _offer(self, order: tuple[int, int], geom: int, distance: float, normal: Vector) -> None:
        """Take a hit at a distance from the ray's start if the sensor sees it and none is nearer.

        Args:
            order: of hits at the same distance, the one with the least counts.
            geom: the geom.
            distance: metres.
            normal: the outward normal.
        """
        if distance > self.reach:
            return
        if self.best is not None and distance == self.reach and order >= self.order:
            return
        away = self._looks.offset + distance
        if self._looks.accepts((0.0, 0.0, away), normal):
            self.reach, self.order = distance, order
            self.best = Hit(away, normal, geom)

    def offer_true_surface(self, geom: int) -> None:
        instant, axis = self._instant, self._axis
        if axis is None:
            axis = self._axis = self._rotation[:, 2].copy()
            self._start = self._origin + self._looks.offset * axis
        distance, normal = true_surface(
            instant.model, geom, instant.geom_xpos[geom], instant.geom_xmat[geom], self._start, axis
        )
        if distance >= 0.0:
            x, y, z = (normal @ self._rotation).tolist()
            self._offer((-1, geom), geom, distance, (x, y, z))

    def _turn(self, geom: int) -> Array:
        """Return (3, 3): rows are a geom's axes in the sensor's frame."""
        return self._instant.geom_xmat[geom].reshape(3, 3).T @ self._rotation

    def _view(self, geom: int) -> _View:
        turn = self._turn(geom)
        place = self._places[geom]
        axes, away = turn.tolist(), place.tolist()
        start = [-_dot(axis, away) for axis in axes]
        direction = [axis[2] for axis in axes]
        faces = _box_faces(self._instant.surroundings.boxes[geom], start, direction)
        return _View(turn, place, start, direction, faces)

    def _offer_box(self, geom: int, view: _View) -> None:
        corners = self._instant.surroundings.triangles.of(geom)[0]
        for height, face in sorted(view.faces):
            if -_SLACK <= height - self._looks.offset <= self.reach + _SLACK:
                pair = corners[2 * face : 2 * face + 2]
                self._offer_crossings(geom, pair, view.turn, view.place, 2 * face)

    def _offer_mesh(self, geom: int, view: _View) -> None:
        rows = self._instant.surroundings.lines.crossed(geom, view.start, view.direction)
        if len(rows):
            corners = self._instant.surroundings.triangles.of(geom)[0][rows]
            self._offer_crossings(geom, corners, view.turn, view.place, int(rows[0]))

    def _offer_crossings(self, geom: int, corners: Array, turn: Array, place: Array, first: int) -> None:
        """Offer the points of triangles (n, 3, 3) of a geom on the z axis; `first`: number of the first one."""
        offset = self._looks.offset
        between = offset - _SLACK, offset + self.reach + _SLACK
        for row, height, normal in _crossings(corners @ turn + place, *between):
            if height >= offset:
                self._offer((geom, first + row), geom, height - offset, normal)


def _box_faces(
    box: Sequence[float], start: Sequence[float], direction: Sequence[float]
) -> list[tuple[float, int]]:
    """Return the faces of a box that a line may meet: the distance from its start, and the face's number.

    Args:
        box: its middle and half sides.
        start: of the line.
        direction: a unit vector.
    """
    starts = start[0] - box[0], start[1] - box[1], start[2] - box[2]
    size = box[3:]
    slack = _SLACK * (1.0 + max(size) + max(map(abs, starts)))
    faces: list[tuple[float, int]] = []
    for axis, one, other in _AXES:
        along = direction[axis]
        if along == 0.0:
            continue
        for side, face in ((-size[axis], 2 * axis), (size[axis], 2 * axis + 1)):
            away = (side - starts[axis]) / along
            if (
                abs(starts[one] + away * direction[one]) <= size[one] + slack
                and abs(starts[other] + away * direction[other]) <= size[other] + slack
            ):
                faces.append((away, face))
    return faces


def _crossings(corners: Array, low: float, high: float) -> Iterator[tuple[int, float, Vector]]:
    """Yield where the z axis crosses triangles (n, 3, 3): the triangle, the height and the outward unit normal.

    Triangles that are wholly below `low` or above `high` are left out.

    The steps are those of `seen.Triangles`, one triangle after the other: most rays cross two. Sums of products are
    left to NumPy, which may round them in another way.
    """
    triangles: list[list[list[float]]] = corners.tolist()
    rows: list[int] = []
    products: list[Vector] = []
    insides: list[bool] = []
    for row, ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) in enumerate(triangles):
        if max(az, bz, cz) < low or min(az, bz, cz) > high:
            continue
        first, second, third = ax * by - bx * ay, bx * cy - cx * by, cx * ay - ax * cy
        slack = _SLACK * (_SLACK + abs(ax) + abs(ay) + abs(bx) + abs(by) + abs(cx) + abs(cy))
        least, greatest = min(first, second, third), max(first, second, third)
        if least >= -slack or greatest <= slack:  # the axis lies on one side of all edges
            bx, by, bz, cx, cy, cz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
            rows.append(row)
            products.append((by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx))
            insides.append(least > slack or greatest < -slack)
    if not rows:
        return
    array = np.array(products)
    lengths = [max(math.sqrt(square), 1e-300) for square in np.einsum("ni,ni->n", array, array).tolist()]
    normals = [(x / w, y / w, z / w) for (x, y, z), w in zip(products, lengths, strict=True)]
    heights = np.einsum("ni,ni->n", np.array(normals), corners[rows, 0]).tolist()
    for row, is_inside, length, normal, height in zip(rows, insides, lengths, normals, heights, strict=True):
        if length > _THIN and normal[2] != 0.0:
            z = height / normal[2]
            if is_inside or _holds(triangles[row], normal, z):
                yield row, z, normal


def _holds(triangle: Sequence[Sequence[float]], normal: Vector, z: float) -> bool:
    """Return whether a point of a triangle's plane on the z axis lies within the triangle."""
    u, v, w = normal
    for (ax, ay, az), (bx, by, bz) in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
        bx, by, bz = bx - ax, by - ay, bz - az
        x, y, up = v * bz - w * by, w * bx - u * bz, u * by - v * bx  # inwards
        if not z * up >= x * ax + y * ay + up * az - 1e-9 * math.sqrt(x * x + y * y + up * up):
            return False
    return True


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
