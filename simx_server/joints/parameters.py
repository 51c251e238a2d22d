"""The numbered joint parameters of the legacy interface (`sim_jointintparam_*`, `sim_jointfloatparam_*`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from simx_server.constant_tables import number_of
from simx_server.errors import CommandError
from simx_server.scene.poses.frames import euler_from_quat, xyzw_from_wxyz
from simx_server.scene.poses.poses import normalised, rotation_vector

from .joints import Joints, finite

Reader = Callable[["Joints", int], float | int]
Writer = Callable[["Joints", int, float], None]

CONTROL_MODE = 2039
"""`sim_jointintparam_dynctrlmode` of later versions: one number for motor, control loop and spring."""

_SCRIPTED = 16

_CONTROL_MODES = {
    0: {"motor": False},
    4: {"motor": True, "control_loop": False},
    8: {"motor": True, "control_loop": True, "spring": False},
    12: {"motor": True, "control_loop": True, "spring": True},
    _SCRIPTED: {"motor": True, "control_loop": True, "spring": False},
}
"""Settings for free, velocity, position, spring and damper, and a script's own controller (which it needs besides)."""

_FORCE = 1


def _flag(name: str) -> tuple[Reader, Writer]:
    def read(joints: Joints, handle: int) -> int:
        return int(getattr(joints.state(handle), name))

    def write(joints: Joints, handle: int, value: float) -> None:
        joints.change(handle, **{name: value != 0})

    return read, write


def _number(name: str, what: str, *, may_be_negative: bool = False) -> tuple[Reader, Writer]:
    def read(joints: Joints, handle: int) -> float:
        return getattr(joints.state(handle), name)

    def write(joints: Joints, handle: int, value: float) -> None:
        if value < 0 and not may_be_negative:
            raise CommandError(f"{what} must not be below 0, not {value}")
        joints.change(handle, **{name: value})

    return read, write


def _dependency(name: str, kind: type[int] | type[float]) -> tuple[Reader, Writer]:
    def read(joints: Joints, handle: int) -> float:
        return getattr(joints.state(handle), name)

    def write(joints: Joints, handle: int, value: float) -> None:
        joints.set_dependency(handle, **{name: kind(value)})

    return read, write


def _intrinsic(index: int) -> Reader:
    """Return a reader of x, y, z (index 0..2) and qx, qy, qz, qw (3..6) of the moving frame in the fixed one."""

    def read(joints: Joints, handle: int) -> float:
        position, quat = joints.intrinsic(handle)
        return (*position, *xyzw_from_wxyz(quat))[index]

    return read


def _error(index: int) -> Reader:
    """Return a reader of how far the parts came apart.

    Index 0..5: x, y, z, alpha, beta, gamma; 6, 7: distance and angle.
    """

    def read(joints: Joints, handle: int) -> float:
        position, quat = joints.separation(handle)
        angle = math.hypot(*rotation_vector(quat))
        return (*position, *euler_from_quat(quat), math.hypot(*position), angle)[index]

    return read


def _spherical(index: int) -> Writer:
    """Return a writer of a quaternion component; x, y, z are kept until w is written, which turns the joint."""

    def write(joints: Joints, handle: int, value: float) -> None:
        state = joints.spherical_state(handle)
        if index < 3:
            kept = list(state.spherical)
            kept[index] = value
            state.spherical = (kept[0], kept[1], kept[2])
            return
        try:
            quat = normalised((value, *state.spherical))
        except ValueError as error:
            raise CommandError(f"{error} is no rotation; set qx, qy and qz before qw") from None
        joints.set_spherical_rotation(handle, quat)

    return write


def _read_control_mode(joints: Joints, handle: int) -> int:
    state = joints.state(handle)
    if not state.motor:
        return 0
    if not state.control_loop:
        return _FORCE if state.pushes else 4
    return 12 if state.spring else _SCRIPTED if state.scripted else 8


def _write_control_mode(joints: Joints, handle: int, value: float) -> None:
    if value == _FORCE:
        towards = -1 if joints.target_force(handle) < 0 else 1
        joints.change(handle, motor=True, control_loop=False, pushes=towards)
        return
    if value not in _CONTROL_MODES:
        raise CommandError(
            "a joint's control mode is 0 free, 1 force, 4 velocity, 8 position, 12 spring and damper or 16 a script's; "
            f"not {value:g}"
        )
    joints.change(handle, pushes=0, scripted=value == _SCRIPTED, **_CONTROL_MODES[int(value)])


JointParameter = tuple[str, Reader | None, Writer | None]
"""Constant without ``sim_``, and how to read and set it; None where that is not possible."""

_SETTINGS: dict[str, tuple[Reader, Writer]] = {
    "intparam_motor_enabled": _flag("motor"),
    "intparam_ctrl_enabled": _flag("control_loop"),
    "floatparam_pid_p": _number("p", "the proportional gain"),
    "floatparam_pid_i": _number("i", "the integral gain"),
    "floatparam_pid_d": _number("d", "the derivative gain"),
    "floatparam_upper_limit": _number("upper_velocity", "the upper velocity"),
    "floatparam_kc_k": _number("k", "the spring constant", may_be_negative=True),
    "floatparam_kc_c": _number("c", "the damping", may_be_negative=True),
    "floatparam_ik_weight": _number("ik_weight", "the weight in inverse kinematics"),
    "intparam_velocity_lock": _flag("lock"),
    "intparam_vortex_dep_handle": _dependency("master", int),
    "floatparam_vortex_dep_multiplication": _dependency("factor", float),
    "floatparam_vortex_dep_offset": _dependency("shift", float),
    "floatparam_maxvel": _number("upper_velocity", "the upper velocity"),
    "floatparam_maxaccel": _number("acceleration", "the upper acceleration"),
    "floatparam_maxjerk": _number("jerk", "the upper jerk"),
    "intparam_dynctrlmode": (_read_control_mode, _write_control_mode),
}

_PARTS = ("x", "y", "z", "qx", "qy", "qz", "qw")
_ERRORS = ("x", "y", "z", "a", "b", "g", "pos", "angle")


def _velocity(joints: Joints, handle: int) -> float:
    return joints.velocity(handle)


_NAMED: tuple[JointParameter, ...] = (
    *((name, *pair) for name, pair in _SETTINGS.items()),
    *((f"floatparam_intrinsic_{part}", _intrinsic(i), None) for i, part in enumerate(_PARTS)),
    ("floatparam_velocity", _velocity, None),
    *((f"floatparam_error_{part}", _error(i), None) for i, part in enumerate(_ERRORS)),
    *((f"floatparam_spherical_{part}", None, _spherical(i)) for i, part in enumerate(_PARTS[3:])),
)

PARAMETERS: Mapping[int, JointParameter] = MappingProxyType(
    {number_of(f"joint{name}"): (f"joint{name}", read, write) for name, read, write in _NAMED}
)
"""All of them by number."""


def get_parameter(joints: Joints, handle: int, number: int) -> float | int:
    """Return `sim_jointintparam_*` or `sim_jointfloatparam_*` by number.

    Raises:
        CommandError: the parameter is unknown; the text lists the known ones.
    """
    _, read, _ = PARAMETERS.get(number, _UNKNOWN)
    if read is None:
        raise CommandError(f"joint parameter {number} is not known; known: {_list(1)}")
    return read(joints, handle)


def set_parameter(joints: Joints, handle: int, number: int, value: float) -> None:
    """Set a parameter by number.

    Raises:
        CommandError: the parameter cannot be set; the text lists those that can.
    """
    name, _, write = PARAMETERS.get(number, _UNKNOWN)
    if write is None:
        raise CommandError(f"joint parameter {number} cannot be set; those that can: {_list(2)}")
    write(joints, handle, finite(value, _short(name)))


_UNKNOWN: JointParameter = ("", None, None)


def _list(place: int) -> str:
    known = sorted(number for number, each in PARAMETERS.items() if each[place] is not None)
    return ", ".join(f"{number} {_short(PARAMETERS[number][0])}" for number in known)


def _short(name: str) -> str:
    return name.partition("param_")[2]
