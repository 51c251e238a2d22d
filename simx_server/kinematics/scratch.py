"""A second state on the simulation's model for trial positions; the live state does not change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

Array = NDArray[np.float64]


class Positions(Protocol):
    """Positions on a model, of which a solver moves some joints."""

    @property
    def model(self) -> mujoco.MjModel: ...

    @property
    def data(self) -> mujoco.MjData: ...


class Scratch:
    """Positions only: nothing in it moves. Created again when the simulation has another model."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._data: mujoco.MjData | None = None
        self._model: mujoco.MjModel | None = None

    @property
    def model(self) -> mujoco.MjModel:
        """Return the simulation's present model."""
        return self._sim.model

    @property
    def data(self) -> mujoco.MjData:
        """Return the scratch data of the simulation's present model."""
        if self._data is None or self._model is not self._sim.model:
            self._model = self._sim.model
            self._data = mujoco.MjData(self._sim.model)
            self.load()
        return self._data

    def load(self) -> mujoco.MjData:
        """Copy the present positions."""
        copy_positions(self._sim.data, self.data)
        return self.data


def copy_positions(source: mujoco.MjData, target: mujoco.MjData) -> None:
    """Copy everything that the kinematics depend on."""
    target.qpos[:] = source.qpos
    target.mocap_pos[:] = source.mocap_pos
    target.mocap_quat[:] = source.mocap_quat
