"""Foresee how long MuJoCo's solver takes, from the constraints of a physics step, during which no client is served.

MuJoCo's first half of a step finds the constraints, its second half solves them. Newton's method needs a few
iterations, and in each of them factors a matrix: hundreds of bodies that all touch each other make that take seconds.
Conjugate gradients need more iterations of little work. So a step with too much work for Newton is solved by
conjugate gradients, and one with too much work for these as well is not started.

The work is counted, not timed: equal states lead to the same decision on every machine.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from .watch import TooSlow

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

MOST_WORK = 5e8
"""Multiplications of one factorization up to which Newton's method is used. It makes about ten of them in a step, and
the machine of `docs/operators/reliability.md` 1e9 to 2e9 multiplications in a second.
"""

FEWEST_DOFS = 1145
"""Degrees of freedom below which every factorization has less work: a third of their cube."""

ITERATIONS = 100
"""Iterations of conjugate gradients in place of Newton's method, MuJoCo's default."""

PER_SECOND = 4e8
"""Numbers of the constraints' Jacobian that conjugate gradients handle in a second."""

_NEWTON, _CG = mujoco.mjtSolver.mjSOL_NEWTON, mujoco.mjtSolver.mjSOL_CG


class Foresight:
    """Chooses the solver of single physics steps."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._own: tuple[mujoco.MjModel, int, int] | None = None
        """A model, its solver and iterations, while others are used."""

        self._was_told = False

    @staticmethod
    def is_needed(model: mujoco.MjModel) -> bool:
        """Return whether steps of this model may have too much work."""
        return model.nv >= FEWEST_DOFS and model.opt.solver in (_NEWTON, _CG)

    def begin_run(self) -> None:
        """Tell again, in the log, when another solver is used."""
        self._was_told = False

    def look(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Choose the solver of this step; call it when its constraints are known.

        Raises:
            TooSlow: no solver is quick enough.
        """
        self.restore()
        option = model.opt
        if option.solver == _NEWTON:
            if not has_much_work(model, data):
                return
            self._own = model, int(option.solver), int(option.iterations)
            option.solver, option.iterations = int(_CG), min(int(option.iterations), ITERATIONS)
            self._tell(data)
        seconds = len(data.efc_J) * option.iterations / PER_SECOND
        if seconds > self._sim.limits.step_seconds:
            reached = self._sim.limits.reached("step_seconds", "have fewer contacts or objects")
            raise TooSlow(
                f"a physics step with {data.nefc} constraints would take about {seconds:.0f} s of processor time; "
                f"nobody can be served within one; {reached}"
            )

    def forward(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Compute what follows from a state, as `mj_forward`; without forces where these would take too long."""
        if not self.is_needed(model):
            mujoco.mj_forward(model, data)
            return
        mujoco.mj_fwdPosition(model, data)
        try:
            self.look(model, data)
            mujoco.mj_forward(model, data)
        except TooSlow as problem:
            mujoco.mj_fwdVelocity(model, data)
            logger.warning("the forces in this state are not known: %s", problem)
        finally:
            self.restore()

    def restore(self) -> None:
        """Let the model have its own solver again."""
        if self._own is not None:
            model, model.opt.solver, model.opt.iterations = self._own
            self._own = None

    def _tell(self, data: mujoco.MjData) -> None:
        if not self._was_told:
            self._was_told = True
            logger.warning(
                "with %d contacts Newton's method would take seconds for a physics step; conjugate "
                "gradients solve such steps, less exactly",
                data.ncon,
            )


def has_much_work(model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    """Return whether the factorization of Newton's method has more work than `MOST_WORK`."""
    if not data.nefc:
        return False
    sizes = data.island_nv[: data.nisland].astype(float) if data.nisland else np.array([float(model.nv)])
    return float((sizes**3).sum()) / 3 > MOST_WORK and factor_work(model, data) > MOST_WORK


def factor_work(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Return the multiplications of one factorization of the matrix that Newton's method has.

    MuJoCo factors from the last row to the first. The trees of bodies before a tree that it touches are the pattern of
    its row; eliminating the tree passes its pattern on to the last of them.
    """
    patterns = [0] * model.ntree
    """By tree: bits of the trees before it."""
    for high, low in _touching(model, data):
        patterns[high] |= 1 << low
    dofs: list[int] = model.tree_dofnum.tolist()
    mean = model.nv / model.ntree
    work = 0.0
    for tree in range(model.ntree - 1, -1, -1):
        pattern = patterns[tree]
        row = pattern.bit_count() * mean + dofs[tree]
        work += dofs[tree] * row * row
        if pattern:
            last = pattern.bit_length() - 1
            patterns[last] |= pattern ^ (1 << last)
    return work


def _touching(model: mujoco.MjModel, data: mujoco.MjData) -> list[tuple[int, int]]:
    """Return the pairs of trees that have a constraint together, the later one first."""
    if not mujoco.mj_isSparse(model):
        return [(high, low) for high in range(model.ntree) for low in range(high)]
    first = data.efc_J_rowadr
    last = first + data.efc_J_rownnz - 1
    trees = model.dof_treeid[data.efc_J_colind[np.stack((first, last))[:, data.efc_J_rownnz > 0]]]
    low, high = np.sort(trees, axis=0).astype(np.int64)
    keys = np.unique((high * model.ntree + low)[high != low])
    return list(zip(*(each.tolist() for each in np.divmod(keys, model.ntree)), strict=True))
