"""Objects to grasp: a box, a cylinder, a cup of convex parts, a convex mesh; all about 50 mm wide."""

from __future__ import annotations

import itertools
import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

KINDS = ("box", "cylinder", "cup", "mesh")

_HALF = 0.025
"""Half of the size in metres, in all directions."""

_FRICTION = 0.71
"""Of V-REP's default material on anything of friction 1."""

_WALLS, _THICK = 12, 0.004
"""Parts of the cup's wall, and their thickness in metres."""


def add_object(spec: Any, kind: str, mass: float, place: tuple[float, float, float]) -> None:
    """Add a free body `held`, as the import of a V-REP file makes it."""
    body = spec.worldbody.add_body(name="held", pos=place)
    body.add_freejoint(name="held")
    types = mujoco.mjtGeom
    if kind == "box":
        geoms = [body.add_geom(type=types.mjGEOM_BOX, size=[_HALF] * 3)]
    elif kind == "cylinder":
        geoms = [body.add_geom(type=types.mjGEOM_CYLINDER, size=[_HALF, _HALF, 0])]
    else:
        parts = _cup() if kind == "cup" else [_pebble()]
        geoms = [_add_mesh(spec, body, f"held:{number}", part) for number, part in enumerate(parts)]
    for geom in geoms:
        geom.mass = mass / len(geoms)
        geom.friction[0], geom.priority, geom.solref = _FRICTION, 35, (0.005, 1.0)


def add_pedestal(spec: Any, place: tuple[float, float, float]) -> None:
    """Add what the object stands on, so slender that fingers pass by."""
    spec.worldbody.add_geom(
        name="pedestal",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[0.012, 0.2, 0],
        pos=(place[0], place[1], place[2] - _HALF - 0.2),
        friction=(1.0, 0.005, 0.0001),
        solref=(0.005, 1.0),
    )


def _add_mesh(spec: Any, body: Any, name: str, vertices: NDArray[np.float64]) -> Any:
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
    mesh.uservert = vertices.ravel()
    return body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name)


def _cup() -> list[NDArray[np.float64]]:
    """Return the corners of an open cup's parts: a floor, and a wall all around."""
    angles = 2 * math.pi / _WALLS * (np.arange(_WALLS + 1) - 0.5)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    outer = _HALF / math.cos(math.pi / _WALLS)
    levels = (-_HALF, -_HALF + _THICK), (-_HALF + _THICK, _HALF)
    floor, walls = levels
    parts = [np.array([(*(outer * each), z) for each in circle for z in floor])]
    for one, other in itertools.pairwise(circle):
        corners = [radius * each for radius in (outer, outer - _THICK) for each in (one, other)]
        parts.append(np.array([(*corner, z) for corner in corners for z in walls]))
    return parts


def _pebble() -> NDArray[np.float64]:
    """Return the corners of a convex mesh with small flat faces: a sphere of 48 mm cut flat on all sides."""
    along = [np.arccos(np.linspace(1, -1, 9)), np.linspace(0, 2 * math.pi, 16, endpoint=False)]
    polar, around = (each.ravel() for each in np.meshgrid(*along))
    ball = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=1)
    return np.clip(1.3 * _HALF * ball, -_HALF, _HALF)
