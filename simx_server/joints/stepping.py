"""Make one simulation step with the joint controllers: vectorised, no allocations or look-ups per physics step.

A scene with constant commands over the simulation step is stepped in one call, which releases the interpreter lock
only once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import mujoco
import numpy as np

from simx_server.joints.dependency import Followers
from simx_server.joints.kinematic import Kinematic
from simx_server.joints.scripted import Ask, ScriptedJoints
from simx_server.joints.servo import Entry, Rule, commanded_velocity
from simx_server.joints.state import VREP_DYNAMICS_STEP, Binding, JointState

Accompany = Callable[[int, int, bool], object]
"""Called before and after each physics step: its index in the simulation step (from 0), their number, whether it is
over.
"""

Within = Callable[[mujoco.MjModel, mujoco.MjData], object]
"""Called within each physics step, after MuJoCo's constraints are known and before it computes accelerations."""

Pieces = Callable[[mujoco.MjData, int], Iterable[range]]
"""Divides the physics steps of a simulation step, and checks the progress in between: see `watch.Watch`."""


Control = Callable[[int, int], object]
"""Called at each physics step: its index in the simulation step (from 0), and their number."""


class Memory(NamedTuple):
    """A copy of what the controllers keep from one physics step to the next."""

    places: Mapping[int, int]
    """Handle of a joint to its place in `sums` and `errors`."""

    sums: np.ndarray
    errors: np.ndarray
    forces: np.ndarray
    sensed: np.ndarray

    @property
    def size(self) -> int:
        """Return the bytes of the arrays."""
        return self.sums.nbytes + self.errors.nbytes + self.forces.nbytes + self.sensed.nbytes


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
        loops = [e for e in entries if e[2] in (Rule.POSITION, Rule.HOLD)]
        # Tendons last: their positions come from another array.
        loops.sort(key=lambda e: e[0].element == "tendon")
        self._index = {binding.handle: i for i, (binding, _, _) in enumerate(loops)}
        count = len(loops)
        self._joints = sum(binding.element == "joint" for binding, _, _ in loops)
        self._qpos = np.array([b.qpos for b, _, _ in loops if b.element == "joint"], dtype=np.intp)
        self._tendons = np.array([b.id for b, _, _ in loops if b.element == "tendon"], dtype=np.intp)
        self._offset = np.array([s.offset for b, s, _ in loops if b.element == "tendon"])
        self._ctrl = np.array([b.ctrl for b, _, _ in loops], dtype=np.intp)
        self._gear = np.array([b.gear for b, _, _ in loops])
        self._plain_gear = bool(np.all(self._gear == 1.0))
        self._target = np.array([_goal(s, r) for _, s, r in loops])
        self._limit = np.array([s.upper_velocity for _, s, _ in loops])
        self._least = -self._limit
        # Correcting the error within less than one physics step would overshoot, whatever V-REP's step is.
        step = model.opt.timestep
        gains = [
            min((s.p if r == Rule.POSITION or s.p else 0.1) / VREP_DYNAMICS_STEP, 1 / step)
            for _, s, r in loops
        ]
        self._gain = np.array(gains)
        self._cyclic = np.array([i for i, (_, s, _) in enumerate(loops) if s.cyclic], dtype=np.intp)
        rigid = [(i, b) for i, (b, s, _) in enumerate(loops) if _carries(b, s)]
        self._rigid = np.array([i for i, _ in rigid], dtype=np.intp)
        self._rigid_dof = np.array([b.dof for _, b in rigid], dtype=np.intp)
        self._rigid_share = np.array([1 / b.kv for _, b in rigid])
        self._load = _view(data.qfrc_bias, self._rigid_dof)
        self._carried = np.zeros(len(rigid))
        self._integral = np.array([s.i * step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._derivative = np.array([s.d / step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._pid = bool(np.any(self._integral) or np.any(self._derivative))
        self._sum = np.zeros(count)
        self._last = np.full(count, np.nan)
        self._error = np.zeros(count)
        self._positions = None if self._tendons.size else _view(data.qpos, self._qpos)
        """View of the joint positions, if they are adjacent in MuJoCo's array."""

        commands = _view(data.ctrl, self._ctrl)
        self._are_scattered = commands is None
        self._command = np.zeros(count) if commands is None else commands
        self._rigid_command = _view(self._command, self._rigid)
        self._led = Followers(model, entries, Rule.POSITION)
        self._led_index = np.array([self._index[handle] for handle in self._led.handles], dtype=np.intp)
        self._springs = _CyclicSprings(entries)
        self._carrying = _Carrying(entries)
        self._kinematic = Kinematic(model, data, entries)
        self._force = np.zeros(data.actuator_force.shape)
        self._has_cells = bool(np.any(model.sensor_type == mujoco.mjtSensor.mjSENS_FORCE))
        self._sensed = np.zeros(data.sensordata.shape)

        self._before, self._after = self._controllers()

    def _controllers(self) -> tuple[Sequence[Control], Sequence[Control]]:
        """Return what runs before and after each physics step, in this order."""
        data, call = self._data, self._accompany
        before: list[Control] = []
        after: list[Control] = []
        if self._kinematic:
            after.append(lambda _index, _count: self._kinematic.hold(data))
        if call is not None:
            before.append(lambda index, count: call(index, count, False))
            after.append(lambda index, count: call(index, count, True))
        if self._index:
            before.append(self._control)
        if self._carrying:
            before.append(lambda _index, _count: self._carrying.control(data))
        if self._scripted:
            before.append(lambda index, count: self._scripted.control(data, index, count))
        if self._springs:
            before.append(lambda _index, _count: self._springs.control(data))
        return before, after

    @property
    def is_constant(self) -> bool:
        """Return whether no controller has to run between the physics steps of a simulation step."""
        return not (self._index or self._springs or self._carrying or self._kinematic or self._accompany)

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
        index = self._index.get(handle)
        if index is None:
            return self._springs.retarget(handle, value)
        self._target[index] = value
        return True

    def step(self, count: int, *, average_force: bool, within: Within | None = None) -> None:
        """Make `count` physics steps. Without `average_force` and controllers, forces are those of the last one.

        With `within` a model with integrator RK4 is stepped with Euler's method: MuJoCo's halves of a step have no RK4.

        Raises the exceptions of `pieces`.
        """
        model, data = self._model, self._data
        if self.is_constant and not average_force and not self._has_cells and within is None:
            for piece in self._pieces(data, count):
                mujoco.mj_step(model, data, len(piece))
            self._force[:] = data.actuator_force
            return
        step = mujoco.mj_step if within is None else _halved(within)
        total, sensed, has_cells = self._force, self._sensed, self._has_cells
        force, sensor_values, accumulate = data.actuator_force, data.sensordata, np.add
        before, after = self._before, self._after
        total.fill(0.0)
        if has_cells:
            sensed.fill(0.0)
        for index in chain.from_iterable(self._pieces(data, count)):
            for control in before:
                control(index, count)
            step(model, data)
            accumulate(total, force, out=total)
            if has_cells:
                accumulate(sensed, sensor_values, out=sensed)
            for follow in after:
                follow(index, count)
        if count > 1:
            total /= count
            if has_cells:
                sensed /= count

    def adopt(self, earlier: Stepper) -> None:
        """Take over the controllers' memory (integral, last error, forces) of the stepper that this one replaces."""
        self._take_over(earlier._index, earlier._sum, earlier._last)
        if earlier._force.shape == self._force.shape:
            self._force[:] = earlier._force

    def remember(self) -> Memory:
        """Return a copy of the controllers' memory."""
        return Memory(
            self._index, self._sum.copy(), self._last.copy(), self._force.copy(), self._sensed.copy()
        )

    def recall(self, memory: Memory) -> None:
        """Restore the memory of a stepper of the same model."""
        self._take_over(memory.places, memory.sums, memory.errors)
        self._force[:], self._sensed[:] = memory.forces, memory.sensed

    def _take_over(self, places: Mapping[int, int], sums: np.ndarray, errors: np.ndarray) -> None:
        for handle, index in self._index.items():
            source = places.get(handle)
            if source is not None:
                self._sum[index] = sums[source]
                self._last[index] = errors[source]

    def _control(self, _index: int, _count: int) -> None:
        data, error, command = self._data, self._error, self._command
        if self._led_index.size:
            self._target[self._led_index] = self._led.wanted(data)
        positions = self._positions
        if positions is None:
            positions = error
            data.qpos.take(self._qpos, out=error[: self._joints], mode="clip")
            error[self._joints :] = data.ten_length[self._tendons] + self._offset
        np.subtract(self._target, positions, out=error)
        if self._cyclic.size:
            error[self._cyclic] = np.remainder(error[self._cyclic] + math.pi, 2 * math.pi) - math.pi
        np.multiply(error, self._gain, out=command)
        if self._pid:
            self._sum += error * self._integral
            change = np.where(np.isnan(self._last), 0.0, error - self._last)
            command += self._sum + change * self._derivative
            self._last[:] = error
        np.minimum(command, self._limit, out=command)
        np.maximum(command, self._least, out=command)
        if self._rigid.size:
            self._carry(command)
        if not self._plain_gear:
            np.multiply(command, self._gear, out=command)
        if self._are_scattered:
            data.ctrl[self._ctrl] = command

    def _carry(self, command: np.ndarray) -> None:
        """Add to the commands of rigid motors what carries their load."""
        if self._load is None or self._rigid_command is None:
            command[self._rigid] += self._data.qfrc_bias[self._rigid_dof] * self._rigid_share
            return
        np.multiply(self._load, self._rigid_share, out=self._carried)
        np.add(self._rigid_command, self._carried, out=self._rigid_command)


def _halved(within: Within) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
    def step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        mujoco.mj_step1(model, data)
        within(model, data)
        mujoco.mj_step2(model, data)

    return step


def _view(values: np.ndarray, indices: np.ndarray) -> np.ndarray | None:
    """Return a view of these items; None if they are not adjacent in this order."""
    if not indices.size or np.any(np.diff(indices) != 1):
        return None
    return values[indices[0] : indices[-1] + 1]


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


class _Carrying:
    """Rigid motors under velocity control: they carry their load beside keeping their velocity.

    Under a load, a velocity servo alone moves; V-REP's motors do not.
    """

    def __init__(self, entries: Sequence[Entry]) -> None:
        chosen = [(b, s) for b, s, r in entries if r == Rule.VELOCITY and _carries(b, s)]
        self._dof = np.array([b.dof for b, _ in chosen], dtype=np.intp)
        self._ctrl = np.array([b.ctrl for b, _ in chosen], dtype=np.intp)
        self._target = np.array([commanded_velocity(b, s) * b.gear for b, s in chosen])
        self._share = np.array([b.gear / b.kv for b, _ in chosen])

    def __bool__(self) -> bool:
        return bool(self._dof.size)

    def control(self, data: mujoco.MjData) -> None:
        data.ctrl[self._ctrl] = self._target + data.qfrc_bias[self._dof] * self._share


def _carries(binding: Binding, state: JointState) -> bool:
    return state.rigid and binding.dof >= 0 and binding.kv > 0


def _goal(state: JointState, rule: Rule) -> float:
    return state.held if rule == Rule.HOLD else state.target_position
