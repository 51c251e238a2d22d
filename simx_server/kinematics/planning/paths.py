"""Collision-free paths in joint space: RRT-Connect, shortened and made even.

J. Kuffner and S. LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning", ICRA 2000.

Algorithm names are accepted and all mean this planner, unless the server was started with ``--planner ompl``
(`ompl_planner.py`). It stays the default: nearly all the time goes into the checks, which are the same either way, and
OMPL's random numbers have one seed for all worlds of a process.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from simx_server.kinematics.scratch import Array

from .space import Line, Space

Check = Callable[[Array], bool]

_TIMEOUT = 0.005
"""Seconds of planning between two questions whether it may go on."""

_LEAST = 400
"""Checks in each part of a search, so that it adds a branch or two however short its time is."""


class Failure(Enum):
    """The reason why no path was found."""

    START = "the start state is not valid"
    GOAL = "no goal state is valid"
    TIME = "no path was found in time"


@dataclass
class Progress:
    """The findings of a search that ended in `Failure.TIME`, for the next one."""

    trees: tuple[Tree, Tree] | None = None


class Planner:
    """Plans in one space.

    `is_clear` is a stricter check of all states but the given ones, so that the path keeps a distance between two
    checks. Where start or goal do not pass it, they must pass `is_valid`. `may_go_on` is called every few
    milliseconds; where it returns false, the time is over.
    """

    sampler: Callable[[], Array] | None = None
    """Returns states (n,) to grow towards; None: an even distribution in the space."""

    def __init__(
        self,
        space: Space,
        is_valid: Check,
        random: np.random.Generator,
        may_go_on: Callable[[], bool] | None = None,
        is_clear: Check | None = None,
    ) -> None:
        self._space = space
        self._accepts = is_valid
        self._is_clear = is_clear
        self._check = is_valid
        self._random = random
        self._may_go_on = may_go_on
        self._ask_next = 0.0
        self._count = 0
        self._least = 0
        self._most = math.inf
        self._end = 0.0

    @property
    def checks(self) -> int:
        """Return how many states were checked so far."""
        return self._count

    def plan(
        self,
        start: Array,
        goals: Sequence[Array],
        seconds: float,
        progress: Progress | None = None,
        checks: int | None = None,
    ) -> list[Array] | Failure:
        """Return states (n,) from the start to one of the goals; the straight line between two of them is valid.

        Args:
            start: (n,) first state.
            goals: each (n,).
            seconds: maximum wall time.
            progress: of an earlier search with the same start and goals, to continue it; it is updated.
            checks: maximum number of checks, which does not depend on the machine.
        """
        self._limit(seconds, checks, _LEAST if progress is not None else 0)
        progress = progress or Progress()
        try:
            good = self._begin(start, goals)
            if isinstance(good, Failure):
                return good
            if progress.trees is not None:
                return self._connect(progress.trees)
            progress.trees = (Tree([start]), Tree(good, is_backward=bool(self._space.cars)))
            lines = [(self._space.line(start, goal), goal) for goal in good]
            for line, goal in sorted(lines, key=lambda each: each[0].extent):
                if self._is_free(line):
                    return [start, goal]
            return self._connect(progress.trees)
        except TimeIsUpError:
            return Failure.TIME

    def _limit(self, seconds: float, checks: float | None = None, least: int = 0) -> None:
        """Let the next checks end after this wall time, but not before `least` checks, and at most `checks`."""
        self._end = time.monotonic() + seconds
        self._most = math.inf if checks is None else self._count + checks
        self._least = self._count + least if least else 0

    def _begin(self, start: Array, goals: Sequence[Array]) -> list[Array] | Failure:
        """Choose the check for a search; return the valid goals, or the reason for the failure."""
        self._check = self._accepts
        if not self._is_valid(start):
            return Failure.START
        good = [goal for goal in goals if self._is_valid(goal)]
        if not good:
            return Failure.GOAL
        self._choose_check(start, good)
        return good

    def prune(self, path: list[Array], seconds: float, checks: int) -> list[Array]:
        """Leave out states: try straight lines from each one to the farthest ones, the last one first.

        Args:
            path: states (n,).
            seconds: maximum wall time.
            checks: approximate maximum number of checks, which does not depend on the machine.
        """
        last_check = self._count + checks
        self._limit(seconds)
        self._choose_check(path[0], path[-1:])
        kept, rest = path[:1], path[1:]
        try:
            while rest:
                reached = (
                    index
                    for index in range(len(rest) - 1, 0, -1)
                    if self._count < last_check and self._is_free(self._space.line(kept[-1], rest[index]))
                )
                nearest = next(reached, 0)
                kept.append(rest[nearest])
                rest = rest[nearest + 1 :]
        except TimeIsUpError:
            pass
        return [*kept, *rest]

    def shorten(self, path: list[Array], seconds: float, checks: int | None = None) -> list[Array]:
        """Leave out unnecessary states: try straight lines between random points of the path, while that helps.

        Args:
            path: states (n,).
            seconds: maximum wall time.
            checks: approximate maximum number of checks, which does not depend on the machine.
        """
        last_check = math.inf if checks is None else self._count + checks
        self._limit(seconds)
        self._choose_check(path[0], path[-1:])
        idle = 0
        while len(path) > 2 and idle < 30 and self._count < last_check and time.monotonic() < self._end:
            first, last = sorted(self._random.random(2) * (len(path) - 1))
            i, j = int(first), int(last)
            if i == j:
                idle += 1
                continue
            a, b = self._at(path, first), self._at(path, last)
            between = [a, *path[i + 1 : j + 1], b]
            saved = self._lengths(between) - self._lengths([a, b])
            try:
                is_better = saved > 1e-6 and self._is_free(self._space.line(a, b))
            except TimeIsUpError:
                break
            if is_better:
                path = self._without_repeats([*path[: i + 1], a, b, *path[j + 1 :]])
            idle = 0 if is_better and saved > 0.01 * self._lengths(path) else idle + 1
        return path

    def passes(self, states: Sequence[Array], seconds: float) -> bool:
        """Return whether all states are valid, and were checked within this wall time."""
        self._limit(seconds)
        self._check = self._accepts
        try:
            return all(self._is_valid(state) for state in states)
        except TimeIsUpError:
            return False

    def _is_free(self, line: Line) -> bool:
        """Return whether all states of a line are valid; its ends are not checked."""
        count = int(np.ceil(line.extent / self._space.resolution))
        # The middle first, then the middles of the halves: a blocked line is mostly blocked in its middle.
        width = 1 << max(0, count - 1).bit_length()
        while width > 1:
            for at in range(width >> 1, count, width):
                if not self._is_valid(line.at(at / count)):
                    return False
            width >>= 1
        return True

    def _choose_check(self, start: Array, goals: Sequence[Array]) -> None:
        clear = self._is_clear
        strict = clear is not None and clear(start) and all(clear(goal) for goal in goals)
        self._check = clear if strict and clear is not None else self._accepts

    def _is_valid(self, state: Array) -> bool:
        self._go_on()
        return self._check(state)

    def _go_on(self) -> None:
        """Count a check, and serve others. Raises TimeIsUpError."""
        self._count += 1
        now = time.monotonic()  # one check of large meshes takes as long as thousands of simple ones
        if self._count > self._most or (now > self._end and self._count > self._least):
            raise TimeIsUpError
        if now > self._ask_next and self._may_go_on is not None:
            if not self._may_go_on():
                raise TimeIsUpError
            self._ask_next = time.monotonic() + _TIMEOUT

    def _connect(self, trees: tuple[Tree, Tree]) -> list[Array]:
        grows_forward = True
        while True:
            one, other = trees if grows_forward else trees[::-1]
            added = self._extend(one, self._sampled())
            if added is not None:
                while True:
                    reached = self._extend(other, one.states[added])
                    if reached is None:
                        break
                    gap = self._space.difference(other.states[reached], one.states[added])
                    if self._space.length(gap) < 1e-9:
                        halves = one.path(added), other.path(reached)
                        forward, backward = halves if grows_forward else halves[::-1]
                        return [*forward, *backward[::-1][1:]]
            grows_forward = not grows_forward

    def _sampled(self) -> Array:
        return self._space.sample(self._random) if self.sampler is None else self.sampler()

    def _extend(self, tree: Tree, towards: Array) -> int | None:
        """Add one branch from the nearest state; return its index, or None if something is in the way."""
        space = self._space
        near = int(np.argmin(space.distances(tree.array(), towards, is_backward=tree.is_backward)))
        line = tree.line(space, tree.states[near], towards)
        if line.extent < 1e-12:
            return near
        share = min(1.0, space.step / line.extent)
        state = space.normalised(line.at(1.0 - share if tree.is_backward else share))
        if self._is_valid(state) and self._is_free(tree.line(space, tree.states[near], state)):
            return tree.add(state, near)
        return None

    def _at(self, path: list[Array], where: float) -> Array:
        index = min(int(where), len(path) - 2)
        return self._space.normalised(self._space.line(path[index], path[index + 1]).at(where - index))

    def _lengths(self, path: list[Array]) -> float:
        return sum(self._space.line(a, b).length for a, b in pairwise(path))

    def _without_repeats(self, path: list[Array]) -> list[Array]:
        kept = [path[0]]
        for state in path[1:]:
            if self._space.length(self._space.difference(kept[-1], state)) > 1e-9:
                kept.append(state)
        return kept if len(kept) > 1 else [path[0], path[-1]]


class TimeIsUpError(Exception):
    """The time for a plan is up."""


class Tree:
    """States, each with the index of its parent; -1 for roots."""

    def __init__(self, roots: list[Array], *, is_backward: bool = False) -> None:
        """Start with the roots; `is_backward`: ways lead from the branches to the roots, which
        makes a difference for cars.
        """
        self.states = list(roots)
        self.is_backward = is_backward
        self.parents = [-1] * len(roots)
        self._array = np.array(roots)

    def add(self, state: Array, parent: int) -> int:
        self.states.append(state)
        self.parents.append(parent)
        count = len(self.states)
        if count > len(self._array):
            self._array = np.concatenate([self._array, np.zeros_like(self._array)])
        self._array[count - 1] = state
        return count - 1

    def line(self, space: Space, state: Array, other: Array) -> Line:
        """Return the way between a state of the tree and another state, in its direction."""
        return space.line(other, state) if self.is_backward else space.line(state, other)

    def array(self) -> Array:
        return self._array[: len(self.states)]

    def path(self, index: int) -> list[Array]:
        """Return the states from the root to this one."""
        states: list[Array] = []
        while index >= 0:
            states.append(self.states[index])
            index = self.parents[index]
        return states[::-1]


def interpolate(space: Space, path: Sequence[Array], count: int) -> list[Array]:
    """Return `count` states evenly along the path, with its ends.

    A path with at least as many states is returned unchanged.
    """
    if count <= len(path) or len(path) < 2:
        return list(path)
    lines = [space.line(a, b) for a, b in pairwise(path)]
    lengths = np.array([line.length for line in lines])
    # Corners stay states, else the path would cut them; the other states are distributed by length.
    shares = lengths / max(lengths.sum(), 1e-12) * (count - len(path))
    extra = np.floor(shares).astype(int)
    for index in np.argsort(extra - shares)[: count - len(path) - int(extra.sum())]:
        extra[index] += 1
    states = [path[0]]
    for line, more in zip(lines, extra.tolist(), strict=True):
        states += [space.normalised(line.at(step / (more + 1))) for step in range(1, more + 2)]
    return states
