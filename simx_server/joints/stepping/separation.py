"""Overlapping shapes part at a walking pace: what overlaps at the start, or is put into something, does not explode.

MuJoCo pushes two shapes apart the harder the deeper they overlap. So the reference acceleration of deep contacts is
limited, within a physics step, to what gives them a speed of separation. Damping and bounce stay as they are.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

DEEP = 0.01
"""Metres of overlap from which on contacts are limited; of less, MuJoCo's push is gentle."""

FASTEST = 1.0
"""Greatest speed in m/s that an overlap gives."""

_DAMPING = 1
"""Column of MuJoCo's `efc_KBIP`."""


def has_deep_contacts(data: mujoco.MjData) -> bool:
    """Return whether anything overlapped deeply in the last physics step."""
    return data.ncon > 0 and float(data.contact.dist.min()) < -DEEP


def limit_separation(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Limit the push of deep contacts in this physics step; see `stepper.Within`."""
    if not has_deep_contacts(data):
        return
    contacts = data.contact
    first = contacts.efc_address
    chosen: NDArray[np.bool_] = (contacts.dist < -DEEP) & (first >= 0)
    rows: NDArray[np.intp] = first[chosen].astype(np.intp)
    if (
        model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL.value
    ):  # each edge of the pyramid has a part of the normal
        edges: NDArray[np.intp] = np.maximum(1, 2 * (contacts.dim[chosen] - 1))
        within = np.arange(int(edges.sum())) - np.repeat(np.cumsum(edges) - edges, edges)
        rows = np.repeat(rows, edges) + within
    speed = data.efc_vel[rows]
    damping = -data.efc_KBIP[rows, _DAMPING] * speed
    most = np.maximum(damping, (FASTEST - speed) / model.opt.timestep)
    data.efc_aref[rows] = np.minimum(data.efc_aref[rows], most)
