"""The shortest of several paths. The effort is counted in checks, so that equal runs give equal paths on any machine.

A search looks at few states of each line, then all states of the result are checked; where one of them is not valid,
the search is made again at the task's own resolution.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from simx_server.kinematics.scratch import Array

from .paths import Failure, interpolate
from .space import Space
from .states import Task
from .tasks import Solving

if TYPE_CHECKING:
    from .planning_world import PlanningWorld

_COARSE = 0.02
"""Weighted rad or m between two checks of a search. OMPL's usual distance is three times as long for an arm."""

_STEP = 0.6
"""Weighted rad or m: maximum length of a tree's branch. Shorter ones need more checks, longer ones make detours."""

_SHORTENING = 8.0
"""Weighted rad or m of lines that are checked to shorten a path: 400 checks, which take an arm about 50 ms."""

_CHECKS = 8000
"""Maximum number of checks of one search; an arm between boxes needs about 1000."""

_ENOUGH, _ALL = 6000, 20_000
"""Number of checks after which no trial starts: with a path, and without one."""

_SECONDS = 10.0
"""Maximum seconds of one search on a machine, or in a scene, that is very slow."""

_GOOD = 1.2
"""A path is good enough when it is at most this much longer than the straight line to the nearest goal."""

_ROUNDING = 1e-6
"""Amount by which a goal may miss the bounds, as single precision does."""


def shortest_path(world: PlanningWorld, task: Task, trials: int, count: int) -> list[Array]:
    """Return the shortest path that several searches find, as at least `count` states (n,); empty without one.

    Args:
        world: the world.
        task: state spaces, pairs, start and goals.
        trials: number of searches; there are fewer when one finds a good path, or when they check too many states.
        count: number of states.

    Raises:
        CommandError: the task cannot be solved as it is, or there are too many states.
    """
    solving = Solving(world, task)
    start, goals = solving.ends()
    goals = [goal for goal in goals if _is_within(solving.space, goal)]
    if not goals:
        return []
    nearest = min(solving.space.line(start, goal).length for goal in goals)
    # A separate source: the number of checks here changes no later search.
    random = np.random.default_rng(world.ik_groups.random.integers(1 << 63))
    best: list[Array] = []
    shortest = math.inf
    spent = 0
    for _ in range(trials):
        path, checks = _search(solving, random, start, goals, count, shortest)
        spent += checks
        if isinstance(path, list):
            best, shortest = path, _length(solving.space, path)
        elif path not in (None, Failure.TIME):
            break
        if shortest <= _GOOD * nearest or spent > (_ENOUGH if best else _ALL):
            break
    return best


def _search(
    solving: Solving,
    random: np.random.Generator,
    start: Array,
    goals: list[Array],
    count: int,
    shortest: float,
) -> tuple[list[Array] | Failure | None, int]:
    """Return a path, None for one that is not shorter, or the reason why there is none; and the number of checks."""
    spent, own = 0, solving.space
    for resolution in sorted({max(_COARSE, own.resolution), own.resolution}, reverse=True):
        space = replace(own, resolution=resolution, step=max(_STEP, own.step))
        planner = solving.planner(space, random)
        found = planner.plan(start, goals, _SECONDS, checks=_CHECKS)
        if isinstance(found, Failure):
            return found, spent + planner.checks
        last_check = planner.checks + round(_SHORTENING / resolution)
        found = planner.prune(found, _SECONDS, last_check - planner.checks)
        found = planner.shorten(found, _SECONDS, last_check - planner.checks)
        if _length(space, found) >= shortest:
            return None, spent + planner.checks
        states = interpolate(space, found, count)
        is_valid = planner.passes(states, _SECONDS)
        spent += planner.checks
        if is_valid:
            return states, spent
    return Failure.TIME, spent


def _length(space: Space, path: list[Array]) -> float:
    return sum(space.line(a, b).length for a, b in pairwise(path))


def _is_within(space: Space, state: Array) -> bool:
    """Return whether a state has its coordinates within the bounds; those of angles without an end have none."""
    beyond = np.maximum(space.low - state, state - space.high)
    return bool(np.all(beyond[space.endless == 0] <= _ROUNDING))
