"""Move joints and objects within limits of velocity, acceleration and jerk; the calls wait for the arrival.

Each simulation step makes one step of a motion, the first one immediately. Limits are tables with one magnitude per
joint; those of a pose are x, y, z in metres and the rotation angle in radians. A jerk of 0 means unlimited.
"""

from __future__ import annotations

import math

from simx_server.handlers import joints
from simx_server.scene.poses import frames
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.values.matrices import as_numbers, vector

from .moving import ARRIVED, Moving, Way, lists, nearest, numbers, profile_to

_TURN = 2 * math.pi
_WAY = 4
"""Number of values that move between two poses: x, y, z and angle."""


class MotionFunctions(Moving):
    """Functions for motions. They wait, so they work only in a thread. Joints in force mode with position control
    get target positions, other joints get positions.
    """

    def rmlMoveToJointPositions(
        self,
        handles: list[int],
        flags: int,
        velocity: list[float] | None,
        acceleration: list[float] | None,
        max_velocity: list[float],
        max_acceleration: list[float],
        max_jerk: list[float],
        goal: list[float],
        goal_velocity: list[float] | None = None,
        direction: list[float] | None = None,
    ) -> Waiting:
        """Move joints; return 1, the positions, velocities and accelerations reached, and the unused seconds of the
        last simulation step.

        `direction` of cyclic joints: 0 the shorter way, n > 0 upwards and n - 1 more turns, n < 0 downwards.
        """
        own, count = [self._self(each) for each in handles], len(handles)
        now = [joints.get_joint_position(self._world, each) for each in own]
        ways = numbers(direction, count, "directions", [0.0] * count)
        wanted = [
            self._joint_goal(*each)
            for each in zip(own, now, numbers(goal, count, "a goal"), ways, strict=True)
        ]
        most = max_velocity, max_acceleration, max_jerk
        motion = yield from self._carry_out(
            profile_to(wanted, goal_velocity, now, velocity, acceleration, most, flags),
            lambda state: self._put_joints(own, state.position),
        )
        return ARRIVED, *lists(motion.state), motion.unused

    def rmlMoveToPosition(
        self,
        handle: int,
        relative_to: int,
        flags: int,
        velocity: list[float] | None,
        acceleration: list[float] | None,
        max_velocity: list[float],
        max_acceleration: list[float],
        max_jerk: list[float],
        position: list[float] | None,
        quaternion: list[float] | None = None,
        goal_velocity: list[float] | None = None,
    ) -> Waiting:
        """Move an object; return 1, the position, quaternion, velocity and acceleration reached, and the unused
        seconds of the last simulation step. Nil for a position or quaternion keeps the present one.
        """
        own, reference = self._self(handle), self._self(relative_to)
        start = frames.get_pose(self._sim, own, reference)
        goal = (
            start[0] if position is None else vector(position, "a position"),
            start[1] if quaternion is None else frames.wxyz_from_xyzw(quaternion),
        )
        way = Way(start, goal)
        most = max_velocity, max_acceleration, max_jerk
        motion = yield from self._carry_out(
            profile_to(way.lengths, goal_velocity, [0.0] * _WAY, velocity, acceleration, most, flags),
            lambda state: self._put_pose(own, reference, way.pose(state.position)),
        )
        reached = as_numbers(way.pose(motion.state.position))
        _, *rates = lists(motion.state)
        return ARRIVED, reached[:3], reached[3:], *rates, motion.unused

    def _joint_goal(self, handle: int, now: float, goal: float, direction: float) -> float:
        if not self._is_cyclic(handle):
            return goal
        if direction == 0:
            return nearest(now, goal)
        turns = direction - 1 if direction > 0 else direction
        return now + (goal - now) % _TURN + turns * _TURN
