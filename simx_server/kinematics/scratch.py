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


class Trials:
    """A state that several users share, one after the other: a new one takes longer than many trials."""

    def __init__(self) -> None:
        """Make none yet."""
        self._data: mujoco.MjData | None = None
        self._model: mujoco.MjModel | None = None
        self._user: object = None

    def of(self, user: object, model: mujoco.MjModel, positions: Snapshot) -> mujoco.MjData:
        """Return the state for a user.

        Args:
            user: the state is as it was left by this object, unless others have used it since.
            model: the model of the state.
            positions: those of the state for a new user, or after others have used it.
        """
        data = self._data
        if data is None or self._model is not model:
            self._model, self._user = model, None
            data = self._data = mujoco.MjData(model)
        if self._user is not user:
            self._user = user
            positions.write(data)
        return data


class Snapshot:
    """Everything that the kinematics of a state depend on, apart from the model."""

    def __init__(self, data: mujoco.MjData) -> None:
        """Copy the positions of a state."""
        self._qpos, self._mocap_pos, self._mocap_quat = (
            each.copy() for each in (data.qpos, data.mocap_pos, data.mocap_quat)
        )

    def write(self, data: mujoco.MjData) -> None:
        """Bring a state to these positions."""
        data.qpos[:] = self._qpos
        data.mocap_pos[:] = self._mocap_pos
        data.mocap_quat[:] = self._mocap_quat


def copy_positions(source: mujoco.MjData, target: mujoco.MjData) -> None:
    """Copy everything that the kinematics depend on."""
    target.qpos[:] = source.qpos
    target.mocap_pos[:] = source.mocap_pos
    target.mocap_quat[:] = source.mocap_quat
