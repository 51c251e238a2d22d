"""Path planning tasks as in `simOMPL`: state spaces over objects, pairs that must not collide, start, goals, path."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from itertools import pairwise
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.scratch import Array
from simx_server.kinematics.search import MOST_STATES
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import (
    euler_from_quat,
    get_pose,
    quat_from_euler,
    set_pose,
    xyzw_from_wxyz,
)
from simx_server.scene.poses.joint_chain import body_pose
from simx_server.scene.poses.placing import free_joint
from simx_server.scene.poses.poses import Pose, compose, inverse, normalised

from .ompl_planner import OmplPlanner
from .paths import Failure, Planner, Progress, interpolate
from .space import Car, Space
from .validity import Pairs, Validity

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .planning_world import PlanningWorld


class SpaceKind(IntEnum):
    """The plugin's numbers of the supported kinds."""

    POSITION2D = 30001
    POSE2D = 30002
    POSITION3D = 30003
    POSE3D = 30004
    JOINT = 30005
    DUBINS = 30006


_COUNTS = {
    SpaceKind.POSITION2D: 2,
    SpaceKind.POSE2D: 3,
    SpaceKind.POSITION3D: 3,
    SpaceKind.POSE3D: 7,
    SpaceKind.JOINT: 1,
    SpaceKind.DUBINS: 3,
}

ROTATIONS = {SpaceKind.POSE2D: (math.pi,), SpaceKind.DUBINS: (math.pi,), SpaceKind.POSE3D: (1.0,) * 4}
"""Upper bounds of the coordinates that are a rotation, gamma or the quaternion x, y, z, w; the lower are the same below
0.
"""


@dataclass(frozen=True)
class StateSpace:
    """A few coordinates of one object."""

    name: str
    kind: SpaceKind
    handle: int
    low: tuple[float, ...]
    high: tuple[float, ...]
    weight: float = 1.0
    reference: int = -1
    """Frame of positions; -1: the world."""
    radius: float = 1.0
    """Smallest radius of the turns of a DUBINS space in metres."""
    is_symmetric: bool = False
    """Ways in a DUBINS space may lead backwards."""

    @property
    def count(self) -> int:
        return _COUNTS[self.kind]


@dataclass
class Task:
    """One task. States are lists of the coordinates of all its spaces, one after the other."""

    name: str
    spaces: list[StateSpace] = field(default_factory=list[StateSpace])
    pairs: Pairs = field(default_factory=Pairs)
    start: list[float] = field(default_factory=list[float])
    goals: list[list[float]] = field(default_factory=list[list[float]])
    judge: Callable[[list[float]], bool] | None = None
    """A further condition for a state."""
    algorithm: str = ""
    """Name of an algorithm of OMPL; it counts where OMPL plans. Empty: none was chosen, and our planner plans."""
    resolution: float = 0.01
    """Distance between two checks of a path as a share of the space's extent, as in OMPL."""
    path: list[list[float]] = field(default_factory=list[list[float]])
    problem: str = ""
    """The reason why the last solving found nothing."""

    @property
    def count(self) -> int:
        """Return the number of coordinates in a state."""
        return sum(space.count for space in self.spaces)


_FLAT_POSES = (SpaceKind.POSE2D, SpaceKind.DUBINS)

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
        own_model = any(writer.is_fixed for writer in self._writers)
        self._validity = Validity(world, moved, task.pairs, own_model=own_model) if task.pairs else None
        self.space = self._space()

    def is_valid(self, state: Array, margin: float = 0.0) -> bool:
        """Return whether nothing comes nearer than the margin (m), and the script agrees. A car stays in its bounds,
        which its ways may leave.
        """
        if self.space.cars and not self.space.contains(state):
            return False
        if self._validity is not None and not self._validity.at(
            lambda data: self._write(data, state), margin
        ):
            return False
        return self._task.judge is None or self._task.judge(state.tolist())

    def _write(self, data: mujoco.MjData, state: Array) -> None:
        """Put the objects there on a scratch state, without kinematics."""
        assert self._validity is not None
        if self._addresses is not None:
            data.qpos[self._addresses] = state
            return
        at = 0
        for writer in self._writers:
            writer.write(self._validity.model, data, state[at : at + writer.space.count])
            at += writer.space.count

    def solve(self, seconds: float, progress: Progress | None = None) -> bool:
        """Find a path; return whether there is one.

        Args:
            seconds: maximum wall time.
            progress: of an earlier search with the same start and goals, to continue it; it is updated.

        Raises:
            CommandError: start or goals are missing or have a wrong size, or OMPL cannot plan this.
        """
        start, goals = self.ends()
        found = self.planner().plan(start, goals, seconds, progress)
        if isinstance(found, Failure):
            self._task.path, self._task.problem = [], found.value
            return False
        self._task.path, self._task.problem = [state.tolist() for state in found], ""
        return True

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
        return Planner(used, self.is_valid, dice, may_go_on, self._is_clear)

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
        if space.kind in _FLAT_POSES:
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


def pose_at(kind: SpaceKind, present: Pose, values: Sequence[float] | Array) -> Pose:
    """Return the pose that the coordinates mean; the other coordinates stay."""
    (_, _, z), quat = present
    if kind == SpaceKind.POSE3D:
        x, y, z, *turn = map(float, values)
        return (x, y, z), normalised((turn[3], *turn[:3]))
    if kind == SpaceKind.POSITION3D:
        return (float(values[0]), float(values[1]), float(values[2])), quat
    if kind in _FLAT_POSES:
        alpha, beta, _ = euler_from_quat(quat)
        quat = quat_from_euler([alpha, beta, float(values[2])])
    return (float(values[0]), float(values[1]), z), quat


def read_state(sim: Simulation, task: Task) -> list[float]:
    """Return the present state of the scene's objects."""
    state: list[float] = []
    for space in task.spaces:
        if space.kind == SpaceKind.JOINT:
            state.append(sim.joints.position(space.handle))
            continue
        state += coordinates(space.kind, get_pose(sim, space.handle, space.reference))
    return state


def coordinates(kind: SpaceKind, pose: Pose) -> list[float]:
    """Return what the coordinates of a space of poses are at a pose."""
    (x, y, z), quat = pose
    if kind == SpaceKind.POSE3D:
        return [x, y, z, *xyzw_from_wxyz(quat)]
    if kind in _FLAT_POSES:
        return [x, y, euler_from_quat(quat)[2]]
    return [x, y, z] if kind == SpaceKind.POSITION3D else [x, y]


def write_state(sim: Simulation, task: Task, state: Sequence[float]) -> None:
    """Move the scene's objects to a state."""
    at = 0
    for space in task.spaces:
        values = state[at : at + space.count]
        at += space.count
        if space.kind == SpaceKind.JOINT:
            sim.joints.set_position(space.handle, values[0])
        else:
            present = get_pose(sim, space.handle, space.reference)
            set_pose(sim, space.handle, space.reference, pose_at(space.kind, present, values))
