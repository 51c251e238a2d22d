"""Detection by proximity sensors at one instant: the nearest point of a detectable surface within their volumes.

Sensors with equal optics are handled together: a ring of them costs little more than one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import CURVED, plane_triangles, true_surface
from simx_server.scene.poses.poses import Vector
from simx_server.sensors.instant import Instant

from .first_hit import MET_BY_RAYS, first_hit
from .nearest import nearest_points
from .optics import Optics
from .reach import pairs_in_reach
from .seen import Triangles
from .volume import Array

_SPHERE = int(mujoco.mjtGeom.mjGEOM_SPHERE)
_CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_MET_BY_RAYS = np.isin(np.arange(int(mujoco.mjtGeom.mjNGEOMTYPES)), tuple(MET_BY_RAYS))
"""(types,) whether MuJoCo's rays meet the surface of a geom as sensors do."""
_FEW_RAYS = 8
"""Rays up to which `detect` for each is quicker than `detect_all`, also where it is not compiled."""
_SNAP = 0.05
"""Maximum distance of the true surface from its triangles along a line of sight, as a share of the distance."""


class Detection(NamedTuple):
    """The nearest point, in the sensor's frame."""

    point: Vector
    """Position in metres from the sensor's origin."""
    normal: Vector
    """Unit vector, outward from the surface."""
    handle: int
    """Object of the surface, -1 for an unnamed geom of the world."""


def are_quick_alone(instant: Instant, rays: int) -> bool:
    """Return whether `detect` for each of many rays is quicker than `detect_all`; the results are the same."""
    return rays <= _FEW_RAYS or instant.surroundings.for_rays is not None


def detect(
    instant: Instant, looks: Optics, origin: Array, rotation: Array, wanted: NDArray[np.bool_]
) -> Detection | None:
    """Return what a sensor detects.

    Args:
        instant: the world.
        looks: the sensor's optics.
        origin: (3,) position of the sensor in the world.
        rotation: (3, 3) in the world; the columns are the sensor's axes.
        wanted: (ngeom,) the geoms to detect.
    """
    if looks.kind == "ray":
        return unblinded(looks, _on_ray(instant, looks, origin, rotation, wanted))
    return detect_all(instant, looks, origin[np.newaxis], rotation[np.newaxis], wanted[np.newaxis])[0]


def detect_all(
    instant: Instant, looks: Optics, origins: Array, rotations: Array, wanted: NDArray[np.bool_]
) -> list[Detection | None]:
    """Return the same for sensors (s,) with equal optics; `wanted`: (s, ngeom)."""
    look = _Look(instant, looks, origins, rotations, wanted)
    found = look.along_rays() if looks.kind == "ray" else look.in_volumes()
    return [unblinded(looks, one) for one in found]


def unblinded(looks: Optics, found: Detection | None) -> Detection | None:
    """Return a detection, None if it is so near that it blinds the sensor."""
    if found is None or not looks.least_distance:
        return found
    return None if math.dist(found.point, (0.0, 0.0, 0.0)) < looks.least_distance else found


def _on_ray(
    instant: Instant, looks: Optics, origin: Array, rotation: Array, wanted: NDArray[np.bool_]
) -> Detection | None:
    hit = first_hit(instant, looks, origin, rotation, wanted)
    if hit is None:
        return None
    return Detection((0.0, 0.0, hit.distance), hit.normal, int(instant.surroundings.owners[hit.geom]))


class _Look:
    """Sensors with equal optics, at one instant."""

    def __init__(
        self, instant: Instant, looks: Optics, origins: Array, rotations: Array, wanted: NDArray[np.bool_]
    ) -> None:
        self._instant = instant
        self._looks = looks
        self._origins = origins
        self._rotations = rotations
        self._pairs = pairs_in_reach(
            instant.model, instant.geom_xpos, instant.geom_xmat, looks.volume, origins, rotations, wanted
        )
        self._kinds = instant.model.geom_type[self._pairs.geoms]
        self._found: list[Detection | None] = [None] * len(origins)

    def in_volumes(self) -> list[Detection | None]:
        looks, pairs = self._looks, self._pairs
        squares = np.full(len(self._found), np.inf)
        settled = self._offer_round_ones(squares)
        which, corners = self._triangles(np.flatnonzero(~settled))
        if len(which) == 0:
            return self._found
        triangles = Triangles.of(corners, pairs.views[which])
        if looks.faces != "both":
            seen = (triangles.heights < 0) == (looks.faces == "front")
            triangles = triangles.take(np.flatnonzero(seen))
        nearest = nearest_points(looks.volume, triangles, squares, looks.least_cosine)
        places = np.searchsorted(triangles.rows, nearest.rows)
        for view in np.flatnonzero(nearest.rows >= 0).tolist():
            geom = int(pairs.geoms[which[nearest.rows[view]]])
            distance, normal = math.sqrt(nearest.squares[view]), triangles.normals[places[view]]
            self._found[view] = self._refined(view, geom, distance, nearest.points[view], normal)
        return self._found

    def along_rays(self) -> list[Detection | None]:
        """Return the first surface on the segment of the z axis."""
        looks, pairs = self._looks, self._pairs
        reaches = [looks.reach] * len(self._found)
        by_rays = _MET_BY_RAYS[self._kinds]
        for pair in np.flatnonzero(by_rays).tolist():
            view, geom = int(pairs.views[pair]), int(pairs.geoms[pair])
            axis = self._rotations[view, :, 2].copy()
            distance, normal = self._surface(geom, self._origins[view] + looks.offset * axis, axis)
            if 0.0 <= distance <= reaches[view]:
                self._offer_hit(reaches, view, geom, distance, self._local(view, normal))
        which, corners = self._triangles(np.flatnonzero(~by_rays))
        if len(which) == 0:
            return self._found
        triangles = Triangles.of(corners, which)
        with np.errstate(divide="ignore", invalid="ignore"):
            heights = triangles.heights / triangles.normals[:, 2]
        points = np.zeros((len(heights), 3))
        points[:, 2] = heights = np.where(np.isfinite(heights), heights, np.nan)
        for row in np.flatnonzero(triangles.hold(points) & (heights >= looks.offset)).tolist():
            pair, distance = triangles.views[row], float(heights[row]) - looks.offset
            view, normal = int(pairs.views[pair]), tuple(triangles.normals[row].tolist())
            if distance <= reaches[view]:
                self._offer_hit(reaches, view, int(pairs.geoms[pair]), distance, normal)
        return self._found

    def _offer_hit(self, reaches: list[float], view: int, geom: int, distance: float, normal: Vector) -> None:
        if self._found[view] is not None and distance >= reaches[view]:
            return
        point = 0.0, 0.0, self._looks.offset + distance
        if self._looks.accepts(point, normal):
            reaches[view] = distance
            self._found[view] = Detection(point, normal, self._owner(geom))

    def _offer_round_ones(self, squares: Array) -> NDArray[np.bool_]:
        """Offer the nearest point of each sphere and capsule that lies within the volume and is seen.

        `squares`: (s,) squared distances, which are updated.

        Returns:
            (m,) the pairs whose triangles need no examination.
        """
        settled = np.zeros(len(self._kinds), bool)
        round_ones = np.flatnonzero((self._kinds == _SPHERE) | (self._kinds == _CAPSULE))
        if len(round_ones) == 0:
            return settled
        pairs, sizes = self._pairs, self._instant.model.geom_size
        for pair in round_ones.tolist():
            view, geom = int(pairs.views[pair]), int(pairs.geoms[pair])
            half = float(sizes[geom, 1]) if self._kinds[pair] == _CAPSULE else 0.0
            x, y, z = pairs.places[pair].tolist()
            u, v, w = pairs.turns[pair, 2].tolist()
            shift = min(max(-(x * u + y * v + z * w), -half), half)
            x, y, z = x + shift * u, y + shift * v, z + shift * w
            away = math.sqrt(x * x + y * y + z * z)
            if away < 1e-12:
                continue
            radius = float(sizes[geom, 0])
            normal = -x / away, -y / away, -z / away
            point = x + radius * normal[0], y + radius * normal[1], z + radius * normal[2]
            if self._looks.volume.contains(np.array(point)) and self._looks.accepts(point, normal):
                settled[pair] = True
                square = (away - radius) ** 2
                if square < squares[view]:
                    squares[view] = square
                    self._found[view] = Detection(point, normal, self._owner(geom))
        return settled

    def _triangles(self, chosen: NDArray[np.intp]) -> tuple[NDArray[np.intp], Array]:
        """Return the triangles that may meet the volumes.

        Returns:
            (n,) which pair, and (n, 3, 3) a triangle of its geom, in the sensor's frame.
        """
        volume, pairs = self._looks.volume, self._pairs
        is_plane = self._kinds[chosen] == _PLANE
        others, planes = chosen[~is_plane], chosen[is_plane]
        which, corners = self._instant.surroundings.bundles.near(pairs.take(others), volume)
        which = others[which]
        if len(planes) == 0:
            return which, corners
        some = pairs.take(planes)
        sizes = self._instant.model.geom_size[some.geoms]
        made = plane_triangles(sizes, some.to_geom(volume.centre), volume.reach).reshape(-1, 3, 3)
        made = some.to_sensor(np.repeat(np.arange(len(planes)), 2), made)
        which, corners = np.concatenate([which, planes.repeat(2)]), np.concatenate([corners, made])
        order = np.argsort(which, kind="stable")
        return which[order], corners[order]

    def _refined(self, view: int, geom: int, distance: float, point: Array, normal: Array) -> Detection:
        """Return the point on the true surface of a curved primitive along the same line of sight.

        For other geoms the given point is returned.
        """
        if int(self._instant.model.geom_type[geom]) in CURVED and distance > 0.0:
            direction = self._rotations[view] @ (point / distance)
            true, outward = self._surface(geom, self._origins[view], direction)
            moved = point * (true / distance)
            if abs(true - distance) <= _SNAP * distance and self._looks.volume.contains(moved):
                point, normal = moved, np.array(self._local(view, outward))
        return Detection(tuple(point.tolist()), tuple(normal.tolist()), self._owner(geom))  # type: ignore[arg-type]

    def _surface(self, geom: int, origin: Array, direction: Array) -> tuple[float, Array]:
        place = self._instant.geom_xpos[geom], self._instant.geom_xmat[geom]
        return true_surface(self._instant.model, geom, *place, origin, direction)

    def _local(self, view: int, normal: Array) -> Vector:
        return tuple((normal @ self._rotations[view]).tolist())  # type: ignore[return-value]

    def _owner(self, geom: int) -> int:
        return int(self._instant.surroundings.owners[geom])
