"""The effect of a joint's value on its moving frame: V-REP's intrinsic transformation."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.scene.poses.poses import NO_TURN, Pose, Quaternion, about, conjugate, multiply, normalised

from .state import Binding, JointState


def intrinsic_pose(binding: Binding, position: float) -> Pose:
    """Return the moving frame in the fixed one: a rotation about z or a shift along z."""
    if binding.kind == "slide":
        return (0.0, 0.0, position), NO_TURN
    return (0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), position)


def spherical_pose(binding: Binding, state: JointState, data: mujoco.MjData) -> Pose:
    """Return the same for a spherical joint, whose value MuJoCo counts in its body's axes."""
    value = normalised(data.qpos[binding.qpos : binding.qpos + 4].tolist())
    align = state.alignment or NO_TURN
    return (0.0, 0.0, 0.0), multiply(multiply(conjugate(align), value), align)


def spherical_value(state: JointState, quat_wxyz: Quaternion) -> Quaternion:
    """Return the joint value that gives this rotation of the moving frame relative to the fixed one."""
    align = state.alignment or NO_TURN
    return multiply(multiply(align, quat_wxyz), conjugate(align))


def quat_of_matrix(matrix: Sequence[float]) -> Quaternion:
    """Return the quaternion w, x, y, z of a 3 x 4 matrix of 12 numbers, row by row; the translation is ignored."""
    rows = np.array(matrix, dtype=float).reshape(3, 4)[:, :3]
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rows.flatten())
    return normalised(quat.tolist())
