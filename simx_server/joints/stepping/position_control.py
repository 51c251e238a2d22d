"""V-REP's position controllers of one model, in arrays: they command the motors before each physics step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.joints.dependency import Followers
from simx_server.joints.servo import MOST_VELOCITY, Entry, Rule
from simx_server.joints.state import VREP_DYNAMICS_STEP, JointState

from .indices import Columns, as_slice

Control = Callable[[int, int], object]
"""Called at each physics step: its index in the simulation step (from 0), and their number."""


class PositionMemory(NamedTuple):
    """The values that position controllers keep from one physics step to the next."""

    places: Mapping[int, int]
    """Handle of a joint to its place in the arrays."""

    sums: np.ndarray
    """Integrals."""

    errors: np.ndarray
    """Last errors."""

    @property
    def size(self) -> int:
        """Return the bytes of the arrays."""
        return self.sums.nbytes + self.errors.nbytes


class PositionControl:
    """The position controllers and those that hold a joint where it stopped. No allocations for plain ones."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        loops = [e for e in entries if e[2] in (Rule.POSITION, Rule.HOLD)]
        # Tendons last: their positions come from another array.
        loops.sort(key=lambda e: e[0].element == "tendon")
        self._data = data
        self._index = {binding.handle: i for i, (binding, _, _) in enumerate(loops)}
        self._target = np.array([_goal(s, r) for _, s, r in loops])
        step = model.opt.timestep
        self._gain = np.array(
            [position_gain(s.p if r == Rule.POSITION or s.p else 0.1, step) for _, s, r in loops]
        )
        self._limit = np.array([min(s.upper_velocity, MOST_VELOCITY) for _, s, _ in loops])
        self._integral = np.array([s.i * step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._derivative = np.array([s.d / step / VREP_DYNAMICS_STEP for _, s, _ in loops])
        self._sum = np.zeros(len(loops))
        self._last = np.full(len(loops), np.nan)
        self._error = np.zeros(len(loops))
        self._ctrl = ctrl = np.array([b.ctrl for b, _, _ in loops], dtype=np.intp)
        self._gear = np.array([b.gear for b, _, _ in loops])
        self._cyclic = np.array([s.cyclic for _, s, _ in loops], dtype=np.intp)
        self._of_joints = np.array([b.qpos for b, _, _ in loops if b.element == "joint"], dtype=np.intp)
        self._of_tendons = np.array([b.id for b, _, _ in loops if b.element == "tendon"], dtype=np.intp)
        self._offset = np.array([s.offset for b, s, _ in loops if b.element == "tendon"])
        self._led = Followers(model, entries, Rule.POSITION)
        self._led_places = np.array([self._index[handle] for handle in self._led.handles], dtype=np.intp)
        commands = _view(data.ctrl, ctrl)
        self._command = np.zeros(len(loops)) if commands is None else commands
        self._positions, self._gather = self._measuring()
        self._before_gain, self._after_gain, self._after_limit = (
            self._before_gains(),
            self._pid() if np.any(self._integral) or np.any(self._derivative) else None,
            self._after_limits(None if commands is not None else ctrl),
        )

    def __bool__(self) -> bool:
        return bool(self._index)

    def retarget(self, handle: int, value: float) -> bool:
        """Set the target of a joint; return False if it has no controller here."""
        index = self._index.get(handle)
        if index is None:
            return False
        self._target[index] = value
        return True

    def target_address(self, handle: int) -> tuple[memoryview[float], int] | None:
        """Return where the target of a joint is: array and index; None if it has no controller here."""
        index = self._index.get(handle)
        return None if index is None else (self._target.data.cast("B").cast("d"), index)

    def place_of(self, handle: int) -> int | None:
        """Return the place of a joint among the targets; None: it has no controller here."""
        return self._index.get(handle)

    def target_of(self, handle: int) -> float:
        """Return the target of a joint, rad or m."""
        return float(self._target[self._index[handle]])

    def remember(self) -> PositionMemory:
        """Return a copy of the controllers' memory."""
        return PositionMemory(self._index, self._sum.copy(), self._last.copy())

    def recall(self, memory: PositionMemory) -> None:
        """Take over the memory of earlier controllers, for the joints that have one in both."""
        for handle, index in self._index.items():
            source = memory.places.get(handle)
            if source is not None:
                self._sum[index] = memory.sums[source]
                self._last[index] = memory.errors[source]

    @property
    def columns(self) -> Columns:
        """Return the arrays by name, for the compiled form."""
        own = {
            "target": self._target,
            "gain": self._gain,
            "limit": self._limit,
            "integral": self._integral,
            "derivative": self._derivative,
            "sum": self._sum,
            "last": self._last,
            "ctrl": self._ctrl,
            "gear": self._gear,
            "cyclic": self._cyclic,
            "qpos": self._of_joints,
            "tendon": self._of_tendons,
            "offset": self._offset,
        }
        led = self._led.columns
        return {
            **{f"position.{name}": values for name, values in own.items()},
            "led.place": self._led_places,
            **{f"led.{name}": led[name] for name in ("factor", "shift", "low", "high")},
            "led.qpos": led["lead_qpos"],
        }

    def control(self) -> Control:
        """Return the function that commands all motors: without a condition or a look-up for what no joint has."""
        target, error, command, positions = self._target, self._error, self._command, self._positions
        gain, limit, least = self._gain, self._limit, -self._limit
        gather, prepare, add_terms, complete = (
            self._gather,
            self._before_gain,
            self._after_gain,
            self._after_limit,
        )
        subtract, multiply, minimum, maximum = np.subtract, np.multiply, np.minimum, np.maximum

        def run(_index: int, _count: int) -> None:
            if gather is not None:
                gather()
            if prepare is None:
                subtract(target, positions, error)
            else:
                prepare()
            multiply(error, gain, command)
            if add_terms is not None:
                add_terms()
            minimum(command, limit, out=command)
            maximum(command, least, out=command)
            if complete is not None:
                complete()

        return run

    def _measuring(self) -> tuple[np.ndarray, Callable[[], None] | None]:
        """Return the positions, and what brings them up to date; None if they are a view of MuJoCo's array."""
        data, qpos, tendons, offset = self._data, self._of_joints, self._of_tendons, self._offset
        adjacent = None if tendons.size else _view(data.qpos, qpos)
        if adjacent is not None:
            return adjacent, None
        positions = np.zeros(len(self._index))
        of_joints, of_tendons = positions[: len(qpos)], positions[len(qpos) :]

        def gather() -> None:
            data.qpos.take(qpos, out=of_joints, mode="clip")
            if tendons.size:
                np.add(data.ten_length[tendons], offset, of_tendons)

        return positions, gather

    def _before_gains(self) -> Callable[[], None] | None:
        """Return what computes the errors of joints that follow others, or that turn the short way round."""
        data, target, error, positions = self._data, self._target, self._error, self._positions
        led, led_index, cyclic = self._led, self._led_places, np.flatnonzero(self._cyclic)
        if not led and not cyclic.size:
            return None

        def prepare() -> None:
            if led:
                target[led_index] = led.wanted(data)
            np.subtract(target, positions, error)
            if cyclic.size:
                error[cyclic] = np.remainder(error[cyclic] + math.pi, 2 * math.pi) - math.pi

        return prepare

    def _pid(self) -> Callable[[], None]:
        """Return what adds the integral and the derivative term to the commands."""
        error, command, memory, last = self._error, self._command, self._sum, self._last
        integral, derivative = self._integral, self._derivative

        def add_terms() -> None:
            np.add(memory, error * integral, memory)
            change = np.where(np.isnan(last), 0.0, error - last)
            np.add(command, memory + change * derivative, command)
            last[:] = error

        return add_terms

    def _after_limits(self, ctrl: np.ndarray | None) -> Callable[[], object] | None:
        """Return what makes controls of the limited commands.

        Args:
            ctrl: places of the controls, if the commands are not a view of them.
        """
        steps: list[Callable[[], object]] = []
        data, command, gear = self._data, self._command, self._gear
        if not np.all(gear == 1.0):
            steps.append(lambda: np.multiply(command, gear, command))
        if ctrl is not None:
            steps.append(lambda: data.ctrl.__setitem__(ctrl, command))
        if len(steps) < 2:
            return steps[0] if steps else None

        def complete() -> None:
            for step in steps:
                step()

        return complete


def position_gain(p: float, step: float) -> float:
    """Return the velocity per error, 1/s, of V-REP's position controller at a physics step of `step` seconds.

    In each dynamics step of 5 ms V-REP's removes the part P of the error. Any other step removes the part that leaves
    the same error after the same time. Removing more than all of it would overshoot.
    """
    left = max(0.0, 1.0 - p) ** (step / VREP_DYNAMICS_STEP)
    return (1.0 - left) / step


def _goal(state: JointState, rule: Rule) -> float:
    return state.held if rule == Rule.HOLD else state.target_position


def _view(values: np.ndarray, indices: NDArray[np.intp]) -> np.ndarray | None:
    """Return a view of these items; None if they are not adjacent in this order."""
    items = as_slice(indices)
    return None if items is None else values[items]
