"""Inverse kinematics by damped least squares on a scratch state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import mujoco
import numpy as np

from simx_server.scene.poses.poses import Pose, Quaternion, about, multiply, normalised

from ..errors import CommandError
from .chain import Arm, Joints
from .rows import Miss, Rows, joined
from .scratch import Array, Positions

_ENOUGH = 0.01
"""Share of the precision below which the solver stops; so a target at rest leaves the joints at rest."""

_STUCK = 1e-7
"""rad or m: an iteration that moves no joint farther is the last."""

_HALVINGS = 6
"""Number of times that a step is halved if it increases the error; then the position counts as the nearest."""

_LEAST_DAMPING = 1e-3
"""Minimum of the adaptive damping.

Sugihara, "Solvability-Unconcerned Inverse Kinematics by the Levenberg-Marquardt Method", IEEE T-RO 27 (2011),
recommends about 1e-3 of the squared length of the links, which is near 1 here.
"""

_SINGULAR = 1e-6
"""Squared damping of the pseudo inverse: without it, a stretched arm would jump."""

_Z = np.array([0.0, 0.0, 1.0])


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

_ALL = MOST_ITERATIONS * _HALVINGS + 1
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
    """One set of joints and elements on one model; targets are passed with each call."""

    def __init__(self, scratch: Positions, joints: Joints, arms: Sequence[Arm]) -> None:
        self._scratch = scratch
        self._joints = joints
        self._rows = [Rows(scratch.model, joints, arm) for arm in arms]
        self._eagerness = np.sqrt(joints.weights)
        self._turns: list[Quaternion] = []
        """Present values of the spherical joints."""
        self.seconds_per_look = _SECONDS_PER_LOOK + scratch.model.nbody * _SECONDS_PER_BODY
        """Time for a look at one state on a slow machine: searches count it as their work."""

    def solve(
        self, start: Array, goals: Sequence[Pose], how: Calculation, most_looks: int = _ALL
    ) -> Solution:
        """Move the joints from `start` (n,) until each tip is at its goal (world), or the iterations end.

        Everything except these joints stays where the scratch state has it; spherical joints start there. At most
        `most_looks` states are tried.
        """
        joints = self._joints
        qpos = self._scratch.data.qpos
        self._turns = [normalised(qpos[ball.address : ball.address + 4].tolist()) for ball in joints.balls]
        values = joints.clip(np.concatenate([start, np.zeros(3 * len(joints.balls))]))
        largest = joints.max_step if how.method != Method.ADAPTIVE else joints.max_step * 4
        error, jacobian, misses = self.look(values, goals)
        left = most_looks - 1
        for _ in range(how.iterations):
            if self._are_within(misses, _ENOUGH):
                break
            change = self._limited_change(values, error, jacobian, how)
            change /= max(1.0, float(np.max(np.abs(change) / largest)))
            for _ in range(min(_HALVINGS, left)):
                left -= 1
                trial = joints.clip(values + change)
                looked = self._look(trial, goals)
                if looked[0] @ looked[0] < error @ error:
                    break
                # The step is too long: out of reach, the direction of improvement curves back.
                change *= 0.5
            else:
                break
            values, (error, jacobian, misses) = self._with_new_turns(trial), looked
            if np.max(np.abs(change)) < _STUCK:
                break
        return Solution(
            values=values[: len(joints.handles)],
            result=Result.SUCCESS if self._are_within(misses, 1.0) else Result.FAIL,
            distance=max(miss[0] for miss in misses),
            angle=max(miss[1] for miss in misses),
            is_at_limit=bool(np.any((values <= joints.low) | (values >= joints.high))),
            turns=tuple(self._turns),
            looks=most_looks - left,
        )

    def tips(self, values: Array) -> list[Pose]:
        """Return the world poses of the tips with the joints at `values` (n,)."""
        data = self._place(values)
        return [rows.tip(data) for rows in self._rows]

    def look(self, values: Array, goals: Sequence[Pose]) -> tuple[Array, Array, list[Miss]]:
        """Return the errors with the joints at `values`.

        Args:
            values: (n,), or (m,) with how far the spherical joints turn from where they are.
            goals: the poses of the targets.

        Returns:
            Weighted error (m,), weighted Jacobian (m, n), distance and angle of each element.
        """
        data = self._place(values)
        for rows in self._rows:
            rows.renew(data)
        return self._errors(data, goals)

    def _look(self, values: Array, goals: Sequence[Pose]) -> tuple[Array, Array, list[Miss]]:
        """Return the same; only these joints have moved since the last look."""
        return self._errors(self._place(values), goals)

    def _errors(self, data: mujoco.MjData, goals: Sequence[Pose]) -> tuple[Array, Array, list[Miss]]:
        found = [rows.of(goal, data) for rows, goal in zip(self._rows, goals, strict=True)]
        return (
            joined([error for error, _, _ in found]),
            joined([jacobian for _, jacobian, _ in found]),
            [miss for _, _, miss in found],
        )

    def _are_within(self, misses: Sequence[Miss], share: float) -> bool:
        """Return whether all tips are within this share of their precisions."""
        for rows, (distance, angle) in zip(self._rows, misses, strict=True):
            linear, angular = rows.arm.element.precision
            if distance > linear * share or angle > angular * share:
                return False
        return True

    def _place(self, values: Array) -> mujoco.MjData:
        """Put the joints there on the scratch state."""
        joints, qpos = self._joints, self._scratch.data.qpos
        if len(values) > len(joints.handles):
            for ball, turn in zip(joints.balls, self._turned(values), strict=True):
                qpos[ball.address : ball.address + 4] = turn
        return self._scratch.place(joints.addresses, values[: len(joints.handles)])

    def _turned(self, values: Array) -> list[Quaternion]:
        """Return the values of the spherical joints after the turns in `values` (m,)."""
        found: list[Quaternion] = []
        for number, turn in enumerate(self._turns):
            first = len(self._joints.handles) + 3 * number
            angle = float(np.linalg.norm(values[first : first + 3]))
            axis = values[first : first + 3] / angle if angle > 0 else _Z
            found.append(multiply(turn, about(axis.tolist(), angle)))
        return found

    def _with_new_turns(self, values: Array) -> Array:
        """Let further turns start where the spherical joints are now; return the values without them."""
        if self._turns:
            self._turns = [normalised(turn) for turn in self._turned(values)]
            values = values.copy()
            values[len(self._joints.handles) :] = 0.0
        return values

    def _limited_change(self, values: Array, error: Array, jacobian: Array, how: Calculation) -> Array:
        """Return the change of one step.

        A joint that would leave its interval stays, and the others are solved again.
        """
        joints = self._joints
        free = np.ones(len(values), dtype=bool)
        while True:
            eager = self._eagerness * free
            change = eager * _change(jacobian * eager, error, how)
            outside = ((values <= joints.low) & (change < 0)) | ((values >= joints.high) & (change > 0))
            outside &= free
            if not outside.any():
                return change
            free &= ~outside


def _change(jacobian: Array, error: Array, how: Calculation) -> Array:
    """Return how far the joints move: J^T (J J^T + damping^2)^-1 e, or the best step along the transpose."""
    if how.method == Method.JACOBIAN_TRANSPOSE:
        change = jacobian.T @ error
        moved = jacobian @ change
        square = float(moved @ moved)
        return change * (float(error @ moved) / square) if square > 0 else change
    if how.method == Method.ADAPTIVE:
        damping = 0.5 * float(error @ error) + _LEAST_DAMPING
    else:
        damping = _SINGULAR if how.method == Method.PSEUDO_INVERSE else max(how.damping**2, _SINGULAR)
    square = jacobian @ jacobian.T
    square.flat[:: len(error) + 1] += damping
    return jacobian.T @ np.linalg.solve(square, error)
