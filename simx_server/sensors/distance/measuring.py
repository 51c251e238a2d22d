"""Minimum distance between objects at one instant; `meeting.py` has their collision.

All geoms of a shape count, whether they collide in the physics or not. Convex geoms are solid and measured by
MuJoCo; meshes that are not convex and height fields are surfaces, measured triangle by triangle. So are octrees
and point clouds. Of V-REP's other objects only dummies can be measured, as points.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array, plane_triangles
from simx_server.scene.objects import ObjectKind
from simx_server.sensors.instant import Instant
from simx_server.sensors.proximity.detection import detect
from simx_server.sensors.proximity.optics import Optics
from simx_server.sensors.proximity.volume import cone

from .box_tree import BoxTree, Placed
from .triangle_pairs import Gap, least_gap

FAR = 1e6
"""Metres; objects farther away are not measured."""

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
_KIND = mujoco.mjtGeom
_HAS_HULL = frozenset(
    map(int, (_KIND.mjGEOM_PLANE, _KIND.mjGEOM_SPHERE, _KIND.mjGEOM_CAPSULE, _KIND.mjGEOM_ELLIPSOID,
              _KIND.mjGEOM_CYLINDER, _KIND.mjGEOM_BOX, _KIND.mjGEOM_MESH))
)  # fmt: skip
"""Types of geoms that MuJoCo measures as convex ones: meshes by their hulls."""

_FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD)
_UNKNOWN = Gap(math.inf, np.zeros(3), np.zeros(3))


class Nearest(NamedTuple):
    """The points where two sets of objects are nearest."""

    distance: float
    """Distance in metres, 0 where they meet."""
    first: Array
    second: Array
    """(3,) each, in the world; for overlapping objects one point between the two surfaces."""
    objects: tuple[int, int]
    """Handles of the objects that the points belong to."""


class _Found(NamedTuple):
    """The best pair of geoms so far; the distance is negative where convex ones overlap."""

    gap: Gap
    geoms: tuple[int, int]


def distance(instant: Instant, first: Collection[int], second: Collection[int]) -> float | None:
    """Return the minimum distance in metres, 0 where they meet; None when there is nothing to measure."""
    found = nearest(instant, first, second)
    return None if found is None else found.distance


def nearest(instant: Instant, first: Collection[int], second: Collection[int]) -> Nearest | None:
    """Return the minimum distance and its points; None when there is nothing to measure."""
    found = _least(instant, first, second)
    best: Nearest | None = None
    if found.gap.distance < FAR:
        one, other = found.gap.first, found.gap.second
        if found.gap.distance <= 0.0:
            one = other = (one + other) / 2
        best = Nearest(max(0.0, found.gap.distance), one, other, _owners(instant, found))
    points, others = _points(instant, first), _points(instant, second)
    for handle, place in points.items():
        best = _nearer(best, _from_point(instant, handle, place, set(second) - {handle}, best))
        for other, there in others.items():
            if other != handle:
                best = _nearer(best, Nearest(math.dist(place, there), place, there, (handle, other)))
    for handle, place in others.items():
        back = _from_point(instant, handle, place, set(first) - {handle}, best)
        if back is not None:
            one, other = back.objects
            best = _nearer(best, Nearest(back.distance, back.second, back.first, (other, one)))
    return best


def _nearer(best: Nearest | None, other: Nearest | None) -> Nearest | None:
    """Return the nearer one, the first of equally near ones."""
    if best is None or other is None:
        return other if best is None else best
    return other if other.distance < best.distance else best


def _owners(instant: Instant, found: _Found) -> tuple[int, int]:
    one, other = found.geoms
    return int(instant.surroundings.owners[one]), int(instant.surroundings.owners[other])


def _least(instant: Instant, first: Collection[int], second: Collection[int]) -> _Found:
    """Return the minimum signed distance between geoms of two sets; infinity when none is below `FAR`."""
    mine, theirs = instant.geoms_of(first), instant.geoms_of(second)
    best = _Found(_UNKNOWN, (-1, -1))
    if len(mine) == 0 or len(theirs) == 0:
        return best
    lower = lower_bounds(instant, mine, theirs)
    for index in np.argsort(lower, axis=None):
        row, column = divmod(int(index), len(theirs))
        least = best.gap.distance
        if lower[row, column] > min(least, FAR) or least <= 0.0:
            break
        geoms = int(mine[row]), int(theirs[column])
        gap = _between(instant, *geoms, min(least, FAR))
        if gap.distance < least:
            best = _Found(gap, geoms)
    return best


def lower_bounds(instant: Instant, mine: NDArray[np.intp], theirs: NDArray[np.intp]) -> Array:
    """Return metres (n, m) from which on geoms (n,) and (m,) are apart, by the balls around them.

    Minus infinity for planes, which have no balls; infinity for two geoms of one object.
    """
    owners, model = instant.surroundings.owners, instant.model
    away = instant.geom_xpos[mine, np.newaxis] - instant.geom_xpos[theirs]
    reach, other_reach = model.geom_rbound[mine], model.geom_rbound[theirs]
    lower = np.sqrt(np.einsum("nmi,nmi->nm", away, away)) - reach[:, np.newaxis] - other_reach
    lower[reach <= 0.0, :] = lower[:, other_reach <= 0.0] = -np.inf
    lower[owners[mine, np.newaxis] == owners[theirs]] = np.inf
    return lower


def _between(instant: Instant, first: int, second: int, limit: float) -> Gap:
    """Return the signed distance of two geoms and its points; infinity when it is above `limit`."""
    triangles = instant.surroundings.triangles
    kinds = {int(instant.model.geom_type[first]), int(instant.model.geom_type[second])}
    if kinds == {_PLANE}:
        return _UNKNOWN
    if triangles.is_solid(first) and triangles.is_solid(second):
        ends = np.zeros(6)
        away = mujoco.mj_geomDistance(instant.model, instant.data, first, second, limit, ends)
        found = Gap(away, ends[:3], ends[3:])
    elif _HAS_HULL.issuperset(kinds) and (
        mujoco.mj_geomDistance(instant.model, instant.data, first, second, limit, None) >= limit
    ):
        return _UNKNOWN  # a surface is not nearer than its hull, which MuJoCo measures much faster
    else:
        guesses = instant.surroundings.nearest_triangles
        found, pair = least_gap(
            placed(instant, first, second),
            placed(instant, second, first),
            limit,
            guesses.get((first, second)),
        )
        if pair is not None:
            guesses[first, second] = pair
    return found if found.distance < limit else _UNKNOWN


def placed(instant: Instant, geom: int, other: int) -> Placed:
    """Return a geom's triangles in its pose; of an infinite plane, the part under another geom."""
    turn, place = instant.geom_xmat[geom].reshape(3, 3), instant.geom_xpos[geom]
    if int(instant.model.geom_type[geom]) == _PLANE:
        return Placed(BoxTree(_of_plane(instant, geom, other)), turn, place)
    return Placed(instant.surroundings.triangles.form(geom).once(BoxTree), turn, place)


def _of_plane(instant: Instant, geom: int, other: int) -> Array:
    """Return the triangles (2, 3, 3) of the part of a plane under another geom, in the plane's frame."""
    turn, place = instant.geom_xmat[geom].reshape(3, 3), instant.geom_xpos[geom]
    towards = (instant.geom_xpos[other] - place) @ turn
    return plane_triangles(instant.model.geom_size[geom], towards, float(instant.model.geom_rbound[other]))


def triangles_in_world(instant: Instant, geom: int, other: int) -> Array:
    """Return a geom's triangles (n, 3, 3) in the world; of an infinite plane, the part under another geom."""
    turn, place = instant.geom_xmat[geom].reshape(3, 3), instant.geom_xpos[geom]
    if int(instant.model.geom_type[geom]) == _PLANE:
        corners = _of_plane(instant, geom, other)
    else:
        corners = instant.surroundings.triangles.of(geom)[0]
    return corners @ turn.T + place


def _points(instant: Instant, handles: Collection[int]) -> dict[int, Array]:
    """Return the world positions of the dummies among some objects."""
    found: dict[int, Array] = {}
    for handle in handles:
        item = instant.scene.objects.get(handle)
        if item is not None and item.kind == ObjectKind.DUMMY:
            found[handle] = instant.xpos[item.id] if item.element == "body" else instant.site_xpos[item.id]
    return found


def _from_point(
    instant: Instant, handle: int, place: Array, others: Collection[int], best: Nearest | None
) -> Nearest | None:
    """Return the distance from a dummy's position to the surfaces of some shapes, if it can be less than the best."""
    geoms, model = instant.geoms_of(others), instant.model
    most = FAR if best is None else best.distance
    reaches = model.geom_rbound[geoms]
    away = instant.geom_xpos[geoms] - place
    geoms = geoms[(reaches <= 0.0) | (np.sqrt(np.einsum("ni,ni->n", away, away)) - reaches < most)]
    if not len(geoms) or most <= 0.0:
        return None
    wanted = np.zeros(model.ngeom, bool)
    wanted[geoms] = True
    # Only triangles that are not farther than the nearest middle of one are examined: few of many thousand.
    reach = min(most, *(_at_most(instant, geom, place) for geom in geoms.tolist()))
    found = detect(instant, Optics("cone", 0.0, reach, cone(2 * math.pi, reach)), place, np.eye(3), wanted)
    if found is None:
        return None
    point = place + np.array(found.point)
    return Nearest(math.hypot(*found.point), place, point, (handle, found.handle))


def _at_most(instant: Instant, geom: int, place: Array) -> float:
    """Return a distance (m) from a point to a geom's surface that the true one does not exceed."""
    if int(instant.model.geom_type[geom]) == _PLANE:
        return FAR
    centres = instant.surroundings.triangles.of(geom)[1]
    if not len(centres):
        return FAR
    away = (place - instant.geom_xpos[geom]) @ instant.geom_xmat[geom].reshape(3, 3) - centres
    nearest = math.sqrt(float(np.einsum("ni,ni->n", away, away).min()))
    # Triangles of round geoms lie a little below the surface.
    return min(FAR, 1.001 * nearest + 0.01 * float(instant.model.geom_rbound[geom]) + 1e-6)
