"""The number of corners that round geoms need to look round: MuJoCo uses one number for a whole image.

A circle of r pixels drawn with n corners is at most r (1 - cos(pi / n)) pixels off. A whole robot cell seen from
afar consists of many cylinders a few pixels thick, and their corners are most of the cost of its image.
"""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.cameras.image import CameraView
from simx_server.scene.cameras.visibility import VISIBLE_GROUPS

_ROUND = (
    int(mujoco.mjtGeom.mjGEOM_SPHERE),
    int(mujoco.mjtGeom.mjGEOM_CAPSULE),
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID),
    int(mujoco.mjtGeom.mjGEOM_CYLINDER),
)
TOLERANCE_PIXELS = 0.15
MANY = 12
"""Number of round geoms from which fewer corners pay: fewer geoms cost less than a millisecond."""


def round_geoms(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Return (ngeom,): the geoms that are drawn with corners although they have none."""
    return np.isin(model.geom_type, _ROUND)


def may_be_coarse(
    model: mujoco.MjModel, data: mujoco.MjData, view: CameraView, chosen: NDArray[np.intp], corners: int
) -> bool:
    """Return whether the round geoms `chosen` near the view are many, and `corners` are enough for all of them."""
    if len(chosen) < MANY:
        return False
    chosen = chosen[np.isin(model.geom_group[chosen], VISIBLE_GROUPS)]
    if len(chosen) < MANY:
        return False
    size: NDArray[np.float64] = model.geom_size[chosen]
    # The first size of capsules and cylinders is their radius, the second their half length.
    is_ellipsoid: NDArray[np.bool_] = model.geom_type[chosen] == mujoco.mjtGeom.mjGEOM_ELLIPSOID.value
    radius = np.where(is_ellipsoid, size.max(axis=1), size[:, 0])
    pixels_per_metre = 0.5 * view.height / view.half_extent()[1]
    if view.orthographic_size is not None:
        largest = radius.max() * pixels_per_metre
    else:
        eye, turn = view.pose(data)
        depth = (eye - data.geom_xpos[chosen]) @ turn[:, 2]
        nearest = np.maximum(depth - model.geom_rbound[chosen], view.near)
        largest = (radius / nearest).max() * pixels_per_metre
    return bool(largest * (1.0 - math.cos(math.pi / corners)) <= TOLERANCE_PIXELS)
