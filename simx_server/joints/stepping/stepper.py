"""Make one simulation step with the joint controllers: in C, or in Python where the compiled module cannot.

Python has something to do between or within the physics steps where scripts control motors or are called, where motion
profiles move joints, and where surfaces move. Both forms share the arrays of the controllers, and give equal numbers.
The Python form is vectorised, without allocations or look-ups per physics step; a scene with constant commands over the
simulation step is stepped in one call, which releases the interpreter lock only once.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from simx_server.joints.guards import watch as watching
from simx_server.joints.guards.watch import DIVERGED, Divergence, StepFailed, Watch, are_finite
from simx_server.joints.native.loading import compiled_module
from simx_server.joints.servo import Entry

from . import kinematics
from .apart import Apart, Made
from .cyclic_springs import CyclicSprings
from .grip import Grip
from .indices import Columns
from .kinematic import Kinematic
from .motors import Motors, Step, no_room
from .noslip import Noslip
from .position_control import Control, PositionControl, PositionMemory
from .scripted import Ask, ScriptedJoints
from .separation import has_deep_contacts, limit_separation
from .sliding import keep_down, lifts_what_slides
from .stiff_springs import StiffSprings

if TYPE_CHECKING:
    from simx_server.joints.native._physics_step import PhysicsStep

Accompany = Callable[[int, int, bool], object]
"""Called before and after each physics step: its index in the simulation step (from 0), their number, whether it is
over.
"""

Within = Callable[[mujoco.MjModel, mujoco.MjData], object]
"""Called within each physics step, after MuJoCo's constraints are known and before it computes accelerations."""

LIMIT_SEPARATION, KEEP_DOWN, LAST_FORCE, UPDATE = 1, 2, 4, 8
"""Parts of a step, as a sum: corrections of contacts (`separation.py`, `sliding.py`), no averages, kinematics
at the end. The compiled module has the same numbers.
"""

_CORRECTIONS: dict[int, tuple[Within, ...]] = {
    0: (),
    LIMIT_SEPARATION: (limit_separation,),
    KEEP_DOWN: (keep_down,),
    LIMIT_SEPARATION | KEEP_DOWN: (limit_separation, keep_down),
}


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
        watch: Watch,
        asked: Mapping[int, Ask] | None = None,
        accompany: Accompany | None = None,
    ) -> None:
        """Build the arrays; `asked` holds by joint handle the scripts that control a motor."""
        self._watch = watch
        self._accompany = accompany
        self._scripted = ScriptedJoints(model, entries, asked or {})
        self._model = model
        self._data = data
        self._position = PositionControl(model, data, entries)
        self._springs = CyclicSprings(entries)
        self._stiff_springs = StiffSprings(model, entries)
        self._motors = Motors(model, data, entries)
        self._grip = Grip(model)
        self._noslip = Noslip(model)
        self._kinematic = Kinematic(model, data, entries)
        self._force = np.zeros(data.actuator_force.shape)
        self._has_cells = bool(np.any(model.sensor_type == mujoco.mjtSensor.mjSENS_FORCE.value))
        self._sensed = np.zeros(data.sensordata.shape)
        self._divergence = Divergence(data)

        self._is_constant = not (
            self._motors
            or self._position
            or self._springs
            or self._kinematic
            or self._accompany
            or self._scripted
        )
        """Nothing has to run between, or within, the physics steps of a simulation step."""

        self._flags = KEEP_DOWN if lifts_what_slides(model) else 0
        self._has_stiff_springs = bool(self._stiff_springs)
        self._before, self._after = self._controllers()
        needs_python = bool(self._scripted or accompany or self._kinematic.needs_python)
        self._module = None if needs_python else compiled_module()
        self._step: PhysicsStep | None = None
        """The compiled form, from the first simulation step on."""
        self._no_room: type[Exception] = StepFailed if self._module is None else self._module.NoRoom

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

    def target_address(self, handle: int) -> tuple[memoryview[float], int] | None:
        """Return where the target of a running position controller is; None when the joint has none here."""
        return self._position.target_address(handle)

    def step(
        self, count: int, flags: int = 0, *, average_force: bool = False, within: Sequence[Within] = ()
    ) -> bool:
        """Make `count` physics steps.

        With `within` or a correction a model with integrator RK4 is stepped with Euler's method: MuJoCo's halves of a
        step have no RK4.

        Args:
            count: number of physics steps.
            flags: the sum of `LIMIT_SEPARATION` and `UPDATE` that are wanted.
            average_force: whether forces are averaged also without controllers; else they are those of the last step.
            within: called within each step, before the corrections.

        Returns:
            Whether shapes overlap deeply.

        Raises:
            StepFailed: see `Watch.made`; or the result is not finite.
        """
        flags |= self._flags
        corrections = flags & (LIMIT_SEPARATION | KEEP_DOWN)
        if self.may_skip_means(average_force=average_force) and not (within or corrections):
            flags |= LAST_FORCE
        self._watch.begin(count)
        if self._module is not None and not within:
            return self._run_compiled(count, flags)
        self._divergence.forget()
        if flags & LAST_FORCE:
            self._run_constant(count)
        else:
            self._run(count, (*within, *_CORRECTIONS[corrections]))
        # MuJoCo checks the state before each physics step, so it does not check the result of the last one.
        if not are_finite(self._data):
            raise StepFailed(DIVERGED)
        if flags & UPDATE:
            kinematics.update(self._model, self._data)
        return has_deep_contacts(self._data)

    def may_skip_means(self, *, average_force: bool) -> bool:
        """Return whether nothing has to be averaged over physics steps without corrections of contacts."""
        return self._is_constant and not (average_force or self._has_cells)

    @property
    def own_flags(self) -> int:
        """Return the parts of each step that the model needs."""
        return self._flags

    @property
    def compiled(self) -> PhysicsStep | None:
        """Return the compiled form; None where Python makes the steps."""
        if self._step is None and self._module is not None:
            self._step = self._compile()
        return self._step

    def place_of(self, handle: int) -> int | None:
        """Return the place of a joint among the targets of position controllers, or of cyclic springs; None: none."""
        place = self._position.place_of(handle)
        return self._springs.place_of(handle) if place is None else place

    def target_of(self, handle: int) -> float:
        """Return the target of a joint's position controller or cyclic spring, rad or m."""
        targets = self._springs if self._position.place_of(handle) is None else self._position
        return targets.target_of(handle)

    def step_apart(
        self, count: int, flags: int, log: Callable[[Sequence[str]], object], *, average_force: bool
    ) -> Generator[Apart, Made, bool]:
        """Make physics steps as `step`, in C by the caller, who gets them by a yield.

        Args:
            log: takes the texts of MuJoCo's warnings.
        """
        step = self.compiled
        assert step is not None
        flags |= self._flags
        if self.may_skip_means(average_force=average_force) and not flags & (LIMIT_SEPARATION | KEEP_DOWN):
            flags |= LAST_FORCE
        self._watch.begin(count)
        if self._has_stiff_springs:
            self._stiff_springs.refresh()
        try:
            made = yield Apart(step, count, flags)
        except self._no_room:
            raise no_room(self._data) from None
        if made.warnings:
            log(made.warnings)
        return self.go_on(made.steps, count, flags)

    def go_on(self, done: int, count: int, flags: int) -> bool:
        """Check physics steps that another thread has made in C, and make those that are missing.

        Args:
            done: number of physics steps that were made.
            count: number of all in the simulation step.
            flags: see `step`.

        Returns:
            Whether shapes overlap deeply.

        Raises:
            StepFailed: as `step`.
        """
        step = self._step
        assert step is not None
        if step.has_diverged or done < count or step.seconds > watching.GLANCE:
            self._watch.made(done, has_diverged=step.has_diverged, seconds=step.seconds)
        return self._run_compiled(count, flags, done)

    def _run_compiled(self, count: int, flags: int, done: int = 0) -> bool:
        """Do the same in C, which lets other threads run meanwhile; `done` physics steps were made already."""
        step, watch = self.compiled, self._watch
        assert step is not None
        while done < count:
            if self._has_stiff_springs:
                self._stiff_springs.refresh()
            try:
                done = step.run(done, watch.next_end(stops=True), count, watching.GLANCE, flags)
            except self._no_room:
                raise no_room(self._data) from None
            if step.has_diverged or done < count or step.seconds > watching.GLANCE:
                watch.made(done, has_diverged=step.has_diverged)
        if not step.is_finite:
            raise StepFailed(DIVERGED)
        return step.has_deep_contacts

    def _run_constant(self, count: int) -> None:
        """Make physics steps without anything between them."""
        model, data, watch, done = self._model, self._data, self._watch, 0
        while done < count:
            end = watch.next_end()
            mujoco.mj_step(model, data, end - done)
            done = end
            watch.made(done, has_diverged=self._divergence.is_found)
        self._force[:] = data.actuator_force

    def _run(self, count: int, within: Sequence[Within]) -> None:
        """Make the physics steps in Python, and average forces and sensors."""
        model, data, watch, done = self._model, self._data, self._watch, 0
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
        while done < count:
            self._stiff_springs.refresh()
            end = watch.next_end()
            for index in range(done, end):
                for control in before:
                    control(index, count)
                step(model, data)
                accumulate(total, force, total)
                if has_cells:
                    accumulate(sensed, sensor_values, sensed)
                for follow in after:
                    follow(index, count)
            done = end
            watch.made(done, has_diverged=self._divergence.is_found)
        if count > 1:
            total /= count
            if has_cells:
                sensed /= count

    def _compile(self) -> PhysicsStep:
        """Return the compiled form of these controllers, which shares their arrays."""
        assert self._module is not None
        table: Columns = {
            **self._position.columns,
            **self._springs.columns,
            **self._stiff_springs.columns,
            **self._motors.columns,
            **self._kinematic.columns,
            "geom.base": self._noslip.base,
            "mean.force": self._force,
            "mean.sensed": self._sensed,
        }
        return self._module.PhysicsStep(
            self._model,
            self._data,
            table,
            self._motors.rows_in_all,
            self._has_cells,
            self._grip.hold,
            self._noslip.has_immobile,
        )

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
