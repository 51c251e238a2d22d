"""The numbers of an observation and of an action, by name: ``UR5_joint1.position``, ``Cube.quaternion``.

The names are those of `simx_client.gym`. A recording has them all, so they are chosen when it is exported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import mujoco

from simx_client.protocol.constants import sim_joint_spherical_subtype
from simx_server.errors import CommandError
from simx_server.joints.servo import Rule
from simx_server.joints.state import JointMode
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import object_pose

if TYPE_CHECKING:
    from simx_server.world.world import World

Read = Callable[["World", int], Sequence[float]]
"""Returns the numbers of an object, by its handle."""

_AXES = ("x", "y", "z")

TELEOPERATION = "teleoperation.velocity"
"""The velocity at which an operator moved the tip of an arm: m/s and rad/s, axes of the world."""


@dataclass(frozen=True)
class Quantity:
    """One quantity of a scene that is open."""

    names: tuple[str, ...]
    """The name of each number."""

    read: Callable[[], Sequence[float]]
    is_of_robot: bool
    """Whether it belongs to joints; otherwise to the surroundings."""


def find(world: World, text: str) -> Quantity:
    """Return the quantity of a name. Raises CommandError: the scene has no such object or property."""
    if text == TELEOPERATION:
        names = (*(f"{text}.{axis}" for axis in _AXES), *(f"{text}.about_{axis}" for axis in _AXES))
        return Quantity(names, lambda: world.arm_drive.twist, is_of_robot=True)
    name, _, attribute = text.rpartition(".")
    if attribute in _SIGNALS:
        table = getattr(world.signals, _SIGNALS[attribute])
        return Quantity((text,), lambda: (float(table.get(name, 0)),), is_of_robot=True)
    item = world.simulation.scene.get(world.simulation.scene.resolve(name))
    is_joint = item.kind == ObjectKind.JOINT
    of_kind = _OF_JOINT if is_joint else _OF_OBJECT
    if attribute not in of_kind:
        valid = ", ".join([*of_kind, *_SIGNALS])
        raise CommandError(f"'{text}': '{name}' has no {attribute or 'property'}; valid: {valid}")
    parts, read = of_kind[attribute]
    names = tuple(f"{text}.{part}" for part in parts) or (text,)
    return Quantity(names, partial(read, world, item.handle), is_of_robot=is_joint)


def usual_observations(world: World) -> list[str]:
    """Return the names of what is observed where nothing is chosen: joints, and poses of all free bodies."""
    scene, model = world.simulation.scene, world.simulation.model
    joints = [scene.get(handle).name for handle in _moved_joints(world)]
    free = model.jnt_bodyid[model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)].tolist()
    bodies = [
        scene.get(handle).name for body in free if (handle := scene.by_element("body", int(body))) is not None
    ]
    return [
        *(f"{name}.position" for name in joints),
        *(f"{name}.velocity" for name in joints),
        *(f"{name}.{part}" for name in bodies for part in ("position", "quaternion")),
    ]


def usual_actions(world: World) -> list[str]:
    """Return the names of what is commanded where nothing is chosen: what the motor of each joint obeys."""
    joints, scene = world.simulation.joints, world.simulation.scene
    found: list[str] = []
    for handle in _moved_joints(world):
        rule, name = joints.rule(handle), scene.get(handle).name
        if rule in (Rule.VELOCITY, Rule.HOLD, Rule.MOTION):
            found.append(f"{name}.target_velocity")
        elif rule != Rule.FREE:
            by_target = joints.mode(handle) == JointMode.FORCE or joints.is_hybrid(handle)
            found.append(f"{name}.{'target_position' if by_target else 'position'}")
    return found


def _moved_joints(world: World) -> list[int]:
    """Return the joints with one number that do not follow others."""
    joints = world.simulation.joints
    return [
        handle
        for handle in world.simulation.scene.of_kind(ObjectKind.JOINT)
        if joints.rule(handle) != Rule.DEPENDENT and joints.joint_type(handle) != sim_joint_spherical_subtype
    ]


_SIGNALS = {"int_signal": "integers", "float_signal": "floats"}


def _position(world: World, handle: int) -> Sequence[float]:
    return object_pose(world.simulation, world.simulation.scene.get(handle))[0]


def _quaternion(world: World, handle: int) -> Sequence[float]:
    w, x, y, z = object_pose(world.simulation, world.simulation.scene.get(handle))[1]
    return x, y, z, w


_OF_OBJECT: Mapping[str, tuple[Sequence[str], Read]] = {
    "position": (_AXES, _position),
    "quaternion": ((*_AXES, "w"), _quaternion),
    "velocity": (_AXES, lambda world, handle: world.velocities.measure(handle)[0]),
    "angular_velocity": (_AXES, lambda world, handle: world.velocities.measure(handle)[2]),
}

_OF_JOINT: Mapping[str, tuple[Sequence[str], Read]] = {
    "position": ((), lambda world, handle: (world.simulation.joints.position(handle),)),
    "velocity": ((), lambda world, handle: (world.simulation.joints.velocity(handle),)),
    "force": ((), lambda world, handle: (world.simulation.joints.force(handle),)),
    "target_position": ((), lambda world, handle: (world.simulation.joints.target_position(handle),)),
    "target_velocity": ((), lambda world, handle: (world.simulation.joints.target_velocity(handle),)),
}
