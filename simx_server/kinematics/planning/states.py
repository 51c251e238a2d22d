"""Path planning tasks as in `simOMPL`: state spaces over objects, pairs that must not collide, start, goals, path."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING

from simx_server.kinematics.scratch import Array
from simx_server.scene.poses.frames import (
    euler_from_quat,
    get_pose,
    quat_from_euler,
    set_pose,
    xyzw_from_wxyz,
)
from simx_server.scene.poses.poses import Pose, normalised

from .graphs import Graph
from .validity import Pairs

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


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
    is_projected: bool = False
    """It is part of the default projection."""

    @property
    def count(self) -> int:
        return _COUNTS[self.kind]


Judged = Callable[[list[float]], tuple[bool, float]]
"""Return whether a state is a goal, and its distance to one."""


@dataclass(frozen=True)
class DummyGoal:
    """A goal that is reached where an object of the robot is at another one."""

    robot: int
    target: int
    tolerance: float
    metric: tuple[float, float, float, float]
    """Factors of the distances along x, y and z (m), and of the angle (rad)."""
    reference: int
    """Frame of these axes; -1: the world."""


@dataclass(frozen=True)
class Projection:
    """A function that projects states on points with few coordinates."""

    function: Callable[[list[float]], list[float]]
    size: int


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
    region: DummyGoal | Judged | None = None
    """A goal that takes the place of goal states."""
    sampler: Callable[[], list[float]] | None = None
    near_sampler: Callable[[list[float], float], list[float]] | None = None
    projection: Projection | None = None
    """Takes the place of the default projection."""
    path: list[list[float]] = field(default_factory=list[list[float]])
    distance: float = 0.0
    """Of the path's last state to the goal; 0 if it is one."""
    is_approximate: bool = False
    """The path ends near the goal only."""
    graph: Graph = field(default_factory=Graph)
    """That of the last search."""
    problem: str = ""
    """The reason why the last solving found nothing."""
    verbosity: int = 0
    """0: the status bar tells nothing of a search."""

    @property
    def count(self) -> int:
        """Return the number of coordinates in a state."""
        return sum(space.count for space in self.spaces)

    @property
    def goal_text(self) -> str:
        """Return the kind of the goal in words."""
        if self.region is None:
            return f"{len(self.goals)} goals"
        return "an object as goal" if isinstance(self.region, DummyGoal) else "a function as goal"


FLAT_POSES = (SpaceKind.POSE2D, SpaceKind.DUBINS)


def pose_at(kind: SpaceKind, present: Pose, values: Sequence[float] | Array) -> Pose:
    """Return the pose that the coordinates mean; the other coordinates stay."""
    (_, _, z), quat = present
    if kind == SpaceKind.POSE3D:
        x, y, z, *turn = map(float, values)
        return (x, y, z), normalised((turn[3], *turn[:3]))
    if kind == SpaceKind.POSITION3D:
        return (float(values[0]), float(values[1]), float(values[2])), quat
    if kind in FLAT_POSES:
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
    if kind in FLAT_POSES:
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
