"""Joints, and dummies, force sensors: what links bodies."""

from __future__ import annotations

import math

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import Dummy, Engine, ForceSensor, Joint, JointType

from .colors import material_of
from .context import Reading
from .numbers import turn, vector

CYCLIC, MOTOR, POSITION_CONTROL, HYBRID, SPRING = 1, 16, 32, 64, 128
"""Bits of Va9."""
LOCK = 2
FORCE, VELOCITY, POSITION, SPRING_CONTROL, SCRIPT = 1, 4, 8, 12, 16
"""Ways of control in Dcm; the lowest bit may stand beside the others."""
CONTROLS = {VELOCITY: "velocity", POSITION: "position", SPRING_CONTROL: "spring", SCRIPT: "script"}
ENGINE_TAGS = {
    Engine.BULLET: "BtN",
    Engine.ODE: "OdN",
    Engine.VORTEX: "Vo2",
    Engine.NEWTON: "Nw1",
    Engine.MUJOCO: "Mj3",
}
PLACES_OF_PID = {
    Engine.BULLET: (5, 8),
    Engine.ODE: (5, 8),
    Engine.VORTEX: (51, 54),
    Engine.NEWTON: (2, 5),
    Engine.MUJOCO: (27, 30),
}
"""Places of P, I, D among the real numbers of an engine, since CoppeliaSim 4.4."""


def fill_joint(joint: Joint, own: Chunks, reading: Reading) -> None:
    """Fill a joint. Raises SceneError."""
    (kind,) = own.ints("Jtt")
    if kind not in JointType.__members__.values():
        raise own.error("Jtt", f"has the type {kind}; valid is 10 revolute, 11 prismatic or 12 spherical")
    joint.type = JointType(kind)
    (joint.position,) = own.reals("Prt", 0.0)
    if own.has("Jst"):
        joint.turn = turn(own, "Jst", own.reals("Jst"))
    (pitch,) = own.reals("Jsp", 0.0)
    (lead,) = own.reals("Sld", pitch * math.tau)
    joint.pitch = lead / math.tau
    joint.minimum, joint.range = own.reals("Pmr", 0.0, 0.0)
    (joint.mode,) = own.ints("Jmd", joint.mode)
    joint.target_velocity, joint.max_force = own.reals("Dmp", 0.0, 0.0)
    (joint.target_position,) = own.reals("Dtp", 0.0)
    stiffness, damping = own.reals("Spp", 0.0, 0.0)
    joint.spring = stiffness, damping
    (joint.master,) = own.ints("Jdt", -1)
    joint.factor, joint.offset = own.reals("Jdt", 1.0, 0.0)
    (joint.ik_weight,) = own.reals("Ikw", joint.ik_weight)
    joint.length, joint.diameter = own.reals("Arg", joint.length, joint.diameter)
    _fill_control(joint, own)
    for engine, tag in ENGINE_TAGS.items():
        if (values := own.array(tag)) is not None:
            joint.engines[engine] = values
    for tag in ("Dp2", "Dpc"):
        if joint.pid is None and own.has(tag):
            joint.pid = vector(own.reals(tag, 0.1, 0.0, 0.0))


def _fill_control(joint: Joint, own: Chunks) -> None:
    (flags,) = own.ints("Va9", 0)
    joint.is_cyclic, joint.is_hybrid = bool(flags & CYCLIC), bool(flags & HYBRID)
    joint.motor = bool(flags & MOTOR)
    joint.control = "velocity"
    if flags & POSITION_CONTROL:
        joint.control = "spring" if flags & SPRING else "position"
    if own.has("Dcm"):
        (way,) = own.ints("Dcm")
        joint.motor = way != 0
        way = way & ~1 if way > 1 else way
        control = "force" if 0 <= way <= FORCE else CONTROLS.get(way)
        if control is None:
            own.note("Dcm", f"has the unknown way of control {way}; {joint.control} control is taken")
        joint.control = control or joint.control
    (flags,) = own.ints("Vaa", 0)
    joint.lock = bool(flags & LOCK)
    if own.has("Ruc"):
        velocity, joint.upper_acceleration, joint.upper_jerk = own.reals("Ruc", 0.0, 0.0, 0.0)
    else:
        (velocity,) = own.reals("Ulv", 0.0)
    joint.upper_velocity = velocity if velocity > 0 else None


def choose_pid(joint: Joint, engine: Engine) -> None:
    """Give a joint the P, I, D of the scene's engine, where its file has them per engine."""
    reals, _ = joint.engines.get(engine, ([], []))
    first, last = PLACES_OF_PID.get(engine, (0, 0))
    if last and len(reals) >= last:
        joint.pid = vector(reals[first:last])


FOLLOWS = 2
"""Bit of Var."""

BREAKS, IS_OVERLOADED = "Tre", "Tri"
"""Records with the thresholds of force sensors that break, and of those that only tell an overload."""
LIMITS_FORCE, LIMITS_TORQUE = 1, 2
"""Bits of Vab."""
MEDIAN = 1
"""Kind of filter in Fil; all others take the average."""


def fill_dummy(dummy: Dummy, own: Chunks, reading: Reading) -> None:
    """Fill a dummy."""
    (dummy.linked,) = own.ints("Lli", -1)
    (dummy.link_type,) = own.ints("Dl2", 0)
    (dummy.size,) = own.reals("Dy2", dummy.size)
    dummy.color = material_of(own.child("Cl0"))
    (flags,) = own.ints("Var", 0)
    if flags & FOLLOWS:
        dummy.path_offset, _ = own.reals("Po5", 0.0, 0.0)


def fill_force_sensor(sensor: ForceSensor, own: Chunks, reading: Reading) -> None:
    """Fill a force sensor."""
    tag = IS_OVERLOADED if own.has(IS_OVERLOADED) else BREAKS
    force, torque = own.reals(tag, 100.0, 10.0)
    (sensor.violations,) = own.ints(tag, 1)
    sensor.breaks = tag == BREAKS
    (flags,) = own.ints("Vab", 0)
    sensor.max_force = force if flags & LIMITS_FORCE else None
    sensor.max_torque = torque if flags & LIMITS_TORQUE else None
    sensor.samples, kind = own.ints("Fil", 1, 0)
    sensor.filter = "median" if kind == MEDIAN else "average"
    (sensor.size,) = own.reals("Siz", sensor.size)
