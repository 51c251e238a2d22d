"""Sliding bodies stay on their ground: a dragged caster or a pushed box does not hop.

MuJoCo's friction is convex. The price: where friction cannot stop the sliding, MuJoCo pushes the two bodies apart as
well, with the coefficient of friction times the acceleration that friction could not reach. A box with friction 1 that
slides at 2 m/s hops 35 mm; in V-REP's engines it stays down. So the reference acceleration of the contact is lowered by
this product within a physics step. Contacts that hold need no correction, and get none: there, friction reached what it
wanted in the last step. Those between two moving bodies are left to `joints/stepping/grip.py`.
"""

from __future__ import annotations

import mujoco
import numpy as np

SLOWEST = 1e-2
"""Sliding in m/s that is not worth a correction: it lifts nothing by more than micrometres."""

# MuJoCo's own enumerations take microseconds to compare.
_ELLIPTIC, _RK4 = int(mujoco.mjtCone.mjCONE_ELLIPTIC), int(mujoco.mjtIntegrator.mjINT_RK4)

_DAMPING = 1
"""Column of MuJoCo's `efc_KBIP`."""


def lifts_what_slides(model: mujoco.MjModel) -> bool:
    """Return whether the correction is for this model: elliptic cones, and an integrator whose step has two halves."""
    options = model.opt
    return options.cone == _ELLIPTIC and options.integrator != _RK4


def keep_down(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Correct the contacts that slide in this physics step; see `stepper.Within`."""
    if not data.ncon:
        return
    velocity = data.efc_vel
    if np.abs(velocity[data.ne + data.nf :]).max(initial=0.0) < SLOWEST:
        return
    contacts = data.contact
    still = model.body_weldid[model.geom_bodyid[contacts.geom]] == 0
    chosen = np.flatnonzero((contacts.efc_address >= 0) & (contacts.dim >= 3) & still.any(axis=1))
    rows = contacts.efc_address[chosen, None] + (1, 2)
    damping = data.efc_KBIP[rows, _DAMPING]
    wanted = data.efc_aref[rows]  # -damping times the sliding; on a belt that is not the velocity
    sliding = np.abs(wanted).max(axis=1, initial=0.0) > SLOWEST * damping[:, 0]
    if not sliding.any():
        return
    chosen, rows, damping, wanted = chosen[sliding], rows[sliding], damping[sliding], wanted[sliding]
    acceleration = np.zeros(data.nefc)
    mujoco.mj_mulJacVec(model, data, acceleration, data.qacc_warmstart)
    # At the start of the last step the sliding was smaller by its acceleration; friction wanted -damping times that.
    missed = acceleration[rows] * (1.0 - damping * model.opt.timestep) - wanted
    lift = np.linalg.norm(contacts.friction[chosen, :2] * missed, axis=1)
    data.efc_aref[contacts.efc_address[chosen]] -= lift
