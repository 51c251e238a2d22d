"""Bodies that MuJoCo lets sleep: they lie still, cost nothing, and wake up when something touches them.

Only in scenes that ask for it, with ``<flag sleep="enable"/>``. MuJoCo then leaves out of its computations what sleeps
and what is static: so what is moved, or loses its ground, has to be woken, and who wants to know contacts asks here.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import mujoco
import numpy as np

if TYPE_CHECKING:
    from .simulation import Simulation

logger = logging.getLogger(__name__)

_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


def kinematics(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """MuJoCo's kinematics of everything, also of what is static: for states that nobody steps."""
    with _sleepless(model):
        mujoco.mj_kinematics(model, data)


@contextmanager
def _sleepless(model: mujoco.MjModel) -> Iterator[None]:
    flags = model.opt.enableflags
    model.opt.enableflags = flags & ~_SLEEP
    try:
        yield
    finally:
        model.opt.enableflags = flags


class Sleepers:
    """The sleeping bodies of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.are_to_wake = False
        """Something was edited: before the next physics step kinematics must be brought up to date."""

        self._copy: tuple[int, mujoco.MjData] | None = None
        """Version of the simulation, and the data made of it in which nothing sleeps."""

    def keep_possible(self) -> None:
        """Switch sleeping off in a new model that has what MuJoCo cannot wake: tendons that are held together."""
        model = self._sim.model
        if model.opt.enableflags & _SLEEP and np.any(model.eq_type == mujoco.mjtEq.mjEQ_TENDON):
            model.opt.enableflags &= ~_SLEEP
            logger.info(
                "nothing sleeps in this scene, as MuJoCo cannot wake tendons that an equality holds together"
            )

    def wake(self) -> None:
        """Everything wakes up with the next kinematics, and may fall asleep again."""
        self.are_to_wake = True

    @contextmanager
    def woken_if_due(self) -> Iterator[None]:
        """Around MuJoCo's kinematics, which wakes everything up where sleep is off."""
        if not self.are_to_wake:
            yield
            return
        self.are_to_wake = False
        with _sleepless(self._sim.model):
            yield

    def data_with_all_contacts(self) -> mujoco.MjData:
        """The simulation's data, or if something sleeps a copy in which nothing does: all contacts are there."""
        model, data = self._sim.model, self._sim.data
        if not model.opt.enableflags & _SLEEP or np.all(data.tree_asleep < 0):
            return data
        if self._copy is None or self._copy[0] != self._sim.version:
            copy = mujoco.MjData(model)
            mujoco.mj_copyData(copy, model, data)
            with _sleepless(model):
                mujoco.mj_forward(model, copy)
            self._copy = self._sim.version, copy
        return self._copy[1]
