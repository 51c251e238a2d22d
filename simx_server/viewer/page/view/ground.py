"""Find the bodies that are the ground: a click there turns the view and selects nothing."""

from __future__ import annotations

import mujoco
import numpy as np

from simx_server.sensors.vision.content import geom_boxes, is_flat_and_wide
from simx_server.viewer.page.mirror import Copy


def is_ground(copy: Copy, body: int) -> bool:
    """Return whether a body never moves and is a plane, or flat and as wide as half of the scene."""
    model, data = copy.model, copy.data
    if model.body_weldid[body] != 0:
        return False
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    if not count:
        return False
    geoms = slice(first, first + count)
    if np.any(model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_PLANE.value):
        return True
    low, high = geom_boxes(model, data)
    least, greatest = low[geoms].min(axis=0), high[geoms].max(axis=0)
    return bool(is_flat_and_wide(least, greatest, float(model.stat.extent)))
