"""``simOMPL``: planning ways in the space of joints, or of the places of an object.

One planner stands for all algorithms (`kinematics/paths.py`, which says why). V-REP 3's flat names
(``simExtOMPL_createTask``) are in `ompl_flat.py`.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.search import LONGEST
from simx_server.kinematics.tasks import SpaceKind, StateSpace, Task, read_state, write_state
from simx_server.kinematics.validity import as_pairs
from simx_server.scripting.interpreter import Function

from .ompl_tasks import OmplTasks

ALGORITHMS = MappingProxyType(
    {
        name: 20001 + number
        for number, name in enumerate(
            (
                *(
                    "BiTRRT",
                    "BITstar",
                    "BKPIECE1",
                    "CForest",
                    "EST",
                    "FMT",
                    "KPIECE1",
                    "LazyPRM",
                    "LazyPRMstar",
                ),
                *(
                    "LazyRRT",
                    "LBKPIECE1",
                    "LBTRRT",
                    "PDST",
                    "PRM",
                    "PRMstar",
                    "pRRT",
                    "pSBL",
                    "RRT",
                    "RRTConnect",
                ),
                *("RRTstar", "SBL", "SPARS", "SPARStwo", "STRIDE", "TRRT"),
            )
        )
    }
)
"""The plugin's numbers."""

SPACE_KINDS = MappingProxyType(
    {
        "position2d": 30001,
        "pose2d": 30002,
        "position3d": 30003,
        "pose3d": 30004,
        "joint_position": 30005,
        "dubins": 30006,
    }
)

_FARTHEST = 1e6
"""Bounds beyond that make no sense in metres or radians."""


class OmplFunctions(OmplTasks):
    """The whole namespace."""

    CONSTANTS = MappingProxyType(
        {
            "Algorithm": dict(ALGORITHMS),
            "StateSpaceType": dict(SPACE_KINDS),
            **{f"algorithm_{name}": number for name, number in ALGORITHMS.items()},
            **{f"statespacetype_{name}": number for name, number in SPACE_KINDS.items()},
        }
    )

    def createTask(self, name: str) -> int:
        return self._add(self._tasks, Task(name))

    def destroyTask(self, task: int) -> bool:
        self._task(task)
        del self._tasks[task]
        return True

    def createStateSpace(
        self,
        name: str,
        kind: int,
        handle: int,
        low: list[float],
        high: list[float],
        _projection: int = 0,
        weight: float = 1.0,
        reference: int = -1,
    ) -> int:
        """Coordinates of one object: a joint's position, or x, y (, z) of a shape or dummy, with or without its turn.

        `low` and `high` are those of the coordinates; the turn of pose2d has none. Partly: no pose3d, no dubins.
        """
        if kind not in tuple(SpaceKind):
            known = ", ".join(
                f"{number} {name}" for name, number in SPACE_KINDS.items() if number in tuple(SpaceKind)
            )
            raise CommandError(f"{kind} is no kind of state space that is there; those are {known}")
        self._sim.scene.get(self._self(handle))
        if weight <= 0:
            raise CommandError("a weight is above 0")
        space = StateSpace(name, SpaceKind(kind), self._self(handle), (), (), weight, reference)
        bounded = 2 if space.kind == SpaceKind.POSE2D else space.count
        if len(low) < bounded or len(high) < bounded:
            raise CommandError(f"lower and upper bounds are {bounded} numbers each")
        if any(a >= b for a, b in zip(low[:bounded], high[:bounded], strict=True)):
            raise CommandError("each lower bound must be below the upper one")
        if max(map(abs, (*low[:bounded], *high[:bounded]))) > _FARTHEST:
            raise CommandError(f"bounds are at most {_FARTHEST:.0f} away from 0")
        turn = (float(np.pi),) if space.kind == SpaceKind.POSE2D else ()
        bounds = (*low[:bounded], *(-each for each in turn)), (*high[:bounded], *turn)
        return self._add(self._spaces, StateSpace(name, space.kind, space.handle, *bounds, weight, reference))

    def destroyStateSpace(self, space: int) -> bool:
        """Tasks that have it keep it."""
        self._space(space)
        del self._spaces[space]
        return True

    def setStateSpace(self, task: int, spaces: list[int]) -> bool:
        chosen = self._task(task)
        chosen.spaces = [self._space(space) for space in spaces]
        chosen.start, chosen.goals, chosen.path = [], [], []
        return True

    def setAlgorithm(self, task: int, algorithm: int) -> bool:
        """One of simOMPL.Algorithm. Partly: all of them are RRT-Connect here."""
        self._task(task)
        if algorithm not in ALGORITHMS.values():
            known = ", ".join(f"{number} {name}" for name, number in ALGORITHMS.items())
            raise CommandError(f"{algorithm} is no algorithm; those are {known}")
        return True

    def setVerboseLevel(self, task: int, _level: int) -> bool:
        """Partly: nothing is printed in any case."""
        self._task(task)
        return True

    def setCollisionPairs(self, task: int, pairs: list[int]) -> bool:
        """{entity, entity, ...} two by two that must not meet; sim.handle_all as second: all others."""
        chosen = as_pairs(pairs)
        for first, second in chosen:
            self._world.meters.collisions.entities(first, second)
        self._task(task).pairs = chosen
        return True

    def setStateValidityCheckingResolution(self, task: int, resolution: float) -> bool:
        """Share of the space's extent between two checks. Partly: never coarser than 5 mrad or 5 mm."""
        if not 0 < resolution <= 1:
            raise CommandError("a resolution is above 0, up to 1")
        self._task(task).resolution = resolution
        return True

    def setStateValidityCallback(self, task: int, callback: str | Function, name: str = "") -> bool:
        """A function(state) that says whether a state will do, beside the collision pairs."""
        if isinstance(callback, str) and name:  # script handle or type first, as V-REP 3 had it
            callback = name
        function = self._function(callback)

        def judge(state: list[float]) -> bool:
            answer = function(state)
            return bool(answer and answer[0])

        self._task(task).judge = judge
        return True

    def setStartState(self, task: int, state: list[float]) -> bool:
        self._task(task).start = self._state(task, state)
        return True

    def setGoalState(self, task: int, state: list[float]) -> bool:
        self._task(task).goals = [self._state(task, state)]
        return True

    def addGoalState(self, task: int, state: list[float]) -> bool:
        self._task(task).goals.append(self._state(task, state))
        return True

    def setup(self, task: int) -> bool:
        """Looks whether the task can be solved; false when the start or all goals are not valid."""
        chosen, solving = self._task(task), self._solving(task)
        return solving.is_valid(np.array(chosen.start)) and any(
            solving.is_valid(np.array(goal)) for goal in chosen.goals
        )

    def solve(self, task: int, seconds: float = 1.0) -> bool:
        """Find a path within that wall time. Other clients are answered meanwhile."""
        with self._planning(task) as solving:
            return solving.solve(_limited(seconds))

    def simplifyPath(self, task: int, seconds: float = -1.0) -> bool:
        """Shorten the path within that wall time; without one, about 1 s, and equal runs give equal paths."""
        with self._planning(task) as solving:
            solving.simplify(None if seconds < 0 else _limited(seconds))
        return bool(self._task(task).path)

    def interpolatePath(self, task: int, count: int = 0) -> bool:
        """At least `count` states; 0: as many as checks are made."""
        with self._planning(task) as solving:
            solving.interpolate(count)
        return bool(self._task(task).path)

    def compute(
        self, task: int, seconds: float, shortening: float = -1.0, count: int = 0
    ) -> tuple[bool, list[float]]:
        """solve, simplifyPath and interpolatePath; whether there is a path, and its states one after the other."""
        if not (self.solve(task, seconds) and self.simplifyPath(task, shortening)):
            return False, []
        self.interpolatePath(task, count)
        return True, self.getPath(task)

    def getPath(self, task: int) -> list[float]:
        """The states of the path one after the other; empty when there is none."""
        return [value for state in self._task(task).path for value in state]

    def getPathStateCount(self, task: int) -> int:
        return len(self._task(task).path)

    def getPathState(self, task: int, index: int) -> list[float]:
        """Numbered from 0."""
        path = self._task(task).path
        if not 0 <= index < len(path):
            raise CommandError(f"the path has {len(path)} states, so there is no state {index}")
        return path[index]

    def getReversedPath(self, task: int, path: list[float]) -> list[float]:
        """The states in the other order."""
        count = self._task(task).count
        if count == 0 or len(path) % count:
            raise CommandError(f"a path of this task has a multiple of {count} numbers")
        return [
            value for start in range(len(path) - count, -1, -count) for value in path[start : start + count]
        ]

    def hasExactSolution(self, task: int) -> bool:
        return bool(self._task(task).path)

    def hasApproximateSolution(self, task: int) -> bool:
        """False: a path leads to its goal, or there is none."""
        self._task(task)
        return False

    def isStateValid(self, task: int, state: list[float]) -> bool:
        values = np.array(self._state(task, state))
        solving = self._solving(task)
        return solving.space.contains(values) and solving.is_valid(values)

    def isStateWithinBounds(self, task: int, state: list[float]) -> bool:
        return self._solving(task).space.contains(np.array(self._state(task, state)))

    def readState(self, task: int) -> list[float]:
        """Where the scene's objects are now."""
        return read_state(self._sim, self._task(task))

    def writeState(self, task: int, state: list[float]) -> None:
        """Put the scene's objects there."""
        write_state(self._sim, self._task(task), self._state(task, state))

    def stateDistance(self, task: int, first: list[float], second: list[float]) -> float:
        """Weighted Euclidean, angles the short way."""
        space = self._solving(task).space
        change = space.difference(np.array(self._state(task, first)), np.array(self._state(task, second)))
        return float(np.linalg.norm(change * space.weights))

    def printTaskInfo(self, task: int) -> bool:
        """To the status bar."""
        chosen = self._task(task)
        spaces = ", ".join(f"{space.name} ({space.kind.name.lower()})" for space in chosen.spaces) or "none"
        self._world.status_bar.add(
            f"task '{chosen.name}': spaces {spaces}; {len(chosen.goals)} goals, {len(chosen.path)} states of a path"
            + (f"; {chosen.problem}" if chosen.problem else "")
        )
        return True


def _limited(seconds: float) -> float:
    return min(max(0.0, seconds), LONGEST)
