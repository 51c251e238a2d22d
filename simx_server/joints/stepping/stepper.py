"""Make one simulation step with the joint controllers: vectorised, no allocations or look-ups per physics step.

A scene with constant commands over the simulation step is stepped in one call, which releases the interpreter lock
only once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from simx_server.joints.servo import Entry, Rule

from .grip import Grip
from .kinematic import Kinematic
from .motors import Motors, Step
from .noslip import Noslip
from .position_control import Control, PositionControl, PositionMemory
from .scripted import Ask, ScriptedJoints
from .stiff_springs import StiffSprings

Accompany = Callable[[int, int, bool], object]
"""Called before and after each physics step: its index in the simulation step (from 0), their number, whether it is
over.
"""

Within = Callable[[mujoco.MjModel, mujoco.MjData], object]
"""Called within each physics step, after MuJoCo's constraints are known and before it computes accelerations."""

Pieces = Callable[[mujoco.MjData, int], Iterable[range]]
"""Divides the physics steps of a simulation step, and checks the progress in between: see `watch.Watch`."""


class Memory(NamedTuple):
    """A copy of what the controllers keep from one physics step to the next."""

    of_positions: PositionMemory
    forces: np.ndarray
    sensed: np.ndarray

    @property
    def size(self) -> int:
        """Return the bytes of the arrays."""
        return self.of_positions.size + self.forces.nbytes + self.sensed.nbytes


class Stepper:
    """The controllers of one model and its data, in arrays. Rebuilt when a setting other than a target changes."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        entries: Sequence[Entry],
        pieces: Pieces,
        asked: Mapping[int, Ask] | None = None,
        accompany: Accompany | None = None,
    ) -> None:
        """Build the arrays; `asked` holds by joint handle the scripts that control a motor."""
        self._pieces = pieces
        self._accompany = accompany
        self._scripted = ScriptedJoints(model, entries, asked or {})
        self._model = model
        self._data = data
        self._position = PositionControl(model, data, entries)
        self._springs = _CyclicSprings(entries)
        self._stiff_springs = StiffSprings(model, entries)
        self._motors = Motors(model, data, entries)
        self._grip = Grip(model)
        self._noslip = Noslip(model)
        self._kinematic = Kinematic(model, data, entries)
        self._force = np.zeros(data.actuator_force.shape)
        self._has_cells = bool(np.any(model.sensor_type == mujoco.mjtSensor.mjSENS_FORCE))
        self._sensed = np.zeros(data.sensordata.shape)

        self._before, self._after = self._controllers()

    def _controllers(self) -> tuple[Sequence[Control], Sequence[Control]]:
        """Return what runs before and after each physics step, in this order."""
        data, call = self._data, self._accompany
        before: list[Control] = []
        after: list[Control] = [lambda _index, _count: self._noslip.restore(self._model)]
        if self._kinematic:
            after.append(lambda _index, _count: self._kinematic.hold(data))
        if call is not None:
            before.append(lambda index, count: call(index, count, False))
            after.append(lambda index, count: call(index, count, True))
        if self._position:
            before.append(self._position.control())
        if self._scripted:
            before.append(lambda index, count: self._scripted.control(data, index, count))
        if self._springs:
            before.append(lambda _index, _count: self._springs.control(data))
        if self._stiff_springs:
            before.append(lambda _index, _count: self._stiff_springs.control(data))
        return before, after

    @property
    def is_constant(self) -> bool:
        """Return whether nothing has to run between, or within, the physics steps of a simulation step."""
        return not (
            self._motors
            or self._position
            or self._springs
            or self._kinematic
            or self._accompany
            or self._scripted
        )

    @property
    def mean_force(self) -> np.ndarray:
        """Return the actuator forces (N, N m; at the actuator), mean over the last simulation step."""
        return self._force

    @property
    def mean_sensed(self) -> np.ndarray:
        """Return the values of all sensors, mean over the last simulation step, in a model with force sensors."""
        return self._sensed

    def retarget(self, handle: int, value: float) -> bool:
        """Give a running position controller or spring a new target; return False when the joint has none here."""
        return self._position.retarget(handle, value) or self._springs.retarget(handle, value)

    def step(self, count: int, *, average_force: bool, within: Sequence[Within] = ()) -> None:
        """Make `count` physics steps, with calls of `within` in each.

        Without `average_force` and controllers, forces are those of the last one.

        With `within` a model with integrator RK4 is stepped with Euler's method: MuJoCo's halves of a step have no RK4.

        Raises the exceptions of `pieces`.
        """
        model, data = self._model, self._data
        if self.is_constant and not average_force and not self._has_cells and not within:
            for piece in self._pieces(data, count):
                mujoco.mj_step(model, data, len(piece))
            self._force[:] = data.actuator_force
            return
        step = (
            self._motors.stepped((*within, self._grip.hold, self._noslip.suspend))
            if self._motors
            else _halved(within)
        )
        total, sensed, has_cells = self._force, self._sensed, self._has_cells
        force, sensor_values, accumulate = data.actuator_force, data.sensordata, np.add
        before, after = self._before, self._after
        total.fill(0.0)
        if has_cells:
            sensed.fill(0.0)
        for piece in self._pieces(data, count):
            for index in piece:
                for control in before:
                    control(index, count)
                step(model, data)
                accumulate(total, force, total)
                if has_cells:
                    accumulate(sensed, sensor_values, sensed)
                for follow in after:
                    follow(index, count)
        if count > 1:
            total /= count
            if has_cells:
                sensed /= count

    def adopt(self, earlier: Stepper) -> None:
        """Take over the controllers' memory (integral, last error, forces) of the stepper that this one replaces."""
        self._position.recall(earlier._position.remember())
        if earlier._force.shape == self._force.shape:
            self._force[:] = earlier._force

    def remember(self) -> Memory:
        """Return a copy of the controllers' memory."""
        return Memory(self._position.remember(), self._force.copy(), self._sensed.copy())

    def recall(self, memory: Memory) -> None:
        """Restore the memory of a stepper of the same model."""
        self._position.recall(memory.of_positions)
        self._force[:], self._sensed[:] = memory.forces, memory.sensed


def _halved(within: Sequence[Within]) -> Step:
    """Return what makes a physics step without motors."""
    if not within:
        return mujoco.mj_step

    def step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        mujoco.mj_step1(model, data)
        for call in within:
            call(model, data)
        mujoco.mj_step2(model, data)

    return step


class _CyclicSprings:
    """Springs that pull the short way round; those of other joints need no control between the physics steps."""

    def __init__(self, entries: Sequence[Entry]) -> None:
        chosen = [(b, s) for b, s, r in entries if r == Rule.SPRING and s.cyclic]
        self._index = {binding.handle: i for i, (binding, _) in enumerate(chosen)}
        self._qpos = np.array([b.qpos for b, _ in chosen], dtype=np.intp)
        self._ctrl = np.array([b.ctrl for b, _ in chosen], dtype=np.intp)
        self._gear = np.array([b.gear for b, _ in chosen])
        self._target = np.array([s.target_position for _, s in chosen])

    def __bool__(self) -> bool:
        return bool(self._index)

    def retarget(self, handle: int, value: float) -> bool:
        index = self._index.get(handle)
        if index is None:
            return False
        self._target[index] = value
        return True

    def control(self, data: mujoco.MjData) -> None:
        position = data.qpos[self._qpos]
        error = np.remainder(self._target - position + math.pi, 2 * math.pi) - math.pi
        data.ctrl[self._ctrl] = (position + error) * self._gear
