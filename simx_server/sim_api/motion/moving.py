"""Shared code of the functions that move joints and objects: a motion under way, and the way between two poses."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from typing import Any

from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.handlers.objects import poses as handlers
from simx_server.joints import JointMode
from simx_server.motion_profiles import Goal, Limits, Profile, State
from simx_server.scene.poses import poses
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.base import ApiPart

from .profiles import MIN_ACCELERATION, MIN_VELOCITY, synchronisation

ON_ITS_WAY, ARRIVED, ABORTED = 0, 1, 2
"""Results of a step."""

REVOLUTE = 10
"""`sim_joint_revolute_subtype`."""

_STRAIGHT = 1e-6
"""Length of a way in a script's metric below which nothing moves."""

Put = Callable[[State], bool]
"""Applies a state of a motion to the scene; returning true ends the motion."""


class Motion:
    """A profile under way, and a function that applies its states."""

    def __init__(self, profile: Profile, put: Put, seconds: float = 0.0) -> None:
        """Create a motion with steps of `seconds`; 0: one simulation step."""
        self.profile = profile
        self.state = profile.at(0.0)
        self.unused = 0.0
        """Seconds of the last step that remain after the arrival."""
        self._put = put
        self._seconds = seconds

    def step(self, time_step: float) -> int:
        """Make a step and return one of the results above. The motion ends exactly at its goal, not up to a step
        beyond it.
        """
        profile = self.profile
        profile.time += self._seconds or time_step
        self.unused = max(0.0, -profile.time_left)
        self.state = profile.goal() if profile.is_over else profile.at(profile.time)
        if self._put(self.state):
            return ABORTED
        return ARRIVED if profile.is_over else ON_ITS_WAY


class Way:
    """The way from one pose to another: as x, y, z in metres and the rotation angle; with a metric as one length."""

    def __init__(self, start: Pose, goal: Pose, metric: Sequence[float] | None = None) -> None:
        """Create a way. `metric` holds the factors of x, y, z and the angle in the combined length."""
        self._start, self._goal = start, goal
        shift = poses.subtract(goal[0], start[0])
        turn = poses.rotation_vector(poses.multiply(poses.conjugate(start[1]), goal[1]))
        self._angle = math.hypot(*turn)
        self._is_one = metric is not None
        self.lengths = [*shift, self._angle]
        if metric is not None:
            if len(metric) != len(self.lengths):
                raise CommandError(
                    f"a metric is factors of x, y, z and the angle, 4 numbers, not {len(metric)}"
                )
            self.lengths = [math.hypot(*(a * b for a, b in zip(self.lengths, metric, strict=True)))]

    def pose(self, done: Sequence[float]) -> Pose:
        """Return the pose after this part of each of the lengths."""
        if self._is_one:
            share = done[0] / self.lengths[0] if self.lengths[0] > _STRAIGHT else 1.0
            return between(self._start, self._goal, share)
        share = done[3] / self._angle if self._angle > _STRAIGHT else 1.0
        return poses.add(self._start[0], done[:3]), poses.blend(self._start[1], self._goal[1], share)


class Moving(ApiPart):
    """Base class that executes motions."""

    def _carry_out(self, profile: Profile, put: Put, seconds: float = 0.0) -> Generator[None, None, Motion]:
        """Create a motion and step it to its end; arguments as for `Motion`."""
        return self._step_to_the_end(Motion(profile, put, seconds))

    def _step_to_the_end(self, motion: Motion) -> Generator[None, None, Motion]:
        """Make a step per simulation step until the end; wait one more, so that two motions never share a
        simulation step.
        """
        result = ON_ITS_WAY
        while result == ON_ITS_WAY:
            result = motion.step(self._sim.time_step)
            yield
        return motion

    def _put_joints(self, handles: Sequence[int], positions: Sequence[float]) -> bool:
        for handle, position in zip(handles, positions, strict=True):
            if self._is_driven(handle):
                joints.set_joint_target_position(self._world, handle, position)
            else:
                joints.set_joint_position(self._world, handle, position)
        return False

    def _put_pose(self, handle: int, relative_to: int, pose: Pose) -> bool:
        handlers.set_object_pose(self._world, handle, relative_to, pose)
        return False

    def _is_driven(self, handle: int) -> bool:
        """Return whether a motor drives the joint to its target position, or would if one were set."""
        state = self._sim.joints.state(handle)
        return state.mode == JointMode.FORCE and (not state.annotated or (state.motor and state.control_loop))

    def _is_cyclic(self, handle: int) -> bool:
        return self._sim.joints.interval(handle)[0] and self._sim.joints.joint_type(handle) == REVOLUTE


def between(start: Pose, goal: Pose, share: float) -> Pose:
    """Return the pose at this share of the straight line and of the rotation."""
    shift = poses.subtract(goal[0], start[0])
    return poses.add(start[0], poses.scale(shift, share)), poses.blend(start[1], goal[1], share)


def profile_to(
    goal: Sequence[float],
    goal_velocity: Sequence[float] | None,
    start: Sequence[float],
    velocity: Sequence[float] | None,
    acceleration: Sequence[float] | None,
    most: Sequence[Sequence[float] | None],
    flags: int,
    announced: int = 0,
) -> Profile:
    """Return the profile that the lists of a script describe; missing velocities and accelerations are 0.

    Args:
        most: maximum velocities, accelerations and jerks.
        flags: a sim.ruckig_*sync, -1 for the default.
        announced: flags that announce negative bounds after the others.
    """
    count = len(start)
    return Profile(
        start_state(start, velocity, acceleration),
        Goal(goal, numbers(goal_velocity, count, "velocities at the goal", [0.0] * count)),
        limits_of(most, count, announced),
        synchronisation(flags),
    )


def stops(callback: Function, *arguments: Any) -> bool:
    """Return whether a call-back ends the motion: it returns anything but nil and false."""
    results = callback(*arguments)
    return bool(results) and results[0] is not None and results[0] is not False


def nearest(now: float, goal: float) -> float:
    """Return the angle equal to `goal` except for whole turns, at most half a turn away from `now`."""
    return now + math.remainder(goal - now, 2 * math.pi)


def numbers(
    values: Sequence[float] | None, count: int, what: str, default: Sequence[float] | None = None
) -> list[float]:
    """Return the first `count` values; more are ignored, as in V-REP.

    Raises:
        CommandError: there are too few values.
    """
    found = default if values is None else values
    if found is None or len(found) < count:
        raise CommandError(f"{what}: {count} numbers are needed, not {0 if found is None else len(found)}")
    return list(found[:count])


def start_state(
    position: Sequence[float], velocity: Sequence[float] | None, acceleration: Sequence[float] | None
) -> State:
    """Return the start state; missing velocities and accelerations mean rest."""
    count = len(position)
    rest = [0.0] * count
    return State(
        list(position),
        numbers(velocity, count, "the present velocities", rest),
        numbers(acceleration, count, "the present accelerations", rest),
    )


def limits_of(most: Sequence[Sequence[float] | None], count: int, flags: int) -> Limits:
    """Return the limits; negative bounds follow the others where the flags announce them."""
    velocity, acceleration, jerk = (values or [] for values in most)

    def least(bit: int, values: Sequence[float]) -> list[float] | None:
        return numbers(values[count:], count, "negative bounds") if flags >= 0 and flags & bit else None

    return Limits(
        numbers(velocity, count, "the greatest velocities"),
        numbers(acceleration, count, "the greatest accelerations"),
        numbers(jerk, count, "the greatest jerks"),
        least(MIN_VELOCITY, velocity),
        least(MIN_ACCELERATION, acceleration),
    )


def lists(state: State) -> tuple[list[float], list[float], list[float]]:
    """Return positions, velocities and accelerations as lists for a script."""
    return list(state.position), list(state.velocity), list(state.acceleration)
