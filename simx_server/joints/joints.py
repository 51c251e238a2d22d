"""The joints of one scene and what a caller may do with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.joints.parameters import READ, WRITE, describe
from simx_server.joints.servo import Rule, rule_of, write_actuator, write_force_limit
from simx_server.joints.state import Binding, JointMode, JointState, bind, initial_state
from simx_server.joints.stepping import Stepper
from simx_server.scene.frames import matrix12, xyzw_from_wxyz
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import NO_TURN, Quaternion, about, normalised

if TYPE_CHECKING:
    from simx_server.simulation import Simulation

JOINT_TYPES = {"hinge": 10, "slide": 11, "ball": 12}
"""`sim_joint_revolute_subtype`, `..._prismatic_subtype`, `..._spherical_subtype`."""


@dataclass(frozen=True)
class Settings:
    """What `Joints.remember` keeps."""

    bindings: dict[int, Binding]
    states: dict[int, JointState]


class Joints:
    """All joints of the loaded scene, by handle. Every method raises UnknownHandle, WrongKind for other objects,
    and CommandError for a spherical joint where a single number is meant, or for a number that is not finite."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._bindings: dict[int, Binding] = {}
        self._states: dict[int, JointState] = {}
        self._average_force = False
        self._stepper: Stepper | None = None
        self.bind_all()

    def bind_all(self) -> None:
        """Find all joints in a freshly compiled model; those known by handle keep their settings."""
        scene, model, data = self._sim.scene, self._sim.model, self._sim.data
        known = self._states
        self._bindings, self._states = {}, {}
        for handle in scene.of_kind(ObjectKind.JOINT):
            item = scene.objects[handle]
            binding = self._bindings[handle] = bind(item, model)
            state = known.get(handle) or initial_state(item, binding, model, self._raw_position(binding))
            self._states[handle] = state
        for handle, binding in self._bindings.items():
            state = self._states[handle]
            write_actuator(binding, state, rule_of(binding, state), model, data)
        for body in {binding.body for binding in self._bindings.values() if binding.element == "joint"}:
            self._write_gravcomp(body)

    def rebind(self) -> None:
        """An edit replaced the model: the same, and the controllers keep their memory."""
        earlier = self._stepper
        self.bind_all()
        self._stepper = None
        if earlier is not None:
            self._current_stepper().adopt(earlier)

    def remember(self) -> Settings:
        """A copy of all settings, for `recall`."""
        return Settings(
            dict(self._bindings), {handle: replace(state) for handle, state in self._states.items()}
        )

    def recall(self, settings: Settings) -> None:
        """Bring remembered settings back; model and data were restored already."""
        self._bindings = dict(settings.bindings)
        self._states = {handle: replace(state) for handle, state in settings.states.items()}
        self.forget_run()

    def forget_run(self) -> None:
        """A run begins: no force was measured, no controller has a memory."""
        self._average_force = False
        self._stepper = None

    def step(self, count: int) -> None:
        """`count` physics steps under the controllers."""
        self._current_stepper().step(count, average_force=self._average_force)

    def position(self, handle: int) -> float:
        """Angle (rad) or displacement (m), cyclic joints in -pi..pi; a tendon joint: length plus its offset."""
        binding, state = self._single(handle)
        value = self._raw_position(binding) + state.offset
        return _wrapped(value) if state.cyclic and binding.kind == "hinge" else value

    def set_position(self, handle: int, value: float) -> None:
        """Put the joint there at once (clamped to its interval, cyclic: wrapped to -pi..pi), velocity zero.

        In force mode a controller drives it back to its target, as in V-REP. Raises CommandError for a tendon joint.
        """
        binding, state = self._single(handle)
        value = _finite(value, "a joint position")
        if binding.element == "tendon":
            raise CommandError(
                f"'{binding.name}' is moved through its tendon; give it a target position or velocity"
            )
        cyclic, least, extent = self.interval(handle)
        value = _wrapped(value) if cyclic else min(max(value, least), least + extent)
        self._sim.data.qpos[binding.qpos] = value
        self._sim.data.qvel[binding.dof] = 0.0
        state.held = value
        if rule_of(binding, state) in (Rule.KINEMATIC, Rule.HOLD):
            self._rebuild()
        self._sim.changed()

    def velocity(self, handle: int) -> float:
        """rad/s or m/s."""
        binding, _ = self._single(handle)
        data = self._sim.data
        return float(data.ten_velocity[binding.id] if binding.element == "tendon" else data.qvel[binding.dof])

    def target_position(self, handle: int) -> float:
        """rad or m."""
        return self._single(handle)[1].target_position

    def set_target_position(self, handle: int, value: float) -> None:
        """Where the position controller drives the joint; a joint without annotation is switched to it (and on).

        Raises CommandError when the joint is not in force mode.
        """
        binding, state = self._single(handle)
        value = _finite(value, "a target position")
        if state.mode != JointMode.FORCE:
            raise CommandError(
                f"'{binding.name}' is in {state.mode.name.lower()} mode, which has no target position; "
                "set its position, or annotate it with mode=force"
            )
        state.target_position = value
        if not state.annotated and not (state.motor and state.control_loop):
            state.motor = state.control_loop = True
            self._apply(handle)
        elif rule_of(binding, state) == Rule.NATIVE:
            self._sim.data.ctrl[binding.ctrl] = (value - state.offset) * binding.gear
        elif state.motor and state.control_loop and self._stepper is not None:
            self._stepper.retarget(handle, value)

    def target_velocity(self, handle: int) -> float:
        """rad/s or m/s."""
        return self._single(handle)[1].target_velocity

    def set_target_velocity(self, handle: int, value: float) -> None:
        """Stored in any mode; moves the joint in force mode with motor on and control loop off.

        A joint without annotation is switched to that. At 0 with the lock on, the position reached now is held.
        """
        binding, state = self._single(handle)
        value = _finite(value, "a target velocity")
        before = rule_of(binding, state)
        same = state.target_velocity == value
        state.target_velocity = value
        if not state.annotated and state.mode == JointMode.FORCE:
            state.motor, state.control_loop = True, False
        if same and rule_of(binding, state) == before:
            return
        self._apply(handle, rebuild=before != Rule.VELOCITY or rule_of(binding, state) != Rule.VELOCITY)

    def max_force(self, handle: int) -> float:
        """N m or N; 1e9 stands for none."""
        return self._single(handle)[1].max_force

    def set_max_force(self, handle: int, value: float) -> None:
        """The magnitude; a negative number counts as its magnitude."""
        binding, state = self._single(handle)
        state.max_force = abs(_finite(value, "a maximum force"))
        write_force_limit(binding, state, self._sim.model)

    def force(self, handle: int) -> float:
        """Motor force along the joint's +z on its child, mean over the last pass; 0 when stopped or not driven.

        Averaging costs a stop after every physics step: in a scene without position controllers it begins with the
        first call of a run, which itself is answered with the force of the last step.
        """
        binding, state = self._single(handle)
        self._average_force = True
        if binding.out < 0 or self._stepper is None or self._sim.pass_count == 0:
            return 0.0
        if rule_of(binding, state) in (Rule.FREE, Rule.KINEMATIC):
            return 0.0
        value = float(self._stepper.mean_force[binding.out]) * binding.gear
        model = self._sim.model
        if binding.element == "joint" and model.jnt_actfrclimited[binding.id]:
            low, high = model.jnt_actfrcrange[binding.id].tolist()
            value = min(max(value, low), high)
        return value

    def mode(self, handle: int) -> JointMode:
        """Of any joint, spherical ones too."""
        return self._any(handle)[1].mode

    def set_mode(self, handle: int, mode: JointMode) -> None:
        """Leaving force mode freezes the joint where it is; entering it, the motor and its targets count again."""
        state = self._any(handle)[1]
        if mode != state.mode:
            state.mode = JointMode(mode)
            self._apply(handle)
            self._sim.changed()

    def joint_type(self, handle: int) -> int:
        """10 revolute, 11 prismatic, 12 spherical."""
        return JOINT_TYPES[self._any(handle)[0].kind]

    def interval(self, handle: int) -> tuple[bool, float, float]:
        """(cyclic, minimum, range): -pi and 2 pi when cyclic, -1e9 and 2e9 for a joint without limits."""
        binding, state = self._any(handle)
        model = self._sim.model
        if (state.cyclic and binding.kind == "hinge") or binding.kind == "ball":
            return True, -math.pi, 2 * math.pi
        if binding.element == "tendon":
            limited, (low, high) = model.tendon_limited[binding.id], model.tendon_range[binding.id].tolist()
        else:
            limited, (low, high) = model.jnt_limited[binding.id], model.jnt_range[binding.id].tolist()
        return (False, low + state.offset, high - low) if limited else (False, -1e9, 2e9)

    def set_interval(self, handle: int, cyclic: bool, minimum: float, extent: float) -> None:
        """Limits of a hinge, slide or tendon joint; a range below 0 counts as none."""
        binding, state = self._single(handle)
        low = _finite(minimum, "an interval's minimum") - state.offset
        high = low + max(0.0, _finite(extent, "an interval's range"))
        state.cyclic = bool(cyclic) and binding.kind == "hinge"
        model = self._sim.model
        limited, ranges = (
            (model.tendon_limited, model.tendon_range)
            if binding.element == "tendon"
            else (model.jnt_limited, model.jnt_range)
        )
        limited[binding.id] = not state.cyclic
        if not state.cyclic:
            ranges[binding.id] = (low, high)
        self._rebuild()
        self._sim.changed()

    def matrix(self, handle: int) -> list[float]:
        """What the joint value does to the moving frame: 12 numbers, row-major 3 x 4."""
        binding, _ = self._any(handle)
        if binding.kind == "ball":
            address = binding.qpos
            return matrix12(
                ((0.0, 0.0, 0.0), normalised(self._sim.data.qpos[address : address + 4].tolist()))
            )
        value = self.position(handle)
        if binding.kind == "slide":
            return matrix12(((0.0, 0.0, value), NO_TURN))
        return matrix12(((0.0, 0.0, 0.0), about((0.0, 0.0, 1.0), value)))

    def quaternion(self, handle: int) -> list[float]:
        """The turn of the moving frame against the fixed one, [x, y, z, w]; of any joint."""
        binding, _ = self._any(handle)
        if binding.kind == "ball":
            return xyzw_from_wxyz(normalised(self._sim.data.qpos[binding.qpos : binding.qpos + 4].tolist()))
        angle = self.position(handle) if binding.kind == "hinge" else 0.0
        return xyzw_from_wxyz(about((0.0, 0.0, 1.0), angle))

    def set_spherical_matrix(self, handle: int, matrix: Sequence[float]) -> None:
        """12 numbers as above, the translation is ignored. Raises CommandError for other joints."""
        binding, _ = self._any(handle)
        if binding.kind != "ball":
            raise CommandError(f"'{binding.name}' is not spherical; set its position instead")
        if len(matrix) != 12 or not all(math.isfinite(v) for v in matrix):
            raise CommandError("a joint matrix is 12 finite numbers, row-major 3 x 4")
        data = self._sim.data
        data.qpos[binding.qpos : binding.qpos + 4] = _quat_of_rows(matrix)
        data.qvel[binding.dof : binding.dof + 3] = 0.0
        self._sim.changed()

    def get_parameter(self, handle: int, parameter: int) -> float | int:
        """`sim_jointintparam_*` / `sim_jointfloatparam_*` by number. Raises CommandError listing the known ones."""
        if parameter not in READ:
            raise CommandError(f"joint parameter {parameter} is not known; known: {describe(READ)}")
        return READ[parameter][1](self, handle)

    def set_parameter(self, handle: int, parameter: int, value: float) -> None:
        """Raises CommandError listing those that can be set."""
        if parameter not in WRITE:
            raise CommandError(
                f"joint parameter {parameter} cannot be set; those that can: {describe(WRITE)}"
            )
        WRITE[parameter][1](self, handle, _finite(value, WRITE[parameter][0]))

    def state(self, handle: int) -> JointState:
        """The settings of a joint that has a single value; to be changed through `change` only."""
        return self._single(handle)[1]

    def change(self, handle: int, **settings: float | bool) -> None:
        """Change settings by field name (motor, control_loop, lock, p, i, d, upper_velocity) and act on them."""
        _, state = self._single(handle)
        for name, value in settings.items():
            setattr(state, name, value)
        state.motor_was_set |= "motor" in settings
        self._apply(handle)

    def _any(self, handle: int) -> tuple[Binding, JointState]:
        try:
            return self._bindings[handle], self._states[handle]
        except KeyError:
            self._sim.scene.get_kind(handle, ObjectKind.JOINT)
            raise

    def _single(self, handle: int) -> tuple[Binding, JointState]:
        pair = self._any(handle)
        if pair[0].kind == "ball":
            raise CommandError(
                f"'{pair[0].name}' is a spherical joint, which has no single value; use its matrix"
            )
        return pair

    def _raw_position(self, binding: Binding) -> float:
        if binding.element == "tendon":
            self._sim.refresh()
            return float(self._sim.data.ten_length[binding.id])
        return float(self._sim.data.qpos[binding.qpos])

    def _apply(self, handle: int, *, rebuild: bool = True) -> None:
        """Act on changed settings."""
        binding, state = self._bindings[handle], self._states[handle]
        rule = rule_of(binding, state)
        if rule in (Rule.HOLD, Rule.KINEMATIC) and rebuild:
            state.held = self._raw_position(binding) + state.offset
        write_actuator(binding, state, rule, self._sim.model, self._sim.data)
        if binding.element == "joint":
            self._write_gravcomp(binding.body)
        if rebuild:
            self._rebuild()

    def _write_gravcomp(self, body: int) -> None:
        """No compensation for a body with a joint whose motor was switched off: it would float."""
        here = [b for b in self._bindings.values() if b.body == body and b.element == "joint"]
        states = [self._states[b.handle] for b in here]
        falls = any(s.motor_was_set and s.mode == JointMode.FORCE and not s.motor for s in states)
        self._sim.model.body_gravcomp[body] = 0.0 if falls else here[0].gravcomp

    def _rebuild(self) -> None:
        """Targets of the arrays are stale: make a new stepper before the next step, with the old one's memory."""
        if self._stepper is not None:
            earlier, self._stepper = self._stepper, self._make_stepper()
            self._stepper.adopt(earlier)

    def _current_stepper(self) -> Stepper:
        if self._stepper is None:
            self._stepper = self._make_stepper()
        return self._stepper

    def _make_stepper(self) -> Stepper:
        pairs = ((binding, self._states[handle]) for handle, binding in self._bindings.items())
        return Stepper(self._sim.model, self._sim.data, [(b, s, rule_of(b, s)) for b, s in pairs])


def _finite(value: float, what: str) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise CommandError(f"{what} must be a finite number, not {number}")
    return number


def _wrapped(angle: float) -> float:
    """The angle in -pi..pi."""
    return angle if -math.pi <= angle <= math.pi else math.remainder(angle, 2 * math.pi)


def _quat_of_rows(matrix: Sequence[float]) -> Quaternion:
    rows = np.array(matrix, dtype=float).reshape(3, 4)[:, :3]
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rows.flatten())
    return normalised(quat.tolist())
