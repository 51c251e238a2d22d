"""V-REP's primitives as geoms of MuJoCo, where those have the same form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from simx_server.scene.formats.vrep.objects import Leaf, Primitive

_GEOM = mujoco.mjtGeom

_ALIKE = 1e-3
"""Difference, in parts, up to which two sizes are equal."""

_ROUND = 24
"""Points of a mesh below which a round primitive looks angular in V-REP, and is drawn as it is."""

_LEAST = 1e-5
"""Least half size of a geom in metres."""


@dataclass(frozen=True)
class Form:
    """A geom's type and size, as MuJoCo counts them."""

    type: mujoco.mjtGeom
    size: tuple[float, float, float]


def form_of(leaf: Leaf) -> Form | None:
    """Return the geom with the form of a leaf; None where MuJoCo has none, and for damaged sizes.

    A primitive whose mesh has another size than it says is a mesh.
    """
    if not all(math.isfinite(size) and size >= 0 for size in leaf.size) or not _fits(leaf):
        return None
    x, y, z = (max(size / 2, _LEAST) for size in leaf.size)
    is_round = _alike(x, y)
    match leaf.primitive:
        case Primitive.CUBOID:
            return Form(_GEOM.mjGEOM_BOX, (x, y, z))
        case Primitive.SPHEROID if is_round and _alike(x, z):
            return Form(_GEOM.mjGEOM_SPHERE, (x, 0.0, 0.0))
        case Primitive.SPHEROID:
            return Form(_GEOM.mjGEOM_ELLIPSOID, (x, y, z))
        case Primitive.CYLINDER if is_round:
            return Form(_GEOM.mjGEOM_CYLINDER, (x, z, 0.0))
        case Primitive.CAPSULE if is_round and z - x > _LEAST:
            return Form(_GEOM.mjGEOM_CAPSULE, (x, z - x, 0.0))
        case Primitive.CAPSULE if is_round:
            return Form(_GEOM.mjGEOM_SPHERE, (x, 0.0, 0.0))
        case _:
            return None


def looks_round(leaf: Leaf) -> bool:
    """Return whether V-REP draws a round primitive with enough corners to look round; True for others."""
    is_round = leaf.primitive in (Primitive.SPHEROID, Primitive.CYLINDER, Primitive.CAPSULE)
    return not is_round or not len(leaf.vertices) or len(leaf.vertices) >= _ROUND


def _fits(leaf: Leaf) -> bool:
    if not len(leaf.vertices):
        return True
    extent = np.ptp(leaf.vertices, axis=0)
    # A round mesh with few corners does not reach its size on each side.
    tolerance = 0.15 if leaf.primitive != Primitive.CUBOID else _ALIKE
    largest = max(float(extent.max()), *leaf.size)
    return bool((np.abs(extent - leaf.size) <= tolerance * largest).all())


def _alike(a: float, b: float) -> bool:
    return abs(a - b) <= _ALIKE * max(a, b)
