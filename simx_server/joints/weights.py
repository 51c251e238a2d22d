"""Weights of kinematic joints: so great that nothing moves them, in the equations of motion and in every contact.

MuJoCo softens each constraint by what moves at its two ends (`invweight0`), and counts in it the masses, but not
the inertia of motors. It takes the inertia of degrees of freedom that touch no other (`dof_simplenum`) from
`dof_M0`. So writing the motor's inertia alone would make a light kinematic body push as softly as light bodies do.
"""

from __future__ import annotations

from collections.abc import Collection

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass

KINEMATIC_ARMATURE = 1e5
"""Inertia in kg m2 (kg) added to a kinematic joint. With ten times as much the solver ends too early."""


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """The numbers of one model as its file and masses give them, and those written in their place."""

    armature: np.ndarray
    bodies: np.ndarray
    """Inverse weights of the bodies."""

    dofs: np.ndarray
    """Inverse weights of the degrees of freedom."""

    inertia: np.ndarray
    """Of the degrees of freedom, with the armature of the file."""

    @classmethod
    def of(cls, model: mujoco.MjModel, armature: np.ndarray | None = None) -> Weights:
        """Return the numbers of a model.

        Args:
            model: just compiled or with new masses.
            armature: the value from the file, if the model's has changed.
        """
        of_file = model.dof_armature.copy() if armature is None else armature
        inertia = model.dof_M0 - (model.dof_armature - of_file)
        return cls(of_file, model.body_invweight0.copy(), model.dof_invweight0.copy(), inertia)

    def write(self, model: mujoco.MjModel, kinematic: Collection[int]) -> None:
        """Write the inertia of kinematic joints; `kinematic`: ids of the joints that physics does not move."""
        is_kinematic = np.zeros(model.njnt, dtype=bool)
        is_kinematic[list(kinematic)] = True
        if model.nv:
            dofs = is_kinematic[model.dof_jntid]
            model.dof_armature[:] = self.armature
            model.dof_armature[dofs] = KINEMATIC_ARMATURE
            model.dof_M0[:] = self.inertia + (model.dof_armature - self.armature)
            model.dof_invweight0[:] = self.dofs
            model.dof_invweight0[dofs] = 0.0
        model.body_invweight0[:] = self.bodies
        model.body_invweight0[_immovable_bodies(model, is_kinematic)] = 0.0


def _immovable_bodies(model: mujoco.MjModel, is_kinematic: np.ndarray) -> np.ndarray:
    """Return (nbody,) which bodies only such joints (njnt,) move, or none."""
    moves = np.zeros(model.nbody, dtype=bool)
    moves[model.jnt_bodyid[~is_kinematic]] = True
    above = model.body_parentid
    while above.any():  # each round looks twice as far up the tree
        moves |= moves[above]
        above = above[above]
    return ~moves
