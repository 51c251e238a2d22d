"""What one proximity sensor detects at one instant: the nearest point of a detectable surface within its volume."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..scene.annotations import Annotation
from ..scene.poses import Vector
from . import volume as volumes
from .instant import Instant
from .nearest import Triangles, nearest_point
from .triangles import CURVED, plane_triangles, true_surface, with_balls
from .volume import Array, Volume

_SPHERE = int(mujoco.mjtGeom.mjGEOM_SPHERE)
_CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_SNAP = 0.05
"""How far, as a share of the distance, the true surface may lie from its triangles along a line of sight."""


@dataclass(frozen=True, slots=True)
class Detection:
    """The nearest point, in the sensor's frame."""

    point: Vector
    """Metres from the sensor's origin."""
    normal: Vector
    """Unit, outward from the surface."""
    handle: int
    """Object of the surface, -1 for an unnamed geom of the world."""


@dataclass(frozen=True)
class Optics:
    """How a sensor looks, apart from where it is."""

    kind: str
    offset: float
    """Metres along z before the volume begins."""
    reach: float
    """Length of the volume, metres."""
    volume: Volume
    faces: str = "both"
    """Which sides of surfaces are seen: both, front or back."""
    least_cosine: float = 0.0
    """Of the angle between line of sight and normal; surfaces seen at a flatter angle are not detected."""
    least_distance: float = 0.0
    """Metres: something nearer blinds the sensor, and nothing is detected."""


def optics(note: Annotation, default_reach: float) -> Optics:
    """From a checked `simx:proximity` annotation."""
    kind = str(note.get("type", "ray"))
    offset, reach = _number(note, "offset"), _number(note, "range", default_reach)
    angle, radius, gap = (
        math.radians(_number(note, "angle_deg")),
        _number(note, "radius"),
        _number(note, "inside_gap"),
    )
    match kind:
        case "cone":
            volume = volumes.cone(angle, reach, offset, radius, gap)
        case "disc":
            volume = volumes.disc(angle, reach, _number(note, "height"), offset, radius, gap)
        case "cylinder":
            volume = volumes.cylinder(radius, reach, offset, _number(note, "radius_far", radius))
        case "pyramid":
            size = _number(note, "size_x"), _number(note, "size_y")
            far = _number(note, "size_x_far", size[0]), _number(note, "size_y_far", size[1])
            volume = volumes.pyramid(size, reach, offset, far)
        case _:
            volume = volumes.ray(reach, offset)
    steepest = _number(note, "max_normal_deg", 90.0)
    return Optics(
        kind, offset, reach, volume,
        faces=str(note.get("faces", "both")),
        least_cosine=math.cos(math.radians(steepest)) if steepest < 90.0 else 0.0,
        least_distance=_number(note, "min_distance"),
    )  # fmt: skip


def detect(
    instant: Instant, looks: Optics, origin: Array, rotation: Array, wanted: NDArray[np.bool_]
) -> Detection | None:
    """`origin` (3,) and `rotation` (3, 3, columns are its axes): the sensor in the world. `wanted`: (ngeom,)."""
    view = _View(instant, looks, origin, rotation)
    geoms = view.geoms_in_reach(wanted)
    found = view.along_ray(geoms) if looks.kind == "ray" else view.in_volume(geoms)
    if found is None or math.dist(found.point, (0.0, 0.0, 0.0)) < looks.least_distance:
        return None
    return found


class _View:
    """One sensor at one instant."""

    def __init__(self, instant: Instant, looks: Optics, origin: Array, rotation: Array) -> None:
        self._instant = instant
        self._looks = looks
        self._origin = origin
        self._rotation = rotation
        self._centre = origin + rotation @ looks.volume.centre

    def geoms_in_reach(self, wanted: NDArray[np.bool_]) -> list[int]:
        """Geoms whose bounding ball may meet the volume; planes have none."""
        model = self._instant.model
        local = (self._instant.geom_xpos - self._origin) @ self._rotation
        radius = model.geom_rbound
        near = self._touches(local, radius)
        if self._looks.kind == "ray":
            near &= np.hypot(local[:, 0], local[:, 1]) <= radius
        return np.flatnonzero(wanted & (near | (radius <= 0.0))).tolist()

    def _touches(self, centres: Array, radii: Array) -> NDArray[np.bool_]:
        """(n,) whether balls in the sensor's frame may meet the volume."""
        volume = self._looks.volume
        away = centres - volume.centre
        near = np.einsum("ni,ni->n", away, away) <= (radii + volume.reach) ** 2
        return near & volume.may_touch(centres, radii)

    def in_volume(self, geoms: list[int]) -> Detection | None:
        volume, looks = self._looks.volume, self._looks
        best: Detection | None = None
        least = math.inf
        groups: list[Array] = []
        members: list[int] = []
        for geom in geoms:
            exact = self._free_nearest(geom)
            if exact is not None:
                distance, point, normal = exact
                if volume.contains(np.array([point]))[0] and self._accepts(point, normal):
                    if distance < least:
                        best, least = Detection(point, normal, self._owner(geom)), distance
                    continue
            corners = self._corners(geom)
            if len(corners):
                groups.append(corners)
                members.append(geom)
        if not groups:
            return best
        triangles, kept = Triangles.of(np.concatenate(groups))
        if looks.faces != "both":
            seen = (triangles.heights < 0) == (looks.faces == "front")
            triangles, kept = triangles.take(np.flatnonzero(seen)), kept[seen]
        found = nearest_point(volume, triangles, looks.least_cosine)
        if found is None or found[0] >= least:
            return best
        distance, point, index = found
        ends = np.cumsum([len(group) for group in groups])
        geom = members[int(np.searchsorted(ends, kept[index], side="right"))]
        return self._refined(geom, distance, point, triangles.normals[index])

    def along_ray(self, geoms: list[int]) -> Detection | None:
        """The first surface on the segment of the z axis."""
        looks = self._looks
        axis = self._rotation[:, 2].copy()
        start = self._origin + looks.offset * axis
        best: tuple[float, Array, int] | None = None
        for geom in geoms:
            for distance, normal in self._hits(geom, start, axis):
                nearer = distance <= looks.reach if best is None else distance < best[0]
                if nearer and self._accepts((0.0, 0.0, looks.offset + distance), self._local(normal)):
                    best = distance, normal, geom
        if best is None:
            return None
        distance, normal, geom = best
        return Detection((0.0, 0.0, looks.offset + distance), self._local(normal), self._owner(geom))

    def _hits(self, geom: int, start: Array, axis: Array) -> list[tuple[float, Array]]:
        """Distances and outward normals (world) along a ray, of a primitive only the nearest."""
        instant = self._instant
        if int(instant.model.geom_type[geom]) in (*CURVED, _PLANE):
            place = instant.geom_xpos[geom], instant.geom_xmat[geom]
            distance, normal = true_surface(instant.model, geom, *place, start, axis)
            return [(distance, normal)] if distance >= 0.0 else []
        corners = self._corners(geom)
        triangles, _ = Triangles.of(corners)
        slope = triangles.normals[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            heights = triangles.heights / slope
        heights = np.where(np.isfinite(heights), heights, np.nan)
        points = np.zeros((len(heights), 3))
        points[:, 2] = heights
        held = np.flatnonzero(
            triangles.hold(points, np.arange(len(points))) & (heights >= self._looks.offset)
        )
        return [(float(heights[i]) - self._looks.offset, self._rotation @ triangles.normals[i]) for i in held]

    def _corners(self, geom: int) -> Array:
        """(n, 3, 3) those of the geom's triangles that may meet the volume, in the sensor's frame."""
        instant, reach = self._instant, self._looks.volume.reach
        turn, place = instant.geom_xmat[geom].reshape(3, 3), instant.geom_xpos[geom]
        if int(instant.model.geom_type[geom]) == _PLANE:
            corners = plane_triangles(instant.model.geom_size[geom], (self._centre - place) @ turn, reach)
            corners, centres, radii = with_balls(corners)
        else:
            corners, centres, radii = instant.surroundings.triangles.of(geom)
        turn, place = turn.T @ self._rotation, (place - self._origin) @ self._rotation
        chosen = self._touches(centres @ turn + place, radii)
        return (corners[chosen].reshape(-1, 3) @ turn + place).reshape(-1, 3, 3)

    def _free_nearest(self, geom: int) -> tuple[float, Vector, Vector] | None:
        """(distance, point, normal) of a sphere's or capsule's surface, whatever the volume; None for other geoms."""
        instant = self._instant
        kind = int(instant.model.geom_type[geom])
        if kind not in (_SPHERE, _CAPSULE):
            return None
        centre = (instant.geom_xpos[geom] - self._origin) @ self._rotation
        radius, half = instant.model.geom_size[geom, :2]
        if kind == _CAPSULE:
            axis = self._rotation.T @ instant.geom_xmat[geom].reshape(3, 3)[:, 2]
            centre = centre + np.clip(-(centre @ axis), -half, half) * axis
        away = float(np.sqrt(centre @ centre))
        if away < 1e-12:
            return None
        outward = -centre / away
        point = centre + radius * outward
        return abs(away - radius), tuple(point.tolist()), tuple(outward.tolist())  # type: ignore[return-value]

    def _refined(self, geom: int, distance: float, point: Array, normal: Array) -> Detection:
        """On the true surface of a curved primitive, along the same line of sight; else as it is."""
        instant, looks = self._instant, self._looks
        if int(instant.model.geom_type[geom]) in CURVED and distance > 0.0:
            place = instant.geom_xpos[geom], instant.geom_xmat[geom]
            direction = self._rotation @ (point / distance)
            true, outward = true_surface(instant.model, geom, *place, self._origin, direction)
            moved = point * (true / distance)
            if abs(true - distance) <= _SNAP * distance and looks.volume.contains(moved[np.newaxis])[0]:
                point, normal = moved, np.array(self._local(outward))
        return Detection(tuple(point.tolist()), tuple(normal.tolist()), self._owner(geom))  # type: ignore[arg-type]

    def _accepts(self, point: Vector, normal: Vector) -> bool:
        """Whether the side and the angle of a surface are ones the sensor sees."""
        along = sum(a * b for a, b in zip(point, normal, strict=True))
        if self._looks.faces != "both" and (along < 0) != (self._looks.faces == "front"):
            return False
        return abs(along) >= self._looks.least_cosine * math.dist(point, (0.0, 0.0, 0.0))

    def _local(self, normal: Array) -> Vector:
        return tuple((normal @ self._rotation).tolist())  # type: ignore[return-value]

    def _owner(self, geom: int) -> int:
        return int(self._instant.surroundings.owners[geom])


def _number(note: Annotation, key: str, default: float = 0.0) -> float:
    return float(note.get(key, default))
