"""Thin convex solids behind a surface, which collide exactly where it lies.

The solid behind a facet is a prism. It is as thick as the body there, up to a limit, so that it does not stick out at
the other side; where a face at its edge bends back by more than a right angle, the prism ends at that face's plane.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from simx_server.scene.formats.vrep.conversion.geometry.topology import Faces, Points

from .facets import Array, Facet

SHEET = 0.002
"""Thickness in metres of the solids behind a surface that encloses nothing."""

DEEPEST = 0.1
"""Most metres behind the surface of a body. A thing that falls 10 m moves 4 cm in a physics step."""

_THINNEST = 0.0005

_INWARD = 0.02
"""Part of the way to the middle of a facet from which its corners look for the other side."""

_ATTEMPTS = 8
"""Times that a prism is made half as deep, where the faces around leave no space at its back."""


def prisms(
    facets: list[Facet], points: Points, faces: Faces, *, is_closed: bool, deepest: float = DEEPEST
) -> list[Points]:
    """Return the points of a solid behind each facet.

    Args:
        facets: the surface.
        points: (n, 3), the same surface as triangles.
        faces: (m, 3), indices of points.
        is_closed: it encloses a body and looks outwards; else it is a sheet.
        deepest: most metres that a solid is thick.
    """
    if not is_closed:
        return [_prism(facet, SHEET) for facet in facets]
    depths = np.minimum(_depths(facets, points, faces), deepest)
    return [_prism(facet, float(depth)) for facet, depth in zip(facets, depths, strict=True)]


def _prism(facet: Facet, depth: float) -> Points:
    corners, back = facet.corners, np.zeros((0, 3))
    for _ in range(_ATTEMPTS):
        back = _back(facet, depth)
        if len(back) >= 3:
            break
        depth /= 2
    if len(back) < 3:
        back = corners - depth * facet.normal
    return np.concatenate([corners, back]).astype(np.float32)


def _back(facet: Facet, depth: float) -> Array:
    """Return the polygon at the back of a prism; without corners where the faces around leave no space."""
    polygon = facet.corners
    for normal, level in facet.limits:
        polygon = _cut(polygon, normal, level + depth * float(normal @ facet.normal))
    return polygon - depth * facet.normal


def _cut(polygon: Array, outward: Array, level: float) -> Array:
    """Return the part of a convex polygon up to a level along a direction."""
    heights = polygon @ outward - level
    kept: list[Array] = []
    for place, height in enumerate(heights):
        after = (place + 1) % len(polygon)
        if height <= 0:
            kept.append(polygon[place])
        if (height < 0 < heights[after]) or (heights[after] < 0 < height):
            share = height / (height - heights[after])
            kept.append(polygon[place] + share * (polygon[after] - polygon[place]))
    return np.array(kept).reshape(-1, 3)


def _depths(facets: list[Facet], points: Points, faces: Faces) -> list[float]:
    """Return how thick the body is behind each facet, within the limits: the least of what rays from it find."""
    look = _Looking(points, faces)
    found: list[float] = []
    for facet in facets:
        middle = facet.corners.mean(axis=0)
        starts = np.concatenate([facet.corners, (facet.corners + np.roll(facet.corners, -1, axis=0)) / 2])
        starts = np.concatenate([[middle], starts + _INWARD * (middle - starts)])
        depth = min(look.distance(start, -facet.normal) for start in starts)
        found.append(min(max(depth, _THINNEST), DEEPEST))
    return found


class _Looking:
    """Looks from one side of a body to the other, by MuJoCo's rays."""

    def __init__(self, points: Points, faces: Faces) -> None:
        spec: Any = mujoco.MjSpec()
        mesh = spec.add_mesh(name="mesh", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.userface = points.ravel(), faces.ravel()
        geom = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
        geom.contype = geom.conaffinity = 0
        self._model: Any = spec.compile()
        self._data = mujoco.MjData(self._model)
        mujoco.mj_kinematics(self._model, self._data)
        self._least = 1e-5 * float(np.ptp(points, axis=0).max())

    def distance(self, start: Array, direction: Array) -> float:
        """Return how far the surface is from a point that lies on it; infinity where there is none."""
        hit = np.zeros(1, np.int32)
        found = mujoco.mj_ray(
            self._model, self._data, start + self._least * direction, direction, None, 1, -1, hit, None
        )
        return float("inf") if found < 0 else float(found) + self._least
