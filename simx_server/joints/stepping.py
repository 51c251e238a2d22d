"""One pass of physics with the joint controllers: vectorised, nothing allocated or looked up per step.

A scene whose commands are all constant over the pass is stepped in one call, which gives the interpreter lock away
only once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.servo import Rule
from simx_server.joints.state import VREP_DYNAMICS_STEP, Binding, JointState

Entry = tuple[Binding, JointState, Rule]


class Stepper:
    """The controllers of one model and its data, in arrays. Rebuilt when a setting changes other than a target."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        self._model = model
        self._data = data
        self._entries = list(entries)
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
        # Faster than one step per error would overshoot whatever V-REP's own step is.
        step = model.opt.timestep
        gains = [
            min((s.p if r == Rule.POSITION or s.p else 0.1) / VREP_DYNAMICS_STEP, 1 / step)
            for _, s, r in loops
        ]
        self._gain = np.array(gains)
        self._cyclic = np.array([i for i, (_, s, _) in enumerate(loops) if s.cyclic], dtype=np.intp)
        self._integral = np.array([s.i * step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._derivative = np.array([s.d / step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._pid = bool(np.any(self._integral) or np.any(self._derivative))
        self._sum = np.zeros(count)
        self._last = np.full(count, np.nan)
        self._error = np.zeros(count)
        self._command = np.zeros(count)
        kinematic = [(b, s) for b, s, r in entries if r == Rule.KINEMATIC]
        self._kinematic_qpos = np.array([b.qpos for b, _ in kinematic], dtype=np.intp)
        self._kinematic_dof = np.array([b.dof for b, _ in kinematic], dtype=np.intp)
        self._kinematic_value = np.array([s.held - s.offset for _, s in kinematic])
        self._has_kinematic = bool(kinematic)
        self._has_loops = count > 0
        self._force = np.zeros(data.actuator_force.shape)

    @property
    def is_constant(self) -> bool:
        """True when no controller has to run between the steps of a pass."""
        return not (self._has_loops or self._has_kinematic)

    @property
    def mean_force(self) -> np.ndarray:
        """Actuator forces (N, N m; at the actuator), mean over the last pass."""
        return self._force

    def retarget(self, handle: int, value: float) -> bool:
        """Give a running position controller a new target; False when the joint has none."""
        index = self._index.get(handle)
        if index is None:
            return False
        self._target[index] = value
        return True

    def step(self, count: int, *, average_force: bool) -> None:
        """`count` physics steps. Without `average_force` and without controllers, forces are those of the last step."""
        model, data = self._model, self._data
        if self.is_constant and not average_force:
            mujoco.mj_step(model, data, count)
            self._force[:] = data.actuator_force
            return
        step, control, hold = mujoco.mj_step, self._control, self._hold
        loops, kinematic = self._has_loops, self._has_kinematic
        total, now, accumulate = self._force, data.actuator_force, np.add
        total[:] = 0.0
        for _ in range(count):
            if loops:
                control()
            step(model, data)
            if kinematic:
                hold()
            accumulate(total, now, out=total)
        total /= count

    def adopt(self, earlier: Stepper) -> None:
        """Take over the controllers' memory (integral, last error, forces) of the stepper this one replaces."""
        for handle, index in self._index.items():
            source = earlier._index.get(handle)
            if source is not None:
                self._sum[index] = earlier._sum[source]
                self._last[index] = earlier._last[source]
        if earlier._force.shape == self._force.shape:
            self._force[:] = earlier._force

    def _control(self) -> None:
        data, error, command = self._data, self._error, self._command
        if self._joints:
            data.qpos.take(self._qpos, out=error[: self._joints], mode="clip")
        if self._joints < len(error):
            error[self._joints :] = data.ten_length[self._tendons] + self._offset
        np.subtract(self._target, error, out=error)
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
        if not self._plain_gear:
            np.multiply(command, self._gear, out=command)
        data.ctrl[self._ctrl] = command

    def _hold(self) -> None:
        self._data.qpos[self._kinematic_qpos] = self._kinematic_value
        self._data.qvel[self._kinematic_dof] = 0.0


def _goal(state: JointState, rule: Rule) -> float:
    return state.held if rule == Rule.HOLD else state.target_position
