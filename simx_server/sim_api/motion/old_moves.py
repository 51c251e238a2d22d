"""V-REP's oldest motions, which wait: one velocity and acceleration along the whole way, with unlimited jerk."""

from __future__ import annotations

import math

from simx_client.protocol import constants
from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.motion_profiles import Goal, Limits, Profile, State, Synchronisation, line
from simx_server.scene.geometry.curve import LENGTH_PER_ANGLE, Method, length_by
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.values.matrices import vector

from .moving import REVOLUTE, Moving, Way, between, nearest, numbers

_POSITION, _ORIENTATION = 1, 2


class OldMoveFunctions(Moving):
    """Functions that return the unused seconds of the last simulation step. An acceleration of nil means unlimited.

    V-REP started the next such motion with those seconds; here each motion starts with a simulation step.
    """

    def moveToPosition(
        self,
        handle: int,
        relative_to: int,
        position: list[float] | None,
        euler: list[float] | None,
        velocity: float,
        acceleration: float = 0.0,
        method: list[float] | None = None,
    ) -> Waiting:
        """Move an object to a position and orientation; nil for position or Euler angles keeps the present ones.

        `method`: {a sim.distcalcmethod_*, m per rad} selects the length that the velocity applies to; nil: the
        distance if there is one, else the angle with 0.1 m per quarter turn.
        """
        if position is None and euler is None:
            raise CommandError("a position, Euler angles or both must say where to")
        own, reference = self._self(handle), self._self(relative_to)
        start = frames.get_pose(self._sim, own, reference)
        goal = (
            start[0] if position is None else vector(position, "a position"),
            start[1] if euler is None else frames.quat_from_euler(vector(euler, "Euler angles")),
        )
        kind, factor = (
            (constants.sim_distcalcmethod_dl_if_nonzero, LENGTH_PER_ANGLE)
            if method is None
            else numbers(method, 2, "a method")
        )
        length = _length(start, goal, int(kind), factor)

        def put(state: State) -> bool:
            share = state.position[0] / length
            now = frames.get_pose(self._sim, own, reference)
            place, turn = between(start, goal, share)
            return self._put_pose(
                own, reference, (now[0] if position is None else place, now[1] if euler is None else turn)
            )

        if length == 0:
            self._put_pose(own, reference, goal)
            return (0.0,)
        motion = yield from self._carry_out(line(length, velocity, abs(acceleration)), put)
        return (motion.unused,)

    def moveToJointPositions(
        self,
        handles: list[int],
        goal: list[float],
        velocity: float | list[float],
        acceleration: float | list[float] = 0.0,
        angle_to_length: float = 1.0,
    ) -> Waiting:
        """Move joints so that all arrive together, the longest way with this velocity; if velocities are a table,
        each joint moves with its velocity.

        `angle_to_length`: m per rad, to compare lengths of ways. Cyclic joints take the shorter way; goals outside
        an interval are clipped to its limit.
        """
        own, count = [self._self(each) for each in handles], len(handles)
        if not count:
            raise CommandError("the table of joints is empty")
        start = [joints.get_joint_position(self._world, each) for each in own]
        ends = [self._end(*each) for each in zip(own, start, numbers(goal, count, "a goal"), strict=True)]
        if isinstance(velocity, list):
            profile = _each_by_itself(start, ends, numbers(velocity, count, "velocities"), acceleration)
            motion = yield from self._carry_out(profile, lambda state: self._put_joints(own, state.position))
            return (motion.unused,)
        if isinstance(acceleration, list):
            raise CommandError("with one velocity for all there is one acceleration; give tables of both")
        length = max(
            abs(end - begin)
            * (abs(angle_to_length) if self._sim.joints.joint_type(each) == REVOLUTE else 1.0)
            for each, begin, end in zip(own, start, ends, strict=True)
        )
        if length == 0:
            return (0.0,)

        def put(state: State) -> bool:
            share = state.position[0] / length
            return self._put_joints(own, [a + (b - a) * share for a, b in zip(start, ends, strict=True)])

        motion = yield from self._carry_out(line(length, velocity, abs(acceleration)), put)
        return (motion.unused,)

    def moveToObject(
        self,
        handle: int,
        target: int,
        what: int = 3,
        distance_on_path: float | None = None,
        velocity: float = 1.0,
        acceleration: float = 0.0,
    ) -> Waiting:
        """Move to an object that may itself move; the velocity is in ways per second. `what`: 1 position, 2
        orientation, 3 both. `distance_on_path`, from 0 to 1, selects a point of a path object.
        """
        own, other = self._self(handle), self._self(target)
        done = 0.0

        def goal() -> Pose:
            if distance_on_path is None:
                return frames.get_pose(self._sim, other)
            paths = self._world.paths
            share = min(max(distance_on_path, 0.0), 1.0)
            return paths.pose_at(other, share * paths.get(other).curve.length)

        def put(state: State) -> bool:
            nonlocal done
            share = 1.0 if done >= 1 else min(1.0, max(0.0, (state.position[0] - done) / (1 - done)))
            done = state.position[0]
            now = frames.get_pose(self._sim, own)
            place, turn = between(now, goal(), share)
            return self._put_pose(
                own,
                frames.WORLD,
                (place if what & _POSITION else now[0], turn if what & _ORIENTATION else now[1]),
            )

        motion = yield from self._carry_out(line(1.0, velocity, abs(acceleration)), put)
        return (motion.unused,)

    def _end(self, handle: int, now: float, goal: float) -> float:
        if self._is_cyclic(handle):
            return nearest(now, goal)
        _, least, extent = self._sim.joints.interval(handle)
        return min(max(goal, least), least + extent)


def _each_by_itself(
    start: list[float], ends: list[float], velocity: list[float], acceleration: float | list[float]
) -> Profile:
    count = len(start)
    bounds = acceleration if isinstance(acceleration, list) else [acceleration] * count
    free = [abs(each) or math.inf for each in numbers(bounds, count, "accelerations")]
    rest = [0.0] * count
    limits = Limits([abs(each) for each in velocity], free, [math.inf] * count)
    return Profile(State(start, rest, rest), Goal(ends, rest), limits, Synchronisation.NONE)


def _length(start: Pose, goal: Pose, method: int, factor: float) -> float:
    """Return the length of the way in metres by one of V-REP's distance calculation methods."""
    *place, angle = Way(start, goal).lengths
    shift, turn = math.hypot(*place), angle * factor
    if method not in set(Method):
        raise CommandError(
            f"{method} is no distance calculation method; they are {min(Method):d} to {max(Method):d}"
        )
    return length_by(Method(method), shift, turn)
