"""The path planning tasks of V-REP 3: `simx:planning:NAME`. A search writes its path into a path object.

The robot is moved as a whole, so that the start object comes to the goal. V-REP planned on a grid of steps that grew in
each search step; here the planner of `paths.py` searches, with random numbers. It is imported with the first search.
"""

from __future__ import annotations

import time
from enum import IntEnum
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Annotation, numbers_of
from simx_server.scene.registered import Registry
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from ..planning_world import PlanningWorld
    from .path_searches import Search

FIRST_TASK = 2_070_000

MOST_SEARCHES = 100


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
    kind: str
    """Value of the annotation's key `type`, one of `path_searches.KINDS`."""
    low: tuple[float, ...]
    high: tuple[float, ...]
    """Bounds around the start: x, y, z in m."""
    seconds: float


class PathPlannings(Part):
    """All tasks of the scene, by handle, and the searches under way."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._registry = Registry(sim, "planning", FIRST_TASK, _read, self._is_alive)
        self._searches: dict[int, Search] = {}
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
        if search.go_on(self._sim, world, seconds):
            outcome = Outcome.FOUND
        elif search.needs_time and time.monotonic() < search.ends:
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
        return search.finish(self._sim, world)

    def _prepared(self, world: PlanningWorld, handle: int, seconds: float, step: float) -> Search:
        from .path_searches import search_for  # with it the planners, and few scenes have tasks

        return search_for(self._sim, world, self._get(handle), seconds, step)

    def _get(self, handle: int) -> Planning:
        planning = self._registry.get(handle)
        if planning is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(f"no path planning task with handle {handle}; there are {known}")
        return planning

    def _is_alive(self, planning: Planning) -> bool:
        names = self._sim.scene.by_names()
        return all(name in names for name in (planning.path, planning.start, planning.goal))


def _read(name: str, note: Annotation) -> Planning:
    return Planning(
        name=name,
        path=str(note["path"]),
        start=str(note["start"]),
        goal=str(note["goal"]),
        robot=str(note.get("robot", "")),
        obstacles=str(note.get("obstacles", "all")),
        kind=str(note.get("type", "xy")),
        low=numbers_of(note["low"]) if "low" in note else (-5.0, -5.0, -5.0),
        high=numbers_of(note["high"]) if "high" in note else (5.0, 5.0, 5.0),
        seconds=float(note.get("seconds", 5.0)),
    )
