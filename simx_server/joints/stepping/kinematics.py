"""Everything of MuJoCo's data that follows from positions, without a step."""

from __future__ import annotations

import mujoco


def update(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute everything that follows from positions: poses, cameras and lights, flexes, tendons. No time passes."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    if model.nflex:
        mujoco.mj_flex(model, data)
    if model.ntendon:
        mujoco.mj_tendon(model, data)
