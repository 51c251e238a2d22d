"""Shapes that overlap when a scene is loaded: the physics pushes them apart, often violently."""

from __future__ import annotations

import logging
from collections.abc import Iterable

import mujoco
import numpy as np

from simx_server.scene.objects import Scene

logger = logging.getLogger(__name__)

_TOLERANCE = 1e-3
"""Tolerance in metres; objects that rest on each other overlap less."""

_MOST_NAMED = 5

_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


def overlaps(scene: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> dict[tuple[str, str], float]:
    """Return the pairs of objects that overlap by more than a millimetre, with the depth in m, the deepest first.

    Positions are those of `data`, which stays as it is; what follows from them has been computed.
    """
    if model.opt.enableflags & _SLEEP:
        data = _awake(model, data)
    found: dict[tuple[str, str], float] = {}
    for place in np.flatnonzero(data.contact.dist < -_TOLERANCE).tolist():
        contact = data.contact[place]
        depth = -float(contact.dist)
        if min(contact.geom) < 0 or _are_immovable(model, contact.geom):
            continue
        first, second = sorted(_name(scene, model, int(geom)) for geom in contact.geom)
        found[first, second] = max(depth, found.get((first, second), 0.0))
    return dict(sorted(found.items(), key=lambda pair: -pair[1]))


def _awake(model: mujoco.MjModel, data: mujoco.MjData) -> mujoco.MjData:
    """Return the same positions with the contacts of bodies that sleep in `data`, which has none of these."""
    awake = mujoco.MjData(model)
    awake.qpos[:], awake.eq_active[:] = data.qpos, data.eq_active
    awake.mocap_pos[:], awake.mocap_quat[:] = data.mocap_pos, data.mocap_quat
    mujoco.mj_fwdPosition(model, awake)
    return awake


def log_overlaps(scene: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Log a warning that names them, in one line."""
    found = overlaps(scene, model, data)
    if not found:
        return
    pairs = [f"'{one}' and '{other}' by {1000 * depth:.0f} mm" for (one, other), depth in found.items()]
    more = f" and {len(pairs) - _MOST_NAMED} more pairs" if len(pairs) > _MOST_NAMED else ""
    logger.warning(
        "objects overlap at the start and will be pushed apart: %s%s; move them, or part them by "
        "<exclude body1= body2=> under <contact>",
        ", ".join(pairs[:_MOST_NAMED]),
        more,
    )


def _are_immovable(model: mujoco.MjModel, geoms: Iterable[int]) -> bool:
    """Return whether physics moves none of these geoms: what only kinematic joints carry is not pushed apart."""
    return not any(model.body_invweight0[model.geom_bodyid[geom]].any() for geom in geoms)


def _name(scene: Scene, model: mujoco.MjModel, geom: int) -> str:
    handle = scene.owner_of_geom(geom, model)
    return scene.objects[handle].name if handle in scene.objects else "the world"
