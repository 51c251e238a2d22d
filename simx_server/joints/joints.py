"""The joints of one scene and what a caller may do with them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.simulation import Simulation


class JointMode(IntEnum):
    """The legacy `sim_jointmode_*` numbers."""

    PASSIVE = 0
    MOTION = 1
    IK = 2
    IK_DEPENDENT = 3
    DEPENDENT = 4
    FORCE = 5


class Joints:
    """All joints of the loaded scene, by handle. Every method raises UnknownHandle, WrongKind for other objects,
    and CommandError for a spherical joint where a single number is meant."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim

    def position(self, handle: int) -> float:
        """Angle (rad) or displacement (m); a tendon joint: length plus its offset."""
        raise NotImplementedError

    def set_position(self, handle: int, value: float) -> None:
        """Put the joint there at once (clamped to its interval, cyclic: wrapped to -pi..pi), velocity zero."""
        raise NotImplementedError

    def velocity(self, handle: int) -> float:
        """rad/s or m/s."""
        raise NotImplementedError

    def target_position(self, handle: int) -> float:
        raise NotImplementedError

    def set_target_position(self, handle: int, value: float) -> None:
        """Raises CommandError when the joint is not in force mode."""
        raise NotImplementedError

    def target_velocity(self, handle: int) -> float:
        raise NotImplementedError

    def set_target_velocity(self, handle: int, value: float) -> None:
        """Stored in any mode; moves the joint in force mode with motor on and control loop off."""
        raise NotImplementedError

    def max_force(self, handle: int) -> float:
        """N m or N."""
        raise NotImplementedError

    def set_max_force(self, handle: int, value: float) -> None:
        """The magnitude; a negative number counts as its magnitude."""
        raise NotImplementedError

    def force(self, handle: int) -> float:
        """Motor force along the joint's +z on its child, mean over the last pass; 0 when stopped or not driven."""
        raise NotImplementedError

    def mode(self, handle: int) -> JointMode:
        raise NotImplementedError

    def set_mode(self, handle: int, mode: JointMode) -> None:
        raise NotImplementedError

    def joint_type(self, handle: int) -> int:
        """10 revolute, 11 prismatic, 12 spherical."""
        raise NotImplementedError

    def interval(self, handle: int) -> tuple[bool, float, float]:
        """(cyclic, minimum, range)."""
        raise NotImplementedError

    def set_interval(self, handle: int, cyclic: bool, minimum: float, extent: float) -> None:
        raise NotImplementedError

    def matrix(self, handle: int) -> list[float]:
        """What the joint value does to the moving frame: 12 numbers, row-major 3 x 4."""
        raise NotImplementedError

    def set_spherical_matrix(self, handle: int, matrix: Sequence[float]) -> None:
        """12 numbers as above, the translation is ignored. Raises CommandError for other joints."""
        raise NotImplementedError

    def get_parameter(self, handle: int, parameter: int) -> float | int:
        """`sim_jointintparam_*` / `sim_jointfloatparam_*` by number. Raises CommandError listing the known ones."""
        raise NotImplementedError

    def set_parameter(self, handle: int, parameter: int, value: float) -> None:
        """Raises CommandError listing those that can be set."""
        raise NotImplementedError
