"""CoppeliaSim 4's motions: `sim.moveToConfig` and `sim.moveToPose`, which wait, and their single steps, which do
not.

Both forms of arguments are accepted: positional ones as in versions up to 4.5, and a table with names as since 4.6.
A call-back ends the motion by returning true.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.motion_profiles import Goal, Limits, Profile, State, Synchronisation
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.conversion.signature import (
    to_bool,
    to_first,
    to_float,
    to_function,
    to_int,
    to_list,
    to_text,
)
from simx_server.scripting.interpreter import Function, Waiting
from simx_server.sim_api.kinematics.following_target import FollowingTarget
from simx_server.sim_api.values.matrices import as_numbers, as_pose

from .fields import NUMBERS, field, read
from .moving import (
    Motion,
    Moving,
    Way,
    lists,
    nearest,
    numbers,
    profile_to,
    start_state,
    stops,
)
from .profiles import synchronisation

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_MATRIX = 12
_FREE = Limits([9999.0], [99999.0], [9999999.0])
"""Limits that CoppeliaSim uses when a table names none: the motion is over in one step of `_FREE_STEP` seconds."""
_FREE_STEP = 10.0


class MoveFunctions(Moving, effect="changes"):
    """Functions for motions. A table has the fields pos or joints, targetPos, vel, accel, targetVel, maxVel,
    maxAccel, maxJerk, minVel, minAccel, flags, cyclicJoints, timeStep, callback; for a pose also pose or object,
    relObject or ik (tip, target, base, joints, method, damping, iterations, constraints, precision, allowError,
    breakFlags), targetPose, metric.
    """

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._motions: dict[int, tuple[Motion, dict[str, Any]]] = {}
        self._next_motion = 1

    def moveToConfig(
        self,
        flags: int | dict[str, Any],
        position: list[float] | None = None,
        velocity: list[float] | None = None,
        acceleration: list[float] | None = None,
        max_velocity: list[float] | None = None,
        max_acceleration: list[float] | None = None,
        max_jerk: list[float] | None = None,
        goal: list[float] | None = None,
        goal_velocity: list[float] | None = None,
        callback: Function | str | None = None,
        auxiliary: Any = None,
        cyclic: list[bool] | None = None,
        time_step: float = 0.0,
    ) -> Waiting:
        """Move joints; return positions, velocities, accelerations and the unused seconds of the last step; called
        with a table, return that table in its final state.

        The call-back is called with (positions, velocities, accelerations, auxiliary), or with that table. Joints
        named in a table are moved without a call-back.
        """
        if isinstance(flags, dict):
            motion, data = self._configuration(flags)
            yield from self._step_to_the_end(motion)
            return (data,)
        now = position or []
        function = self._function(_given(callback, "a call-back"))
        wanted = _turned(now, numbers(goal, len(now), "a goal"), cyclic)
        most = max_velocity, max_acceleration, max_jerk
        motion = yield from self._carry_out(
            profile_to(wanted, goal_velocity, now, velocity, acceleration, most, flags, flags),
            lambda state: stops(function, *lists(state), auxiliary),
            time_step,
        )
        return *lists(motion.state), motion.unused

    def moveToPose(
        self,
        flags: int | dict[str, Any],
        position: list[float] | None = None,
        max_velocity: list[float] | None = None,
        max_acceleration: list[float] | None = None,
        max_jerk: list[float] | None = None,
        goal: list[float] | None = None,
        callback: Function | str | None = None,
        auxiliary: Any = None,
        metric: list[float] | None = None,
        time_step: float = 0.0,
    ) -> Waiting:
        """Move an object; return the pose and the unused seconds of the last step; called with a table, return that
        table in its final state.

        The call-back is called with (pose, velocities, accelerations, auxiliary), or with that table. An object
        named in a table is moved without a call-back. Poses may be matrices. Limits apply to x, y, z and the angle;
        with a metric (their factors) to the combined length. The field ik names a tip
        and its target: the target moves, and joints bring the tip to it.
        """
        if isinstance(flags, dict):
            motion, data = self._posed(flags)
            yield from self._step_to_the_end(motion)
            return (data,)
        way = Way(_pose(position, "a pose"), _pose(goal, "a goal"), metric)
        function = self._function(_given(callback, "a call-back"))
        is_matrix = len(position or []) == _MATRIX
        rest = [0.0] * len(way.lengths)
        most = max_velocity, max_acceleration, max_jerk

        def written(state: State) -> list[float]:
            pose = way.pose(state.position)
            return frames.matrix12(pose) if is_matrix else as_numbers(pose)

        def put(state: State) -> bool:
            return stops(function, written(state), *lists(state)[1:], auxiliary)

        motion = yield from self._carry_out(
            profile_to(way.lengths, None, rest, None, None, most, flags, flags), put, time_step
        )
        return written(motion.state), motion.unused

    def moveToConfig_init(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Prepare moveToConfig with a table; return the table for moveToConfig_step."""
        return self._begin(*self._configuration(parameters))

    def moveToConfig_step(self, data: dict[str, Any]) -> tuple[int, dict[str, Any]]:
        """Make one step; return 0 on the way, 1 at the goal, 2 when the call-back ended the motion; and the table."""
        motion, present = self._motion(data)
        return motion.step(self._sim.time_step), present

    def moveToConfig_cleanup(self, data: dict[str, Any]) -> None:
        """Delete the motion."""
        self._motions.pop(data.get("ruckigObj", 0), None)

    moveToPose_step = moveToConfig_step
    moveToPose_cleanup = moveToConfig_cleanup

    def moveToPose_init(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Prepare moveToPose with a table; return the table for moveToPose_step."""
        return self._begin(*self._posed(parameters))

    def _begin(self, motion: Motion, data: dict[str, Any]) -> dict[str, Any]:
        data["ruckigObj"] = self._next_motion
        self._motions[self._next_motion] = motion, data
        self._next_motion += 1
        return data

    def _motion(self, data: Mapping[str, Any]) -> tuple[Motion, dict[str, Any]]:
        found = self._motions.get(data.get("ruckigObj", 0))
        if found is None:
            raise CommandError("this table is of no motion; take the one that the _init function gives")
        return found

    def _configuration(self, parameters: dict[str, Any]) -> tuple[Motion, dict[str, Any]]:
        """Return the motion that a table describes, and the table that shows its state."""
        own = [self._self(each) for each in read(parameters, "joints", to_list(to_int), [])]
        now = read(parameters, "pos", NUMBERS, None) or [
            joints.get_joint_position(self._world, each) for each in own
        ]
        if not now:
            raise CommandError(
                "the table needs pos (where the motion begins) or joints (whose positions those are)"
            )
        if own and len(own) != len(now):
            raise CommandError(f"the table has {len(own)} joints but {len(now)} numbers in pos")
        goal = _turned(
            now,
            field(parameters, "targetPos", len(now)),
            read(parameters, "cyclicJoints", to_list(to_bool), None),
        )
        data, callback = self._opened(parameters)

        def show(state: State) -> None:
            data["pos"] = list(state.position)

        def carry(state: State) -> None:
            if own:
                self._put_joints(own, state.position)

        return self._described(data, callback, now, goal, show, carry)

    def _posed(self, parameters: dict[str, Any]) -> tuple[Motion, dict[str, Any]]:
        moved, given = read(parameters, "object", to_int, None), read(parameters, "pose", NUMBERS, None)
        handle, relative_to = (
            None if moved is None else self._self(moved),
            self._self(read(parameters, "relObject", to_int, -1)),
        )
        following: FollowingTarget | None = None
        if given:
            start, handle = _pose(given, "pose"), None
        elif handle is not None:
            start = frames.get_pose(self._sim, handle, relative_to)
        elif parameters.get("ik") is not None:
            following = FollowingTarget(self._world, parameters["ik"], self._self)
            start, relative_to = following.start, frames.WORLD
        else:
            raise CommandError(
                "the table needs pose (where the motion begins), object (what moves), or ik (a tip and its target)"
            )
        goal = _pose(read(parameters, "targetPose", NUMBERS, None), "targetPose")
        way = Way(start, goal, read(parameters, "metric", NUMBERS, None))
        data, callback = self._opened(parameters)

        def show(state: State) -> None:
            data["pose"] = as_numbers(way.pose(state.position))
            data["matrix"] = frames.matrix12(way.pose(state.position))

        def carry(state: State) -> None:
            if following is not None:
                following.follow(way.pose(state.position))
            elif handle is not None:
                self._put_pose(handle, relative_to, way.pose(state.position))

        return self._described(data, callback, [0.0] * len(way.lengths), way.lengths, show, carry)

    def _opened(self, parameters: dict[str, Any]) -> tuple[dict[str, Any], Function | None]:
        """Return the table without its call-back, and the call-back."""
        callback = read(parameters, "callback", to_first(to_function, to_text), None)
        data = {name: value for name, value in parameters.items() if name != "callback"}
        return data, None if callback is None else self._function(callback)

    def _described(
        self,
        data: dict[str, Any],
        callback: Function | None,
        now: Sequence[float],
        goal: list[float],
        show: Any,
        carry: Any,
    ) -> tuple[Motion, dict[str, Any]]:
        count = len(now)
        limits, flags, seconds = _bounds(data, count)
        rest = [0.0] * count
        start = start_state(now, read(data, "vel", NUMBERS, None), read(data, "accel", NUMBERS, None))
        profile = Profile(start, Goal(goal, field(data, "targetVel", count, rest)), limits, flags)

        def put(state: State) -> bool:
            _, data["vel"], data["accel"] = lists(state)
            data["timeLeft"] = motion.unused
            show(state)
            if callback is not None:
                return stops(callback, data)
            carry(state)
            return False

        motion = Motion(profile, put, seconds)
        _, data["vel"], data["accel"] = lists(start)
        show(start)
        data["timeLeft"] = 0.0
        return motion, data


def _bounds(data: Mapping[str, Any], count: int) -> tuple[Limits, Synchronisation, float]:
    """Return the limits, the synchronisation and the seconds per step that a table names."""
    if not any(name in data for name in ("maxVel", "maxAccel", "maxJerk")):
        free = (_FREE.velocity, _FREE.acceleration, _FREE.jerk)
        return Limits(*([*each] * count for each in free)), Synchronisation.NONE, _FREE_STEP
    most = [field(data, name, count) for name in ("maxVel", "maxAccel", "maxJerk")]
    least = [field(data, name, count) if name in data else None for name in ("minVel", "minAccel")]
    return (
        Limits(*most, *least),
        synchronisation(read(data, "flags", to_int, -1)),
        read(data, "timeStep", to_float, 0.0),
    )


def _turned(now: Sequence[float], goal: Sequence[float], cyclic: Sequence[bool] | None) -> list[float]:
    """Return goals that cyclic joints reach by the shorter way."""
    wraps = [False] * len(now) if cyclic is None else cyclic
    return [
        nearest(a, b) if index < len(wraps) and wraps[index] else b
        for index, (a, b) in enumerate(zip(now, goal, strict=True))
    ]


def _given(value: Function | str | None, what: str) -> Function | str:
    if value is None:
        raise CommandError(f"{what} is needed: a function, or the name of one")
    return value


def _pose(values: Sequence[float] | None, what: str) -> Pose:
    if values is not None and len(values) == _MATRIX:
        return frames.pose_from_matrix12(values)
    if values is None:
        raise CommandError(f"{what} is needed: 7 numbers, or a matrix")
    return as_pose(values)
