"""Bodies that MuJoCo puts to sleep: they are at rest, cost nothing, and wake up when something touches them.

Only in scenes with ``<flag sleep="enable"/>``. MuJoCo then leaves sleeping and static bodies out of its
computations. So a body that is moved, or loses its support, has to be woken, and code that needs contacts calls
this module.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING

import mujoco
import numpy as np

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

logger = logging.getLogger(__name__)

_SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)
_LOADED = (mujoco.mjtSensor.mjSENS_FORCE.value, mujoco.mjtSensor.mjSENS_TORQUE.value)

_ASLEEP_ARRAYS = (
    "tree_asleep", "tree_awake", "body_awake", "body_awake_ind", "dof_awake_ind", "parent_awake_ind",
)  # fmt: skip
_ASLEEP_COUNTS = "ntree_awake", "nbody_awake", "nparent_awake", "nv_awake"
"""Not in MuJoCo's state: the trees that sleep, and the lists of those that do not."""

Asleep = tuple[dict[str, np.ndarray], dict[str, int], bool]
"""Arrays and counts by name, and whether everything is to wake."""


def kinematics(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute MuJoCo's kinematics of everything, also of static bodies: for states that are never stepped."""
    if not model.opt.enableflags & _SLEEP:
        mujoco.mj_kinematics(model, data)
        return
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
    """Return why bodies of a model must not sleep; empty if they may."""
    if np.any(model.eq_type == mujoco.mjtEq.mjEQ_TENDON.value):
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
        """Something was edited: the kinematics must be updated before the next physics step."""

        self.contacts_are_asked_about = False
        """A script decides about contacts: MuJoCo would not call it for sleeping bodies."""

        self.surfaces_move = False
        """Static shapes move in the physics of this simulation step, and may drag what sleeps on them."""

        self._copy: tuple[int, mujoco.MjData] | None = None
        """Version of the simulation, and a copy of its data in which nothing sleeps."""

    def note_contact_callback(self, is_there: bool) -> None:
        """Note whether a script decides about contacts."""
        self.contacts_are_asked_about = is_there

    def note_moving_surfaces(self, are_moving: bool) -> None:
        """Note whether surfaces move in this simulation step."""
        self.surfaces_move = are_moving

    def keep_possible(self, model: mujoco.MjModel) -> None:
        """Switch sleeping off in a new model in which it would change results: see `_reason_against`."""
        if model.opt.enableflags & _SLEEP and (reason := _reason_against(model)):
            model.opt.enableflags &= ~_SLEEP
            logger.info("nothing sleeps in this scene, as %s", reason)

    def remember(self) -> Asleep | None:
        """Return what sleeps and what does not, for `recall`; None: nothing may sleep in this scene."""
        if not self._sim.model.opt.enableflags & _SLEEP:
            return None
        data = self._sim.data
        arrays = {name: getattr(data, name).copy() for name in _ASLEEP_ARRAYS}
        return arrays, {name: getattr(data, name) for name in _ASLEEP_COUNTS}, self.are_to_wake

    def recall(self, memory: Asleep | None) -> None:
        """Let the same bodies sleep; the state was restored already."""
        if memory is None:
            self.are_to_wake = False
            return
        arrays, counts, self.are_to_wake = memory
        for name, values in arrays.items():
            getattr(self._sim.data, name)[:] = values
        for name, count in counts.items():
            setattr(self._sim.data, name, count)

    def wake(self) -> None:
        """Wake everything with the next kinematics; bodies may fall asleep again."""
        self.are_to_wake = True

    def wake_with(self, update: Callable[[mujoco.MjModel, mujoco.MjData], None]) -> None:
        """Wake everything that was due to wake, by MuJoCo's kinematics with sleep switched off."""
        self.are_to_wake = False
        model, data = self._sim.model, self._sim.data
        if model.opt.enableflags & _SLEEP:
            with _sleepless(model):
                update(model, data)
        else:
            update(model, data)

    @property
    def must_stay_awake(self) -> bool:
        """Return whether nothing may sleep in the physics of this simulation step: scripts are called in between, or
        surfaces move.
        """
        return (
            self.contacts_are_asked_about or self.surfaces_move or self._sim.joints.controllers.calls_scripts
        )

    def kept_awake(self) -> AbstractContextManager[None]:
        """Switch sleep off within the block."""
        return _sleepless(self._sim.model)

    def data_with_all_contacts(self) -> mujoco.MjData:
        """Return data with all contacts: the simulation's, or a copy in which nothing sleeps."""
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
