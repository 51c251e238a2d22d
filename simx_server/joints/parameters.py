"""The numbered joint parameters of the legacy interface (`sim_jointintparam_*`, `sim_jointfloatparam_*`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import euler_from_quat, xyzw_from_wxyz
from simx_server.scene.poses.poses import normalised, rotation_vector

if TYPE_CHECKING:
    from .joints import Joints

Reader = Callable[["Joints", int], float | int]
Writer = Callable[["Joints", int, float], None]

CONTROL_MODE = 2039
"""`sim_jointintparam_dynctrlmode` of later versions: one number for motor, control loop and spring."""

_CONTROL_MODES = {
    0: {"motor": False},
    4: {"motor": True, "control_loop": False},
    8: {"motor": True, "control_loop": True, "spring": False},
    12: {"motor": True, "control_loop": True, "spring": True},
    16: {"motor": True, "control_loop": True, "spring": False},
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
    return 12 if state.spring else 8


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
    joints.change(handle, pushes=0, **_CONTROL_MODES[int(value)])


_SETTINGS: dict[int, tuple[str, tuple[Reader, Writer]]] = {
    2000: ("motor_enabled", _flag("motor")),
    2001: ("ctrl_enabled", _flag("control_loop")),
    2002: ("pid_p", _number("p", "the proportional gain")),
    2003: ("pid_i", _number("i", "the integral gain")),
    2004: ("pid_d", _number("d", "the derivative gain")),
    2017: ("upper_limit", _number("upper_velocity", "the upper velocity")),
    2018: ("kc_k", _number("k", "the spring constant", may_be_negative=True)),
    2019: ("kc_c", _number("c", "the damping", may_be_negative=True)),
    2021: ("ik_weight", _number("ik_weight", "the weight in inverse kinematics")),
    2030: ("velocity_lock", _flag("lock")),
    2031: ("vortex_dep_handle", _dependency("master", int)),
    2032: ("vortex_dep_multiplication", _dependency("factor", float)),
    2033: ("vortex_dep_offset", _dependency("shift", float)),
    2036: ("maxvel", _number("upper_velocity", "the upper velocity")),
    2037: ("maxaccel", _number("acceleration", "the upper acceleration")),
    2038: ("maxjerk", _number("jerk", "the upper jerk")),
    CONTROL_MODE: ("dynctrlmode", (_read_control_mode, _write_control_mode)),
}

_PARTS = ("x", "y", "z", "qx", "qy", "qz", "qw")
_ERRORS = ("x", "y", "z", "a", "b", "g", "pos", "angle")

READ: Mapping[int, tuple[str, Reader]] = MappingProxyType(
    {
        **{number: (name, pair[0]) for number, (name, pair) in _SETTINGS.items()},
        **{2005 + i: (f"intrinsic_{part}", _intrinsic(i)) for i, part in enumerate(_PARTS)},
        2012: ("velocity", lambda joints, handle: joints.velocity(handle)),
        **{2022 + i: (f"error_{part}", _error(i)) for i, part in enumerate(_ERRORS)},
    }
)
"""Maps a number to (name, reader)."""

WRITE: Mapping[int, tuple[str, Writer]] = MappingProxyType(
    {
        **{number: (name, pair[1]) for number, (name, pair) in _SETTINGS.items()},
        **{2013 + i: (f"spherical_{part}", _spherical(i)) for i, part in enumerate(_PARTS[3:])},
    }
)
"""Maps a number to (name, writer)."""


def describe(table: Mapping[int, tuple[str, object]]) -> str:
    """Return the table in one line, for messages."""
    return ", ".join(f"{number} {name}" for number, (name, _) in sorted(table.items()))
