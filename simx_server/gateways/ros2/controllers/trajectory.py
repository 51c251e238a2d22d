"""The action ``FollowJointTrajectory`` of one arm: MoveIt's way to move it.

After each simulation step the joints get the positions of the path for the end of the next step.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.joints.joints import Joints
from simx_server.simulation.simulation import Simulation, SimulationState

from ..actions import ABORTED, CANCELED, SUCCEEDED, Goal
from ..annotated.joint_groups import Group
from ..content.joint_commands import joint_calls
from ..endpoints import Context, Message, Moment
from ..table_call import Call
from .paths import Array, Path, Sample, read_path

SUCCESSFUL, INVALID_GOAL, INVALID_JOINTS, OLD_STAMP, PATH_VIOLATED, GOAL_VIOLATED = 0, -1, -2, -3, -4, -5
"""Codes of the result."""

GOAL_TOLERANCE = 0.05
"""Distance from the goal, rad or m, of a joint for which the request names no other."""

GOAL_TIME = 2.0
"""Simulated seconds that joints have to come so near after the end of the path, unless the request has others."""

LONGEST_DELAY = 3600.0
"""Seconds in the future in which a trajectory may start. A stamp of the wall clock is beyond it."""


class Refusal(CommandError):
    """A goal is not valid; `code` is that of its result."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


class _Motion:
    """A goal under way."""

    def __init__(self, goal: Goal, names: Sequence[str], path: Path, start: int) -> None:
        self.goal, self.names, self.path, self.start = goal, names, path, start
        count = len(names)
        self.path_tolerance = np.full((2, count), np.inf)
        self.goal_tolerance = np.stack([np.full(count, GOAL_TOLERANCE), np.full(count, np.inf)])
        """Rows: positions, velocities."""

        self.goal_time = GOAL_TIME

    def seconds(self, moment: Moment) -> float:
        """Return how long it has been under way."""
        return (moment.nanoseconds - self.start) * 1e-9


class TrajectoryHandler:
    """Executes the trajectories of one arm, one at a time. Physics thread."""

    def __init__(self, context: Context) -> None:
        self._client = context.client
        self._simulation: Simulation = context.world.simulation
        self.group = Group((), (), ())
        """The joints of the arm in the present scene."""

        self._motion: _Motion | None = None

    @property
    def _joints(self) -> Joints:
        return self._simulation.joints

    def begin(self, goal: Goal) -> None:
        """Start a trajectory; one that is under way is canceled, and motion goes on from where it is."""
        try:
            motion = self._read(goal)
        except Refusal as problem:
            goal.end(ABORTED, _result(problem.code, str(problem)))
            return
        if self._motion is not None:
            self._motion.goal.end(CANCELED, _result(INVALID_GOAL, "another trajectory has come"))
        self._motion = motion

    def cancel(self, goal: Goal) -> bool:
        """Hold the joints where they are."""
        motion = self._motion
        if motion is None or motion.goal is not goal:
            return False
        self._motion = None
        goal.end(CANCELED, _result(INVALID_GOAL, "the goal was canceled"))
        self._client.execute(self._calls(motion.names, self._actual(motion.names)))
        return True

    def abort(self, why: str) -> None:
        """Abort the goal that is under way."""
        if self._motion is not None:
            self._end(self._motion, ABORTED, INVALID_GOAL, why)

    def is_under_way(self) -> bool:
        """Return whether there is a goal."""
        return self._motion is not None

    def due(self, moment: Moment) -> Sequence[Call]:
        """Return the calls for the next simulation step, and end the goal when it is reached or missed."""
        motion = self._motion
        if motion is None:
            return ()
        missing = [name for name in motion.names if name not in self.group.names]
        if missing:
            self._end(motion, ABORTED, INVALID_JOINTS, f"joint {missing[0]} has gone")
            return ()
        passed, actual = motion.seconds(moment), self._actual(motion.names)
        desired = motion.path.at(passed)
        velocity = np.array([self._joints.velocity(handle) for handle in self._handles(motion.names)])
        self._tell(motion, moment, desired, actual, velocity)
        errors = np.abs(np.stack([desired.position - actual, desired.velocity - velocity]))
        is_over = passed >= motion.path.duration - 1e-9
        tolerance = motion.goal_tolerance if is_over else motion.path_tolerance
        if passed >= 0 and not is_over and (errors > tolerance).any():
            self._end(motion, ABORTED, PATH_VIOLATED, _worst(motion.names, errors, tolerance))
            return list(self._calls(motion.names, actual))
        if is_over and not (errors > tolerance).any():
            self._end(motion, SUCCEEDED, SUCCESSFUL, "the goal is reached")
            return list(self._calls(motion.names, motion.path.goal))
        if passed > motion.path.duration + motion.goal_time:
            self._end(motion, ABORTED, GOAL_VIOLATED, _worst(motion.names, errors, tolerance))
            return ()
        if passed + self._simulation.time_step < 0:
            return ()
        coming = motion.path.at(passed + self._simulation.time_step)
        return list(self._calls(motion.names, coming.position))

    def _end(self, motion: _Motion, status: int, code: int, text: str) -> None:
        self._motion = None
        motion.goal.end(status, _result(code, text))

    # --- joints ----------------------------------------------------------------------------------

    def _handles(self, names: Sequence[str]) -> list[int]:
        known = dict(zip(self.group.names, self.group.handles, strict=True))
        return [known[name] for name in names]

    def _offsets(self, names: Sequence[str]) -> Array:
        known = dict(zip(self.group.names, self.group.offsets, strict=True))
        return np.array([known[name] for name in names])

    def _actual(self, names: Sequence[str]) -> Array:
        positions = [self._joints.position(handle) for handle in self._handles(names)]
        return np.array(positions) + self._offsets(names)

    def _calls(self, names: Sequence[str], positions: Array) -> Iterator[Call]:
        nothing = np.empty(0)
        message = {
            "name": names,
            "position": positions - self._offsets(names),
            "velocity": nothing,
            "effort": nothing,
        }
        handles = dict(zip(self.group.names, self.group.handles, strict=True))
        return joint_calls(self._joints, handles, message)

    # --- goals -----------------------------------------------------------------------------------

    def _read(self, goal: Goal) -> _Motion:
        """Return the motion of a goal. Raises Refusal."""
        wanted = goal.request["trajectory"]
        names: list[str] = list(wanted["joint_names"])
        if not names or len(set(names)) < len(names):
            raise Refusal(INVALID_JOINTS, "joint_names is empty, or names a joint twice")
        for name in names:
            if name not in self.group.names:
                hint = did_you_mean(name[:80], list(self.group.names))
                raise Refusal(INVALID_JOINTS, f"the arm has no joint '{name[:80]}'{hint}")
        if goal.request["multi_dof_trajectory"]["points"]:
            raise Refusal(INVALID_GOAL, "joints with several degrees of freedom are not supported")
        if self._simulation.state is SimulationState.STOPPED:
            raise Refusal(INVALID_GOAL, "the simulation is stopped; start it first")
        try:
            path = read_path(wanted, self._actual(names))
        except CommandError as problem:
            raise Refusal(INVALID_GOAL, str(problem)) from None
        now = Moment.of(self._simulation.step_count, self._simulation.time_step).nanoseconds
        motion = _Motion(goal, names, path, _start(wanted["header"]["stamp"], now, path.duration))
        self._set_tolerances(motion, goal.request)
        return motion

    def _set_tolerances(self, motion: _Motion, request: Mapping[str, Any]) -> None:
        for field, limits in (
            ("path_tolerance", motion.path_tolerance),
            ("goal_tolerance", motion.goal_tolerance),
        ):
            if len(request[field]) > len(motion.names):
                raise Refusal(INVALID_GOAL, f"{field} has more values than the trajectory has joints")
            for each in request[field]:
                if each["name"] not in motion.names:
                    raise Refusal(
                        INVALID_JOINTS, f"{field} names '{each['name'][:80]}', and the trajectory does not"
                    )
                column = motion.names.index(each["name"])
                for row, part in enumerate(("position", "velocity")):
                    value = each[part]
                    if value != value or (value < 0 and value != -1):
                        raise Refusal(
                            INVALID_GOAL, f"the {part} of {field} is {value:g}; valid: 0, -1 or a distance"
                        )
                    if value:
                        limits[row, column] = np.inf if value == -1 else value
        given = request["goal_time_tolerance"]
        seconds = given["sec"] + given["nanosec"] * 1e-9
        if seconds > 0:
            motion.goal_time = seconds

    def _tell(self, motion: _Motion, moment: Moment, desired: Sample, actual: Array, velocity: Array) -> None:
        def point(position: Array, rate: Array) -> Message:
            since = max(moment.nanoseconds - motion.start, 0)
            sec, nanosec = divmod(since, 1_000_000_000)
            return {
                "positions": position,
                "velocities": rate,
                "time_from_start": {"sec": sec, "nanosec": nanosec},
            }

        motion.goal.feedback(
            {
                "header": moment.header(""),
                "joint_names": motion.names,
                "desired": point(desired.position, desired.velocity),
                "actual": point(actual, velocity),
                "error": point(desired.position - actual, desired.velocity - velocity),
                "index": desired.point,
            }
        )


def _start(stamp: Mapping[str, int], now: int, duration: float) -> int:
    """Return when a trajectory starts, in simulated nanoseconds. Raises Refusal."""
    wanted = stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
    if not wanted:
        return now
    if wanted + duration * 1e9 < now:
        raise Refusal(
            OLD_STAMP, "the trajectory ends in the past; send a stamp of 0, or of the simulated time"
        )
    if wanted > now + LONGEST_DELAY * 1e9:
        raise Refusal(
            INVALID_GOAL, "the trajectory starts far in the future; set use_sim_time, or send a stamp of 0"
        )
    return wanted


def _worst(names: Sequence[str], errors: Array, tolerance: Array) -> str:
    beyond = np.where(errors > tolerance, errors / np.maximum(tolerance, 1e-12), 0)
    row, column = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    kind = ("position", "velocity")[int(row)]
    return (
        f"the {kind} of {names[int(column)]} is {errors[row, column]:.4g} away, and "
        f"{tolerance[row, column]:.4g} are allowed"
    )


def _result(code: int, text: str) -> Message:
    return {"error_code": code, "error_string": text}
