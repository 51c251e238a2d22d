"""The error of one tip's pose, and the rows of the Jacobian that belong to it."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from simx_server.scene.poses.poses import (
    NO_TURN,
    Pose,
    Quaternion,
    compose,
    conjugate,
    matrix,
    multiply,
    normalised,
    rotation_vector,
    subtract,
    turn_z_to,
)

from .chain import Arm, Constraint, Joints
from .scratch import Array

_TINY = 1e-9
"""Parts of a quaternion below which a rotation about z has no sense."""

Miss = tuple[float, float]
"""Distance in metres, and angle in radians, of a tip from its goal."""


class Rows:
    """The rows of one arm: coordinates in the base's axes, then rotations about the tip's own axes."""

    def __init__(self, model: mujoco.MjModel, joints: Joints, arm: Arm) -> None:
        self.arm = arm
        self._model = model
        self._dofs = joints.dofs
        wanted = arm.element.constraints
        self._coordinates = [i for i in range(3) if wanted & (1 << i)]
        self._turns_z = bool(wanted & Constraint.ALPHA_BETA)
        self._turns_about_z = bool(wanted & Constraint.GAMMA)
        self._straight = len(self._coordinates)
        turns = 2 * self._turns_z + self._turns_about_z
        self._weights = np.repeat(arm.element.weights, (self._straight, turns))
        moved = {int(model.jnt_bodyid[model.dof_jntid[dof]]) for dof in joints.dofs}
        self._base_moves = not moved.isdisjoint(_above(model, arm.base_body))
        self._axes = np.eye(3)
        self._position, self._rotation = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def tip(self, data: mujoco.MjData) -> Pose:
        """Return the world pose of the tip."""
        return compose(pose_of_body(data, self.arm.body), self.arm.tip)

    def renew(self, data: mujoco.MjData) -> None:
        """Note where the base is: at the start, and whenever something else than the joints has moved."""
        base = compose(pose_of_body(data, self.arm.base_body), self.arm.base)
        self._axes = np.array(matrix(base[1])).T[self._coordinates]

    def of(self, goal: Pose, data: mujoco.MjData) -> tuple[Array, Array, Miss]:
        """Return weighted error (k,) and Jacobian (k, m), and how far the tip is from its goal (in the world)."""
        tip = self.tip(data)
        mujoco.mj_jac(self._model, data, self._position, self._rotation, np.array(tip[0]), self.arm.body)
        errors: list[Array] = []
        rows: list[Array] = []
        if self._coordinates:
            if self._base_moves:
                self.renew(data)
            errors.append(self._axes @ np.array(subtract(goal[0], tip[0])))
            rows.append(self._axes @ self._position[:, self._dofs])
        if self._turns_z or self._turns_about_z:
            turn, chosen = multiply(conjugate(tip[1]), goal[1]), slice(3)
            if not self._turns_about_z:
                turn, chosen = turn_z_to([row[2] for row in matrix(turn)]), slice(2)
            elif not self._turns_z:
                turn, chosen = _about_z(turn), slice(2, 3)
            errors.append(np.array(rotation_vector(turn)[chosen]))
            rows.append(np.array(matrix(tip[1])).T[chosen] @ self._rotation[:, self._dofs])
        if not rows:  # a tip without constraints goes wherever the others take it
            return np.empty(0), np.empty((0, len(self._dofs))), (0.0, 0.0)
        error = joined(errors)
        jacobian = joined(rows) * self.arm.used
        miss = _length(error[: self._straight]), _length(error[self._straight :])
        return error * self._weights, jacobian * self._weights[:, np.newaxis], miss


def joined(parts: list[Array]) -> Array:
    """Return arrays as one."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def pose_of_body(data: mujoco.MjData, body: int) -> Pose:
    """Return a body's world pose in a scratch state."""
    return tuple(data.xpos[body].tolist()), tuple(data.xquat[body].tolist())  # type: ignore[return-value]


def _above(model: mujoco.MjModel, body: int) -> set[int]:
    """Return a body and all that carry it."""
    found = {body}
    while body:
        body = int(model.body_parentid[body])
        found.add(body)
    return found


def _about_z(turn: Quaternion) -> Quaternion:
    """Return the part of a rotation that is about z, so that the rest turns z to where it shall be."""
    w, _, _, z = turn
    return normalised((w, 0.0, 0.0, z)) if abs(w) + abs(z) > _TINY else NO_TURN


def _length(vector: Array) -> float:
    return math.sqrt(vector.dot(vector))
