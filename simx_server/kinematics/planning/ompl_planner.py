"""The planners of OMPL by their names, through its own Python module: the extra `ompl`, and ``--planner ompl``.

I. Sucan, M. Moll, L. Kavraki, "The Open Motion Planning Library", IEEE Robotics & Automation Magazine 2012.

Of the 25 algorithms in V-REP's plug-in the module (2.0.1) has ten. PRM and PRMstar are not used: they ask in a second
thread whether to go on, which waits for Python while Python waits for it.

Only the search is OMPL's. The check of a state and the shortening of a path are those of `paths.py`.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import threading
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from simx_client.protocol.cli.installing import extra_line
from simx_server.errors import CommandError
from simx_server.kinematics.scratch import Array

from .graphs import Graph
from .paths import Failure, Planner, Progress, TimeIsUpError
from .space import Space

ALGORITHMS: Sequence[str] = (
    "BITstar",
    "BKPIECE1",
    "FMT",
    "KPIECE1",
    "LBKPIECE1",
    "RRT",
    "RRTConnect",
    "RRTstar",
)

_KEEPS_ITS_GRAPH = "BITstar"
"""An algorithm that never frees a space whose graph was taken from it (module 2.0.1)."""

_LONGEST_WAIT = 60.0
"""Maximum seconds for the end of a search in another world of this process: OMPL has one seed for all of them."""

_PATIENCE = 3
"""An algorithm that goes on for this many times its limits is stopped, and has found nothing."""

_seeding = threading.RLock()
"""A search may serve a client that starts another one."""


@cache
def is_available() -> bool:
    """Return whether OMPL is installed."""
    return importlib.util.find_spec("ompl") is not None


def missing() -> str:
    """Return what to do where OMPL is not installed; otherwise an empty text."""
    return "" if is_available() else f"--planner ompl needs OMPL; install with: {extra_line('ompl')}"


class OmplPlanner(Planner):
    """Plans with one of ALGORITHMS in joints and positions, or for one car, or for one pose."""

    def __init__(self, algorithm: str, space: Space, *more: Any) -> None:
        """Make a planner; the other arguments are those of `Planner`.

        Raises:
            CommandError: OMPL is not installed or cannot plan this.
        """
        super().__init__(space, *more)
        if problem := missing():
            raise CommandError(problem)
        if algorithm not in ALGORITHMS:
            raise CommandError(
                f"{algorithm} cannot be used from the Python module of OMPL; these can: "
                f"{', '.join(ALGORITHMS)}; without --planner ompl the server's own planner stands for all of them"
            )
        self._algorithm = algorithm
        self.graph = Graph()
        """That of the last search; BITstar has none."""
        self._enough, self._late = math.inf, math.inf
        """Number of checks, and moment, from which on the search is over."""

    def plan(
        self,
        start: Array,
        goals: Sequence[Array],
        seconds: float,
        progress: Progress | None = None,
        checks: int | None = None,
    ) -> list[Array] | Failure:
        """Return states (n,) from the start to one of the goals.

        Algorithms that improve their path, such as RRTstar, search until the time or the number of checks is over.
        """
        self._limit(seconds, checks)
        self._enough, self._late = self._most, self._end
        try:
            good = self._begin(start, goals)
            if isinstance(good, Failure):
                return good
            # An algorithm asks now and then whether it is over, and only then tells what it has found.
            self._limit(_PATIENCE * seconds, None if checks is None else _PATIENCE * checks)
            with _seeded(int(self._random.integers(1, 1 << 32))):
                return self._search(start, good)
        except TimeIsUpError:
            return Failure.TIME

    def _search(self, start: Array, goals: Sequence[Array]) -> list[Array] | Failure:
        base, geometric = importlib.import_module("ompl.base"), importlib.import_module("ompl.geometric")
        # Each goal as it is nearest to the start: angles without an end are plain numbers here.
        ends = [start, *(start + self._space.difference(start, goal) for goal in goals)]
        form = _as_ompl(base, self._space, ends)
        setup = geometric.SimpleSetup(form.space)
        information = setup.getSpaceInformation()
        share = self._space.resolution / form.space.getMaximumExtent()
        information.setStateValidityCheckingResolution(min(share, 1.0))

        def is_valid(state: Any) -> bool:
            return self._is_valid(np.array(form.read(state)))

        setup.setStateValidityChecker(is_valid)
        states = [information.allocState() for _ in ends]
        for state, values in zip(states, ends, strict=True):
            form.write(state, values.tolist())
        setup.setStartState(states[0])
        found = base.GoalStates(information)
        for state in states[1:]:
            found.addState(state)
        setup.setGoal(found)
        setup.setPlanner(getattr(geometric, self._algorithm)(information))
        setup.solve(base.PlannerTerminationCondition(self._is_over))
        if self._algorithm != _KEEPS_ITS_GRAPH:
            self.graph = _graph(base, setup, form)
        if not setup.haveExactSolutionPath():
            return Failure.TIME
        path = setup.getSolutionPath()
        if self._space.endless.any():
            path.interpolate(path.getStateCount() + math.ceil(path.length()))
        return [np.array(form.read(path.getState(index))) for index in range(path.getStateCount())]

    def _is_over(self) -> bool:
        return self._count >= self._enough or time.monotonic() > self._late


@dataclass(frozen=True)
class _Form:
    """A space of OMPL, and what its states are as numbers."""

    space: Any
    bounded: int
    """Number of coordinates that have bounds; they come first."""
    read: Callable[[Any], Sequence[float]]
    write: Callable[[Any, list[float]], object]


def _graph(base: Any, setup: Any, form: _Form) -> Graph:
    data = base.PlannerData(setup.getSpaceInformation())
    setup.getPlannerData(data)
    count = data.numVertices()
    return Graph(
        [np.array(form.read(data.getVertex(index).getState())) for index in range(count)],
        [(index, other) for index in range(count) for other in data.getEdges(index)],
        [data.getStartIndex(index) for index in range(data.numStartVertices())],
        [data.getGoalIndex(index) for index in range(data.numGoalVertices())],
    )


def _as_ompl(base: Any, space: Space, ends: Sequence[Array]) -> _Form:
    """Return OMPL's form of a space. Raises CommandError: it is made of parts that do not go together there."""
    count = len(space.low)
    if not (space.cars or space.quaternions):
        form = _Form(base.RealVectorStateSpace(count), count, lambda state: state[0:count], _write_numbers)
    elif count == 3 and space.cars:
        (car,) = space.cars
        form = _Form(base.DubinsStateSpace(car.radius, car.is_symmetric), 2, _read_car, _write_car)
    elif count == 7 and space.quaternions:
        form = _Form(base.SE3StateSpace(), 3, _read_pose, _write_pose)
    else:
        raise CommandError(
            "OMPL plans here in joints and positions, or for one car, or for one pose in space"
        )
    bounds = base.RealVectorBounds(form.bounded)
    # Angles without an end go on beyond their bounds; a start may lie a little outside of its bounds.
    margin = np.where(space.endless, math.pi, 0.0)
    low = np.minimum(space.low - margin, np.min(ends, axis=0))
    high = np.maximum(space.high + margin, np.max(ends, axis=0))
    for index in range(form.bounded):
        bounds.setLow(index, float(low[index]))
        bounds.setHigh(index, float(high[index]))
    form.space.setBounds(bounds)
    return form


def _write_numbers(state: Any, values: list[float]) -> None:
    state[0 : len(values)] = values


def _read_car(state: Any) -> Sequence[float]:
    return state.getX(), state.getY(), state.getYaw()


def _write_car(state: Any, values: list[float]) -> None:
    state.setXY(*values[:2])
    state.setYaw(values[2])


def _read_pose(state: Any) -> Sequence[float]:
    turn = state.rotation()
    return state.getX(), state.getY(), state.getZ(), turn.x, turn.y, turn.z, turn.w


def _write_pose(state: Any, values: list[float]) -> None:
    state.setXYZ(*values[:3])
    turn = state.rotation()
    turn.x, turn.y, turn.z, turn.w = values[3:]


@contextmanager
def _seeded(seed: int) -> Generator[None]:
    """Search from a seed. Raises CommandError: a search of another world takes too long."""
    util: Any = importlib.import_module("ompl.util")
    if not _seeding.acquire(timeout=_LONGEST_WAIT):
        raise CommandError("another world of this process searches with OMPL; try again when it is done")
    try:
        util.setLogLevel(util.LogLevel.LOG_NONE)
        util.RNG.setSeed(seed)
        yield
    finally:
        _seeding.release()
