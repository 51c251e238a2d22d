"""Find the bodies that are the ground: a click there turns the view and selects nothing."""

from __future__ import annotations

import mujoco
import numpy as np

from .mirror import Copy

_FLAT = 0.1
"""Height of a ground as a share of its narrower side, at most."""

_WIDE = 0.5
"""Narrower side of a ground as a share of the scene's extent, at least."""


def is_ground(copy: Copy, body: int) -> bool:
    """Return whether a body never moves and is a plane, or flat and as wide as half of the scene."""
    model, data = copy.model, copy.data
    if model.body_weldid[body] != 0:
        return False
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    if not count:
        return False
    geoms = slice(first, first + count)
    if np.any(model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_PLANE):
        return True
    turns = data.geom_xmat[geoms].reshape(-1, 3, 3)
    boxes = model.geom_aabb[geoms]  # centre and half sides, in the geom's frame
    centres = data.geom_xpos[geoms] + np.einsum("gij,gj->gi", turns, boxes[:, :3])
    halves = np.einsum("gij,gj->gi", np.abs(turns), boxes[:, 3:])
    sides = np.max(centres + halves, axis=0) - np.min(centres - halves, axis=0)
    width = float(min(sides[:2]))
    return bool(sides[2] <= _FLAT * width and width >= _WIDE * model.stat.extent)
