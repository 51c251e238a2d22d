"""How MuJoCo stores the matrix of constraints: dense where loops are closed, while MuJoCo's sparse solver is wrong.

From 60 degrees of freedom on MuJoCo's Newton solver stores only the non-zero numbers. In MuJoCo 4.0.0 its factors of
that sparse matrix are wrong where two or more constraints couple different chains of joints (its release notes: fixed
in 4.0.1): the solver then does not end in 100 iterations, and a gripper of several loops explodes. With the full
matrix the same step takes one iteration. Contacts alone were seen to cost iterations, not accuracy.
"""

from __future__ import annotations

import mujoco
import numpy as np

FIXED = 4_000_001
"""First version of MuJoCo, as `mujoco.mj_version` counts, whose sparse solver is right."""

MOST = 250
"""Number of degrees of freedom up to which the full matrix is affordable; at 300 a step takes ten times as long."""

_LOOPS = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def store_loops_fully(model: mujoco.MjModel) -> None:
    """Choose the full matrix for a model that closes loops, if its file leaves the choice to MuJoCo."""
    if (
        mujoco.mj_version() < FIXED
        and model.opt.jacobian == mujoco.mjtJacobian.mjJAC_AUTO
        and model.nv <= MOST
        and _closes_loops(model)
    ):
        model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_DENSE)


def solver_problem(model: mujoco.MjModel) -> str:
    """Return a sentence if this MuJoCo solves the model's constraints wrongly, with what to do; else an empty text."""
    if (
        mujoco.mj_version() >= FIXED
        or model.opt.solver != mujoco.mjtSolver.mjSOL_NEWTON
        or not mujoco.mj_isSparse(model)
        or not _closes_loops(model)
    ):
        return ""
    return (
        f"MuJoCo {mujoco.mj_versionString()} may move closed loops wrongly, or let them diverge, in this scene of "
        f'{model.nv} degrees of freedom: install mujoco 4.0.1 or newer, or set jacobian="dense" in the scene\'s '
        "<option>, which is slower"
    )


def _closes_loops(model: mujoco.MjModel) -> bool:
    return bool(model.neq) and bool(np.isin(model.eq_type, _LOOPS).any())
