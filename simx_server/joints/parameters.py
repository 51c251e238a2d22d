"""The numbered joint parameters of the legacy interface (`sim_jointintparam_*`, `sim_jointfloatparam_*`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from simx_server.errors import CommandError

if TYPE_CHECKING:
    from simx_server.joints.joints import Joints

Reader = Callable[["Joints", int], float | int]
Writer = Callable[["Joints", int, float], None]


def _flag(name: str) -> tuple[Reader, Writer]:
    def read(joints: Joints, handle: int) -> int:
        return int(getattr(joints.state(handle), name))

    def write(joints: Joints, handle: int, value: float) -> None:
        joints.change(handle, **{name: value != 0})

    return read, write


def _number(name: str, what: str) -> tuple[Reader, Writer]:
    def read(joints: Joints, handle: int) -> float:
        return getattr(joints.state(handle), name)

    def write(joints: Joints, handle: int, value: float) -> None:
        if value < 0:
            raise CommandError(f"{what} must not be below 0, not {value}")
        joints.change(handle, **{name: value})

    return read, write


def _matrix_quat(index: int) -> Reader:
    """x, y, z, w (index 0..3) of what the joint value does to the moving frame."""

    def read(joints: Joints, handle: int) -> float:
        return joints.quaternion(handle)[index]

    return read


_SETTINGS: dict[int, tuple[str, tuple[Reader, Writer]]] = {
    2000: ("motor_enabled", _flag("motor")),
    2001: ("ctrl_enabled", _flag("control_loop")),
    2002: ("pid_p", _number("p", "the proportional gain")),
    2003: ("pid_i", _number("i", "the integral gain")),
    2004: ("pid_d", _number("d", "the derivative gain")),
    2017: ("upper_limit", _number("upper_velocity", "the upper velocity")),
    2030: ("velocity_lock", _flag("lock")),
}

READ: Mapping[int, tuple[str, Reader]] = {
    **{number: (name, pair[0]) for number, (name, pair) in _SETTINGS.items()},
    2012: ("velocity", lambda joints, handle: joints.velocity(handle)),
    **{2013 + i: (f"spherical_q{axis}", _matrix_quat(i)) for i, axis in enumerate("xyzw")},
}
"""Number to (name, reader)."""

WRITE: Mapping[int, tuple[str, Writer]] = {
    number: (name, pair[1]) for number, (name, pair) in _SETTINGS.items()
}
"""Number to (name, writer)."""


def describe(table: Mapping[int, tuple[str, object]]) -> str:
    """The table in one line, for messages."""
    return ", ".join(f"{number} {name}" for number, (name, _) in sorted(table.items()))
