"""Collision-free paths in joint space: RRT-Connect, shortened and made even.

J. Kuffner and S. LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning", ICRA 2000.

**Why not OMPL.** `ompl` 2.0 has wheels for Python 3.11 to 3.13 (5 MB) and is well maintained. It was not used: its
random numbers have one seed for the process, which is set before first use, so two equal runs in one server differ;
an exception of a validity check (a script's) would cross C++; and nearly all the time goes into the check, which is
ours either way. Algorithm names are accepted and all mean this planner.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

import numpy as np

from .scratch import Array

Check = Callable[[Array], bool]

_PATIENCE = 0.005
"""Seconds of planning between two questions whether it may go on."""

_LEAST = 400
"""Checks in each part of a search, so that it adds a branch or two however short its time is."""


@dataclass(frozen=True)
class Space:
    """The space of the states."""

    low: Array
    high: Array
    """(n,) maximum of each coordinate."""
    weights: Array
    """(n,) weight of each coordinate in distances."""
    endless: Array
    """(n,) bool: coordinates that are angles, for which 2 pi equals 0."""
    resolution: float = 0.005
    """Maximum weighted distance between two states that are checked along a path: an arm of 1 m moves by 5 mm."""
    step: float = 0.3
    """Maximum weighted length of a tree's branch."""
    quaternions: tuple[slice, ...] = ()
    """Coordinates that are a rotation, of which q and -q are the same. They change linearly: the length of a change is
    about half the angle.
    """

    def difference(self, start: Array, end: Array) -> Array:
        """Return the change from start to end (..., n), angles and rotations the short way round."""
        change = end - start
        if self.endless.any():
            turned = np.remainder(change + np.pi, 2 * np.pi) - np.pi
            change = np.where(self.endless, turned, change)
        for part in self.quaternions:
            a, b = start[..., part], end[..., part]
            is_far = np.sum(a * b, axis=-1, keepdims=True) < 0.0
            change[..., part] = np.where(is_far, -b, b) - a
        return change

    def normalised(self, state: Array) -> Array:
        """Return the state (n,) with quaternions of length 1."""
        if not self.quaternions:
            return state
        state = state.copy()
        for part in self.quaternions:
            state[part] /= max(float(np.linalg.norm(state[part])), 1e-12)
        return state

    def length(self, change: Array) -> float:
        """Return the weighted length: the greatest coordinate, so that no joint moves farther between two checks."""
        return float(np.max(np.abs(change) * self.weights))

    def distances(self, states: Array, to: Array) -> Array:
        """Return the distances (m,) of states (m, n)."""
        change = self.difference(states, to) * self.weights
        return np.einsum("mi,mi->m", change, change)

    def sample(self, random: np.random.Generator) -> Array:
        state = self.low + (self.high - self.low) * random.random(len(self.low))
        for part in self.quaternions:
            state[part] = random.standard_normal(4)
        return self.normalised(state)

    def contains(self, state: Array) -> bool:
        return bool(np.all((state >= self.low - 1e-9) & (state <= self.high + 1e-9)))


class Failure(Enum):
    """The reason why no path was found."""

    START = "the start state is not valid"
    GOAL = "no goal state is valid"
    TIME = "no path was found in time"


@dataclass
class Progress:
    """The findings of a search that ended in `Failure.TIME`, for the next one."""

    trees: tuple[_Tree, _Tree] | None = None


class Planner:
    """Plans in one space.

    `is_clear` is a stricter check of all states but the given ones, so that the path keeps a distance between two
    checks. Where start or goal do not pass it, they must pass `is_valid`. `may_go_on` is called every few
    milliseconds; where it returns false, the time is over.
    """

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
        self._end = 0.0

    def plan(
        self, start: Array, goals: Sequence[Array], seconds: float, progress: Progress | None = None
    ) -> list[Array] | Failure:
        """Return states (n,) from the start to one of the goals; the straight line between two of them is valid.

        Args:
            start: (n,) first state.
            goals: each (n,).
            seconds: maximum wall time.
            progress: of an earlier search with the same start and goals, to continue it; it is updated.
        """
        self._least = self._count + _LEAST if progress is not None else 0
        progress = progress or Progress()
        self._end = time.monotonic() + seconds
        self._check = self._accepts
        space = self._space
        try:
            if not self._is_valid(start):
                return Failure.START
            good = [goal for goal in goals if self._is_valid(goal)]
            if not good:
                return Failure.GOAL
            self._choose_check(start, good)
            if progress.trees is not None:
                return self._connect(progress.trees)
            progress.trees = (_Tree([start]), _Tree(good))
            for goal in sorted(good, key=lambda each: space.length(space.difference(start, each))):
                if self._is_free(start, goal):
                    return [start, goal]
            return self._connect(progress.trees)
        except _TimeIsUpError:
            return Failure.TIME

    def shorten(self, path: list[Array], seconds: float, checks: int | None = None) -> list[Array]:
        """Leave out unnecessary states: try straight lines between random points of the path, while that helps.

        Args:
            path: states (n,).
            seconds: maximum wall time.
            checks: approximate maximum number of checks, which does not depend on the machine.
        """
        last_check = math.inf if checks is None else self._count + checks
        self._end = time.monotonic() + seconds
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
                is_better = saved > 1e-6 and self._is_free(a, b)
            except _TimeIsUpError:
                break
            if is_better:
                path = self._without_repeats([*path[: i + 1], a, b, *path[j + 1 :]])
            idle = 0 if is_better and saved > 0.01 * self._lengths(path) else idle + 1
        return path

    def _is_free(self, start: Array, end: Array) -> bool:
        """Return whether all states of the straight line are valid; its ends are not checked."""
        change = self._space.difference(start, end)
        count = int(np.ceil(self._space.length(change) / self._space.resolution))
        # The middle first, then the middles of the halves: a blocked line is mostly blocked in its middle.
        width = 1 << max(0, count - 1).bit_length()
        while width > 1:
            for at in range(width >> 1, count, width):
                if not self._is_valid(start + change * (at / count)):
                    return False
            width >>= 1
        return True

    def _choose_check(self, start: Array, goals: Sequence[Array]) -> None:
        clear = self._is_clear
        strict = clear is not None and clear(start) and all(clear(goal) for goal in goals)
        self._check = clear if strict and clear is not None else self._accepts

    def _is_valid(self, state: Array) -> bool:
        self._count += 1
        now = time.monotonic()  # one check of large meshes takes as long as thousands of simple ones
        if now > self._end and self._count > self._least:
            raise _TimeIsUpError
        if now > self._ask_next and self._may_go_on is not None:
            if not self._may_go_on():
                raise _TimeIsUpError
            self._ask_next = time.monotonic() + _PATIENCE
        return self._check(state)

    def _connect(self, trees: tuple[_Tree, _Tree]) -> list[Array]:
        grows_forward = True
        while True:
            one, other = trees if grows_forward else trees[::-1]
            added = self._extend(one, self._space.sample(self._random))
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

    def _extend(self, tree: _Tree, towards: Array) -> int | None:
        """Add one branch from the nearest state; return its index, or None if something is in the way."""
        space = self._space
        near = int(np.argmin(space.distances(tree.array(), towards)))
        change = space.difference(tree.states[near], towards)
        length = space.length(change)
        if length < 1e-12:
            return near
        state = space.normalised(tree.states[near] + change * min(1.0, space.step / length))
        if self._is_valid(state) and self._is_free(tree.states[near], state):
            return tree.add(state, near)
        return None

    def _at(self, path: list[Array], where: float) -> Array:
        index = min(int(where), len(path) - 2)
        change = self._space.difference(path[index], path[index + 1])
        return self._space.normalised(path[index] + change * (where - index))

    def _lengths(self, path: list[Array]) -> float:
        return sum(
            float(np.linalg.norm(self._space.difference(a, b) * self._space.weights))
            for a, b in pairwise(path)
        )

    def _without_repeats(self, path: list[Array]) -> list[Array]:
        kept = [path[0]]
        for state in path[1:]:
            if self._space.length(self._space.difference(kept[-1], state)) > 1e-9:
                kept.append(state)
        return kept if len(kept) > 1 else [path[0], path[-1]]


class _TimeIsUpError(Exception):
    """The time for a plan is up."""


class _Tree:
    """States, each with the index of its parent; -1 for roots."""

    def __init__(self, roots: list[Array]) -> None:
        self.states = list(roots)
        self._parents = [-1] * len(roots)
        self._array = np.array(roots)

    def add(self, state: Array, parent: int) -> int:
        self.states.append(state)
        self._parents.append(parent)
        count = len(self.states)
        if count > len(self._array):
            self._array = np.concatenate([self._array, np.zeros_like(self._array)])
        self._array[count - 1] = state
        return count - 1

    def array(self) -> Array:
        return self._array[: len(self.states)]

    def path(self, index: int) -> list[Array]:
        """Return the states from the root to this one."""
        states: list[Array] = []
        while index >= 0:
            states.append(self.states[index])
            index = self._parents[index]
        return states[::-1]


def interpolate(space: Space, path: Sequence[Array], count: int) -> list[Array]:
    """Return `count` states evenly along the path, with its ends.

    A path with at least as many states is returned unchanged.
    """
    if count <= len(path) or len(path) < 2:
        return list(path)
    pieces = [space.difference(a, b) for a, b in pairwise(path)]
    lengths = np.array([np.linalg.norm(piece * space.weights) for piece in pieces])
    # Corners stay states, else the path would cut them; the other states are distributed by length.
    shares = lengths / max(lengths.sum(), 1e-12) * (count - len(path))
    extra = np.floor(shares).astype(int)
    for index in np.argsort(extra - shares)[: count - len(path) - int(extra.sum())]:
        extra[index] += 1
    states = [path[0]]
    for begin, piece, more in zip(path, pieces, extra.tolist(), strict=False):
        states += [space.normalised(begin + piece * (step / (more + 1))) for step in range(1, more + 2)]
    return states
