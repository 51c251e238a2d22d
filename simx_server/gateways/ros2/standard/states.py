"""States and bounds of entities: where they are, how they move, and the calls that place them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_client.protocol import constants as c
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses import frames
from simx_server.scene.poses.placing import body_pose, free_joint, object_pose
from simx_server.scene.poses.poses import Pose, Vector, compose, rotate
from simx_server.simulation.simulation import Simulation, SimulationState

from ..annotated.odometry import quaternion, vector
from ..content.naming import WORLD, frame_name
from ..endpoints import Message, Moment
from ..table_call import Call
from .filters import BOX, EMPTY, box_of
from .results import FAILED, Refused

if TYPE_CHECKING:
    from simx_server.world.world import World

FARTHEST = 1e6
"""Metres from the origin that an entity may be placed at, and m/s and rad/s that it may get."""

_FIRST_VELOCITY = (
    c.sim_shapefloatparam_init_velocity_x,
    c.sim_shapefloatparam_init_velocity_y,
    c.sim_shapefloatparam_init_velocity_z,
    c.sim_shapefloatparam_init_velocity_a,
    c.sim_shapefloatparam_init_velocity_b,
    c.sim_shapefloatparam_init_velocity_g,
)
"""V-REP's parameters of the first velocity: linear, then angular."""


def pose_message(pose: Pose) -> Message:
    """Return a ``geometry_msgs/Pose``."""
    return {"position": vector(pose[0]), "orientation": quaternion(pose[1])}


def state_messages(world: World, items: Iterable[SceneObject], moment: Moment) -> list[Message]:
    """Return ``EntityState`` of each in the world: the pose now, velocity over and acceleration in the last step."""
    simulation = world.simulation
    simulation.refresh()
    moves = simulation.state is not SimulationState.STOPPED and not simulation.is_before_first_step
    if moves:
        mujoco.mj_rnePostConstraint(simulation.model, simulation.data)  # accelerations of all bodies
    return [_state_message(world, item, moment, has_acceleration=moves) for item in items]


def _state_message(world: World, item: SceneObject, moment: Moment, *, has_acceleration: bool) -> Message:
    simulation = world.simulation
    linear, _, angular = world.velocities.measure(item.handle)
    if simulation.state is SimulationState.STOPPED:
        linear, angular = [0.0] * 3, [0.0] * 3
    acceleration = _acceleration(simulation, item) if has_acceleration else (0.0,) * 6
    return {
        "header": moment.header(WORLD),
        "pose": pose_message(object_pose(simulation, item)),
        "twist": {"linear": vector(tuple(linear)), "angular": vector(tuple(angular))},
        "acceleration": {"linear": vector(acceleration[3:]), "angular": vector(acceleration[:3])},
    }


def _acceleration(simulation: Simulation, item: SceneObject) -> tuple[float, ...]:
    """Return angular and linear acceleration, rad/s² and m/s², world axes; of what has no body, zero."""
    if item.body <= 0:
        return (0.0,) * 6
    model, data = simulation.model, simulation.data
    found = np.empty(6)
    mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, item.body, found, 0)
    found[3:] += model.opt.gravity  # MuJoCo's is that of a scale: at rest +9.81 upwards
    return tuple(found.tolist())


def bounds_message(world: World, item: SceneObject) -> Message:
    """Return the ``Bounds`` of an entity in its own frame: upper and lower corner; empty without a form."""
    box = box_of(world, item)
    if box is None:
        return {"type": EMPTY, "points": []}
    return {"type": BOX, "points": [vector(tuple(box[1].tolist())), vector(tuple(box[0].tolist()))]}


def read_pose(world: World, header: Mapping[str, Any], pose: Mapping[str, Any], code: int) -> Pose:
    """Return a pose of a message in the world.

    Raises:
        Refused: with this code: the frame is unknown, a number is not finite or too large, or the quaternion is zero.
    """
    place = tuple(float(pose["position"][axis]) for axis in "xyz")
    turn = tuple(float(pose["orientation"][axis]) for axis in "wxyz")
    length = math.sqrt(sum(part * part for part in turn))
    if not all(abs(each) <= FARTHEST for each in place):  # false for NaN too
        raise Refused(
            code, f"the position {list(place)} is not valid; valid: finite numbers up to {FARTHEST:g} m"
        )
    if not 0.5 < length < 2:
        raise Refused(code, f"the quaternion has the length {length:g}; valid: a unit quaternion")
    w, x, y, z = (part / length for part in turn)
    return compose(
        frame_pose(world, header["frame_id"], code), ((place[0], place[1], place[2]), (w, x, y, z))
    )


def frame_pose(world: World, frame: str, code: int) -> Pose:
    """Return the pose of a frame in the world: that of an object, or `world`. Raises Refused."""
    simulation = world.simulation
    simulation.refresh()
    if frame in ("", WORLD):
        return (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    for item in simulation.scene.objects.values():
        if frame_name(item) == frame:
            return object_pose(simulation, item)
    raise Refused(code, f"the frame '{frame[:80]}' is unknown; valid: {WORLD}, or the name of an object")


def placing_calls(
    item: SceneObject, pose: Pose, velocity: tuple[Vector, Vector] | None = None
) -> Iterator[Call]:
    """Yield the calls that place an object with all below it.

    Args:
        velocity: linear and angular velocity of its body from then on, or from the start on; None: it is at rest.
    """
    yield Call("simxSetObjectQuaternion", [item.handle, -1, frames.xyzw_from_wxyz(pose[1])])
    if velocity is not None:  # the next call applies it
        for number, value in zip(_FIRST_VELOCITY, (*velocity[0], *velocity[1]), strict=True):
            yield Call("simxSetObjectFloatParameter", [item.handle, number, value])
    yield Call("simxSetObjectPosition", [item.handle, -1, list(pose[0])])


def moves_freely(world: World, item: SceneObject) -> bool:
    """Return whether an entity can get a velocity: physics moves it, and no joint holds it."""
    return (
        item.kind is ObjectKind.SHAPE
        and item.element == "body"
        and free_joint(world.simulation.model, item.body) >= 0
    )


def present_velocity(world: World, item: SceneObject) -> tuple[Vector, Vector]:
    """Return the linear and angular velocity of a body that moves freely, m/s and rad/s, world axes."""
    simulation = world.simulation
    simulation.refresh()
    dof = int(simulation.model.jnt_dofadr[free_joint(simulation.model, item.body)])
    x, y, z, *turning = simulation.data.qvel[dof : dof + 6].tolist()
    return (x, y, z), rotate(body_pose(simulation, item.body)[1], (turning[0], turning[1], turning[2]))


def read_twist(world: World, header: Mapping[str, Any], twist: Mapping[str, Any]) -> tuple[Vector, Vector]:
    """Return the linear and angular velocity of a message along world axes. Raises Refused."""
    turn = frame_pose(world, header["frame_id"], FAILED)[1]
    parts = [tuple(float(twist[part][axis]) for axis in "xyz") for part in ("linear", "angular")]
    if not all(abs(each) <= FARTHEST for part in parts for each in part):
        raise Refused(
            FAILED, f"the twist is not valid; valid: finite numbers up to {FARTHEST:g} m/s and rad/s"
        )
    linear, angular = (rotate(turn, (part[0], part[1], part[2])) for part in parts)
    return linear, angular
