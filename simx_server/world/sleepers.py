"""Bodies that MuJoCo lets sleep: they lie still, cost nothing, and wake up when something touches them.

Only in scenes that ask for it, with ``<flag sleep="enable"/>``. MuJoCo then leaves out of its computations what sleeps
and what is static: so what is moved, or loses its ground, has to be woken, and who wants to know contacts asks here.
"""

from __future__ import annotations

import logging
from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import mujoco
import numpy as np

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
_LOADED = (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE)


def kinematics(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """MuJoCo's kinematics of everything, also of what is static: for states that nobody steps."""
    with _sleepless(model):
        mujoco.mj_kinematics(model, data)


@contextmanager
def _sleepless(model: mujoco.MjModel) -> Generator[None]:
    flags = model.opt.enableflags
    model.opt.enableflags = flags & ~_SLEEP
    try:
        yield
    finally:
        model.opt.enableflags = flags


def _reason_against(model: mujoco.MjModel) -> str:
    """Why nothing may sleep in a model; empty if everything may."""
    if np.any(model.eq_type == mujoco.mjtEq.mjEQ_TENDON):
        return "MuJoCo cannot wake tendons that an equality holds together"
    sites = model.sensor_objid[np.isin(model.sensor_type, _LOADED)]
    if np.any(model.body_weldid[model.site_bodyid[sites]] == 0):
        return "a force sensor that does not move feels no load that sleeps"
    return ""


class Sleepers:
    """The sleeping bodies of one simulation."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self.are_to_wake = False
        """Something was edited: before the next physics step kinematics must be brought up to date."""

        self.contacts_are_asked_about = False
        """A script decides about contacts: of what sleeps it would not be asked."""

        self._copy: tuple[int, mujoco.MjData] | None = None
        """Version of the simulation, and the data made of it in which nothing sleeps."""

    def keep_possible(self, model: mujoco.MjModel) -> None:
        """Switch sleeping off in a new model in which it would be noticed: see `_reason_against`."""
        if model.opt.enableflags & _SLEEP and (reason := _reason_against(model)):
            model.opt.enableflags &= ~_SLEEP
            logger.info("nothing sleeps in this scene, as %s", reason)

    def wake(self) -> None:
        """Everything wakes up with the next kinematics, and may fall asleep again."""
        self.are_to_wake = True

    @contextmanager
    def woken_if_due(self) -> Generator[None]:
        """Around MuJoCo's kinematics, which wakes everything up where sleep is off."""
        if not self.are_to_wake:
            yield
            return
        self.are_to_wake = False
        with _sleepless(self._sim.model):
            yield

    @contextmanager
    def watched_awake(self) -> Generator[None]:
        """Around the steps of a pass: nothing sleeps in them while scripts are called in between."""
        if not (self.contacts_are_asked_about or self._sim.joints.calls_scripts):
            yield
            return
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
