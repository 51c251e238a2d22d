"""The joints of a robot for which V-REP 3's motion planning searches configurations, paths and straight lines.

A configuration is the values of the task's joints in its order; those of its joints that inverse kinematics does not
move keep the values of the start.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.group import Group
from simx_server.kinematics.sampling import LONGEST
from simx_server.kinematics.scratch import Array
from simx_server.kinematics.search import MOST_STATES, find_configs, straight_path
from simx_server.kinematics.solver import Calculation, Method, Result
from simx_server.scene.poses.poses import Pose, blend, conjugate, multiply, rotation_vector

from ..states import SpaceKind, StateSpace, Task
from ..tasks import Solving

if TYPE_CHECKING:
    from ..planning_world import PlanningWorld

IGNORES_SELF, IGNORES_OBSTACLES = 16, 32
"""V-REP's options: what is not checked."""

_HOW = Calculation(Method.ADAPTIVE, 0.0, 60)

_FINEST = 1e-4
"""Least step between two states, in weighted rad or m."""


@dataclass(frozen=True)
class Kept:
    """Two entities that must not come nearer than a distance (m)."""

    pair: tuple[int, int]
    clearance: float


@dataclass(frozen=True)
class TipPath:
    """A path with what the tip does on it; n states."""

    states: list[list[float]]
    lengths: list[float]
    """Weighted distance of the joint values from the state before; 0 for the first."""
    tips: list[Pose]
    tip_lengths: list[float]
    """Weighted distance of the tip from the state before; 0 for the first."""


class PlannedChain:
    """The joints of one task on the scene as it is now; nothing in the scene moves."""

    def __init__(
        self,
        world: PlanningWorld,
        group: Group,
        handles: list[int],
        kept: Sequence[Kept],
        weights: Sequence[float],
        tip_weights: Sequence[float],
    ) -> None:
        """Prepare the joints.

        Raises:
            CommandError: the group has no joint, or one of the joints cannot be planned for.
        """
        self.handles = handles
        self._world, self._group = world, group
        self._weights, self._tip_weights = np.array(weights), np.array(tip_weights)
        self._may_go_on = world.simulation.interruptions.may_go_on
        self._joints, self._solver = world.ik_groups.solver(group, handles)
        self._used = [handle in self._joints.handles for handle in handles]
        model, joints = world.simulation.model, world.simulation.scene
        self._addresses = [int(model.jnt_qposadr[joints.get(handle).id]) for handle in handles]
        spaces = [self._space_of(handle) for handle in handles]
        far = [
            (Solving(world, Task("", spaces, [each.pair])), each.clearance)
            for each in kept
            if each.clearance > 0
        ]
        self._task = Task("", spaces, [each.pair for each in kept if each.clearance <= 0])
        if far:
            self._task.judge = lambda state: all(
                check.is_valid(np.array(state), clearance) for check, clearance in far
            )
        self._planning = Solving(world, self._task)

    def is_valid(self, state: Sequence[float] | Array) -> bool:
        """Return whether nothing in the task comes too near in a configuration."""
        return self._planning.is_valid(np.asarray(state))

    def checked(self, state: Sequence[float]) -> list[float]:
        """Return a configuration from a script. Raises CommandError for a wrong number of values."""
        if len(state) != len(self.handles):
            raise CommandError(
                f"a configuration of this task has {len(self.handles)} numbers, not {len(state)}"
            )
        return list(state)

    def find_config(
        self,
        tip: Pose,
        seconds: float,
        trials: int,
        references: Sequence[Sequence[float]],
        weights: Sequence[float],
    ) -> list[float] | None:
        """Return a configuration that brings the tip to a pose (world), or None.

        Args:
            tip: the pose.
            seconds: longest duration; 0: as many as a search may take.
            trials: highest number of random starts.
            references: the configuration that is nearest to one of these is returned; empty: the first one found.
            weights: of the joints, for that.
        """
        start = np.array([self._world.simulation.joints.position(handle) for handle in self.handles])
        self._place(start)
        found = find_configs(
            self._solver,
            self._joints,
            [tip],
            self._world.ik_groups.random,
            seconds=seconds if seconds > 0 else LONGEST,
            trials=max(1, trials),
            accepts=lambda values: self.is_valid(self._listed(values, start)),
            may_go_on=self._may_go_on,
        )
        if not references:
            first = next(found, None)
            return None if first is None else self._listed(first, start).tolist()
        ends = np.array(references)
        return min(
            (self._listed(values, start).tolist() for values in found),
            key=lambda state: float(np.min(np.linalg.norm((ends - state) * weights, axis=1))),
            default=None,
        )

    def find_path(
        self, start: Sequence[float], goal: Sequence[float], step: float, seconds: float
    ) -> TipPath | None:
        """Return a path between two configurations that touches nothing, or None.

        Args:
            start: the first configuration.
            goal: the last one.
            step: longest step between two states, in weighted rad or m; 0: as they are checked.
            seconds: longest duration; 0: as many as a plan may take.
        """
        self._task.start, self._task.goals = list(start), [list(goal)]
        if not self._planning.solve(seconds if seconds > 0 else LONGEST):
            return None
        return self._told(self._task.path, step)

    def simplified(self, path: list[list[float]], step: float, seconds: float) -> TipPath | None:
        """Return a shorter path with the same ends; None if the path touches something.

        The steps and seconds are as in `find_path`; with 0 seconds all machines make the same effort.
        """
        if not all(self.is_valid(state) for state in path):
            return None
        self._task.path = path
        self._planning.simplify(min(seconds, LONGEST) if seconds > 0 else None)
        return self._told(self._task.path, step)

    def straight(self, start: Sequence[float], goal: Pose, step: float) -> TipPath | None:
        """Return a path on which the tip moves from its pose at `start` on a straight line to a goal (world), or None.

        Args:
            start: the first configuration.
            goal: the last pose of the tip.
            step: longest step of the tip, in weighted m and rad.
        """
        first = self._place(np.array(start))
        tip = self._solver.tips(first)[0]
        count = self._count(self._tip_distance(tip, goal), step) + 1
        path = straight_path(
            self._solver,
            first,
            [tip],
            [goal],
            count,
            lambda values: self.is_valid(self._listed(values, np.array(start))),
            self._may_go_on,
        )
        if path is None:
            return None
        return self._told([self._listed(values, np.array(start)) for values in path])

    def transition(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        ways: Sequence[Pose] | None,
        eagerness: Mapping[int, float],
        step: float,
        out_step: float,
    ) -> TipPath | None:
        """Return a path from one configuration to another without planning, or None if it touches something.

        Args:
            start: the first configuration.
            goal: the last one.
            ways: the tip moves on straight lines through these poses (world); empty: on one line from the start to the
                goal; None: all joints change evenly.
            eagerness: how readily joints move to keep the tip on its way, 1 for those left out; 0: they change evenly.
            step: longest step of the tip while it is computed.
            out_step: longest step between two states of the result, in weighted rad or m.
        """
        begin, end = np.array(start), np.array(goal)
        if ways is None:
            count = self._count(self._distance(begin, end), min(step, out_step))
            states = [begin + (end - begin) * (number / count) for number in range(count + 1)]
        else:
            found = self._along(begin, end, ways, eagerness, step)
            if found is None:
                return None
            states = found
        if not all(self._may_go_on() and self.is_valid(state) for state in states):
            return None
        return self._told(states, out_step)

    def _along(
        self, begin: Array, end: Array, ways: Sequence[Pose], eagerness: Mapping[int, float], step: float
    ) -> list[Array] | None:
        """Return states whose tip moves through poses, from the first configuration to the last; None: not possible."""
        tips = [self._solver.tips(self._place(state))[0] for state in (begin, end)]
        corners = [tips[0], *(ways or [tips[1]])]
        lines = [(a, b, self._count(self._tip_distance(a, b), step)) for a, b in pairwise(corners)]
        total = sum(count for _, _, count in lines)
        fixed = [handle for handle, share in eagerness.items() if share == 0.0]
        states, even = [begin], np.array([handle in fixed for handle in self.handles])
        groups = self._world.ik_groups
        moving = [handle for handle in self.handles if handle not in fixed]
        joints, solver = groups.solver(self._group, moving, weights=eagerness)
        places = [self.handles.index(handle) for handle in joints.handles if handle in self.handles]
        chosen = [number for number, handle in enumerate(joints.handles) if handle in self.handles]
        done = 0
        for a, b, count in lines:
            for number in range(1, count + 1):
                if not self._may_go_on():
                    return None
                # A redundant arm drifts towards the last configuration, so that it ends there.
                guess = states[-1] + (end - states[-1]) / (total - done)
                done += 1
                guess[even] = (begin + (end - begin) * (done / total))[even]
                self._place(guess)
                if fixed:
                    solver.renew()
                values = self._world.ik_groups.scratch.data.qpos[joints.addresses].copy()
                solution = solver.solve(values, [_between(a, b, number / count)], _HOW)
                if solution.result != Result.SUCCESS:
                    return None
                guess[places] = solution.values[chosen]
                states.append(guess)
        is_there = np.max(np.abs(states[-1] - end)) < 0.05
        return [*states[:-1], end] if is_there else None

    def _told(self, path: Sequence[Sequence[float] | Array], step: float = math.inf) -> TipPath:
        """Return a path with tips and lengths, and more states where a step is too long; 0: as they are checked."""
        corners = [np.asarray(state) for state in path]
        states = corners[:1]
        for a, b in pairwise(corners):
            count = self._count(self._distance(a, b), step if step > 0 else self._planning.space.resolution)
            change = self._planning.space.difference(a, b) / count
            states += [a + change * number for number in range(1, count)] + [b]
            if len(states) > MOST_STATES:
                raise CommandError(f"a path has up to {MOST_STATES} states; {step:g} is too short a step")
        tips = [self._solver.tips(self._place(state))[0] for state in states]
        lengths = [self._distance(a, b) for a, b in pairwise(states)]
        tip_lengths = [self._tip_distance(a, b) for a, b in pairwise(tips)]
        return TipPath([state.tolist() for state in states], [0.0, *lengths], tips, [0.0, *tip_lengths])

    def _space_of(self, handle: int) -> StateSpace:
        cyclic, least, extent = self._world.simulation.joints.interval(handle)
        low, high = (-math.pi, math.pi) if cyclic else (least, least + max(extent, _FINEST))
        return StateSpace("", SpaceKind.JOINT, handle, (low,), (high,))

    def _place(self, state: Array) -> Array:
        """Put a configuration on the scratch state; return the values of the joints of inverse kinematics there."""
        data = self._world.ik_groups.scratch.data
        data.qpos[self._addresses] = state
        if not all(self._used):
            self._solver.renew()
        return data.qpos[self._joints.addresses].copy()

    def _listed(self, values: Array, start: Array) -> Array:
        """Return the configuration with these values of the joints of inverse kinematics."""
        by_handle = dict(zip(self._joints.handles, values.tolist(), strict=True))
        return np.array(
            [by_handle.get(handle, old) for handle, old in zip(self.handles, start.tolist(), strict=True)]
        )

    def _distance(self, a: Array, b: Array) -> float:
        return float(np.linalg.norm(self._planning.space.difference(a, b) * self._weights))

    def _tip_distance(self, a: Pose, b: Pose) -> float:
        turn = rotation_vector(multiply(conjugate(a[1]), b[1]))
        change = [*(q - p for p, q in zip(a[0], b[0], strict=True)), math.hypot(*turn)]
        return float(np.linalg.norm(np.array(change) * self._tip_weights))

    @staticmethod
    def _count(length: float, step: float) -> int:
        """Return the number of steps of a length, at least 1."""
        return min(max(1, math.ceil(length / max(step, _FINEST) - 1e-9)), MOST_STATES - 1)


def _between(a: Pose, b: Pose, share: float) -> Pose:
    x, y, z = ((1 - share) * p + share * q for p, q in zip(a[0], b[0], strict=True))
    return (x, y, z), blend(a[1], b[1], share)
