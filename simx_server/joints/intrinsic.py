"""What a joint's value does to its moving frame: V-REP's intrinsic transformation."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.state import Binding, JointState
from simx_server.scene.geometry.poses import NO_TURN, Pose, Quaternion, about, conjugate, multiply, normalised


def intrinsic_pose(binding: Binding, position: float) -> Pose:
    """The moving frame in the fixed one: a turn about z or a shift along z."""
    if binding.kind == "slide":
        return (0.0, 0.0, position), NO_TURN
    return (0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), position)


def spherical_pose(binding: Binding, state: JointState, data: mujoco.MjData) -> Pose:
    """The same of a spherical joint, whose value MuJoCo counts in its body's axes."""
    value = normalised(data.qpos[binding.qpos : binding.qpos + 4].tolist())
    align = state.alignment or NO_TURN
    return (0.0, 0.0, 0.0), multiply(multiply(conjugate(align), value), align)


def spherical_value(state: JointState, quat_wxyz: Quaternion) -> Quaternion:
    """The joint value that is this turn of the moving frame against the fixed one."""
    align = state.alignment or NO_TURN
    return multiply(multiply(align, quat_wxyz), conjugate(align))


def quat_of_matrix(matrix: Sequence[float]) -> Quaternion:
    """Quaternion w, x, y, z of a 3 x 4 matrix given as 12 numbers, row by row; the translation is ignored."""
    rows = np.array(matrix, dtype=float).reshape(3, 4)[:, :3]
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rows.flatten())
    return normalised(quat.tolist())
