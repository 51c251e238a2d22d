"""How MuJoCo stores the matrix of constraints: dense where loops are closed, unless the scene is large.

From 60 degrees of freedom on MuJoCo's Newton solver stores only the non-zero numbers. Where two or more constraints
couple different chains of joints, its factors of that sparse matrix are wrong in MuJoCo 4.0: the solver then does not
end in 100 iterations, and a gripper of several loops explodes. With the full matrix the same step takes one iteration.
"""

from __future__ import annotations

import mujoco
import numpy as np

MOST = 250
"""Number of degrees of freedom up to which the full matrix is affordable; at 300 a step takes ten times as long."""

_LOOPS = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def store_loops_fully(model: mujoco.MjModel) -> None:
    """Choose the full matrix for a model that closes loops, if its file leaves the choice to MuJoCo."""
    if (
        model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO
        and model.nv <= MOST
        and np.isin(model.eq_type, _LOOPS).any()
    ):
        model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)
