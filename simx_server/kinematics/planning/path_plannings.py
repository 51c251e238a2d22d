"""The path planning tasks of V-REP 3: `simx:planning:NAME`. A search writes its path into a path object.

The robot is moved as a whole, so that the start object comes to the goal. V-REP planned on a grid of steps that grew in
each search step; here the planner of `paths.py` searches, with random numbers.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.collection import ALL
from simx_server.scene.formats.annotations import Annotation, numbers_of
from simx_server.scene.geometry.curve import ControlPoint
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import Pose, add, compose, inverse, subtract
from simx_server.scene.registered import Registry
from simx_server.simulation.part import Part

from .paths import Failure, Progress
from .planning_world import PlanningWorld, entity
from .states import ROTATIONS, SpaceKind, StateSpace, Task, coordinates, pose_at
from .tasks import Solving

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .planning_world import PlanningWorld

FIRST_TASK = 2_070_000

KINDS = {
    "xy": SpaceKind.POSITION2D,
    "xyz": SpaceKind.POSITION3D,
    "xyg": SpaceKind.POSE2D,
    "xyzabg": SpaceKind.POSE3D,
}
"""Values of the annotation's key `type`."""

MOST_SEARCHES = 100

_SHORTEST = 0.01
"""Seconds of a search step, at least."""

_SHORTENING = 0.5
"""Most seconds for shortening a path that was found step by step: the simulation waits."""


class Outcome(IntEnum):
    """Results of a search step, as V-REP gives them."""

    GOES_ON = -2
    FAILED = 0
    FOUND = 2


@dataclass(frozen=True)
class Planning:
    """A task; all objects and entities by name."""

    name: str
    path: str
    start: str
    goal: str
    robot: str
    obstacles: str
    kind: SpaceKind
    low: tuple[float, ...]
    high: tuple[float, ...]
    """Bounds around the start: x, y, z in m."""
    seconds: float


@dataclass(frozen=True)
class _Search:
    """A search; scripts may carry it out step by step."""

    task: Task
    path: int
    present: Pose
    offset: Pose
    """The robot at the start, and the start object relative to it."""
    ends: float
    step: float
    progress: Progress = field(default_factory=Progress)


class PathPlannings(Part):
    """All tasks of the scene, by handle, and the searches under way."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._registry = Registry(sim, "planning", FIRST_TASK, _read, self._is_alive)
        self._searches: dict[int, _Search] = {}
        self._next = 1

    def scene_changed(self) -> None:
        self._registry.forget()
        self._searches.clear()

    def run_stopped(self) -> None:
        self._searches.clear()

    def find(self, name: str) -> int:
        """Return the handle of a task. Raises CommandError that lists the tasks."""
        return self._registry.handle_of(name, "path planning task")

    def begin(self, world: PlanningWorld, handle: int, seconds: float, step: float) -> int:
        """Start a search and return its number.

        Args:
            world: the world.
            handle: the task.
            seconds: longest duration of the search; 0: as the task says.
            step: seconds of each search step.

        Raises:
            CommandError: no such task, or too many searches.
        """
        if len(self._searches) >= MOST_SEARCHES:
            raise CommandError(f"{MOST_SEARCHES} path searches are under way; end some")
        search = self._prepared(world, handle, seconds, step)
        number, self._next = self._next, self._next + 1
        self._searches[number] = search
        return number

    def go_on(self, world: PlanningWorld, number: int) -> Outcome:
        """Make a search step. A search that does not go on is over. Raises CommandError."""
        search = self._searches.get(number)
        if search is None:
            raise CommandError(f"no path search {number} is under way")
        seconds = min(search.step, search.ends - time.monotonic())
        if self._solve(world, search, seconds, shortening=_SHORTENING):
            outcome = Outcome.FOUND
        elif search.task.problem == Failure.TIME.value and time.monotonic() < search.ends:
            outcome = Outcome.GOES_ON
        else:
            outcome = Outcome.FAILED
        if outcome is not Outcome.GOES_ON:
            del self._searches[number]
        return outcome

    def end(self, number: int) -> None:
        """End a search."""
        self._searches.pop(number, None)

    def search(self, world: PlanningWorld, handle: int, seconds: float) -> bool:
        """Search at once; return whether a path was found. Raises CommandError."""
        search = self._prepared(world, handle, seconds, 0.0)
        return self._solve(world, search, search.ends - time.monotonic())

    def _get(self, handle: int) -> Planning:
        planning = self._registry.get(handle)
        if planning is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(f"no path planning task with handle {handle}; there are {known}")
        return planning

    def _is_alive(self, planning: Planning) -> bool:
        names = self._sim.scene.by_names()
        return all(name in names for name in (planning.path, planning.start, planning.goal))

    def _prepared(self, world: PlanningWorld, handle: int, seconds: float, step: float) -> _Search:
        """Return a search from where the objects are now. Raises CommandError."""
        planning, sim = self._get(handle), self._sim
        start, goal, path = (
            sim.scene.resolve(name) for name in (planning.start, planning.goal, planning.path)
        )
        robot = start
        while sim.scene.objects[robot].parent != -1:
            robot = sim.scene.objects[robot].parent
        begin, end, present = (get_pose(sim, handle) for handle in (start, goal, robot))
        last = coordinates(planning.kind, _arrived(planning.kind, present, begin, end))
        low, high = (coordinates(planning.kind, present) for _ in range(2))
        turns = ROTATIONS.get(planning.kind, ())
        places = len(low) - len(turns)
        for axis in range(places):
            low[axis] = min(low[axis] + planning.low[axis], last[axis])
            high[axis] = max(high[axis] + planning.high[axis], last[axis])
        low[places:], high[places:] = [-each for each in turns], turns
        space = StateSpace(planning.name, planning.kind, robot, tuple(low), tuple(high))
        task = Task(planning.name, [space], start=coordinates(planning.kind, present), goals=[last])
        if planning.robot:
            obstacles = ALL if planning.obstacles == "all" else entity(world, planning.obstacles)
            task.pairs = [(entity(world, planning.robot), obstacles)]
        duration = seconds if seconds > 0 else planning.seconds
        offset = compose(inverse(present), begin)
        return _Search(task, path, present, offset, time.monotonic() + duration, max(step, _SHORTEST))

    def _solve(
        self, world: PlanningWorld, search: _Search, seconds: float, *, shortening: float | None = None
    ) -> bool:
        """Continue a search, and write the path into the path object if one is found."""
        task = search.task
        solving = Solving(world, task)
        if not solving.solve(seconds, search.progress):
            return False
        solving.simplify(shortening)
        kind, frame = task.spaces[0].kind, inverse(get_pose(self._sim, search.path))
        poses = [compose(pose_at(kind, search.present, state), search.offset) for state in task.path]
        points = [ControlPoint(compose(frame, pose)) for pose in poses]
        world.paths.set_points(search.path, points, is_closed=False)
        return True


def _arrived(kind: SpaceKind, robot: Pose, begin: Pose, end: Pose) -> Pose:
    """Return where the robot is when its start object is at the end."""
    if kind in ROTATIONS:
        return compose(end, compose(inverse(begin), robot))
    return add(robot[0], subtract(end[0], begin[0])), robot[1]


def _read(name: str, note: Annotation) -> Planning:
    return Planning(
        name=name,
        path=str(note["path"]),
        start=str(note["start"]),
        goal=str(note["goal"]),
        robot=str(note.get("robot", "")),
        obstacles=str(note.get("obstacles", "all")),
        kind=KINDS[str(note.get("type", "xy"))],
        low=numbers_of(note["low"]) if "low" in note else (-5.0, -5.0, -5.0),
        high=numbers_of(note["high"]) if "high" in note else (5.0, 5.0, 5.0),
        seconds=float(note.get("seconds", 5.0)),
    )
