"""Where objects are and how they move."""

from __future__ import annotations

from ...handlers import poses
from .base import ApiPart


class PoseFunctions(ApiPart):
    """Positions in metres, angles in radians, quaternions (x, y, z, w)."""

    def getObjectPosition(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_position(self._sim, self._self(handle), self._self(relative_to))

    def setObjectPosition(self, handle: int, relative_to: int, position: list[float]) -> None:
        poses.set_object_position(self._sim, self._self(handle), self._self(relative_to), position)

    def getObjectOrientation(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_orientation(self._sim, self._self(handle), self._self(relative_to))

    def setObjectOrientation(self, handle: int, relative_to: int, euler: list[float]) -> None:
        poses.set_object_orientation(self._sim, self._self(handle), self._self(relative_to), euler)

    def getObjectQuaternion(self, handle: int, relative_to: int = -1) -> list[float]:
        return poses.get_object_quaternion(self._sim, self._self(handle), self._self(relative_to))

    def setObjectQuaternion(self, handle: int, relative_to: int, quaternion: list[float]) -> None:
        poses.set_object_quaternion(self._sim, self._self(handle), self._self(relative_to), quaternion)

    def getObjectVelocity(self, handle: int) -> tuple[list[float], list[float]]:
        return poses.get_object_velocity(self._sim, self._self(handle))
