"""Facts about joints, and their records."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from simx_server.joints.state import JointState
from simx_server.scene.editing.marks import joint_sizes
from simx_server.scene.formats.vrep.decoding.joints import (
    CYCLIC,
    ENGINE_TAGS,
    FORCE,
    HYBRID,
    LOCK,
    MOTOR,
    PLACES_OF_PID,
    POSITION,
    POSITION_CONTROL,
    SCRIPT,
    SPRING,
    SPRING_CONTROL,
    VELOCITY,
)
from simx_server.scene.formats.vrep.objects import JointType

from ..field import Field, Fields, Handle, NotInVrepFiles, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_FIRST_WITH_LIMITS_OF_MOTION = 23
"""Version of the format from which joints have limits of velocity, acceleration and jerk in one record."""


def _state(world: World, handle: int) -> JointState | None:
    """Return the settings of a joint; None for a spherical one, which has none."""
    joints = world.simulation.joints
    return None if joints.joint_type(handle) == JointType.SPHERICAL else joints.state(handle)


def _position(world: World, handle: int) -> float | None:
    return None if _state(world, handle) is None else world.simulation.joints.position(handle)


def _turn(world: World, handle: int) -> tuple[float, ...] | None:
    return world.simulation.joints.intrinsic(handle)[1] if _state(world, handle) is None else None


def _put_interval(records: ObjectRecords, interval: tuple[bool, float, float], _writing: Writing) -> None:
    cyclic, minimum, extent = interval
    records.own.put_bits("Va9", CYCLIC, CYCLIC if cyclic else 0)
    if not cyclic:
        records.own.put_numbers("Pmr", minimum, extent)


def _mode(world: World, handle: int) -> tuple[int, bool]:
    state = _state(world, handle)
    return int(world.simulation.joints.mode(handle)), state is not None and state.hybrid


def _put_mode(records: ObjectRecords, value: tuple[int, bool], _writing: Writing) -> None:
    mode, is_hybrid = value
    records.own.put_numbers("Jmd", mode)
    records.own.put_bits("Va9", HYBRID, HYBRID if is_hybrid else 0)


def _control(world: World, handle: int) -> tuple[Any, ...] | None:
    state = _state(world, handle)
    if state is None:
        return None
    way = SPRING_CONTROL if state.spring else SCRIPT if state.scripted else POSITION
    way = way if state.control_loop else FORCE if state.pushes else VELOCITY
    return (way, state.motor, state.k, state.c) if way == SPRING_CONTROL else (way, state.motor)


def _put_control(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    way, motor, *spring = value
    in_loop = way in (POSITION, SPRING_CONTROL, SCRIPT)
    bits = (MOTOR if motor else 0) | (POSITION_CONTROL if in_loop else 0)
    bits |= SPRING if way == SPRING_CONTROL else 0
    records.own.put_bits("Va9", MOTOR | POSITION_CONTROL | SPRING, bits)
    if records.own.has("Dcm") or way in (FORCE, SCRIPT):
        records.own.put_numbers("Dcm", way if motor else 0)
    if spring:
        records.own.put_numbers("Spp", *spring)


def _drive(world: World, handle: int) -> tuple[float, float] | None:
    state = _state(world, handle)
    if state is None:
        return None
    return state.target_velocity, -state.max_force if state.backwards else state.max_force


def _put_limits_of_motion(
    records: ObjectRecords, value: tuple[float, float, float], writing: Writing
) -> None:
    if (
        records.own.has("Ruc")
        or records.own.has("_uc")
        or writing.serialization >= _FIRST_WITH_LIMITS_OF_MOTION
    ):
        records.own.put_numbers("Ruc", *value)
    if records.own.has("Ulv") or writing.serialization < _FIRST_WITH_LIMITS_OF_MOTION:
        records.own.put_numbers("Ulv", value[0])


def _put_pid(records: ObjectRecords, pid: tuple[float, float, float], _writing: Writing) -> None:
    is_per_engine = any(records.own.array(tag) is not None for tag in ENGINE_TAGS.values())
    for tag in [tag for tag in ("Dp2", "Dpc") if records.own.has(tag)] or ([] if is_per_engine else ["Dp2"]):
        records.own.put_numbers(tag, *pid)
    for engine, tag in ENGINE_TAGS.items():
        first, last = PLACES_OF_PID[engine]
        reals, ints = records.own.array(tag) or ([], [])
        if len(reals) >= last:
            reals[first:last] = pid
            records.own.put_array(tag, reals, ints)


def _dependency(world: World, handle: int) -> tuple[Any, ...] | None:
    state = _state(world, handle)
    return None if state is None else (Handle(state.master), state.factor, state.shift)


def _put_dependency(records: ObjectRecords, value: tuple[Any, ...], writing: Writing) -> None:
    master, factor, shift = value
    records.own.put_numbers("Jdt", writing.number(master), factor, shift)


def _drawing(world: World, handle: int) -> tuple[float, float]:
    return joint_sizes(world.simulation.scene.objects[handle])


def _put_lock(records: ObjectRecords, is_locked: bool, _writing: Writing) -> None:
    records.own.put_bits("Vaa", LOCK, LOCK if is_locked else 0)


def _damping(world: World, handle: int) -> float:
    sim = world.simulation
    item = sim.scene.get(handle)
    return float(sim.model.dof_damping[sim.model.jnt_dofadr[item.id]]) if item.element == "joint" else 0.0


def _put_damping(_records: ObjectRecords, damping: float, _writing: Writing) -> None:
    if damping:
        raise NotInVrepFiles("the damping of a joint")


def _of_state(name: str, *more: str) -> Callable[[World, int], Any]:
    """Return the reader of one attribute of the settings, or of several as a tuple."""

    def get(world: World, handle: int) -> Any:
        state = _state(world, handle)
        if state is None or not more:
            return None if state is None else getattr(state, name)
        return tuple(getattr(state, each) for each in (name, *more))

    return get


JOINTS: Fields = {
    "type": Field(
        lambda world, handle: world.simulation.joints.joint_type(handle),
        lambda records, value, _: records.own.put_numbers("Jtt", value),
    ),
    "position": Field(_position, lambda records, value, _: records.own.put_numbers("Prt", value)),
    "spherical position": Field(_turn, lambda records, value, _: records.own.put_numbers("Jst", *value)),
    "interval": Field(lambda world, handle: world.simulation.joints.interval(handle), _put_interval),
    "mode": Field(_mode, _put_mode),
    "control": Field(_control, _put_control),
    "lock": Field(_of_state("lock"), _put_lock),
    "target velocity and force": Field(
        _drive, lambda records, value, _: records.own.put_numbers("Dmp", *value)
    ),
    "target position": Field(
        _of_state("target_position"), lambda records, value, _: records.own.put_numbers("Dtp", value)
    ),
    "limits of motion": Field(_of_state("upper_velocity", "acceleration", "jerk"), _put_limits_of_motion),
    "P, I and D": Field(_of_state("p", "i", "d"), _put_pid),
    "damping": Field(_damping, _put_damping),
    "dependency": Field(_dependency, _put_dependency),
    "weight in inverse kinematics": Field(
        lambda world, handle: world.simulation.joints.ik_weight(handle),
        lambda records, value, _: records.own.put_numbers("Ikw", value),
    ),
    "drawing": Field(_drawing, lambda records, value, _: records.own.put_numbers("Arg", *value)),
}
