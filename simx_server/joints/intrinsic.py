"""What a joint's value does to its moving frame: V-REP's intrinsic transformation."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.state import Binding
from simx_server.scene.poses import NO_TURN, Pose, Quaternion, about, normalised


def intrinsic_pose(binding: Binding, data: mujoco.MjData, position: float) -> Pose:
    """The moving frame in the fixed one: a turn about z, a shift along z, or a spherical joint's rotation."""
    if binding.kind == "ball":
        quat = normalised(data.qpos[binding.qpos : binding.qpos + 4].tolist())
        return (0.0, 0.0, 0.0), quat
    if binding.kind == "slide":
        return (0.0, 0.0, position), NO_TURN
    return (0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), position)


def quat_of_matrix(matrix: Sequence[float]) -> Quaternion:
    """Quaternion w, x, y, z of a 3 x 4 matrix given as 12 numbers, row by row; the translation is ignored."""
    rows = np.array(matrix, dtype=float).reshape(3, 4)[:, :3]
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rows.flatten())
    return normalised(quat.tolist())
