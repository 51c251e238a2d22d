"""Visibility for cameras: the rules that both renderers share, and which geoms lie beside the view."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from .image import CameraView

VISIBLE_GROUPS = (0, 1, 2)
"""MuJoCo geom groups that a camera sees; by MuJoCo's convention group 3 and up hold collision shapes."""

USERS_GROUP = 6
"""Group of the geoms of shapes that users see, and vision sensors do not: V-REP's property "renderable" is off.

Models get it while they run. MuJoCo takes groups above 5 for 5, which it hides unless told otherwise.
"""

SENSORS_GROUP = 7
"""Group of the geoms of shapes that vision sensors see, and users do not: their visibility layers are not shown."""

OPAQUE_ALPHA = 0.995
"""Minimum alpha of a geom that MuJoCo's renderer treats as opaque."""

_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)


def drawn(model: mujoco.MjModel, view: CameraView) -> NDArray[np.bool_]:
    """Return (ngeom,): whether a geom's group is one that the view shows."""
    seen = np.isin(model.geom_group, VISIBLE_GROUPS)
    return seen | (model.geom_group == (USERS_GROUP if view.is_users else SENSORS_GROUP))


def seen_by_users(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Return (ngeom,): whether users see a geom: by its group, and by the opacity of its colour."""
    own, material = model.geom_rgba[:, 3], model.geom_matid
    alpha = own.copy()
    # MuJoCo uses a material's colour while the geom's own one is the default.
    of_material = (material >= 0) & np.all(np.abs(model.geom_rgba - _DEFAULT_RGBA) < 1e-6, axis=1)
    alpha[of_material] = model.mat_rgba[material[of_material], 3]
    return np.isin(model.geom_group, (*VISIBLE_GROUPS, USERS_GROUP)) & (alpha > 0)


def near_the_view(model: mujoco.MjModel, data: mujoco.MjData, view: CameraView) -> NDArray[np.bool_]:
    """Return (ngeom,): whether a geom's bounding sphere reaches into the view; planes (no sphere) always do.

    Geoms that the view leaves out do not.
    """
    radius = model.geom_rbound
    eye, turn = view.pose(data)
    local = (data.geom_xpos - eye) @ turn
    depth = -local[:, 2]
    inside = (depth + radius > view.near) & (depth - radius < view.far)
    for axis, half in enumerate(view.half_extent()):
        if view.orthographic_size is None:
            # The distance from a side of the pyramid is |x| - half * depth, scaled by sqrt(1 + half^2).
            inside &= np.abs(local[:, axis]) - half * depth < radius * math.hypot(1.0, half)
        else:
            inside &= np.abs(local[:, axis]) - half < radius
    inside |= radius <= 0.0
    if view.only is not None:
        chosen = np.zeros(len(inside), bool)
        chosen[list(view.only)] = True
        inside &= chosen
    return inside
