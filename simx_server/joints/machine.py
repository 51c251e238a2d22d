"""The joints of one scene as a machine: bound to the model, moved in simulation steps, saved and restored."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.editing.waiting.basis import when_compiled
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import carry_followers
from simx_server.scene.poses.poses import Quaternion

from .controllers import Controllers
from .dependency import Followers, write_equality
from .measured import Measured
from .moments import Moment, Settings, shared_values
from .saving import save_joints
from .servo import Entry, Rule, is_immovable, rule_of, spring_control, write_actuator
from .state import Binding, JointMode, JointState, bind, copied, initial_state
from .stepping.scripted import Ask
from .weights import Weights

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.saved import Saved


Place = tuple["memoryview[float]", int, JointState]
"""Where a number of a joint is: an array and the index in it; and the joint's settings."""

Position = tuple[int, float, bool]
"""Where the position of a joint is: the index in `qpos`, what is added, and whether it is brought into one turn."""


class Machine:
    """Settings of all joints by handle, and the controllers that use them. `Joints` is the interface for callers."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._bound: dict[int, Binding] = {}
        self._states: dict[int, JointState] = {}
        self._served: frozenset[int] = frozenset()
        """Joints whose targets a script's call-back serves outside force mode."""
        self._has_masters: bool | None = None
        """Whether any joint follows another; None: it is not known."""
        self._measured = Measured(sim)
        self.controllers = Controllers(sim, self._measured, self._entries)
        self._kinematic: frozenset[int] = frozenset()
        self._positions: dict[int, tuple[memoryview[float], Position]] = {}
        """Joints whose position is a number of `qpos`, which the first item is; found when it is read."""
        self._targets: dict[int, Place] = {}
        """Joints whose target is a number of the position controllers; found when it is set."""
        self.places_version: int = 0
        """Increases when positions are found, and when they have to be found again."""
        self.bind_all()

    @property
    def _bindings(self) -> Mapping[int, Binding]:
        """Return where the joints are in the model. Edits that wait move the ids, so they are compiled first."""
        if self._sim.waiting is not None:
            self._sim.compile_edits()
        return self._bound

    def bind_all(self) -> None:
        """Find all joints in a freshly compiled model; joints known by handle keep their settings."""
        self.forget_places()
        scene, model, data = self._sim.scene, self._sim.model, self._sim.data
        known = self._states
        self._bound, self._states = {}, {}
        items = [scene.objects[handle] for handle in scene.of_kind(ObjectKind.JOINT)]
        handles = {item.element_name: item.handle for item in items if item.element == "joint"}
        handles |= {item.name: item.handle for item in items}
        for item in items:
            binding = self._bound[item.handle] = bind(item, model)
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
        self._bound = dict(settings.bindings)
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
        is_same = before is not None and before.bindings is self._bindings
        values, new, is_changed = shared_values(
            list(self._states.values()), before.values if before is not None and is_same else None
        )
        controllers = self.controllers
        moment = Moment(
            self._bindings,
            values,
            self._weights,
            controllers.averages_force,
            controllers.remember(),
            controllers.is_rebuilding,
            self._measured.remember(),
            new,
        )
        return moment, is_changed

    def recall_moment(self, moment: Moment) -> None:
        """Go on from what `remember_moment` returned; `recall` has restored its settings already.

        Writes velocities of joints that move without a motor, so the state is restored once more after this.
        """
        self._measured.recall(moment.measured)
        self.controllers.recall(
            moment.controllers, averages_force=moment.averages_force, is_rebuilding=moment.is_rebuilding
        )
        self._targets.clear()

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
        self.controllers.forget_run()
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
        for handle in self.controllers.ask(asked, custom):
            if handle in self._bindings:
                self._apply(handle)

    def is_spring(self, handle: int) -> bool:
        """Return whether a spring and damper drives a joint, as a plain position actuator does.

        Scripts are not asked about such a joint.
        """
        binding = self._bindings.get(handle)
        return binding is not None and rule_of(binding, self._states[handle]) in (
            Rule.SPRING,
            Rule.STIFF_SPRING,
        )

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

    def measure(self) -> None:
        """Measure velocities at the end of a simulation step, with fresh kinematics."""
        self._measured.end()

    def _any(self, handle: int) -> tuple[Binding, JointState]:
        bindings = self._bindings
        if handle not in bindings:
            self._sim.scene.get_kind(handle, ObjectKind.JOINT)
        return bindings[handle], self._states[handle]

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
        if rule != Rule.HOLD:
            self.controllers.retarget(binding.handle, value)

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
        """Have new controllers made before the next physics step."""
        self._targets.clear()
        self.controllers.rebuild()

    def _entries(self) -> list[Entry]:
        pairs = ((binding, self._states[handle]) for handle, binding in self._bindings.items())
        return [(binding, state, rule_of(binding, state)) for binding, state in pairs]
