"""Searches for the paths of V-REP 3's path planning tasks, see `path_plannings.py`."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from simx_server.scene.collection import ALL
from simx_server.scene.geometry.curve import ControlPoint
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import Pose, add, compose, inverse, subtract

from ..paths import Failure, Progress
from ..planning_world import PlanningWorld, entity
from ..states import ROTATIONS, SpaceKind, StateSpace, Task, coordinates, pose_at
from ..tasks import Solving

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .path_plannings import Planning

KINDS = {
    "xy": SpaceKind.POSITION2D,
    "xyz": SpaceKind.POSITION3D,
    "xyg": SpaceKind.POSE2D,
    "xyzabg": SpaceKind.POSE3D,
}
"""Values of the annotation's key `type`."""

_SHORTEST = 0.01
"""Seconds of a search step, at least."""

_SHORTENING = 0.5
"""Most seconds for shortening a path that was found step by step: the simulation waits."""


@dataclass(frozen=True)
class Search:
    """A search; scripts may carry it out step by step."""

    task: Task
    path: int
    present: Pose
    offset: Pose
    """The robot at the start, and the start object relative to it."""
    ends: float
    step: float
    progress: Progress = field(default_factory=Progress)

    @property
    def needs_time(self) -> bool:
        """Return whether the last step ended without a result because its time was over."""
        return self.task.problem == Failure.TIME.value

    def go_on(self, sim: Simulation, world: PlanningWorld, seconds: float) -> bool:
        """Search for some seconds; return whether a path was found, which is then in the path object."""
        return self._solve(sim, world, seconds, shortening=_SHORTENING)

    def finish(self, sim: Simulation, world: PlanningWorld) -> bool:
        """Search until the end; return whether a path was found, which is then in the path object."""
        return self._solve(sim, world, self.ends - time.monotonic())

    def _solve(
        self, sim: Simulation, world: PlanningWorld, seconds: float, *, shortening: float | None = None
    ) -> bool:
        task = self.task
        solving = Solving(world, task)
        if not solving.solve(seconds, self.progress):
            return False
        solving.simplify(shortening)
        kind, frame = task.spaces[0].kind, inverse(get_pose(sim, self.path))
        poses = [compose(pose_at(kind, self.present, state), self.offset) for state in task.path]
        points = [ControlPoint(compose(frame, pose)) for pose in poses]
        world.paths.set_points(self.path, points, is_closed=False)
        return True


def search_for(
    sim: Simulation, world: PlanningWorld, planning: Planning, seconds: float, step: float
) -> Search:
    """Return a search from where the objects of a task are now.

    Args:
        sim: the simulation.
        world: the world.
        planning: the task.
        seconds: longest duration of the search; 0: as the task says.
        step: seconds of each search step.

    Raises:
        CommandError: an object of the task is gone.
    """
    start, goal, path = (sim.scene.resolve(name) for name in (planning.start, planning.goal, planning.path))
    robot, kind = start, KINDS[planning.kind]
    while sim.scene.objects[robot].parent != -1:
        robot = sim.scene.objects[robot].parent
    begin, end, present = (get_pose(sim, handle) for handle in (start, goal, robot))
    last = coordinates(kind, _arrived(kind, present, begin, end))
    low, high = (coordinates(kind, present) for _ in range(2))
    turns = ROTATIONS.get(kind, ())
    places = len(low) - len(turns)
    for axis in range(places):
        low[axis] = min(low[axis] + planning.low[axis], last[axis])
        high[axis] = max(high[axis] + planning.high[axis], last[axis])
    low[places:], high[places:] = [-each for each in turns], turns
    space = StateSpace(planning.name, kind, robot, tuple(low), tuple(high))
    task = Task(planning.name, [space], start=coordinates(kind, present), goals=[last])
    if planning.robot:
        obstacles = ALL if planning.obstacles == "all" else entity(world, planning.obstacles)
        task.pairs = [(entity(world, planning.robot), obstacles)]
    duration = seconds if seconds > 0 else planning.seconds
    offset = compose(inverse(present), begin)
    return Search(task, path, present, offset, time.monotonic() + duration, max(step, _SHORTEST))


def _arrived(kind: SpaceKind, robot: Pose, begin: Pose, end: Pose) -> Pose:
    """Return where the robot is when its start object is at the end."""
    if kind in ROTATIONS:
        return compose(end, compose(inverse(begin), robot))
    return add(robot[0], subtract(end[0], begin[0])), robot[1]
