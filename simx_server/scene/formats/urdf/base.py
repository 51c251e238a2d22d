"""Decide whether a robot from a URDF is fixed to the world or free, which the format does not define.

A robot that stands on moving links, such as wheels or legs, is free and is set down on the floor (z = 0). Any other
robot keeps the pose of its file, like an arm on its base; so does one whose root link is named ``world``. V-REP's
importer lifts a robot that would reach below the floor.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np

logger = logging.getLogger(__name__)

_LEVEL = 0.01
"""Height in metres above its lowest point within which a robot touches the floor."""

_TOUCH = 1e-3
"""Depth in metres below the floor that counts as touching it."""

_NARROW = 0.02
"""Largest radius in metres on which a round shape stands."""


@dataclass(frozen=True)
class Foot:
    """The part of a geom that would touch the floor."""

    lowest: float
    """Height of the lowest point of a geom in metres."""
    low: np.ndarray
    """Smallest x and y in metres of what is on the floor when the geom stands there."""
    high: np.ndarray
    """Largest x and y."""
    moves: bool
    is_wheel: bool
    """Whether a joint without limits turns it."""


def stand(spec: mujoco.MjSpec, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Free the robot that stands on moving links, and put it onto the floor; lift another one that reaches below it.

    Args:
        spec: the robot.
        model: the compiled spec.
        data: its state in the pose of the file, with the positions of all geoms.
    """
    feet = [foot_of(model, data, geom) for geom in range(model.ngeom) if model.geom_contype[geom]]
    if not feet:
        return
    lowest = min(foot.lowest for foot in feet)
    feet = [foot for foot in feet if foot.lowest <= lowest + _LEVEL]
    base = _loose_base(spec)
    if base is not None and _is_on_feet(feet, data.subtree_com[model.body(base.name).id][:2]):
        base.add_freejoint()
        base.pos[2] -= lowest
        logger.info("'%s' stands on its moving links, so it is free and set down on the floor", base.name)
    elif lowest < -_TOUCH:
        for element in (*spec.worldbody.bodies, *spec.worldbody.geoms):
            element.pos[2] -= lowest
        logger.info(
            "the robot reaches %.3f m below the floor, so it is lifted, as by V-REP's importer", -lowest
        )


def _loose_base(spec: mujoco.MjSpec) -> Any | None:
    """Return the body of the root link, if nothing says how it is connected to the world."""
    top = list(spec.worldbody.bodies)
    if len(top) != 1 or list(top[0].joints) or list(spec.worldbody.geoms):
        return None
    return top[0]


def _is_on_feet(feet: list[Foot], centre: np.ndarray) -> bool:
    """Return whether wheels or legs carry the robot: a hand that lies on its palm has a base."""
    if not any(foot.moves for foot in feet) or not _carry(feet, centre):
        return False
    fixed = [foot for foot in feet if not foot.moves]
    return any(foot.is_wheel for foot in feet) or not fixed or not _carry(fixed, centre)


def _carry(feet: list[Foot], centre: np.ndarray) -> bool:
    """Return whether the centre of mass is above the rectangle around the feet."""
    low = np.min([foot.low for foot in feet], axis=0)
    high = np.max([foot.high for foot in feet], axis=0)
    return bool(np.all((low <= centre) & (centre <= high)))


def foot_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Foot:
    """Return what a geom of a compiled model stands on in a state with its positions."""
    place, turn = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    body = int(model.body_weldid[model.geom_bodyid[geom]])
    joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
    is_wheel = any(
        model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE.value and not model.jnt_limited[joint]
        for joint in joints
    )
    kinds = (body != 0, is_wheel)
    corners = _corners(model, geom)
    if corners is None:
        reach = _reach(model, geom, model.geom_type[geom], model.geom_size[geom], -turn[2])
        width = min(float(model.geom_rbound[geom]), _NARROW)
        return Foot(float(place[2]) - reach, place[:2] - width, place[:2] + width, *kinds)
    points = corners @ turn.T + place
    lowest = float(points[:, 2].min())
    sole = points[points[:, 2] <= lowest + _LEVEL, :2]
    return Foot(lowest, sole.min(axis=0), sole.max(axis=0), *kinds)


def _corners(model: mujoco.MjModel, geom: int) -> np.ndarray | None:
    """Return the points (n, 3) of a mesh or box in the geom's frame; None for round shapes."""
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return model.mesh_vert[first : first + count].astype(float)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return np.array(list(product((-1.0, 1.0), repeat=3))) * size
    return None


def _reach(model: mujoco.MjModel, geom: int, kind: int, size: np.ndarray, way: np.ndarray) -> float:
    """Return the extent of a geom in metres from its centre in a direction of the geom's frame."""
    kinds = mujoco.mjtGeom
    if kind == kinds.mjGEOM_SPHERE:
        return float(size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return float(size[0] + size[1] * abs(way[2]))
    if kind == kinds.mjGEOM_CYLINDER:
        return float(size[0] * np.hypot(way[0], way[1]) + size[1] * abs(way[2]))
    return float(size @ np.abs(way))  # an ellipsoid at most; URDF has no other round types
