"""Where objects are: positions, Euler angles and quaternions relative to the world, a parent or any other object.

Relative to: -1 the world, -11 the parent (the world when there is none), else a handle. A joint as reference means its
moving frame; with 0x400000 added to the queried handle, its fixed frame (then quaternions are w, x, y, z).
Euler angles: R = Rx(alpha) Ry(beta) Rz(gamma), radians. Every quaternion given out or taken is x, y, z, w (else noted).
All functions raise UnknownHandle; the setters raise CommandError for a wrong number of values or numbers that are not finite.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.simulation import Simulation

WORLD = -1
PARENT = -11
JOINT_BASE_FLAG = 0x400000
"""`sim_handleflag_reljointbaseframe`, and on quaternions also `sim_handleflag_wxyzquat`; on velocities the axis flag."""


def get_position(sim: Simulation, handle: int, relative_to: int = WORLD) -> list[float]:
    """Position [x, y, z] in metres."""
    raise NotImplementedError


def get_orientation(sim: Simulation, handle: int, relative_to: int = WORLD) -> list[float]:
    """Euler angles [alpha, beta, gamma] in radians."""
    raise NotImplementedError


def get_quaternion(sim: Simulation, handle: int, relative_to: int = WORLD) -> list[float]:
    """Quaternion [x, y, z, w], w >= 0; with the flag [w, x, y, z]."""
    raise NotImplementedError


def get_matrix(sim: Simulation, handle: int, relative_to: int = WORLD) -> list[float]:
    """The pose as 12 numbers, row-major 3 x 4."""
    raise NotImplementedError


def set_position(sim: Simulation, handle: int, relative_to: int, position: Sequence[float]) -> None:
    """Move an object and all below it; the velocity of dynamic bodies becomes zero."""
    raise NotImplementedError


def set_orientation(sim: Simulation, handle: int, relative_to: int, euler: Sequence[float]) -> None:
    """Turn an object about its own origin, with all below it."""
    raise NotImplementedError


def set_quaternion(sim: Simulation, handle: int, relative_to: int, quaternion: Sequence[float]) -> None:
    """As `set_orientation`; any length but zero, it is normalised."""
    raise NotImplementedError
