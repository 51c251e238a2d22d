"""The interface of both forms of least squares, and the choice of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simx_server.kinematics.scratch import Array

from .in_python import InPython
from .native.loading import compiled_module
from .problem import Problem


class LeastSquares(Protocol):
    """The interface of both forms. Arrays have double precision; those of joints have an entry for each column (m,)."""

    rows: int
    """k, the number of rows of the Jacobian."""

    def solve(
        self,
        values: Array,
        turns: Array,
        goals: Array,
        method: int,
        damping: float,
        stretch: float,
        iterations: int,
        most_looks: int,
        /,
    ) -> tuple[float, float, bool, bool, int]:
        """Move joints until each tip is at its goal, or the iterations end.

        Args:
            values: (m,) where the joints start, and then where they are; 0 for spherical joints.
            turns: (b, 4) the same for the b spherical joints.
            goals: (e, 7) world poses of the goals.
            method: TRANSPOSE, DAMPED or ADAPTIVE.
            damping: squared damping of DAMPED.
            stretch: factor of the longest steps.
            iterations: maximum number.
            most_looks: maximum number of states that are looked at.

        Returns:
            Distance (m) and angle (rad) of the worst tips, whether all are within their precision, whether a joint is
            at a limit, and the number of states that were looked at.
        """
        ...

    def look(self, values: Array, turns: Array, goals: Array, error: Array, jacobian: Array, /) -> None:
        """Write the weighted error (k,) and Jacobian (k, m) with the joints there."""
        ...

    def tips(self, values: Array, turns: Array, poses: Array, /) -> None:
        """Write the world poses (e, 7) of the tips with the joints there."""
        ...

    def sample(
        self,
        random: np.random.Generator,
        low: Array,
        extent: Array,
        goals: Array,
        metric: Sequence[float],
        threshold: float,
        most: int,
        values: Array,
        /,
    ) -> tuple[int, bool]:
        """Draw values (m,) from low to low + extent until all tips are near their goals; without spherical joints.

        Args:
            random: source of the numbers.
            low: (m,) least values.
            extent: (m,) ranges.
            goals: (e, 7) world poses of the goals.
            metric: weights of x, y, z and the angle of the differences.
            threshold: greatest length of the weighted differences.
            most: maximum number of samples.
            values: (m,) the last sample is written there.

        Returns:
            Number of samples, and whether the last one is near.
        """
        ...


def least_squares(problem: Problem) -> LeastSquares:
    """Return the compiled form where there is one."""
    module = compiled_module()
    return InPython(*problem) if module is None else module.LeastSquares(*problem)
