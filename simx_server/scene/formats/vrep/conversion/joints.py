"""Joints of a V-REP file: types, modes, motors, limits."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from simx_server.scene.formats.vrep.objects import Joint, JointType
from simx_server.scene.naming.names import INTERNAL

from .context import Conversion
from .numbers import finite, positive, unusual
from .structure import position_of

_MODES = {0: "passive", 1: "motion", 2: "ik", 3: "dependent", 4: "dependent", 5: "force"}

_TYPES = {
    JointType.REVOLUTE: mujoco.mjtJoint.mjJNT_HINGE,
    JointType.PRISMATIC: mujoco.mjtJoint.mjJNT_SLIDE,
    JointType.SPHERICAL: mujoco.mjtJoint.mjJNT_BALL,
}

_LIMIT = (0.005, 1.0)
"""Time constant (s) and damping ratio of limits: V-REP's joints stop within one of its dynamics steps of 5 ms."""

_LIMIT_IMPEDANCE = (0.99, 0.999, 0.0001)
"""How hard limits are: 20 N move the light finger of a gripper less than 0.1 mm beyond."""

_LEAST_ARMATURE = 1e-4
"""Inertia (kg m^2, kg) of a joint that moves bodies without mass, so that MuJoCo can compute with it."""


def add_joint(conversion: Conversion, joint: Joint, body: Any, is_moved: bool) -> None:
    """Add a joint to its body, with its settings.

    Args:
        is_moved: whether physics moves it; else it stays where programs put it, whatever its mode.
    """
    name = conversion.name(joint)
    added = body.add_joint(name=name, type=_TYPES[joint.type], axis=[0, 0, 1])
    added.armature = 0.0 if is_moved else _LEAST_ARMATURE
    weight = finite(joint.ik_weight)
    if weight is not None and weight >= 0 and weight != 1.0:
        conversion.annotate("joint", name, ik_weight=weight)
    conversion.annotate("joint", name, length=unusual(joint.length, Joint.length))
    conversion.annotate("joint", name, diameter=unusual(joint.diameter, Joint.diameter))
    if joint.type == JointType.SPHERICAL:
        conversion.annotate(
            "joint", name, mode=_mode(joint), turn=",".join(map(repr, joint.turn)), fixed=not is_moved or None
        )
        return
    added.ref = position_of(joint)
    _limit(joint, added)
    _add_pitch(conversion, joint, body)
    p, i, d = _pid(joint)
    # Without physics the motor cannot act, and its settings count once a program makes the joint dynamic.
    conversion.annotate(
        "joint",
        name,
        mode=_mode(joint),
        motor=joint.motor,
        control=joint.control,
        rigid=True,
        P=p,
        I=i or None,
        D=d or None,
        K=finite(joint.spring[0]) if joint.control == "spring" else None,
        C=finite(joint.spring[1]) if joint.control == "spring" else None,
        max_force=finite(joint.max_force if joint.control == "force" else abs(joint.max_force)),
        upper_velocity=positive(joint.upper_velocity or 0.0),
        upper_acceleration=positive(joint.upper_acceleration),
        upper_jerk=positive(joint.upper_jerk),
        target_position=finite(joint.target_position),
        target_velocity=finite(joint.target_velocity) or None,
        lock=joint.lock or None,
        hybrid=joint.is_hybrid or None,
        cyclic=joint.is_cyclic,
        fixed=True if joint.mode == 5 and not is_moved else None,
    )
    if joint.mode == 4:
        _follow(conversion, joint)


def _mode(joint: Joint) -> str:
    return _MODES.get(joint.mode, "passive")


def _limit(joint: Joint, added: Any) -> None:
    """Set the limits; where the stored position lies outside, up to there."""
    if (
        joint.is_cyclic
        or not (math.isfinite(joint.minimum) and math.isfinite(joint.range))
        or joint.range < 0
    ):
        added.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        return
    low = min(joint.minimum, position_of(joint))
    high = max(joint.minimum + joint.range, position_of(joint))
    if high - low < 1e-6:
        low, high = low - 5e-7, low + 5e-7  # MuJoCo needs some room
    added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    added.range = [low, high]
    added.solref_limit = _LIMIT
    added.solimp_limit[:3] = _LIMIT_IMPEDANCE


def _add_pitch(conversion: Conversion, joint: Joint, body: Any) -> None:
    """Make a revolute joint a screw: it moves along its axis too, in proportion."""
    if joint.type != JointType.REVOLUTE or not joint.pitch or not math.isfinite(joint.pitch):
        return
    name = f"{INTERNAL}screw:{conversion.name(joint)}"
    slide = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
    slide.ref = position_of(joint) * joint.pitch
    equality = conversion.spec.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_JOINT,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        name1=name,
        name2=conversion.name(joint),
    )
    equality.data[:2] = (0.0, joint.pitch)
    equality.solref[:2] = _LIMIT


def _pid(joint: Joint) -> tuple[float, float, float]:
    """Return P, I, D; V-REP's defaults without them, and 0 for a number that cannot be one."""
    p, i, d = (
        value if math.isfinite(value) and value >= 0 else 0.0 for value in joint.pid or (0.1, 0.0, 0.0)
    )
    return p, i, d


def _follow(conversion: Conversion, joint: Joint) -> None:
    """Name the master of a dependent joint, if it has a sound one."""
    name, objects = conversion.name(joint), conversion.file.objects
    master = objects.get(joint.master)
    if not isinstance(master, Joint) or JointType.SPHERICAL in (master.type, joint.type):
        return
    seen, above = {joint.handle}, master
    while above.mode == 4:
        if above.handle in seen:
            conversion.report.leave_out(
                "dependent joints that follow each other in a circle stay still", name
            )
            return
        seen.add(above.handle)
        further = objects.get(above.master)
        if not isinstance(further, Joint):
            break
        above = further
    conversion.annotate(
        "joint",
        name,
        master=conversion.name(master),
        multiplication=finite(joint.factor),
        offset=finite(joint.offset),
    )
