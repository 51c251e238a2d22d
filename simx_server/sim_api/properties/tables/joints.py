"""Properties of joints: radians or metres, their rates per second, N m or N."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.joints import JointMode
from simx_server.scene.editing import marks
from simx_server.scene.poses.frames import xyzw_from_wxyz
from simx_server.scene.poses.poses import normalised
from simx_server.sim_api.properties.entry import Property, numbered, renamed
from simx_server.sim_api.properties.property_types import (
    BOOL,
    FLOAT,
    FLOAT_ARRAY,
    HANDLE,
    INT,
    POSE,
    QUATERNION,
)
from simx_server.sim_api.values.matrices import as_numbers

if TYPE_CHECKING:
    from simx_server.joints.joints import Joints
    from simx_server.world.world import World


def _joints(world: World) -> Joints:
    return world.simulation.joints


def _numbers(name: str, what: str, values: list[float], count: int) -> list[float]:
    if len(values) != count:
        raise CommandError(f"'{name}' is a table of {count} numbers, {what}, not of {len(values)}")
    return values


def _quaternion(world: World, handle: int) -> list[float]:
    _joints(world).spherical_state(handle)
    return list(xyzw_from_wxyz(_joints(world).intrinsic(handle)[1]))


def _set_quaternion(world: World, handle: int, quat: list[float]) -> None:
    x, y, z, w = quat
    try:
        turn = normalised((w, x, y, z))
    except ValueError as error:
        raise CommandError(f"{error} is no rotation") from None
    _joints(world).set_spherical_rotation(handle, turn)


def _drawn_size(name: str, place: int) -> Property:
    """Return length or diameter (m) with which V-REP's window draws a joint; `place`: 0 or 1."""

    def put(world: World, handle: int, value: float) -> None:
        if not 0 < value < math.inf:
            raise CommandError(f"'{name}' is a length in metres above 0, not {value:g}")
        item = world.simulation.scene.get(handle)
        length, diameter = marks.joint_sizes(item)
        sizes = (length, value) if place else (value, diameter)
        marks.set_joint_sizes(world.simulation, item, *sizes)

    def get(world: World, handle: int) -> float:
        return marks.joint_sizes(world.simulation.scene.get(handle))[place]

    return Property(name, FLOAT, get, put)


_POSITION = (
    _drawn_size("jointLength", 0),
    _drawn_size("jointDiameter", 1),
    Property("jointPosition", FLOAT, joints.get_joint_position, joints.set_joint_position),
    Property("jointQuaternion", QUATERNION, _quaternion, _set_quaternion),
    Property("jointType", INT, lambda world, handle: _joints(world).joint_type(handle)),
    numbered("calcVelocity", FLOAT, "jointfloatparam_velocity"),
    Property("intrinsicPose", POSE, lambda world, handle: as_numbers(_joints(world).intrinsic(handle))),
    Property("intrinsicError", POSE, lambda world, handle: as_numbers(_joints(world).separation(handle))),
)


def _interval(world: World, handle: int) -> list[float]:
    _, least, extent = _joints(world).interval(handle)
    return [least, least + extent]


def _set_interval(world: World, handle: int, bounds: list[float]) -> None:
    least, greatest = _numbers("interval", "the lower and the upper limit", bounds, 2)
    _joints(world).set_interval(handle, False, least, greatest - least)


def _set_cyclic(world: World, handle: int, cyclic: bool) -> None:
    was_cyclic, least, extent = _joints(world).interval(handle)
    if cyclic != was_cyclic:
        _joints(world).set_interval(handle, cyclic, least, extent)


_LIMITS = (
    Property("cyclic", BOOL, lambda world, handle: _joints(world).interval(handle)[0], _set_cyclic),
    Property("interval", FLOAT_ARRAY, _interval, _set_interval),
)


def _set_mode(world: World, handle: int, mode: int) -> None:
    if mode not in tuple(JointMode):
        known = ", ".join(f"{int(each)} {each.name.lower()}" for each in JointMode)
        raise CommandError(f"{mode} is no joint mode; those are {known}")
    _joints(world).set_mode(handle, JointMode(mode))


def _motion(world: World, handle: int) -> list[float]:
    state = _joints(world).state(handle)
    return [state.upper_velocity, state.acceleration, state.jerk]


def _set_motion(world: World, handle: int, values: list[float]) -> None:
    what = "the greatest velocity, acceleration and jerk"
    _joints(world).limit_motion(handle, _numbers("maxVelAccelJerk", what, values, 3))


def _settings(name: str, what: str, fields: tuple[str, ...]) -> Property:
    """Return a table of settings of a joint's controller."""

    def get(world: World, handle: int) -> list[float]:
        state = _joints(world).state(handle)
        return [getattr(state, field) for field in fields]

    def put(world: World, handle: int, values: list[float]) -> None:
        found = _numbers(name, what, values, len(fields))
        if fields[0] == "p" and min(found) < 0:
            raise CommandError(f"the gains of a position controller must not be below 0, not {found}")
        _joints(world).change(handle, **dict(zip(fields, found, strict=True)))

    return Property(name, FLOAT_ARRAY, get, put)


def _force(world: World, handle: int) -> float:
    return joints.get_joint_force(world, handle)


_CONTROL = (
    Property("jointMode", INT, lambda world, handle: int(_joints(world).mode(handle)), _set_mode),
    numbered("dynCtrlMode", INT, "jointintparam_dynctrlmode"),
    Property(
        "targetPos",
        FLOAT,
        lambda world, handle: _joints(world).target_position(handle),
        joints.set_joint_target_position,
    ),
    Property(
        "targetVel",
        FLOAT,
        lambda world, handle: _joints(world).target_velocity(handle),
        joints.set_joint_target_velocity,
    ),
    Property(
        "targetForce",
        FLOAT,
        lambda world, handle: _joints(world).target_force(handle),
        lambda world, handle, force: _joints(world).set_target_force(handle, force),
    ),
    Property("jointForce", FLOAT, _force),
    Property("averageJointForce", FLOAT, _force),
    Property("maxVelAccelJerk", FLOAT_ARRAY, _motion, _set_motion),
    _settings("springDamperParams", "the spring constant and the damping", ("k", "c")),
    *(
        _settings(f"{engine}.posPid", "the gains P, I and D", ("p", "i", "d"))
        for engine in ("bullet", "ode", "vortex", "newton", "mujoco")
    ),
)
"""There is one force, the mean over a simulation step, and one position controller for the names of all engines."""


def _dependency(world: World, handle: int) -> list[float]:
    state = _joints(world).state(handle)
    return [state.shift, state.factor]


def _set_dependency(world: World, handle: int, values: list[float]) -> None:
    shift, factor = _numbers("dependencyParams", "offset and factor", values, 2)
    _joints(world).set_dependency(handle, shift=shift, factor=factor)


_MASTER = numbered("dependencyMasterHandle", INT, "jointintparam_vortex_dep_handle")

_DEPENDENCY = (
    _MASTER,
    renamed(_MASTER, "dependencyMaster", HANDLE),
    Property("dependencyParams", FLOAT_ARRAY, _dependency, _set_dependency),
)

JOINTS = (*_POSITION, *_LIMITS, *_CONTROL, *_DEPENDENCY)
