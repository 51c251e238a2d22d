"""The joints of one scene as a machine: bound to the model, moved in simulation steps, saved and restored."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing.waiting.basis import when_compiled
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import carry_followers
from simx_server.scene.poses.poses import Quaternion

from .dependency import Followers, write_equality
from .guards.watch import Watch
from .measured import Measured, Positions
from .saving import save_joints
from .servo import Entry, Rule, is_immovable, rule_of, spring_control, write_actuator
from .state import (
    SETTING_NAMES,
    Binding,
    JointMode,
    JointState,
    bind,
    copied,
    initial_state,
    setting_values,
)
from .stepping.apart import Apart, Made
from .stepping.scripted import Ask
from .stepping.stepper import Accompany, Memory, Stepper, Within
from .weights import Weights

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.saved import Saved


@dataclass(frozen=True)
class Settings:
    """The settings that `Machine.remember` keeps."""

    bindings: dict[int, Binding]
    states: dict[int, JointState]
    weights: Weights


_MOVING = {
    "target_position",
    "target_velocity",
    "backwards",
    "motion",
    "motion_time",
    "request",
    "held",
    "offset",
    "spherical",
}
"""Values that change in a run without a change of the model's arrays."""

_BYTES = 56 + 8 * len(SETTING_NAMES) + 4 * 24
"""Of the values of a joint: a tuple, and about four numbers that are not shared with others."""

_settings = attrgetter(*(name for name in SETTING_NAMES if name not in _MOVING))


_SCRIPTS = "scripts"
"""Those that call scripts between the physics steps, among the parts that accompany these."""

Place = tuple["memoryview[float]", int, JointState]
"""Where a number of a joint is: an array and the index in it; and the joint's settings."""

Position = tuple[int, float, bool]
"""Where the position of a joint is: the index in `qpos`, what is added, and whether it is brought into one turn."""


@dataclass(frozen=True, slots=True)
class Moment:
    """The state of the joints at the end of a simulation step; see `Machine.remember_moment`."""

    bindings: dict[int, Binding]
    values: tuple[tuple[Any, ...], ...]
    """Of each joint's state, in the order of the bindings."""

    weights: Weights
    averages_force: bool
    controllers: Memory | None
    """None: no physics step was made in this run yet."""

    is_rebuilding: bool
    """The controllers are made again before the next physics step, because a setting has changed."""

    measured: tuple[Positions | None, Positions | None, Mapping[int, float]]
    new: int
    """About how many bytes of `values` are not shared with the moment before."""

    @property
    def settings(self) -> Settings:
        """Return the settings, for `Machine.recall`."""
        states = {
            handle: JointState(*values) for handle, values in zip(self.bindings, self.values, strict=True)
        }
        return Settings(self.bindings, states, self.weights)

    @property
    def size(self) -> int:
        """Return about how many bytes this takes beside the one before."""
        positions = sum(each.nbytes for each in self.measured[1] or ())
        return self.new + positions + (self.controllers.size if self.controllers else 0)


class Machine:
    """Settings of all joints by handle, and the controllers that use them. `Joints` is the interface for callers."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._bindings: dict[int, Binding] = {}
        self._states: dict[int, JointState] = {}
        self._average_force = False
        self._stepper: Stepper | None = None
        self._earlier: Stepper | None = None
        """The stepper before a change, whose memory the next one takes over."""
        self._asked: Mapping[int, Ask] = {}
        self._custom: frozenset[int] = frozenset()
        """Joints of those that ask only in custom control."""
        self._served: frozenset[int] = frozenset()
        """Joints whose targets a script's call-back serves outside force mode."""
        self._accompanying: dict[str, Accompany] = {}
        """Functions that are called before and after each physics step, by the part that wants it."""
        self.within_steps: Within | None = None
        """Called within each physics step."""
        self._has_masters: bool | None = None
        """Whether any joint follows another; None: it is not known."""
        self._measured = Measured(sim)
        self._watch = Watch(sim)
        self._kinematic: frozenset[int] = frozenset()
        self._positions: dict[int, tuple[memoryview[float], Position]] = {}
        """Joints whose position is a number of `qpos`, which the first item is; found when it is read."""
        self._targets: dict[int, Place] = {}
        """Joints whose target is a number of the position controllers; found when it is set."""
        self.places_version: int = 0
        """Increases when positions are found, and when they have to be found again."""
        self.bind_all()

    def bind_all(self) -> None:
        """Find all joints in a freshly compiled model; joints known by handle keep their settings."""
        self.forget_places()
        scene, model, data = self._sim.scene, self._sim.model, self._sim.data
        known = self._states
        self._bindings, self._states = {}, {}
        items = [scene.objects[handle] for handle in scene.of_kind(ObjectKind.JOINT)]
        handles = {item.element_name: item.handle for item in items if item.element == "joint"}
        handles |= {item.name: item.handle for item in items}
        for item in items:
            binding = self._bindings[item.handle] = bind(item, model)
            self._states[item.handle] = known.get(item.handle) or initial_state(
                item, binding, model, self._raw_position(binding), handles
            )
        self._has_masters = None
        for state in self._states.values():
            if state.master not in self._bindings:
                state.master = -1
        for binding, state, rule in self._entries():
            write_actuator(binding, state, rule, model, data)
            write_equality(binding, state, rule, self._bindings.get(state.master), model, data)
        self._follow()
        for body in {binding.body for binding in self._bindings.values() if binding.element == "joint"}:
            self._write_gravcomp(body)
        self._weights = Weights.of(model)
        self._write_weights(always=True)

    def masses_changed(self) -> None:
        """Recompute what depends on masses and joint positions after they changed in the model.

        Raises:
            mujoco.FatalError: MuJoCo cannot; see `scene.model_changes.undone_on_failure`.
        """
        model = self._sim.model
        # MuJoCo counts the bodies with compensated weight; if the count is 0, it never compensates any. The
        # world counts as one now.
        model.body_gravcomp[0] = 1.0
        # Not with the simulation's own data, because this writes the reset pose into it.
        try:
            mujoco.mj_setConst(model, mujoco.MjData(model))
        finally:
            model.body_gravcomp[0] = 0.0
        self._weights = Weights.of(model, self._weights.armature)
        self._write_weights(always=True)

    def alignment(self, joint: int) -> Quaternion | None:
        """Return the rotation from a body's axes to its joint's (a MuJoCo id).

        None if nothing was placed against the joint.
        """
        handle = self._sim.scene.by_element("joint", joint)
        return self._states[handle].alignment if handle in self._states else None

    def align(self, joint: int, alignment: Quaternion) -> None:
        """Store the rotation from a body's axes to its joint's."""
        handle = self._sim.scene.by_element("joint", joint)
        if handle is not None:
            self._states[handle].alignment = alignment

    def rebind(self) -> None:
        """Bind the joints again after an edit replaced the model; the controllers keep their memory."""
        self._rebuild()
        self._measured.keep(self._bindings.values())
        self.bind_all()

    def saving(self, saved: Saved) -> None:
        """Annotate the joints of a scene or model that is being saved with their settings."""
        save_joints(
            saved, {handle: (self._bindings[handle], state) for handle, state in self._states.items()}
        )

    def remember(self) -> Settings:
        """Return a copy of all settings, for `recall`."""
        return Settings(
            dict(self._bindings),
            {handle: copied(state) for handle, state in self._states.items()},
            self._weights,
        )

    def recall(self, settings: Settings) -> None:
        """Restore saved settings; model and data were restored already."""
        self._bindings = dict(settings.bindings)
        has_others = settings.weights is not self._weights
        self._weights = settings.weights
        self._states = {handle: copied(state) for handle, state in settings.states.items()}
        self._has_masters = None
        self._write_weights(always=has_others)
        self.forget_run()

    def remember_moment(self, before: Moment | None) -> tuple[Moment, bool]:
        """Return what the joints need to go on from here, and whether the model's arrays may differ from before.

        Args:
            before: of the step before, to share what is equal; None: there is none.
        """
        values = tuple(map(setting_values, self._states.values()))
        new_values = len(values)
        is_changed = before is None or before.bindings is not self._bindings
        if before is not None and not is_changed:
            if values == before.values:
                values, new_values = before.values, 0
            else:
                is_changed = list(map(_settings, self._states.values())) != _settings_of(before.values)
                values = tuple(
                    old if new == old else new for new, old in zip(values, before.values, strict=True)
                )
                new_values = sum(new is not old for new, old in zip(values, before.values, strict=True))
        stepper = self._stepper or self._earlier
        moment = Moment(
            self._bindings,
            values,
            self._weights,
            self._average_force,
            None if stepper is None else stepper.remember(),
            self._stepper is None and self._earlier is not None,
            self._measured.remember(),
            new_values * _BYTES + (8 * len(values) if new_values else 0),
        )
        return moment, is_changed

    def recall_moment(self, moment: Moment) -> None:
        """Go on from what `remember_moment` returned; `recall` has restored its settings already.

        Writes velocities of joints that move without a motor, so the state is restored once more after this.
        """
        self._average_force = moment.averages_force
        self._measured.recall(moment.measured)
        if moment.controllers is None:
            return
        self._current_stepper().recall(moment.controllers)
        if moment.is_rebuilding:
            self._rebuild()

    def copy_settings(self, copies: Mapping[int, int]) -> None:
        """Make copies of joints act as their originals do now.

        Args:
            copies: maps the handle of the original to that of the copy; the model may be compiled later.
        """
        states = {
            copy: copied(self._states[original])
            for original, copy in copies.items()
            if original in self._states
        }
        if states:
            when_compiled(self._sim, lambda: self._take(states, copies))

    def _take(self, states: Mapping[int, JointState], copies: Mapping[int, int]) -> None:
        """Give copies of joints these states. `copies`: original to copy."""
        for copy, state in states.items():
            if copy in self._states:
                self._states[copy] = state
                state.master = copies.get(state.master, state.master)
                self._apply(copy)
        self.forget_places()

    @property
    def has_inert(self) -> bool:
        """Return whether any joint is held by `hold_inert`."""
        return any(state.inert for state in self._states.values())

    def hold_inert(self, handles: Collection[int]) -> None:
        """Hold these joints where they are, in any mode; release all others that were held so."""
        changed = [handle for handle, state in self._states.items() if state.inert != (handle in handles)]
        for handle in changed:
            self._states[handle].inert = handle in handles
            self._write(handle)
        if changed:
            self._write_weights()
            self._rebuild()

    def fix(self, handle: int, fixed: bool) -> None:
        """Let physics leave a joint where it is, in any mode, or move it."""
        _, state = self._any(handle)
        if state.fixed != fixed:
            state.fixed = fixed
            self._apply(handle)

    def is_fixed(self, handle: int) -> bool:
        """Return whether physics leaves a joint where it is."""
        return self._any(handle)[1].fixed

    def forget_run(self) -> None:
        """Reset measured forces and velocities and the controllers' memory: a run starts."""
        self._average_force = False
        self._stepper = self._earlier = None
        self.forget_places()
        self._measured.forget()

    def forget_places(self) -> None:
        """Find again where positions and targets are: there are other arrays, or other settings."""
        self._positions.clear()
        self._targets.clear()
        self.places_version += 1

    def ask(
        self,
        asked: Mapping[int, Ask],
        custom: Collection[int] = (),
        kinematic: Collection[int] = (),
    ) -> None:
        """Let these functions alone control the motors of their joints (by handle) from the next step on.

        Args:
            custom: joints of them that ask only in custom control.
            kinematic: joints whose targets a call-back serves outside force mode.
        """
        self._targets.clear()
        self._served = frozenset(kinematic)
        self._custom = frozenset(custom)
        if not asked and not self._asked:
            return
        freed = self._asked.keys() - asked.keys()
        self._asked = dict(asked)
        for handle in freed & self._bindings.keys():
            self._apply(handle)
        self._rebuild()

    def is_spring(self, handle: int) -> bool:
        """Return whether a spring and damper drives a joint, as a plain position actuator does.

        Scripts are not asked about such a joint.
        """
        binding = self._bindings.get(handle)
        return binding is not None and rule_of(binding, self._states[handle]) in (
            Rule.SPRING,
            Rule.STIFF_SPRING,
        )

    def accompany(self, call: Accompany | None, name: str = _SCRIPTS) -> None:
        """Call a function before and after each physics step from the next simulation step on; None: no more.

        Args:
            call: takes the index of the step, their number, and whether it is over.
            name: of the part that wants it; each has one function.
        """
        if call == self._accompanying.get(name):
            return
        if call is None:
            del self._accompanying[name]
        else:
            self._accompanying[name] = call
        self._rebuild()

    @property
    def calls_scripts(self) -> bool:
        """Return whether scripts are called between the physics steps of a simulation step."""
        return bool(self._asked) or _SCRIPTS in self._accompanying

    def call_within_steps(self, within: Within | None) -> None:
        """Call a function within each physics step from the next simulation step on; None: no more."""
        self.within_steps = within

    def step(self, count: int, flags: int = 0, *within: Within) -> bool:
        """Make `count` physics steps under the controllers.

        Args:
            count: number of steps.
            flags: what they do besides, see `stepper.LIMIT_SEPARATION`.
            within: called within each of them, beside `within_steps`.

        Returns:
            Whether shapes overlap deeply.

        Raises:
            StepFailed: the simulation step cannot be completed.
            mujoco.FatalError: MuJoCo failed.
        """
        self._measured.begin()
        if self.within_steps is not None:
            within = (self.within_steps, *within)
        stepper = self._stepper or self._current_stepper()
        return stepper.step(count, flags, average_force=self._average_force, within=within)

    @property
    def may_be_apart(self) -> bool:
        """Return whether nothing within the next physics steps needs Python."""
        return self.within_steps is None and self._current_stepper().compiled is not None

    def step_apart(
        self, count: int, flags: int, log: Callable[[Sequence[str]], object]
    ) -> Generator[Apart, Made, bool]:
        """Make physics steps as `step`, by the caller; only if they `may_be_apart`.

        Args:
            log: takes the texts of MuJoCo's warnings.
        """
        self._measured.begin()
        stepper = self._current_stepper()
        return (yield from stepper.step_apart(count, flags, log, average_force=self._average_force))

    @property
    def stepper(self) -> Stepper:
        """Return the controllers of the next physics steps."""
        return self._current_stepper()

    @property
    def averages_force(self) -> bool:
        """Return whether forces are averaged over the physics steps of a simulation step."""
        return self._average_force

    @property
    def measured(self) -> Measured:
        """Return the positions around the last simulation step."""
        return self._measured

    def entry(self, handle: int) -> Entry | None:
        """Return a joint with its settings and its rule, for reading; None: it does not exist."""
        binding, state = self._bindings.get(handle), self._states.get(handle)
        return None if binding is None or state is None else (binding, state, rule_of(binding, state))

    @property
    def have_masters(self) -> bool:
        """Return whether any joint follows another one."""
        return any(state.master >= 0 for state in self._states.values())

    def is_served(self, handle: int) -> bool:
        """Return whether a script's call-back serves the targets of a joint outside force mode."""
        return handle in self._served

    def note_written(self, handle: int, **settings: float | bool) -> None:
        """Take over settings that were written into the model and the controllers already."""
        for name, value in settings.items():
            setattr(self._states[handle], name, value)

    @property
    def mean_sensed(self) -> np.ndarray:
        """Return the values of all sensors (as `sensordata`), mean over the last simulation step.

        They are averaged in scenes with force sensors.
        """
        return (self._stepper or self._current_stepper()).mean_sensed

    def measure(self) -> None:
        """Measure velocities at the end of a simulation step, with fresh kinematics."""
        self._measured.end()

    def _any(self, handle: int) -> tuple[Binding, JointState]:
        try:
            return self._bindings[handle], self._states[handle]
        except KeyError:
            self._sim.scene.get_kind(handle, ObjectKind.JOINT)
            self._sim.compile_edits()  # a new joint
            return self._bindings[handle], self._states[handle]

    def _single(self, handle: int) -> tuple[Binding, JointState]:
        pair = self._any(handle)
        if pair[0].kind == "ball":
            raise CommandError(
                f"'{pair[0].name}' is a spherical joint, which has no single value; use its matrix"
            )
        return pair

    def _spherical(self, handle: int) -> tuple[Binding, JointState]:
        pair = self._any(handle)
        if pair[0].kind != "ball":
            raise CommandError(f"'{pair[0].name}' is not spherical; set its position instead")
        return pair

    def _raw_position(self, binding: Binding) -> float:
        if binding.element == "tendon":
            self._sim.refresh()
            return self._sim.data.ten_length.item(binding.id)
        return self._sim.data.qpos.item(binding.qpos)

    def _apply(self, handle: int, *, rebuild: bool = True) -> None:
        """Apply changed settings."""
        self._write(handle, may_hold=rebuild)
        if rebuild:
            self._write_weights()
            self._rebuild()

    def _write(self, handle: int, *, may_hold: bool = True) -> None:
        """Write a joint's settings into the model. `may_hold`: a joint that is to be held now is held where it is."""
        self._has_masters = None
        binding, state = self._bindings[handle], self._states[handle]
        rule = rule_of(binding, state)
        if rule == Rule.HOLD and may_hold:
            state.held = self._raw_position(binding) + state.offset
        write_actuator(binding, state, rule, self._sim.model, self._sim.data)
        master = self._bindings.get(state.master)
        write_equality(binding, state, rule, master, self._sim.model, self._sim.data)
        if binding.element == "joint":
            self._write_gravcomp(binding.body)

    def _write_weights(self, *, always: bool = False) -> None:
        kinematic = frozenset(
            b.id for b, _, rule in self._entries() if b.element == "joint" and is_immovable(b, rule)
        )
        if always or kinematic != self._kinematic:
            self._kinematic = kinematic
            self._weights.write(self._sim.model, kinematic)

    def _retarget(self, binding: Binding, state: JointState, value: float) -> None:
        state.target_position = value
        rule = rule_of(binding, state)
        if rule == Rule.SPRING and state.spring:
            self._sim.data.ctrl[binding.ctrl] = spring_control(binding, state)
        if self._stepper is not None and rule != Rule.HOLD:
            self._stepper.retarget(binding.handle, value)

    def _place(self, handle: int, move: Callable[[], None]) -> None:
        """Move a joint with everything below it in the tree.

        In a running simulation, physics alone moves free bodies.
        """

        if self._sim.is_running:
            self._move(move)
        else:
            carry_followers(self._sim, self._sim.scene.get(handle), lambda: self._move(move))

    def _move(self, move: Callable[[], None]) -> None:
        """Move joints, and those that follow them."""
        move()
        self._follow()
        self._sim.changed()

    def _write_position(self, binding: Binding, value: float) -> None:
        self._sim.data.qpos[binding.qpos] = value
        self._sim.data.qvel[binding.dof] = 0.0

    def _follow(self) -> None:
        """Put dependent joints where their masters want them."""
        if self._has_masters is None:
            self._has_masters = any(state.master >= 0 for state in self._states.values())
        if self._has_masters:
            followers = Followers(self._sim.model, self._entries(), Rule.DEPENDENT)
            if followers:
                followers.follow(self._sim.data)

    def _write_gravcomp(self, body: int) -> None:
        """Switch off the compensation of a body with a joint whose motor was switched off; else it would float."""
        here = [b for b in self._bindings.values() if b.body == body and b.element == "joint"]
        states = [self._states[b.handle] for b in here]
        falls = any(s.motor_was_set and s.mode == JointMode.FORCE and not s.motor for s in states)
        self._sim.model.body_gravcomp[body] = 0.0 if falls else here[0].gravcomp

    def _rebuild(self) -> None:
        """Request a new stepper before the next physics step, because the arrays' targets are stale.

        It takes over the memory of the old one. Many changes in a row make a single one.
        """
        self._targets.clear()
        if self._stepper is not None:
            self._earlier, self._stepper = self._stepper, None

    @property
    def _has_run(self) -> bool:
        return self._stepper is not None or self._earlier is not None

    def _current_stepper(self) -> Stepper:
        if self._stepper is None:
            self._stepper = self._make_stepper()
            if self._earlier is not None:
                self._stepper.adopt(self._earlier)
                self._earlier = None
        return self._stepper

    def _make_stepper(self) -> Stepper:
        asked = {
            handle: ask
            for handle, ask in self._asked.items()
            if handle not in self._custom or (handle in self._states and self._states[handle].scripted)
        }
        calls = tuple(self._accompanying.values())

        def accompany(index: int, count: int, is_over: bool) -> None:
            for call in calls:
                call(index, count, is_over)

        return Stepper(
            self._sim.model, self._sim.data, self._entries(), self._watch, asked, accompany if calls else None
        )

    def _entries(self) -> list[Entry]:
        pairs = ((binding, self._states[handle]) for handle, binding in self._bindings.items())
        return [(binding, state, rule_of(binding, state)) for binding, state in pairs]


_SETTINGS = [number for number, name in enumerate(SETTING_NAMES) if name not in _MOVING]


def _settings_of(values: tuple[tuple[Any, ...], ...]) -> list[tuple[Any, ...]]:
    return [tuple(each[number] for number in _SETTINGS) for each in values]
