"""Goals of ``simOMPL``: states, an object that has to reach another one, or a function that judges states."""

from __future__ import annotations

from simx_server.errors import CommandError
from simx_server.kinematics.planning.states import DummyGoal
from simx_server.scripting.interpreter import Function

from .ompl_tasks import OmplTasks, numbers_of

_METRIC = (1.0, 1.0, 1.0, 0.1)


class OmplGoals(OmplTasks, effect="changes"):
    """Functions that set goals and tell what was reached. A goal replaces those that were set before."""

    def setGoalState(self, task: int, state: list[float]) -> bool:
        chosen = self._task(task)
        chosen.goals, chosen.region = [self._state(task, state)], None
        return True

    def addGoalState(self, task: int, state: list[float]) -> bool:
        chosen = self._task(task)
        chosen.goals.append(self._state(task, state))
        chosen.region = None
        return True

    def setGoalStates(self, task: int, states: list[list[float]]) -> bool:
        """Set several goal states; a path leads to one of them."""
        if not states:
            raise CommandError("a task needs at least one goal state")
        chosen = self._task(task)
        chosen.goals, chosen.region = [self._state(task, state) for state in states], None
        return True

    def setGoal(
        self,
        task: int,
        robot: int,
        target: int,
        tolerance: float = 0.001,
        metric: list[float] | None = None,
        reference: int = -1,
    ) -> bool:
        """Set as goal that an object of the robot is at another object, up to a distance of `tolerance`.

        `metric`: factors of the distances along x, y, z (m) of the reference (-1: the world) and of the angle (rad).
        Such goals are always searched by the server's planner, also with `--planner ompl`.
        """
        factors = _METRIC if metric is None else metric
        if len(factors) != len(_METRIC) or min(factors) < 0:
            given = list(factors) if len(factors) <= len(_METRIC) else f"{len(factors)} numbers"
            raise CommandError(f"a metric is 4 factors of at least 0: x, y, z, angle; not {given}")
        if tolerance <= 0:
            raise CommandError("a tolerance is above 0")
        moved, still = self._self(robot), self._self(target)
        for each in [moved, still, *([] if reference == -1 else [reference])]:
            self._sim.scene.get(each)
        x, y, z, angle = factors
        chosen = self._task(task)
        chosen.region = DummyGoal(moved, still, tolerance, (x, y, z, angle), reference)
        chosen.goals = []
        return True

    def setGoalCallback(self, task: int, callback: str | Function, name: str = "") -> bool:
        """Set as goal what a function(state) calls so: it returns whether a state is a goal, and its distance to one.

        Without a distance, or with a constant one, the search has no direction.
        """
        function = self._function(name if isinstance(callback, str) and name else callback)

        def judge(state: list[float]) -> tuple[bool, float]:
            answer = [*function(state), None, None]
            if answer[1] is not None and not isinstance(answer[1], (int, float)):
                raise CommandError("a goal call-back returns whether the state is a goal, and its distance")
            return bool(answer[0]), float(answer[1] or 0.0)

        chosen = self._task(task)
        chosen.region, chosen.goals = judge, []
        return True

    def setValidStateSamplerCallback(
        self, task: int, callback: str | Function, near: str | Function | None = None
    ) -> bool:
        """Set functions that return a state for the search to grow towards: callback() anywhere, near(state, distance)
        within a distance of a state, which goals other than states use. The search checks what they return.
        """
        chosen = self._task(task)
        sampler = self._function(callback)
        chosen.sampler = lambda: numbers_of(sampler(), "a state sampler")
        if near is None:
            chosen.near_sampler = None
            return True
        around = self._function(near)
        chosen.near_sampler = lambda state, distance: numbers_of(around(state, distance), "a state sampler")
        return True

    def hasSolution(self, task: int) -> bool:
        """Return whether there is a path, to a goal or near to one."""
        return bool(self._task(task).path)

    def hasExactSolution(self, task: int) -> bool:
        """Return whether there is a path to a goal."""
        chosen = self._task(task)
        return bool(chosen.path) and not chosen.is_approximate

    def hasApproximateSolution(self, task: int) -> bool:
        """Return whether the path ends near a goal only: where the time was over before an object or a function was
        satisfied. A path to goal states always ends in one of them.
        """
        chosen = self._task(task)
        return bool(chosen.path) and chosen.is_approximate

    def getGoalDistance(self, task: int) -> float:
        """Return the distance of the path's end to the goal; -1 without a path."""
        chosen = self._task(task)
        return chosen.distance if chosen.path else -1.0
