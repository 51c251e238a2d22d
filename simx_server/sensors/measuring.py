"""Collision of, and least distance between, objects at one instant.

All geoms of a shape count, whether they collide in the physics or not. Convex geoms are solid and measured by MuJoCo;
meshes that are not convex and height fields are surfaces, measured triangle by triangle. Of V-REP's other objects
only dummies can be measured: as points.
"""

from __future__ import annotations

import math
from collections.abc import Collection

import mujoco
import numpy as np

from ..scene.objects import ObjectKind
from .detection import Optics, detect
from .instant import Instant
from .triangle_pairs import least_distance
from .triangles import Array, plane_triangles
from .volume import cone

FAR = 1e6
"""Metres; what is farther away is not measured."""

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD)
_ALL_AROUND = Optics("cone", 0.0, FAR, cone(2 * math.pi, FAR))
_UNKNOWN = math.inf


def is_colliding(instant: Instant, first: Collection[int], second: Collection[int]) -> bool:
    """Whether any shape of the first objects meets any of the second ones; no object meets itself."""
    return _least(instant, first, second, limit=0.0, stop=0.0) <= 0.0


def distance(instant: Instant, first: Collection[int], second: Collection[int]) -> float | None:
    """Least distance in metres, 0 where they meet; None when there is nothing to measure."""
    best = _least(instant, first, second, limit=FAR, stop=0.0)
    points, others = _points(instant, first), _points(instant, second)
    for handle, place in points.items():
        best = min(best, _from_point(instant, place, set(second) - {handle}))
        for other, there in others.items():
            if other != handle:
                best = min(best, math.dist(place, there))
    for handle, place in others.items():
        best = min(best, _from_point(instant, place, set(first) - {handle}))
    return max(0.0, best) if best < FAR else None


def _least(
    instant: Instant, first: Collection[int], second: Collection[int], *, limit: float, stop: float
) -> float:
    """Least signed distance between geoms of two sets of objects; anything above `limit` when there is none."""
    owners, model = instant.surroundings.owners, instant.model
    mine, theirs = instant.geoms_of(first), instant.geoms_of(second)
    if len(mine) == 0 or len(theirs) == 0:
        return _UNKNOWN
    away = instant.geom_xpos[mine, np.newaxis] - instant.geom_xpos[theirs]
    reach, other_reach = model.geom_rbound[mine], model.geom_rbound[theirs]
    lower = np.sqrt(np.einsum("nmi,nmi->nm", away, away)) - reach[:, np.newaxis] - other_reach
    lower[reach <= 0.0, :] = lower[:, other_reach <= 0.0] = -np.inf
    lower[owners[mine, np.newaxis] == owners[theirs]] = np.inf
    best = _UNKNOWN
    for index in np.argsort(lower, axis=None):
        row, column = divmod(int(index), len(theirs))
        if lower[row, column] > min(best, limit) or best <= stop:
            break
        best = min(best, _between(instant, int(mine[row]), int(theirs[column]), min(best, max(limit, 1e-3))))
    return best


def _between(instant: Instant, first: int, second: int, limit: float) -> float:
    """Signed distance of two geoms; infinity when it is above `limit`."""
    triangles = instant.surroundings.triangles
    if triangles.is_solid(first) and triangles.is_solid(second):
        if int(instant.model.geom_type[first]) == int(instant.model.geom_type[second]) == _PLANE:
            return _UNKNOWN
        found = mujoco.mj_geomDistance(instant.model, instant.data, first, second, limit, None)
    else:
        found = least_distance(_world(instant, first, second), _world(instant, second, first), limit)
    return found if found < limit else _UNKNOWN


def _world(instant: Instant, geom: int, other: int) -> Array:
    """(n, 3, 3) a geom's triangles in the world; of an infinite plane what lies under another geom."""
    turn, place = instant.geom_xmat[geom].reshape(3, 3), instant.geom_xpos[geom]
    if int(instant.model.geom_type[geom]) == _PLANE:
        towards = (instant.geom_xpos[other] - place) @ turn
        corners = plane_triangles(
            instant.model.geom_size[geom], towards, float(instant.model.geom_rbound[other])
        )
    else:
        corners = instant.surroundings.triangles.of(geom)[0]
    return corners @ turn.T + place


def _points(instant: Instant, handles: Collection[int]) -> dict[int, Array]:
    """World positions of the dummies among some objects."""
    found: dict[int, Array] = {}
    for handle in handles:
        item = instant.scene.objects.get(handle)
        if item is not None and item.kind == ObjectKind.DUMMY:
            found[handle] = instant.xpos[item.id] if item.element == "body" else instant.site_xpos[item.id]
    return found


def _from_point(instant: Instant, place: Array, handles: Collection[int]) -> float:
    """From a point to the surfaces of some shapes."""
    wanted = np.isin(instant.surroundings.owners, list(handles))
    found = detect(instant, _ALL_AROUND, place, np.eye(3), wanted)
    return _UNKNOWN if found is None else math.dist(found.point, (0.0, 0.0, 0.0))
