"""A little mass for bodies that lost all of theirs in an edit: MuJoCo cannot move a body without mass."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

LEAST_MASS = 1e-3
"""kg."""

LEAST_INERTIA = 1e-6
"""kg m^2."""


def make_light(body: Any) -> None:
    """Give a body of an MjSpec the least mass."""
    body.explicitinertial = True
    body.mass, body.inertia = LEAST_MASS, [LEAST_INERTIA] * 3
    body.ipos, body.iquat = [0, 0, 0], [1, 0, 0, 0]
    body.fullinertia[:] = np.nan
    body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def keep_movable(spec: mujoco.MjSpec, name: str) -> None:
    """Give the body with joints that carries this one the least mass, if nothing on it has any."""
    body = spec.body(name) if name != "world" else None
    while body is not None and not list(body.joints):
        body = body.parent if body.parent.name != "world" else None
    if body is not None and not _has_mass(body):
        make_light(body)


def _has_mass(body: Any) -> bool:
    """Return whether a body, or one that is fixed to it, has mass."""
    waiting = [body]
    while waiting:
        one = waiting.pop()
        if one.explicitinertial:
            if one.mass > 0:
                return True
        elif any(not geom.mass <= 0 for geom in one.geoms):  # NaN: by density
            return True
        waiting += [child for child in one.bodies if not list(child.joints)]
    return False
