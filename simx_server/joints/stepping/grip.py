"""Friction between two moving bodies, such as fingers and what they hold: it keeps them together while they turn.

MuJoCo's friction asks for no sliding along the contact as it lies at the start of a physics step, and damps what is
left only slowly. When both bodies turn, the free one leaves the circle along its tangent by half of the centripetal
acceleration in each step: 1 mm in a second, 0.2 m from an axis that turns by 90 degrees in it. So the friction's
reference acceleration becomes the one that ends all sliding within the physics step, as in V-REP's engines, and leaves
no way between the two points of contact, to second order of the step.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

_SLOWEST = 1e-2
"""rad/s below which a turn does not matter: 0.2 m from its axis it moves things apart by 0.1 um/s."""


class Grip:
    """The contacts between moving bodies of one model."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._is_moving = model.body_weldid > 0
        self._body_of_geom = model.geom_bodyid.copy()
        self._root = model.body_rootid.copy()
        self._dofs: dict[int, NDArray[np.intp]] = {}
        """Degrees of freedom that move a body, of the bodies that had such a contact."""
        self._is_elliptic = model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC.value

    def hold(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Write the reference accelerations of the friction; call it when MuJoCo's constraints are known."""
        if not data.ncon or not self._is_elliptic:
            return
        contact = data.contact
        bodies = self._body_of_geom[contact.geom]
        chosen = np.flatnonzero(
            self._is_moving[bodies].all(axis=1) & (contact.efc_address >= 0) & (contact.dim > 1)
        )
        if not chosen.size:
            return
        rows = contact.efc_address[chosen, None] + (1, 2)
        reference = data.efc_vel[rows] / -model.opt.timestep
        bodies = bodies[chosen]
        if np.abs(data.cvel[bodies, :3]).max() > _SLOWEST:
            across = contact.frame[chosen].reshape(-1, 3, 3)[:, 1:]
            apart = self._apart(model, data, bodies, contact.pos[chosen])
            reference -= 0.5 * np.einsum("nij,nj->ni", across, apart)
        data.efc_aref[rows] = reference

    def _apart(
        self, model: mujoco.MjModel, data: mujoco.MjData, bodies: NDArray[Any], places: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the acceleration (m/s^2) between two bodies at each contact, at constant joint velocities."""
        involved, index = np.unique(bodies, return_inverse=True)
        velocity = data.cvel[involved]
        acceleration = np.array([self._bias(model, data, body) for body in involved.tolist()])
        turning, moving = velocity[:, :3], velocity[:, 3:]
        start = acceleration[:, 3:] + np.cross(turning, moving)
        field = _crossing(acceleration[:, :3]) + turning[:, :, None] * turning[:, None, :]
        field -= np.square(turning).sum(axis=1)[:, None, None] * np.eye(3)
        index = index.reshape(bodies.shape)
        lever = places[:, None] - data.subtree_com[self._root[bodies]]
        points = start[index] + np.einsum("nkij,nkj->nki", field[index], lever)
        return points[:, 1] - points[:, 0]

    def _bias(self, model: mujoco.MjModel, data: mujoco.MjData, body: int) -> NDArray[np.float64]:
        """Return a body's spatial acceleration at constant joint velocities, MuJoCo's `cacc` without gravity."""
        if (dofs := self._dofs.get(body)) is None:
            dofs = self._dofs[body] = _dofs_of(model, body)
        return data.qvel[dofs] @ data.cdof_dot[dofs]


def _crossing(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrices that make a cross product with these vectors."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def _dofs_of(model: mujoco.MjModel, body: int) -> NDArray[np.intp]:
    found: list[int] = []
    while body > 0:
        first = int(model.body_dofadr[body])
        found += range(first, first + int(model.body_dofnum[body]))
        body = int(model.body_parentid[body])
    return np.array(found, dtype=np.intp)
