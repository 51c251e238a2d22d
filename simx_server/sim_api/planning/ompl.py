"""``simOMPL``: plan paths in the space of joints or of object poses.

One planner stands for all algorithms, unless OMPL itself plans (`kinematics/planning/ompl_planner.py`). V-REP 3's
flat names are in `ompl_flat.py`.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.planning.states import (
    ROTATIONS,
    SpaceKind,
    StateSpace,
    Task,
    read_state,
    write_state,
)
from simx_server.kinematics.planning.validity import as_pairs
from simx_server.kinematics.sampling import LONGEST
from simx_server.scripting.interpreter import Function

from .ompl_drawing import OmplDrawing
from .ompl_goals import OmplGoals
from .ompl_spaces import OmplSpaces

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
"""Numbers of the algorithms in the plugin."""

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

_LEAST_RADIUS = 1e-3
"""Least radius of a turn in metres."""

_FARTHEST = 1e6
"""Greatest bound accepted, in metres or radians."""


class OmplFunctions(OmplGoals, OmplSpaces, OmplDrawing, effect="changes"):
    """All functions of ``simOMPL``."""

    PLUGIN = "simOMPL"

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
        use_for_projection: int = 0,
        weight: float = 1.0,
        reference: int = -1,
    ) -> int:
        """Create a state space and return its handle: a joint's position, or x, y (, z) of a shape or dummy,
        optionally with its rotation. In a dubins space it moves as a car that drives along its x axis.

        `low` and `high` are the bounds of the positions; rotations have none.
        """
        if kind not in tuple(SpaceKind):
            known = ", ".join(f"{number} {name}" for name, number in SPACE_KINDS.items())
            raise CommandError(f"{kind} is no kind of state space that is there; those are {known}")
        self._sim.scene.get(self._self(handle))
        if weight <= 0:
            raise CommandError("a weight is above 0")
        space = StateSpace(name, SpaceKind(kind), self._self(handle), (), (), weight, reference)
        turn = ROTATIONS.get(space.kind, ())
        bounded = space.count - len(turn)
        if len(low) < bounded or len(high) < bounded:
            raise CommandError(f"lower and upper bounds are {bounded} numbers each")
        if any(a >= b for a, b in zip(low[:bounded], high[:bounded], strict=True)):
            raise CommandError("each lower bound must be below the upper one")
        if max(map(abs, (*low[:bounded], *high[:bounded]))) > _FARTHEST:
            raise CommandError(f"bounds are at most {_FARTHEST:.0f} away from 0")
        bounds = (*low[:bounded], *(-each for each in turn)), (*high[:bounded], *turn)
        low_bounds, high_bounds = bounds
        projected = bool(use_for_projection)
        return self._add(
            self._spaces, replace(space, low=low_bounds, high=high_bounds, is_projected=projected)
        )

    def setDubinsParams(self, space: int, radius: float, is_symmetric: bool = False) -> None:
        """Set the smallest radius of a turn in metres, 1 at first, of a dubins space, also in tasks that use it.
        `is_symmetric`: a way may lead backwards from its start to its end, where that is shorter.
        """
        before = self._space(space)
        if before.kind is not SpaceKind.DUBINS:
            raise CommandError(f"'{before.name}' is no dubins space; give simOMPL.StateSpaceType.dubins")
        if not _LEAST_RADIUS <= radius <= _FARTHEST:
            raise CommandError(f"a radius is from {_LEAST_RADIUS} to {_FARTHEST:.0f} metres")
        after = self._spaces[space] = replace(before, radius=radius, is_symmetric=bool(is_symmetric))
        for task in self._tasks.values():
            task.spaces = [after if each is before else each for each in task.spaces]

    def destroyStateSpace(self, space: int) -> bool:
        """Delete a state space; tasks that use it keep it."""
        self._space(space)
        del self._spaces[space]
        return True

    def setStateSpace(self, task: int, spaces: list[int]) -> bool:
        self._task(task)
        self._set_spaces(task, [self._space(space) for space in spaces])
        return True

    def setAlgorithm(self, task: int, algorithm: int) -> bool:
        """Set the algorithm, one of simOMPL.Algorithm. Partly: RRT-Connect stands for all of them; a server with
        `--planner ompl`, which needs the extra `ompl`, has eight of them.
        """
        chosen = self._task(task)
        names = [name for name, number in ALGORITHMS.items() if number == algorithm]
        if not names:
            known = ", ".join(f"{number} {name}" for name, number in ALGORITHMS.items())
            raise CommandError(f"{algorithm} is no algorithm; those are {known}")
        chosen.algorithm = names[0]
        return True

    def setVerboseLevel(self, task: int, level: int) -> bool:
        """Set the level of messages: 0 none, from 1 on the status bar tells what a search has found."""
        self._task(task).verbosity = level
        return True

    def setCollisionPairs(self, task: int, pairs: list[int]) -> bool:
        """Set pairs {entity, entity, ...} that must not collide; sim.handle_all as second entity stands for all
        others.
        """
        chosen = as_pairs(pairs)
        for first, second in chosen:
            self._world.meters.collisions.entities(first, second)
        self._task(task).pairs = chosen
        return True

    def setStateValidityCheckingResolution(self, task: int, resolution: float) -> bool:
        """Set the distance between two checks as a share of the space's extent. Partly: never coarser than 5 mrad
        or 5 mm, or 20 mm for poses in space.
        """
        if not 0 < resolution <= 1:
            raise CommandError("a resolution is above 0, up to 1")
        self._task(task).resolution = resolution
        return True

    def setStateValidityCallback(self, task: int, callback: str | Function, name: str = "") -> bool:
        """Set a function(state) that returns whether a state is valid, in addition to the collision pairs."""
        if isinstance(callback, str) and name:  # V-REP 3 passed the script handle or type first
            callback = name
        function = self._function(callback)

        def judge(state: list[float]) -> bool:
            answer = function(state)
            return bool(answer and answer[0])

        self._task(task).judge = judge
        return True

    setStateValidationCallback = setStateValidityCallback

    def setStartState(self, task: int, state: list[float]) -> bool:
        self._task(task).start = self._state(task, state)
        return True

    def setup(self, task: int) -> bool:
        """Check that the task can be solved; return false when the start or all goals are invalid."""
        chosen, solving = self._task(task), self._solving(task)
        if not chosen.start or not solving.is_valid(np.array(chosen.start)):
            return False
        return chosen.region is not None or any(solving.is_valid(np.array(goal)) for goal in chosen.goals)

    def solve(self, task: int, seconds: float = 1.0) -> bool:
        """Find a path within this wall time; return whether one was found. The server answers other clients
        meanwhile. If the goal is an object or a function and is not reached in time, the path leads near to it.
        """
        with self._planning(task) as solving:
            is_solved = solving.solve(_limited(seconds))
        if self._task(task).verbosity > 0:
            self.printTaskInfo(task)
        return is_solved

    def simplifyPath(self, task: int, seconds: float = -1.0) -> bool:
        """Shorten the path within this wall time; the default takes about 1 s, and equal runs give equal paths."""
        with self._planning(task) as solving:
            solving.simplify(None if seconds < 0 else _limited(seconds))
        return bool(self._task(task).path)

    def interpolatePath(self, task: int, count: int = 0) -> bool:
        """Interpolate the path to at least `count` states; 0: as many as there are validity checks."""
        with self._planning(task) as solving:
            solving.interpolate(count)
        return bool(self._task(task).path)

    def compute(
        self, task: int, seconds: float, shortening: float = -1.0, count: int = 0
    ) -> tuple[bool, list[float]]:
        """Call solve, simplifyPath and interpolatePath; return whether there is a path, and its states in sequence."""
        if not (self.solve(task, seconds) and self.simplifyPath(task, shortening)):
            return False, []
        self.interpolatePath(task, count)
        return True, self.getPath(task)

    def getPath(self, task: int) -> list[float]:
        """Return the states of the path in sequence; empty without one."""
        return [value for state in self._task(task).path for value in state]

    def getPathStateCount(self, task: int, path: list[float] | None = None) -> int:
        """Return the number of states of the task's path, or of the given one."""
        chosen = self._task(task)
        return len(chosen.path) if path is None else len(path) // max(chosen.count, 1)

    def getPathState(self, task: int, index: int) -> list[float]:
        """Return one state of the path; the index starts at 0."""
        path = self._task(task).path
        if not 0 <= index < len(path):
            raise CommandError(f"the path has {len(path)} states, so there is no state {index}")
        return path[index]

    def getReversedPath(self, task: int, path: list[float]) -> list[float]:
        """Return the states in reverse order."""
        count = self._task(task).count
        if count == 0 or len(path) % count:
            raise CommandError(f"a path of this task has a multiple of {count} numbers")
        return [
            value for start in range(len(path) - count, -1, -count) for value in path[start : start + count]
        ]

    def isStateValid(self, task: int, state: list[float]) -> bool:
        values = np.array(self._state(task, state))
        solving = self._solving(task)
        return solving.space.contains(values) and solving.is_valid(values)

    def isStateWithinBounds(self, task: int, state: list[float]) -> bool:
        return self._solving(task).space.contains(np.array(self._state(task, state)))

    def readState(self, task: int) -> list[float]:
        """Return the present state of the scene's objects."""
        return read_state(self._sim, self._task(task))

    def writeState(self, task: int, state: list[float]) -> None:
        """Move the scene's objects to this state."""
        write_state(self._sim, self._task(task), self._state(task, state))

    def stateDistance(self, task: int, first: list[float], second: list[float]) -> float:
        """Return the weighted Euclidean distance; angles count the short way, cars by their way."""
        space = self._solving(task).space
        return space.line(np.array(self._state(task, first)), np.array(self._state(task, second))).length

    def printTaskInfo(self, task: int) -> bool:
        """Print a description of the task to the status bar."""
        chosen = self._task(task)
        spaces = ", ".join(f"{space.name} ({space.kind.name.lower()})" for space in chosen.spaces) or "none"
        self._world.status_bar.add(
            f"task '{chosen.name}': spaces {spaces}; {chosen.goal_text}, {len(chosen.path)} states of a path"
            f", {len(chosen.graph.states)} states were reached"
            + (f"; {chosen.problem}" if chosen.problem else "")
        )
        return True


def _limited(seconds: float) -> float:
    return min(max(0.0, seconds), LONGEST)
