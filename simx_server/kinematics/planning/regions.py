"""Goals that are not states: a function of the state says whether it is reached, and how far away it is.

One tree grows from the start, as in S. LaValle, "Rapidly-Exploring Random Trees: A New Tool for Path Planning", 1998.
Some of its samples lie near the state that is nearest to the goal, the nearer the smaller the distance is: where the
distance tells the way, the tree follows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simx_server.kinematics.scratch import Array

from .paths import Failure, Planner, TimeIsUpError, Tree

Reached = Callable[[Array], tuple[bool, float]]
"""Return whether a state (n,) is a goal, and its distance to one."""

_NEAR = 0.5
"""Share of the samples near the best state."""


@dataclass
class Reach:
    """The result of a search."""

    path: list[Array]
    """From the start to the goal, or to the state nearest to it; empty where the start is the nearest."""
    distance: float
    """Of the last state to the goal."""
    is_exact: bool
    tree: Tree


class RegionPlanner(Planner):
    """Plans to a goal that a function knows."""

    near: Callable[[Array, float], Array] | None = None
    """Returns a state within a distance of another one; None: an even distribution."""

    def reach(self, start: Array, reached: Reached, seconds: float) -> Reach | Failure:
        """Return the path to the goal, or to the state that comes nearest within this wall time."""
        self._limit(seconds)
        self._check = self._accepts
        tree = Tree([start])
        best = 0
        try:
            if not self._is_valid(start):
                return Failure.START
            is_exact, distance = reached(start)
            self._choose_check(start, [start])
            width = self._space.step
            while not is_exact:
                self._go_on()  # samples may all lie on states that are known, which needs no check
                is_near = self._random.random() < _NEAR
                towards = self._around(tree.states[best], width) if is_near else self._sampled()
                added = self._extend(tree, towards)
                if added is None:
                    continue
                found, gap = reached(tree.states[added])
                is_better = found or gap < distance
                if is_better:
                    best, distance, is_exact = added, gap, found
                if is_near:  # as in a (1+1) evolution strategy: a fifth of the attempts should succeed
                    width = min(width * (1.5 if is_better else 0.9), self._space.step)
                    width = max(width, 1e-9)
        except TimeIsUpError:
            is_exact, distance = reached(tree.states[best])
        path = tree.path(best) if best or is_exact else []
        return Reach([path[0], path[0]] if len(path) == 1 else path, distance, is_exact, tree)

    def _around(self, state: Array, width: float) -> Array:
        if self.near is not None:
            return self._space.normalised(self.near(state, width))
        change = self._random.standard_normal(len(state)) * width / self._space.weights
        moved = state + change
        bounded = np.where(self._space.endless, moved, np.clip(moved, self._space.low, self._space.high))
        return self._space.normalised(bounded)
