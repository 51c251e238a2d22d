"""Inverse kinematics by damped least squares on a scratch state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import mujoco
import numpy as np

from simx_server.scene.poses.poses import (
    NO_TURN,
    Pose,
    Quaternion,
    about,
    compose,
    conjugate,
    matrix,
    multiply,
    normalised,
    rotation_vector,
    subtract,
    turn_z_to,
)

from ..errors import CommandError
from .chain import Arm, Constraint, Joints
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


_TINY = 1e-9
"""Parts of a quaternion below which a rotation about z has no sense."""


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


class Solver:
    """One set of joints and elements on one model; targets are passed with each call."""

    def __init__(self, scratch: Positions, joints: Joints, arms: Sequence[Arm]) -> None:
        self._scratch = scratch
        self._model = model = scratch.model
        self._joints = joints
        self._arms = list(arms)
        self._turns: list[Quaternion] = []
        """Present values of the spherical joints."""
        self._position, self._rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def solve(self, start: Array, goals: Sequence[Pose], how: Calculation) -> Solution:
        """Move the joints from `start` (n,) until each tip is at its goal (world), or the iterations end.

        Everything except these joints stays where the scratch state has it; spherical joints start there.
        """
        joints = self._joints
        qpos = self._scratch.data.qpos
        self._turns = [normalised(qpos[ball.address : ball.address + 4].tolist()) for ball in joints.balls]
        values = joints.clip(np.concatenate([start, np.zeros(3 * len(joints.balls))]))
        largest = joints.max_step if how.method != Method.ADAPTIVE else joints.max_step * 4
        error, jacobian, misses = self.look(values, goals)
        for _ in range(how.iterations):
            if all(_within(arm, miss, _ENOUGH) for arm, miss in zip(self._arms, misses, strict=True)):
                break
            change = self._limited_change(values, error, jacobian, how)
            change /= max(1.0, float(np.max(np.abs(change) / largest)))
            for _ in range(_HALVINGS):
                trial = joints.clip(values + change)
                looked = self.look(trial, goals)
                if looked[0] @ looked[0] < error @ error:
                    break
                # The step is too long: out of reach, the direction of improvement curves back.
                change *= 0.5
            else:
                break
            values, (error, jacobian, misses) = self._with_new_turns(trial), looked
            if np.max(np.abs(change)) < _STUCK:
                break
        reached = all(_within(arm, miss, 1.0) for arm, miss in zip(self._arms, misses, strict=True))
        return Solution(
            values=values[: len(joints.handles)],
            result=Result.SUCCESS if reached else Result.FAIL,
            distance=max(miss[0] for miss in misses),
            angle=max(miss[1] for miss in misses),
            is_at_limit=bool(np.any((values <= joints.low) | (values >= joints.high))),
            turns=tuple(self._turns),
        )

    def tips(self, values: Array) -> list[Pose]:
        """Return the world poses of the tips with the joints at `values` (n,)."""
        data = self._place(values)
        return [compose(pose_of_body(data, arm.body), arm.tip) for arm in self._arms]

    def look(self, values: Array, goals: Sequence[Pose]) -> tuple[Array, Array, list[tuple[float, float]]]:
        """Return the errors with the joints at `values`.

        Args:
            values: (n,), or (m,) with how far the spherical joints turn from where they are.
            goals: the poses of the targets.

        Returns:
            Weighted error (m,), weighted Jacobian (m, n), distance and angle of each element.
        """
        data = self._place(values)
        errors: list[Array] = []
        rows: list[Array] = []
        misses: list[tuple[float, float]] = []
        for arm, goal in zip(self._arms, goals, strict=True):
            error, jacobian = self._of(arm, goal, data)
            errors.append(error)
            rows.append(jacobian)
            straight = _count(arm.element.constraints & Constraint.POSITION)
            misses.append((float(np.linalg.norm(error[:straight])), float(np.linalg.norm(error[straight:]))))
            weights = np.repeat(arm.element.weights, (straight, len(error) - straight))
            errors[-1], rows[-1] = error * weights, jacobian * weights[:, None]
        return np.concatenate(errors), np.concatenate(rows), misses

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

    def _of(self, arm: Arm, goal: Pose, data: mujoco.MjData) -> tuple[Array, Array]:
        """Return the rows of one element: coordinates in the base's axes, then rotations about the tip's own axes."""
        wanted = arm.element.constraints
        tip = compose(pose_of_body(data, arm.body), arm.tip)
        mujoco.mj_jac(self._model, data, self._position, self._rotation, np.array(tip[0]), arm.body)
        errors: list[Array] = [np.empty(0)]  # a tip without constraints goes wherever the others take it
        rows: list[Array] = [np.empty((0, len(self._joints.dofs)))]
        if wanted & Constraint.POSITION:
            chosen = [i for i in range(3) if wanted & (1 << i)]
            axes = np.array(matrix(compose(pose_of_body(data, arm.base_body), arm.base)[1])).T[chosen]
            errors.append(axes @ np.array(subtract(goal[0], tip[0])))
            rows.append(axes @ self._position[:, self._joints.dofs])
        if wanted & Constraint.ORIENTATION:
            turn = multiply(conjugate(tip[1]), goal[1])
            chosen = slice(3)
            if not wanted & Constraint.GAMMA:
                turn, chosen = turn_z_to([row[2] for row in matrix(turn)]), slice(2)
            elif not wanted & Constraint.ALPHA_BETA:
                turn, chosen = _about_z(turn), slice(2, 3)
            errors.append(np.array(rotation_vector(turn)[chosen]))
            rows.append(np.array(matrix(tip[1])).T[chosen] @ self._rotation[:, self._joints.dofs])
        return np.concatenate(errors), np.concatenate(rows) * arm.used

    def _limited_change(self, values: Array, error: Array, jacobian: Array, how: Calculation) -> Array:
        """Return the change of one step.

        A joint that would leave its interval stays, and the others are solved again.
        """
        joints = self._joints
        free = np.ones(len(values), dtype=bool)
        while True:
            eager = np.sqrt(joints.weights) * free
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


def _about_z(turn: Quaternion) -> Quaternion:
    """Return the part of a rotation that is about z, so that the rest turns z to where it shall be."""
    w, _, _, z = turn
    return normalised((w, 0.0, 0.0, z)) if abs(w) + abs(z) > _TINY else NO_TURN


def _within(arm: Arm, miss: tuple[float, float], share: float) -> bool:
    linear, angular = arm.element.precision
    return miss[0] <= linear * share and miss[1] <= angular * share


def _count(flags: Constraint) -> int:
    return int(flags).bit_count()


def pose_of_body(data: mujoco.MjData, body: int) -> Pose:
    """Return a body's world pose in a scratch state."""
    return tuple(data.xpos[body].tolist()), tuple(data.xquat[body].tolist())  # type: ignore[return-value]
