"""The solving of a planning task on the scene as it is now."""

from __future__ import annotations

import copy
import math
from itertools import pairwise
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.scratch import Array
from simx_server.kinematics.search import MOST_STATES
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.joint_chain import body_pose
from simx_server.scene.poses.placing import free_joint
from simx_server.scene.poses.poses import Pose, compose, inverse

from .dummy_goals import at_dummy
from .graphs import Graph, graph_of
from .ompl_planner import OmplPlanner
from .paths import Failure, Planner, Progress, interpolate
from .regions import Reached, RegionPlanner
from .space import Car, Space
from .states import FLAT_POSES, DummyGoal, SpaceKind, StateSpace, Task, pose_at
from .validity import Validity

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .planning_world import PlanningWorld


_EFFORT, _TIMEOUT = 3000, 10.0
"""Number of checks for shortening a path, which takes about 1 s for a UR5, and maximum seconds on any machine."""

MARGIN = 0.004
"""Metres that a path keeps away from obstacles: an arm's end moves by less between two checks."""

FINEST, COARSEST = 0.001, 0.005
"""Limits in rad and m of the distance between two checks, whatever the extent is, so that no obstacle is missed."""

_COARSEST_OF_POSES = 0.02
"""The upper limit for poses in space, whose searches need many more branches; OMPL allows more than this."""


class Solving:
    """A task on the scene as it is now."""

    def __init__(self, world: PlanningWorld, task: Task) -> None:
        """Prepare a task.

        Raises:
            CommandError: the task has no space, or objects cannot be moved on a scratch state.
        """
        if not task.spaces:
            raise CommandError(
                f"task '{task.name}' has no state space; give it some with simOMPL.setStateSpace"
            )
        sim = world.simulation
        self._sim = sim
        self._random = world.ik_groups.random
        self._by_name = world.searching.uses_ompl
        self._task = task
        self._writers = [_Writer(sim, space) for space in task.spaces]
        addresses = [writer.address for writer in self._writers if writer.address is not None]
        self._addresses = np.array(addresses) if len(addresses) == len(self._writers) else None
        """Of the joints in qpos, where the state is only joints."""
        moved = [writer.body for writer in self._writers]
        self._own_model = any(writer.is_fixed for writer in self._writers)
        self._validity = Validity(world, moved, task.pairs, own_model=self._own_model) if task.pairs else None
        self.space = self._space()

    def is_valid(self, state: Array, margin: float = 0.0) -> bool:
        """Return whether nothing comes nearer than the margin (m), and the script agrees. A car stays in its bounds,
        which its ways may leave.
        """
        if self.space.cars and not self.space.contains(state):
            return False
        validity = self._validity
        if validity is not None and not validity.at(
            lambda data: self._write(validity.model, data, state), margin
        ):
            return False
        return self._task.judge is None or self._task.judge(state.tolist())

    def _write(self, model: mujoco.MjModel, data: mujoco.MjData, state: Array) -> None:
        """Put the objects there on a scratch state, without kinematics."""
        if self._addresses is not None:
            data.qpos[self._addresses] = state
            return
        at = 0
        for writer in self._writers:
            writer.write(model, data, state[at : at + writer.space.count])
            at += writer.space.count

    def solve(self, seconds: float, progress: Progress | None = None) -> bool:
        """Find a path; return whether there is one.

        Args:
            seconds: maximum wall time.
            progress: of an earlier search with the same start and goals, to continue it; it is updated.

        Raises:
            CommandError: start or goals are missing or have a wrong size, or OMPL cannot plan this.
        """
        self._task.path, self._task.problem, self._task.is_approximate = [], "", False
        self._task.distance, self._task.graph = 0.0, Graph()
        found = self._search(seconds, progress) if self._task.region is None else self._reach(seconds)
        if isinstance(found, Failure):
            self._task.problem = found.value
            return False
        self._task.path = [state.tolist() for state in found]
        return True

    def _search(self, seconds: float, progress: Progress | None) -> list[Array] | Failure:
        start, goals = self.ends()
        planner, progress = self.planner(), progress or Progress()
        found = planner.plan(start, goals, seconds, progress)
        if isinstance(planner, OmplPlanner):
            self._task.graph = planner.graph
        elif progress.trees is not None:
            self._task.graph = graph_of(progress.trees, [] if isinstance(found, Failure) else found)
        return found

    def _reach(self, seconds: float) -> list[Array] | Failure:
        task = self._task
        if not task.start:
            raise CommandError(f"task '{task.name}' has no start state")
        planner = RegionPlanner(
            self.space, self.is_valid, self._random, self._sim.interruptions.may_go_on, self._is_clear
        )
        self._give_samplers(planner)
        found = planner.reach(self.space.normalised(np.array(task.start)), self.goal(), seconds)
        if isinstance(found, Failure):
            return found
        task.graph = graph_of([found.tree], [] if len(found.tree.states) == 1 else found.path)
        task.is_approximate, task.distance = not found.is_exact, 0.0 if found.is_exact else found.distance
        return found.path or Failure.TIME

    def goal(self) -> Reached:
        """Return the function that knows the goal of a task that has no goal states."""
        region = self._task.region
        if isinstance(region, DummyGoal):
            model = copy.copy(self._sim.model) if self._own_model else self._sim.model
            return at_dummy(self._sim, region, model, lambda data, state: self._write(model, data, state))
        assert region is not None
        return lambda state: region(state.tolist())

    def _give_samplers(self, planner: Planner) -> None:
        task = self._task
        if task.sampler is not None:
            sampler = task.sampler
            planner.sampler = lambda: self._checked(sampler())
        if task.near_sampler is not None and isinstance(planner, RegionPlanner):
            near = task.near_sampler
            planner.near = lambda state, distance: self._checked(near(state.tolist(), distance))

    def _checked(self, state: list[float]) -> Array:
        if len(state) != self._task.count:
            raise CommandError(f"a sampler returns states of {self._task.count} numbers, not {len(state)}")
        return self.space.normalised(np.array(state))

    def ends(self) -> tuple[Array, list[Array]]:
        """Return the first state (n,) and the goals. Raises CommandError: there are none."""
        task = self._task
        if not task.start or not task.goals:
            raise CommandError(f"task '{task.name}' has no {'goal' if task.start else 'start'} state")
        start, *goals = (self.space.normalised(np.array(state)) for state in (task.start, *task.goals))
        return start, goals

    def simplify(self, seconds: float | None) -> None:
        """Shorten the path, for at most `seconds` of wall time; None: with the same effort on every machine."""
        if len(self._task.path) > 2:
            path = [np.array(state) for state in self._task.path]
            limits = (_TIMEOUT, _EFFORT) if seconds is None else (seconds, None)
            shorter = self.planner().shorten(path, *limits)
            self._task.path = [state.tolist() for state in shorter]

    def interpolate(self, count: int) -> None:
        """Interpolate the path to at least `count` states; 0: as many as are checked.

        Raises:
            CommandError: too many states.
        """
        path = [np.array(state) for state in self._task.path]
        if count > MOST_STATES:
            raise CommandError(f"a path has up to {MOST_STATES} states, not {count}")
        if count <= 0:
            length = sum(self.space.line(a, b).extent for a, b in pairwise(path))
            count = min(max(len(path), math.ceil(length / self.space.resolution)), MOST_STATES)
        self._task.path = [state.tolist() for state in interpolate(self.space, path, count)]

    def planner(self, space: Space | None = None, random: np.random.Generator | None = None) -> Planner:
        """Return a planner of the task's algorithm.

        Args:
            space: with another resolution than the task's; None: its own.
            random: source of the random numbers; None: that of all searches.

        Raises:
            CommandError: OMPL is to plan, and cannot.
        """
        used = space or self.space
        dice = self._random if random is None else random
        may_go_on = self._sim.interruptions.may_go_on
        if self._by_name and self._task.algorithm:
            return OmplPlanner(self._task.algorithm, used, self.is_valid, dice, may_go_on, self._is_clear)
        planner = Planner(used, self.is_valid, dice, may_go_on, self._is_clear)
        self._give_samplers(planner)
        return planner

    def _is_clear(self, state: Array) -> bool:
        return self.is_valid(state, MARGIN)

    def _space(self) -> Space:
        low = np.array([value for space in self._task.spaces for value in space.low])
        high = np.array([value for space in self._task.spaces for value in space.high])
        weights = np.array([space.weight for space in self._task.spaces for _ in range(space.count)])
        endless = np.array([flag for writer in self._writers for flag in writer.endless], dtype=bool)
        ends = np.cumsum([space.count for space in self._task.spaces]).tolist()
        quaternions = tuple(
            slice(end - 4, end)
            for space, end in zip(self._task.spaces, ends, strict=True)
            if space.kind == SpaceKind.POSE3D
        )
        cars = tuple(
            Car(slice(end - 3, end), space.radius, space.is_symmetric)
            for space, end in zip(self._task.spaces, ends, strict=True)
            if space.kind == SpaceKind.DUBINS
        )
        extent = float(np.max(high - low))
        coarsest = _COARSEST_OF_POSES if quaternions else COARSEST
        resolution = min(max(self._task.resolution * extent, FINEST), coarsest)
        step = max(0.05 * extent, 10 * resolution)
        return Space(low, high, weights, endless, resolution, step, quaternions, cars)


class _Writer:
    """Writes the coordinates of one space into a scratch state."""

    def __init__(self, sim: Simulation, space: StateSpace) -> None:
        self.space = space
        item = sim.scene.get(space.handle)
        model = sim.model
        self.endless = [False] * space.count
        self.is_fixed = False
        """Whether a position in the model has to be written."""
        self.address: int | None = None
        """Of a joint in qpos."""
        if space.kind == SpaceKind.JOINT:
            sim.scene.get_kind(space.handle, ObjectKind.JOINT)
            sim.joints.state(space.handle)
            if item.element != "joint":
                raise CommandError(f"'{item.name}' is driven through a tendon and cannot be planned for")
            self.address = int(model.jnt_qposadr[item.id])
            self.body = item.body
            self.endless = [bool(sim.joints.interval(space.handle)[0])]
            return
        if item.element != "body":
            raise CommandError(
                f"'{item.name}' is no shape or dummy with a body, so a path of its poses cannot be planned"
            )
        self.body = item.body
        self._free = free_joint(model, item.body)
        self._mocap = int(model.body_mocapid[item.body])
        self.is_fixed = self._free < 0 and self._mocap < 0
        if self.is_fixed and model.body_jntnum[item.body]:
            raise CommandError(f"'{item.name}' hangs on a joint; plan for that with a joint space")
        parent = int(model.body_parentid[item.body])
        self._above = body_pose(sim, parent)
        self._reference: Pose = get_pose(sim, space.reference) if space.reference != -1 else _WORLD
        self._pose = compose(inverse(self._reference), get_pose(sim, space.handle))
        if space.kind in FLAT_POSES:
            self.endless = [False, False, True]
        self._qpos = int(model.jnt_qposadr[self._free]) if self._free >= 0 else -1

    def write(self, model: mujoco.MjModel, data: mujoco.MjData, values: Array) -> None:
        if self.address is not None:
            data.qpos[self.address] = values[0]
            return
        position, quat = compose(self._reference, pose_at(self.space.kind, self._pose, values))
        if self._qpos >= 0:
            data.qpos[self._qpos : self._qpos + 3] = position
            data.qpos[self._qpos + 3 : self._qpos + 7] = quat
        elif self._mocap >= 0:
            data.mocap_pos[self._mocap], data.mocap_quat[self._mocap] = position, quat
        else:
            position, quat = compose(inverse(self._above), (position, quat))
            model.body_pos[self.body], model.body_quat[self.body] = position, quat


_WORLD: Pose = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
