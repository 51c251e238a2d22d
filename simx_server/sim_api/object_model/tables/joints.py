"""Properties of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.joints import JointMode
from simx_server.sim_api.object_model.types import enum_of
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed
from simx_server.sim_api.properties.tables.joints import JOINTS

from .making import Old, engine_properties, kept_colors

if TYPE_CHECKING:
    from simx_server.world.world import World

_OLD = Old(JOINTS)


def _configuration(world: World, handle: int) -> list[float]:
    """Return the position, or the quaternion x, y, z, w of a spherical joint."""
    name = "jointQuaternion" if _is_spherical(world, handle) else "jointPosition"
    get = _OLD[name].get
    assert get is not None
    found = get(world, handle)
    return list(cast(list[float], found)) if isinstance(found, list) else [found]


def _set_configuration(world: World, handle: int, values: list[float]) -> None:
    is_spherical = _is_spherical(world, handle)
    if len(values) != (4 if is_spherical else 1):
        raise CommandError(
            f"'configuration' of this joint is a list of {4 if is_spherical else 1}, not {len(values)}"
        )
    put = _OLD["jointQuaternion" if is_spherical else "jointPosition"].set
    assert put is not None
    put(world, handle, values if is_spherical else values[0])


def _is_spherical(world: World, handle: int) -> bool:
    return world.simulation.joints.joint_type(handle) == c.sim_joint_spherical_subtype


def _mode(world: World, handle: int) -> int:
    """Return an item of jointMode: the modes of V-REP that move a joint without forces are kinematic."""
    mode = int(world.simulation.joints.mode(handle))
    return mode if mode >= JointMode.DEPENDENT else int(JointMode.PASSIVE)


_PID = _OLD.named("mujoco.posPid", "dynamics.mujoco.posPid")

JOINT = (
    *_OLD.same(
        "cyclic dependencyMaster dependencyParams intrinsicError intrinsicPose maxVelAccelJerk targetForce"
    ),
    _OLD.named("jointPosition", "joint.position"),
    _OLD.named("jointQuaternion", "joint.quaternion"),
    _OLD.worded("jointType", "joint.type", "jointType"),
    Property("mode", enum_of("jointMode"), _mode, _OLD["jointMode"].set),
    _OLD.enumerated("dynCtrlMode", "dynamics.ctrlMode", "jointDynamicsCtrlMode"),
    _OLD.named("calcVelocity", "velocity"),
    _OLD.named("jointForce", "force"),
    _OLD.named("averageJointForce", "averageForce"),
    _OLD.named("interval", "bounds"),
    _OLD.named("targetPos", "targetPosition"),
    _OLD.named("targetVel", "targetVelocity"),
    _OLD.named("springDamperParams", "dynamics.springDamperParams"),
    _PID,
    engine_properties([_PID]),
    Property("configuration", t.FLOAT_ARRAY, _configuration, _set_configuration),
    fixed(
        "dynamics.smoothMotionProfile", t.BOOL, False, "motion profiles are for joints outside dynamic mode"
    ),
    fixed("enforceBounds", t.BOOL, True, "the limits of a joint are part of physics"),
    fixed("screwLead", t.FLOAT, 0.0, "a joint turns or slides; couple two joints by an equality of the MJCF"),
    _OLD.named("jointLength", "length"),
    _OLD.named("jointDiameter", "diameter"),
    *kept_colors("color"),
)
