"""An overview for small images: as near as the things that move allow, and following them in jumps.

MuJoCo's free camera shows the whole scene, with its floor; in an image of a few hundred pixels a robot is then a few
pixels large. A camera that followed each movement would hide it, so this one stays in place as long as it can.
"""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import Viewpoint

FILLED = 0.45
"""Share of the view that things must fill at least; otherwise the camera comes nearer."""

ROOM = 1.4
"""Radius of the view over that of the things, when the camera is placed."""

SMALLEST = 0.03
"""Least radius of a view in extents of the scene: the near clipping plane must stay in front of the things."""


class CloseUp:
    """The camera's place for one model. Physics thread only."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find the geoms that can move; a scene without such keeps the free camera."""
        self.model = model
        bodies = model.geom_bodyid
        moves = (model.body_weldid[bodies] != 0) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE.value)
        self._geoms: NDArray[np.intp] = np.flatnonzero(moves)
        self._sizes: NDArray[np.float64] = model.geom_rbound[self._geoms][:, None]
        self._extent = float(model.stat.extent)
        self._slope = math.sin(math.radians(float(model.vis.global_.fovy)) / 2)
        self._is_orthographic = bool(model.vis.global_.orthographic)
        self._centre: NDArray[np.float64] = np.zeros(3)
        self._radius = 0.0

    def viewpoint(self, data: mujoco.MjData, free: Viewpoint) -> Viewpoint:
        """Return where to look from, in the direction of a camera and not from further away.

        Args:
            data: the state, with forward kinematics done.
            free: the camera that shows the whole scene.
        """
        if not self._geoms.size or self._is_orthographic:
            return free
        places = data.geom_xpos[self._geoms]
        low, high = (places - self._sizes).min(axis=0), (places + self._sizes).max(axis=0)
        centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
        if not math.isfinite(radius):
            return free
        is_inside = float(np.linalg.norm(centre - self._centre)) + radius <= self._radius
        smallest = SMALLEST * self._extent
        is_small = radius < FILLED * self._radius and self._radius > smallest
        if not is_inside or is_small:
            self._centre, self._radius = centre, max(ROOM * radius, smallest)
        distance = self._radius / self._slope
        if distance >= free.distance:
            return free
        return replace(free, lookat=tuple(self._centre.tolist()), distance=distance)


def viewpoint_of(data: mujoco.MjData, camera_id: int) -> Viewpoint:
    """Return the view of a camera of the model, upright; its distance is that to the middle of the scene."""
    position = data.cam_xpos[camera_id]
    forward = -data.cam_xmat[camera_id].reshape(3, 3)[:, 2]
    distance = float(np.linalg.norm(position - data.model.stat.center)) or 1.0
    return Viewpoint(
        tuple((position + distance * forward).tolist()),
        distance,
        math.degrees(math.atan2(forward[1], forward[0])),
        math.degrees(math.asin(float(np.clip(forward[2], -1.0, 1.0)))),
    )
