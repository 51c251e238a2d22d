"""Geoms that collide in place of others of their shape, which show its form.

MuJoCo's geoms are convex, so a mesh that is not collides by others; those are in the last group. For measurements, and
for what programs read of a shape, only its form counts.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.objects import Scene

STAND_IN_GROUP = 5
"""Group in the scene file of geoms that collide in place of others; alone in their shape, they are its form."""


def stand_ins(scene: Scene, model: mujoco.MjModel, owners: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return (ngeom,): which geoms are stand-ins.

    Args:
        owners: (ngeom,) handle of each geom's shape, -1 for those without one.
    """
    groups = model.geom_group.copy()
    for (name, array), group in scene.withheld.items():
        if array == "geom_group":  # the group of the file, while another one hides the geom
            groups[model.geom(name).id] = group
    hidden = groups == STAND_IN_GROUP
    return hidden & (owners >= 0) & np.isin(owners, owners[~hidden])
