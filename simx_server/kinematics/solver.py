"""Inverse kinematics by damped least squares on a scratch state."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.poses.poses import Pose, Quaternion, normalised

from ..errors import CommandError
from .chain import Arm, Joints
from .least_squares.form import least_squares
from .least_squares.in_python import HALVINGS
from .least_squares.problem import problem_of
from .least_squares.steps import ADAPTIVE, DAMPED, TRANSPOSE
from .sampling import Nearness
from .scratch import Array, Positions

_SINGULAR = 1e-6
"""Squared damping of the pseudo inverse: without it, a stretched arm would jump."""

_FAR = 4.0
"""Factor of the longest steps of a search."""


class Method(IntEnum):
    """The legacy `sim_ik_*_method` numbers."""

    PSEUDO_INVERSE = 0
    DAMPED_LEAST_SQUARES = 1
    JACOBIAN_TRANSPOSE = 2
    ADAPTIVE = 100
    """Damping that depends on the error: works best from bad starts. V-REP does not have it; for searching."""


class Result(IntEnum):
    """`sim_ikresult_*`."""

    NOT_PERFORMED = 0
    SUCCESS = 1
    FAIL = 2


MOST_ITERATIONS = 1000

_SECONDS_PER_LOOK, _SECONDS_PER_BODY = 80e-6, 0.3e-6

_ALL = MOST_ITERATIONS * HALVINGS + 1
"""More states than a solution looks at."""


@dataclass(frozen=True)
class Calculation:
    """The method and its parameters by which a group is solved."""

    method: Method = Method.DAMPED_LEAST_SQUARES
    damping: float = 0.1
    iterations: int = 20

    @classmethod
    def checked(cls, method: int, damping: float, iterations: int) -> Calculation:
        """Return a calculation from a script's numbers; iterations and damping are brought into their ranges.

        Raises:
            CommandError: the method is not known.
        """
        if method not in (0, 1, 2):
            raise CommandError(f"{method} is no method; those are 0 pseudo inverse, 1 damped, 2 transpose")
        return cls(Method(method), max(damping, 0.0), min(max(iterations, 1), MOST_ITERATIONS))


@dataclass(frozen=True)
class Solution:
    """The result: joint values, and the distance of the worst element from its target."""

    values: Array
    """(n,) values of the joints with a single one."""
    result: Result
    distance: float
    """Distance in metres."""
    angle: float
    """Angle in radians."""
    is_at_limit: bool = False
    turns: tuple[Quaternion, ...] = ()
    """Value of each spherical joint, as MuJoCo counts it."""
    looks: int = 0
    """Number of states that the solver has looked at."""


class Solver:
    """One set of joints and elements on one model; targets are passed with each call.

    Everything except these joints stays where the scratch state has it when the solver is made, or renewed.
    """

    def __init__(self, scratch: Positions, joints: Joints, arms: Sequence[Arm]) -> None:
        """Prepare. Raises CommandError: a joint's value is infinite, or a spherical joint has none."""
        self._scratch, self._joints, self._arms = scratch, joints, arms
        self.renew()
        self.seconds_per_look = _SECONDS_PER_LOOK + scratch.model.nbody * _SECONDS_PER_BODY
        """Time for a look at one state on a slow machine: searches count it as their work."""

    def renew(self) -> None:
        """Take over the present scratch state."""
        model, data = self._scratch.model, self._scratch.data
        self._form = least_squares(problem_of(model, data, self._joints, self._arms))
        turns = [
            normalised(data.qpos[each.address : each.address + 4].tolist()) for each in self._joints.balls
        ]
        self._turns = np.array(turns, dtype=float).reshape(-1, 4)

    def solve(
        self, start: Array, goals: Sequence[Pose], how: Calculation, most_looks: int = _ALL
    ) -> Solution:
        """Move the joints from `start` (n,) until each tip is at its goal (world), or the iterations end.

        Spherical joints start where the scratch state has them. At most `most_looks` states are tried.
        """
        values, turns = self._filled(start), self._turns.copy()
        way, damping, stretch = _way(how)
        distance, angle, is_reached, is_at_limit, looks = self._form.solve(
            values, turns, _flat(goals), way, damping, stretch, how.iterations, most_looks
        )
        return Solution(
            values=values[: len(self._joints.handles)],
            result=Result.SUCCESS if is_reached else Result.FAIL,
            distance=distance,
            angle=angle,
            is_at_limit=is_at_limit,
            turns=tuple((w, x, y, z) for w, x, y, z in turns.tolist()),
            looks=looks,
        )

    def tips(self, values: Array) -> list[Pose]:
        """Return the world poses of the tips with the joints at `values` (n,)."""
        poses = np.empty((len(self._arms), 7))
        self._form.tips(self._filled(values), self._turns, poses)
        return [((x, y, z), (qw, qx, qy, qz)) for x, y, z, qw, qx, qy, qz in poses.tolist()]

    def look(self, values: Array, goals: Sequence[Pose]) -> tuple[Array, Array]:
        """Return the weighted error (k,) and Jacobian (k, m) with the joints at `values` (n,)."""
        error = np.empty(self._form.rows)
        jacobian = np.empty((len(error), len(self._joints.dofs)))
        self._form.look(self._filled(values), self._turns, _flat(goals), error, jacobian)
        return error, jacobian

    def sample(
        self,
        random: np.random.Generator,
        sampled: tuple[Array, Array],
        goals: Sequence[Pose],
        near: Nearness,
        most: int,
    ) -> tuple[Array, int, bool]:
        """Draw joint values until the tips are near their goals; for joints with a single value only.

        Args:
            random: source of the numbers.
            sampled: least values and ranges (n,).
            goals: world poses of the targets.
            near: how near the tips must be.
            most: maximum number of samples, at least 1.

        Returns:
            The last values (n,), the number of samples, and whether these values are near.
        """
        low, extent = (np.ascontiguousarray(each, dtype=float) for each in sampled)
        values = np.empty(len(low))
        count, is_near = self._form.sample(
            random, low, extent, _flat(goals), near.metric, near.threshold, most, values
        )
        return values, count, is_near

    def _filled(self, values: Array) -> Array:
        """Return values (m,) of all columns, without a turn of the spherical joints."""
        filled = np.zeros(len(self._joints.dofs))
        filled[: len(self._joints.handles)] = values
        return filled


def _way(how: Calculation) -> tuple[int, float, float]:
    """Return how least squares compute a step: the method, the squared damping, the factor of the longest steps."""
    if how.method == Method.JACOBIAN_TRANSPOSE:
        return TRANSPOSE, 0.0, 1.0
    if how.method == Method.ADAPTIVE:
        return ADAPTIVE, 0.0, _FAR
    return DAMPED, _SINGULAR if how.method == Method.PSEUDO_INVERSE else max(how.damping**2, _SINGULAR), 1.0


def _flat(poses: Sequence[Pose]) -> Array:
    return np.array([(*place, *turn) for place, turn in poses], dtype=float)
