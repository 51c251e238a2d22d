"""Path objects of V-REP 3: positions along them, their control points, motions along them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.geometry.curve import ControlPoint
from simx_server.scene.poses.frames import euler_from_quat, quat_from_euler
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.values.matrices import vector

_CLOSES, _HAS_CHANNELS = 1, 2
"""Bits of the options of sim.insertPathCtrlPoints."""

_PLAIN, _FULL = 11, 16
"""Numbers of a control point, without and with flags and channels."""

_MOST_COUNT = 1000


class PathObjectFunctions(ApiPart):
    """Functions for path objects: metres along the path by its own method, or shares of its length, 0 to 1."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType(
        {"dummyintparam_follow_path": 10001, "dummyfloatparam_follow_path_offset": 10002}
    )

    def getPathLength(self, path: int) -> float:
        return self._world.paths.get(self._self(path)).curve.length

    def getPathPosition(self, path: int) -> float:
        """Return the position of the path in metres."""
        return self._world.paths.get(self._self(path)).position

    def setPathPosition(self, path: int, position: float) -> int:
        """Set the position in metres; a closed path goes round, an open one ends. Dummies that follow move along."""
        self._world.paths.set_position(self._self(path), position)
        return 1

    def setPathTargetNominalVelocity(self, path: int, velocity: float) -> int:
        """Set the velocity in m/s with which the position moves automatically."""
        self._world.paths.set_target_velocity(self._self(path), velocity)
        return 1

    def handlePath(self, path: int, seconds: float) -> int:
        """Move the position of a path by its velocity; return 1.

        Partly: with sim.handle_all_except_explicit nothing happens, as the server moves these paths itself, after
        the scripts' actuation.
        """
        if path == c.sim_handle_all_except_explicit:
            return 1
        for each in self._world.paths.handles() if path == c.sim_handle_all else [self._self(path)]:
            if path != c.sim_handle_all or self._world.paths.get(each).is_explicit:
                self._world.paths.handle(each, seconds)
        return 1

    def getPositionOnPath(self, path: int, share: float) -> list[float]:
        """Return the position in the world at a share of the path's length; beyond 1 a closed path goes round."""
        return list(self._pose_on_path(path, share)[0])

    def getOrientationOnPath(self, path: int, share: float) -> list[float]:
        """Return the Euler angles in the world at a share of the path's length; beyond 1 a closed path goes round."""
        return euler_from_quat(self._pose_on_path(path, share)[1])

    def getDataOnPath(self, path: int, share: float) -> tuple[int, list[float]]:
        """Return the auxiliary flags, and the four auxiliary channels, at a share of the path's length."""
        curve = self._world.paths.get(self._self(path)).curve
        found = curve.at(share * curve.length)
        return found.flags, list(found.channels)

    def getClosestPositionOnPath(self, path: int, position: list[float]) -> float:
        """Return the share of the path's length whose point is nearest to a position in the world."""
        own = self._self(path)
        length = self._world.paths.get(own).curve.length
        found = self._world.paths.nearest(own, vector(position, "a position"))
        return found / length if length > 0 else 0.0

    def insertPathCtrlPoints(
        self, path: int, options: int, start: int, count: int, numbers: list[float]
    ) -> int:
        """Insert control points before the one at an index, from 0; return 1.

        `numbers` of each point, in the path's frame: x, y, z, three Euler angles, velocity as a share, virtual
        distance, number of Bezier points, two Bezier factors. Options: 1 the path becomes closed; 2 each point has 16
        numbers, with auxiliary flags and four channels at the end.
        """
        own = self._self(path)
        size = _FULL if options & _HAS_CHANNELS else _PLAIN
        if count < 0 or len(numbers) < count * size:
            raise CommandError(f"{count} control points are {count * size} numbers, not {len(numbers)}")
        new = [_control_point(numbers[at : at + size]) for at in range(0, count * size, size)]
        present = list(self._world.paths.get(own).curve.control)
        place = min(max(0, start), len(present))
        present[place:place] = new
        self._world.paths.set_points(own, present, is_closed=True if options & _CLOSES else None)
        return 1

    def cutPathCtrlPoints(self, path: int, start: int, count: int) -> int:
        """Remove control points from an index on, from 0; -1 removes all. Return 1."""
        own = self._self(path)
        present = list(self._world.paths.get(own).curve.control)
        if start < 0:
            present.clear()
        else:
            del present[start : start + max(0, count)]
        self._world.paths.set_points(own, present)
        return 1

    def _pose_on_path(self, path: int, share: float) -> Pose:
        own = self._self(path)
        return self._world.paths.pose_at(own, share * self._world.paths.get(own).curve.length)


def _control_point(numbers: list[float]) -> ControlPoint:
    velocity, virtual, count, before, after, *more = numbers[6:]
    flags, a, b, d, e = more or (0.0, 0.0, 0.0, 0.0, 0.0)
    turn = quat_from_euler(vector(numbers[3:6], "Euler angles"))
    return ControlPoint(
        (vector(numbers[:3], "a position"), turn),
        min(max(before, 0.0), 1.0),
        min(max(after, 0.0), 1.0),
        int(min(max(count, 1), _MOST_COUNT)),
        max(0.0, virtual),
        velocity,
        int(flags),
        (a, b, d, e),
    )
