"""Tasks and state spaces that `simOMPL` keeps for a script."""

from __future__ import annotations

import math
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar, cast

from simx_server.errors import CommandError
from simx_server.kinematics.planning.graphs import Graph
from simx_server.kinematics.planning.states import StateSpace, Task
from simx_server.kinematics.planning.tasks import Solving
from simx_server.sim_api.base import ApiPart

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_Kept = TypeVar("_Kept", Task, StateSpace)


class OmplTasks(ApiPart):
    """Tasks and state spaces live as long as the script."""

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        self._tasks: dict[int, Task] = {}
        self._spaces: dict[int, StateSpace] = {}
        self._next = 1
        self._prepared: tuple[tuple[Any, ...], Solving] | None = None

    @contextmanager
    def _planning(self, task: int) -> Generator[Solving]:
        solving = self._solving(task)
        with self._at_no_cost():
            yield solving

    def _solving(self, task: int) -> Solving:
        """Return the solver of a task, cached while nothing moves: a script may check the validity of many states."""
        chosen = self._task(task)
        key = (
            *(task, id(chosen), self._sim.version, self._sim.model_version, chosen.resolution),
            *(tuple(chosen.spaces), tuple(chosen.pairs)),
        )
        if self._prepared is None or self._prepared[0] != key:
            self._prepared = key, Solving(self._world, chosen)
        return self._prepared[1]

    def _add(self, where: dict[int, Any], what: Any) -> int:
        handle, self._next = self._next, self._next + 1
        where[handle] = what
        return handle

    def _task(self, handle: int) -> Task:
        return _find(self._tasks, handle, "planning task")

    def _space(self, handle: int) -> StateSpace:
        return _find(self._spaces, handle, "state space")

    def _set_spaces(self, task: int, spaces: list[StateSpace]) -> None:
        """Give a task other spaces, which its states, goals, path and graph do not fit."""
        chosen = self._task(task)
        chosen.spaces, chosen.graph = spaces, Graph()
        chosen.start, chosen.goals, chosen.path, chosen.region = [], [], [], None

    def _rows(self, task: int, states: list[float]) -> list[list[float]]:
        """Return the states that are listed one after the other."""
        count = self._count_of(task, states)
        return [states[start : start + count] for start in range(0, len(states), count)]

    def _count_of(self, task: int, states: list[float]) -> int:
        """Return of how many numbers each of several states consists. Raises CommandError: they are none."""
        count = self._task(task).count
        if not count or len(states) % count:
            raise CommandError(
                f"states of this task have {count} numbers each; {len(states)} are no multiple"
            )
        return count

    def _state(self, task: int, state: list[float]) -> list[float]:
        count = self._task(task).count
        if len(state) != count or not count:
            raise CommandError(
                f"a state of this task is {count} numbers, not {len(state)}; set its state space first"
            )
        return state


def numbers_of(results: list[Any], what: str) -> list[float]:
    """Return the table of numbers that a call-back has given. Raises CommandError: it has given something else."""
    given: Any = results[0] if results else None
    if not isinstance(given, list):
        raise CommandError(f"{what} returns a table of numbers")
    found = cast("list[Any]", given)
    if not all(type(each) in (int, float) and math.isfinite(each) for each in found):
        raise CommandError(f"{what} returns a table of numbers")
    return [float(each) for each in found]


def _find(kept: dict[int, _Kept], handle: int, kind: str) -> _Kept:
    if handle not in kept:
        known = ", ".join(f"{each} '{one.name}'" for each, one in kept.items()) or "none"
        raise CommandError(f"no {kind} {handle}; those of this script: {known}")
    return kept[handle]
