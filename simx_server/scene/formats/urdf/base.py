"""Decide whether a robot from a URDF is fixed to the world or free, which the format does not define.

A robot that stands on moving links, such as wheels or legs, is free and is set down on the floor (z = 0). Any other
robot keeps the pose of its file, like an arm on its base; so does one whose root link is named ``world``.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import mujoco
import numpy as np

logger = logging.getLogger(__name__)

_LEVEL = 0.01
"""Height in metres above its lowest point within which a robot touches the floor."""


@dataclass(frozen=True)
class _Foot:
    lowest: float
    """Height of the lowest point of a geom in metres."""
    place: np.ndarray
    """x and y of the foot's centre in metres."""
    width: float
    """Radius around the centre in metres."""
    moves: bool


def stand(spec: mujoco.MjSpec) -> None:
    """Free the robot that stands on moving links, and set it down. Raises ValueError where MuJoCo cannot compile it."""
    top = [body for body in spec.worldbody.bodies if not list(body.joints)]
    if len(top) != 1 or len(list(spec.worldbody.bodies)) != 1 or list(spec.worldbody.geoms):
        return
    base = top[0]
    if not any(not geom.contype == geom.conaffinity == 0 for geom in spec.geoms):
        return
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    feet = [_foot(model, data, geom) for geom in range(model.ngeom) if model.geom_contype[geom]]
    lowest = min(foot.lowest for foot in feet)
    feet = [foot for foot in feet if foot.lowest <= lowest + _LEVEL]
    if not any(foot.moves for foot in feet) or not _carry(
        feet, data.subtree_com[model.body(base.name).id][:2]
    ):
        return
    base.add_freejoint()
    base.pos[2] -= lowest
    logger.info("'%s' stands on its moving links, so it is free and set down on the floor", base.name)


def _carry(feet: list[_Foot], centre: np.ndarray) -> bool:
    """Return whether the centre of mass is above the rectangle around the feet."""
    low = np.min([foot.place - foot.width for foot in feet], axis=0)
    high = np.max([foot.place + foot.width for foot in feet], axis=0)
    return bool(np.all((low <= centre) & (centre <= high)))


def _foot(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> _Foot:
    down = -data.geom_xmat[geom].reshape(3, 3)[2]  # the world's -z in the geom's frame
    size, kind = model.geom_size[geom], model.geom_type[geom]
    reach = _reach(model, geom, kind, size, down)
    place = data.geom_xpos[geom]
    moves = bool(model.body_weldid[model.geom_bodyid[geom]] != 0)
    return _Foot(
        float(place[2]) - reach, place[:2].copy(), min(float(model.geom_rbound[geom]), _LEVEL * 2), moves
    )


def _reach(model: mujoco.MjModel, geom: int, kind: int, size: np.ndarray, way: np.ndarray) -> float:
    """Return the extent of a geom in metres from its centre in a direction of the geom's frame."""
    kinds = mujoco.mjtGeom
    if kind == kinds.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return float(np.max(model.mesh_vert[first : first + count] @ way))
    if kind == kinds.mjGEOM_SPHERE:
        return float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return float(size[0] + size[1] * abs(way[2]))
    if kind == kinds.mjGEOM_CYLINDER:
        return float(size[0] * np.hypot(way[0], way[1]) + size[1] * abs(way[2]))
    return float(np.abs(way) @ size)  # a box; URDF has no other types
