"""MuJoCo's noslip pass, left out where its equations have no solution.

The pass ends all sliding of contacts: it divides by the mobility, by how much a friction force accelerates the two
bodies along itself. Two parts of one mechanism may have none in a direction: closed fingers of a gripper cannot move
past each other across their plane. Rounding errors are left there, and the pass gives forces of 100,000 N. A step with
such a contact has friction without the pass: a little softer, and bounded.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

_IMMOBILE = 1e-6
"""Smallest mobility in the plane of a contact, as a part of the largest, that is none."""


class Noslip:
    """Suspends the noslip pass of one model for single physics steps."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.base = _bases(model)[model.geom_bodyid].astype(np.intp)
        """By geom: what its body moves with."""

        self._suspended = 0

    def suspend(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Leave the pass out of the rest of this step if it has to be; call it when the constraints are known."""
        if not data.ncon or not model.opt.noslip_iterations:
            return
        if model.opt.cone != mujoco.mjtCone.mjCONE_ELLIPTIC.value:
            return
        if self.has_immobile(model, data):
            self._suspended, model.opt.noslip_iterations = int(model.opt.noslip_iterations), 0

    def has_immobile(self, model: mujoco.MjModel, data: mujoco.MjData) -> bool:
        """Return whether a contact between parts of one mechanism cannot move along some friction."""
        contact = data.contact
        base = self.base[contact.geom]
        chosen = (base[:, 0] == base[:, 1]) & (contact.efc_address >= 0) & (contact.dim > 2)
        addresses = contact.efc_address[chosen]
        return bool(addresses.size) and _has_immobile(model, data, addresses)

    def restore(self, model: mujoco.MjModel) -> None:
        """Let the next step have the pass again."""
        if self._suspended:
            model.opt.noslip_iterations, self._suspended = self._suspended, 0


def _bases(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return what each body moves with: the root of its tree if that floats freely, else the world, 0.

    Bodies with different bases can move past each other in all directions.
    """
    floats = np.zeros(model.nbody, dtype=bool)
    floats[model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE.value]] = True
    return np.where(floats[model.body_rootid], model.body_rootid, 0)


def _has_immobile(model: mujoco.MjModel, data: mujoco.MjData, addresses: NDArray[Any]) -> bool:
    """Return whether the bodies of a contact, of those with these first rows, cannot move along some friction."""
    jacobian = _rows(model, data, (addresses[:, None] + (1, 2)).ravel())
    accelerated = np.empty_like(jacobian)
    mujoco.mj_solveM(model, data, accelerated, jacobian)
    pairs = (len(addresses), 2, model.nv)
    mobility = jacobian.reshape(pairs) @ accelerated.reshape(pairs).transpose(0, 2, 1)
    smallest, largest = np.linalg.eigvalsh(mobility).T
    return bool((smallest <= _IMMOBILE * largest).any())


def _rows(model: mujoco.MjModel, data: mujoco.MjData, rows: NDArray[Any]) -> NDArray[np.float64]:
    """Return rows of the constraints' Jacobian as a dense matrix."""
    if not mujoco.mj_isSparse(model):
        return data.efc_J.reshape(-1, model.nv)[rows]
    dense = np.zeros((len(rows), model.nv))
    for place, row in enumerate(rows.tolist()):
        first = int(data.efc_J_rowadr[row])
        entries = slice(first, first + int(data.efc_J_rownnz[row]))
        dense[place, data.efc_J_colind[entries]] = data.efc_J[entries]
    return dense
