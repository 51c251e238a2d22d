"""Geoms as triangles in their own frames, as V-REP's shapes.

Boxes, planes, meshes and height fields are exact. Curved primitives lie within their triangles' corners to about
0.5 % of their radius; for more precision cast a ray at the true surface (`true_surface`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_AROUND = 32
"""Corners around a curved primitive; a multiple of 4, so that the axes' extremes are exact."""
_POLE_TO_POLE = 16

TOGETHER = 32
"""Number of triangles in a bundle of neighbours."""
_CONVEX_AT_MOST = 4000
"""Maximum number of triangles of a mesh that is tested for convexity."""

_TRIED = 64
"""Triangles that are tried first."""

_GEOM = mujoco.mjtGeom
CURVED = frozenset(int(kind) for kind in (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_ELLIPSOID,
                                          _GEOM.mjGEOM_CYLINDER))  # fmt: skip
"""Types of geoms whose triangles only approximate them."""

MESHES = frozenset((int(_GEOM.mjGEOM_MESH), int(_GEOM.mjGEOM_SDF)))
"""Types of geoms that have a mesh."""


def with_balls(corners: Array) -> tuple[Array, Array, Array]:
    """Return triangles (n, 3, 3) with the centres and radii of balls that contain them."""
    centres = corners.mean(axis=1)
    away = corners - centres[:, np.newaxis]
    return corners, centres, np.sqrt(np.einsum("nei,nei->ne", away, away).max(axis=1, initial=0.0))


def bundled(centres: Array, radii: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array, Array]:
    """Return bundles of consecutive triangles, from the balls of these: starts, sizes, and the bundles' balls."""
    starts = np.arange(0, len(centres), TOGETHER)
    sizes = np.diff(np.append(starts, len(centres)))
    if len(starts) == 0:
        return starts, sizes, np.zeros((0, 3)), np.zeros(0)
    middles = np.add.reduceat(centres, starts, axis=0) / sizes[:, np.newaxis]
    away = centres - np.repeat(middles, sizes, axis=0)
    reaches = np.maximum.reduceat(np.sqrt(np.einsum("ni,ni->n", away, away)) + radii, starts)
    return starts, sizes, middles, reaches


def side_by_side(corners: Array) -> Array:
    """Return the same triangles, ordered so that neighbours in space follow each other.

    The set is halved along its longest side.
    """
    centres = corners.mean(axis=1)
    pending = [np.arange(len(corners))]
    ordered: list[NDArray[np.intp]] = []
    while pending:
        some = pending.pop()
        if len(some) <= TOGETHER:
            ordered.append(some)
            continue
        axis = int(np.ptp(centres[some], axis=0).argmax())
        # Whole bundles on the near side, so that bundles stay aligned.
        half = len(some) // 2 // TOGETHER * TOGETHER or TOGETHER
        parts = np.argpartition(centres[some, axis], half)
        pending += [some[parts[half:]], some[parts[:half]]]
    return corners[np.concatenate(ordered)] if ordered else corners


def true_surface(
    model: mujoco.MjModel, geom: int, position: Array, rotation: Array, origin: Array, direction: Array
) -> tuple[float, Array]:
    """Return (distance, unit normal) along a unit direction to a primitive at this pose; distance below 0: not met.

    All in the world frame; `rotation` is MuJoCo's row-major nine numbers.
    """
    normal = np.zeros(3)
    kind = int(model.geom_type[geom])
    distance = mujoco.mju_rayGeom(position, rotation, model.geom_size[geom], origin, direction, kind, normal)
    return distance, normal


def corners_of(model: mujoco.MjModel, geom: int) -> Array:
    """Return the triangles (n, 3, 3) of a geom in its frame; curved primitives are faceted, infinite planes none."""
    kind = int(model.geom_type[geom])
    if kind in MESHES:
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == _GEOM.mjGEOM_HFIELD.value:
        return _height_field(model, int(model.geom_dataid[geom]))
    make = _PRIMITIVES.get(kind)
    return np.empty((0, 3, 3)) if make is None else make(model.geom_size[geom])


def _mesh(model: mujoco.MjModel, mesh: int) -> Array:
    vertices, faces = int(model.mesh_vertadr[mesh]), int(model.mesh_faceadr[mesh])
    chosen = model.mesh_face[faces : faces + int(model.mesh_facenum[mesh])]
    return model.mesh_vert[vertices + chosen].astype(np.float64)


def is_convex(corners: Array) -> bool:
    """Return whether the triangles are a closed surface and all corners lie behind each of them.

    A mesh that is too large for the test counts as not convex.
    """
    if not 4 <= len(corners) <= _CONVEX_AT_MOST or _has_dents(corners):
        return False
    points, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    edges = np.stack([index, index[:, [1, 2, 0]]], axis=2).reshape(-1, 2)
    there, back = (np.unique(e[:, 0] * len(points) + e[:, 1]) for e in (edges, edges[:, ::-1]))
    if not np.array_equal(there, back):
        return False
    return not _lies_before(corners, points, 1e-5)


def _has_dents(corners: Array) -> bool:
    """Return whether corners lie clearly before some of the triangles; most bodies that are not convex show it so."""
    some = corners[:: max(1, len(corners) // _TRIED)]
    return _lies_before(some, corners.reshape(-1, 3), 2e-5)


def _lies_before(corners: Array, points: Array, share: float) -> bool:
    """Return whether a point (k, 3) is before the plane of a triangle by more than a share of the points' extent."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.sqrt((normals**2).sum(axis=1))
    extent = float(np.ptp(points, axis=0).max(initial=0.0))
    heights = normals @ points.T - np.einsum("ni,ni->n", normals, corners[:, 0])[:, np.newaxis]
    return not np.all(heights <= share * extent * lengths[:, np.newaxis])


def _box(size: Array) -> Array:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    corners = signs * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners[[triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]]


def plane_triangles(sizes: Array, points: Array, reach: float | Array) -> Array:
    """Return (..., 2, 3, 3) of plane geoms with sizes (..., 3).

    A side of size 0 is infinite: as much of it is used as a ball (radius `reach`) around a point (..., 3) in its
    frame needs.
    """
    middle, half = points[..., :2], sizes[..., :2]
    endless = half <= 0.0
    low = np.where(endless, middle - 2 * reach, -half)
    high = np.where(endless, middle + 2 * reach, half)
    corners = np.zeros((*half.shape[:-1], 4, 3))
    corners[..., 0], corners[..., 1] = low[..., np.newaxis, 0], low[..., np.newaxis, 1]
    corners[..., 1:3, 0], corners[..., 2:, 1] = high[..., np.newaxis, 0], high[..., np.newaxis, 1]
    return corners[..., [[0, 1, 2], [0, 2, 3]], :]


def _lathe(profile: list[tuple[float, float]]) -> Array:
    """Return the surface of revolution about z of (radius, z) pairs, from the lower pole to the upper."""
    angles = np.linspace(0.0, 2 * math.pi, _AROUND + 1)
    rings = np.array([[[r * math.cos(a), r * math.sin(a), z] for a in angles] for r, z in profile])
    lower, upper = rings[:-1], rings[1:]
    a, b, c, d = lower[:, :-1], lower[:, 1:], upper[:, 1:], upper[:, :-1]
    return np.concatenate(
        [np.stack([a, b, c], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)]
    )


def _ball(size: Array) -> Array:
    steps = np.linspace(-math.pi / 2, math.pi / 2, _POLE_TO_POLE + 1)
    return _lathe([(math.cos(s), math.sin(s)) for s in steps]) * size


def _sphere(size: Array) -> Array:
    return _ball(np.full(3, size[0]))


def _capsule(size: Array) -> Array:
    radius, half = float(size[0]), float(size[1])
    steps = np.linspace(-math.pi / 2, 0.0, _POLE_TO_POLE // 2 + 1)
    lower = [(radius * math.cos(s), radius * math.sin(s) - half) for s in steps]
    return _lathe(lower + [(r, -z) for r, z in reversed(lower)])


def _cylinder(size: Array) -> Array:
    radius, half = float(size[0]), float(size[1])
    return _lathe([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])


def _height_field(model: mujoco.MjModel, field: int) -> Array:
    """Return the upper surface. Each cell is cut from its lower left to its upper right corner, as MuJoCo cuts it."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    start = int(model.hfield_adr[field])
    size_x: float
    size_y: float
    size_x, size_y, size_z, _ = model.hfield_size[field]
    heights = model.hfield_data[start : start + rows * columns].reshape(rows, columns) * size_z
    x, y = np.meshgrid(np.linspace(-size_x, size_x, columns), np.linspace(-size_y, size_y, rows))
    points = np.stack([x, y, heights], axis=2)
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate(
        [np.stack([a, b, c], 2).reshape(-1, 3, 3), np.stack([a, c, d], 2).reshape(-1, 3, 3)]
    )


_PRIMITIVES: Mapping[int, Callable[[Array], Array]] = MappingProxyType(
    {
        int(_GEOM.mjGEOM_BOX): _box,
        int(_GEOM.mjGEOM_SPHERE): _sphere,
        int(_GEOM.mjGEOM_ELLIPSOID): _ball,
        int(_GEOM.mjGEOM_CAPSULE): _capsule,
        int(_GEOM.mjGEOM_CYLINDER): _cylinder,
    }
)
