"""The joints of one scene and the operations for callers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from simx_server.errors import CommandError
from simx_server.motion_profiles import Goal
from simx_server.scene.poses.frames import matrix12
from simx_server.scene.poses.joint_chain import joint_separation
from simx_server.scene.poses.poses import Pose, Quaternion

from . import profiles
from .intrinsic import intrinsic_pose, quat_of_matrix, spherical_pose, spherical_value
from .machine import Machine, Position
from .servo import UNDRIVEN, Rule, rule_of, write_force_limit
from .state import Binding, JointMode, JointState, Request

JOINT_TYPES = {"hinge": 10, "slide": 11, "ball": 12}
"""`sim_joint_revolute_subtype`, `..._prismatic_subtype`, `..._spherical_subtype`."""


class Joints(Machine):
    """All joints of the loaded scene, by handle.

    Every method raises UnknownHandle, WrongKind for other objects, and CommandError for a spherical joint where a
    single number is meant, or for a number that is not finite.
    """

    def position(self, handle: int) -> float:
        """Return the angle (rad) or displacement (m).

        A cyclic joint returns -pi..pi, a tendon joint its length plus its offset.
        """
        if (place := self._positions.get(handle)) is not None:
            return position_in(*place)
        binding, state = self._single(handle)
        if binding.element == "joint":
            numbers, position = self._sim.data.qpos.data.cast("B").cast("d"), _position(binding, state)
            self._positions[handle] = numbers, position
            self.places_version += 1
            return position_in(numbers, position)
        value = self._raw_position(binding) + state.offset
        return _wrapped(value) if _is_cyclic(binding, state) else value

    def present_positions(self) -> memoryview[float]:
        """Return `qpos` itself, for `known_places`; it is the same until `places_version` changes."""
        return self._sim.data.qpos.data.cast("B").cast("d")

    def copied_positions(self) -> memoryview[float]:
        """Return a copy of `qpos`, for `known_places`."""
        return self._sim.data.qpos.copy().data.cast("B").cast("d")

    def known_places(self, handles: Iterable[int]) -> dict[int, Position]:
        """Return where the positions of these joints are, for `position_in`, as far as it is known.

        It stays so until `places_version` changes.
        """
        places = ((handle, self._positions.get(handle)) for handle in handles)
        return {handle: place[1] for handle, place in places if place is not None}

    def set_position(self, handle: int, value: float) -> None:
        """Put the joint there at once (clamped to its interval; cyclic: wrapped to -pi..pi), velocity zero.

        In force mode a controller drives it back to its target, as in V-REP. A dependent joint goes where its
        master wants it. In hybrid operation the motor drives the joint there; in a stopped simulation the position
        is set too.

        Raises:
            CommandError: the joint is a tendon joint in force mode.
        """
        binding, state = self._single(handle)
        value = finite(value, "a joint position")
        self._end_motion(handle)
        cyclic, least, extent = self.interval(handle)
        value = _wrapped(value) if cyclic else min(max(value, least), least + extent)
        rule = rule_of(binding, state)
        if rule == Rule.POSITION and state.mode != JointMode.FORCE:
            self._retarget(binding, state, value)
            if self._sim.step_count > 0 or binding.element == "tendon":
                return
        if binding.element == "tendon":
            raise CommandError(
                f"'{binding.name}' is moved through its tendon; give it a target position or velocity"
            )
        if rule == Rule.DEPENDENT:
            self._place(handle, self._follow)
        else:
            state.held = value
            self._place(handle, lambda: self._write_position(binding, value))
        if rule in (Rule.KINEMATIC, Rule.MOTION, Rule.HOLD):
            self._rebuild()

    def velocity(self, handle: int) -> float:
        """Return the velocity over the last simulation step, rad/s or m/s; 0 when stopped.

        As V-REP measures it: from the difference of two positions.
        """
        return self._measured.velocity(self._single(handle)[0])

    def target_position(self, handle: int) -> float:
        """Return the target position, rad or m."""
        return self._single(handle)[1].target_position

    def set_target_position(self, handle: int, value: float) -> None:
        """Set the position controller's target; a joint without annotation is switched to it (and on).

        In hybrid operation the motor goes there until a position is set, as inverse kinematics does in each
        simulation step. A joint outside force mode with a greatest acceleration moves there by a motion profile,
        a cyclic one the shorter way round.

        Raises:
            CommandError: the joint is neither in force mode nor in hybrid operation, and has no such acceleration.
        """
        if self.aim(handle, value):
            return
        binding, state = self._single(handle)
        value = finite(value, "a target position")
        if self._is_served(handle):
            state.target_position = value
            self.request(handle, Request(value))
            return
        if self._moves_by_profile(binding, state):
            present = self._raw_position(binding)
            goal = value
            if _is_cyclic(binding, state):
                value = _wrapped(value)
                goal = present + _wrapped(value - present)
            self._start_motion(handle, Goal([goal], [0.0]))
            state.target_position = value
            return
        if state.mode != JointMode.FORCE and not state.hybrid:
            raise CommandError(
                f"'{binding.name}' is in {state.mode.name.lower()} mode, which has no target position; "
                "set its position, or annotate it with mode=force or hybrid=yes, or with upper_acceleration"
            )
        is_cyclic = _is_cyclic(binding, state)
        self._retarget(binding, state, _wrapped(value) if is_cyclic else value)
        if not state.annotated and not (state.motor and state.control_loop):
            state.motor = state.control_loop = True
            self._apply(handle)
        elif not is_cyclic and (stepper := self.controllers.made) is not None:
            place = stepper.target_address(handle)
            if place is not None and rule_of(binding, state) == Rule.POSITION:
                self._targets[handle] = *place, state

    def aim(self, handle: int, value: float) -> bool:
        """Set the target where it is known to be a number of the position controllers; return whether it is."""
        place = self._targets.get(handle)
        if place is None or not math.isfinite(value):
            return False
        numbers, index, state = place
        state.target_position = numbers[index] = float(value)
        return True

    def target_velocity(self, handle: int) -> float:
        """Return the target velocity, rad/s or m/s."""
        return self._single(handle)[1].target_velocity

    def set_target_velocity(self, handle: int, value: float) -> None:
        """Set the target velocity, rad/s or m/s.

        It is stored in any mode; it moves the joint in motion mode, outside force mode if there is a greatest
        acceleration, and in force mode with motor on and control loop off. A joint without annotation is switched to
        that. At 0 with the lock on, the present position is held.
        """
        binding, state = self._single(handle)
        value = finite(value, "a target velocity")
        if self._is_served(handle):
            state.target_velocity = value
            self.request(handle, Request(None, value))
            return
        if self._moves_by_profile(binding, state):
            self._start_motion(handle, Goal(None, [value]))
            state.target_velocity = value
            return
        switches = not state.annotated and state.mode == JointMode.FORCE
        is_as_it_was = not switches or (state.motor and not state.control_loop)
        if value == state.target_velocity and is_as_it_was:
            return
        before = rule_of(binding, state)
        state.target_velocity = value
        _point(state, value)
        if switches:
            state.motor, state.control_loop = True, False
        stays = before == rule_of(binding, state) == Rule.VELOCITY
        self._apply(handle, rebuild=not stays)

    def limit_motion(self, handle: int, settings: Sequence[float]) -> None:
        """Set the greatest velocity, acceleration and jerk (rad/s or m/s, ...); those left out or not above 0 stay.

        Raises:
            CommandError: there are more than three numbers, or one is not finite.
        """
        binding, state = self._single(handle)
        profiles.limit(binding, state, settings)
        self._apply(handle)

    def max_force(self, handle: int) -> float:
        """Return the maximum force, N m or N; 1e9 means no limit."""
        return self._single(handle)[1].max_force

    def set_max_force(self, handle: int, value: float) -> None:
        """Set the maximum force; a negative number counts as its magnitude."""
        binding, state = self._single(handle)
        state.max_force = abs(finite(value, "a maximum force"))
        write_force_limit(binding, state, rule_of(binding, state), self._sim.model)

    def target_force(self, handle: int) -> float:
        """Return the maximum force with the sign of its direction."""
        state = self._single(handle)[1]
        return 0.0 - state.max_force if state.backwards else state.max_force

    def set_target_force(self, handle: int, value: float) -> None:
        """Set the maximum force with a sign: in force control the direction, else that of the target velocity."""
        self.set_max_force(handle, value)
        state = self.state(handle)
        before = state.pushes, state.target_velocity
        _point(state, value)
        if value * state.target_velocity < 0:
            state.target_velocity = -state.target_velocity
        if before != (state.pushes, state.target_velocity):
            self._apply(handle, rebuild=state.rigid)

    def force(self, handle: int) -> float:
        """Return the motor's force (N) or torque (N m), mean over the last simulation step, with V-REP's sign.

        The sign is the reverse of the force that the motor applies to the child along the joint's +z: a motor that
        pushes towards greater positions gives a negative number. A spring with damper gives the force of both. The
        result is 0 when the simulation is stopped or no motor acts.

        Averaging costs a stop after every physics step: in a scene without position controllers it starts with the
        first call of a run, which itself returns the force of the last physics step.
        """
        binding, state = self._single(handle)
        self.controllers.average_force()
        if binding.out < 0 or not self.controllers.have_run or self._sim.step_count == 0:
            return 0.0
        if rule_of(binding, state) in UNDRIVEN:
            return 0.0
        return binding.reported_force(self._sim.model, self.controllers.stepper.mean_force)

    def mode(self, handle: int) -> JointMode:
        """Return the mode of any joint, spherical ones too."""
        return self._any(handle)[1].mode

    def rule(self, handle: int) -> Rule:
        """Return the rule by which any joint moves."""
        return rule_of(*self._any(handle))

    def ik_weight(self, handle: int) -> float:
        """Return the weight of any joint in inverse kinematics, of spherical ones too."""
        return self._any(handle)[1].ik_weight

    def is_hybrid(self, handle: int) -> bool:
        """Return whether a motor drives the joint although its mode is not force."""
        state = self._any(handle)[1]
        return state.hybrid and state.mode != JointMode.FORCE

    def set_mode(self, handle: int, mode: JointMode) -> None:
        """Set the mode. Leaving force mode freezes the joint; entering it activates motor and targets again."""
        state = self._any(handle)[1]
        if mode != state.mode:
            state.mode, state.motion = JointMode(mode), None
            self._apply(handle)
            self._sim.changed()

    def joint_type(self, handle: int) -> int:
        """Return the type: 10 revolute, 11 prismatic, 12 spherical."""
        return JOINT_TYPES[self._any(handle)[0].kind]

    def interval(self, handle: int) -> tuple[bool, float, float]:
        """Return (cyclic, minimum, range): -pi and 2 pi when cyclic, -1e9 and 2e9 for a joint without limits."""
        binding, state = self._any(handle)
        model = self._sim.model
        if _is_cyclic(binding, state) or binding.kind == "ball":
            return True, -math.pi, 2 * math.pi
        if binding.element == "tendon":
            limited, (low, high) = model.tendon_limited[binding.id], model.tendon_range[binding.id].tolist()
        else:
            limited, (low, high) = model.jnt_limited[binding.id], model.jnt_range[binding.id].tolist()
        return (False, low + state.offset, high - low) if limited else (False, -1e9, 2e9)

    def set_interval(self, handle: int, cyclic: bool, minimum: float, extent: float) -> None:
        """Set the limits of a hinge, slide or tendon joint; a range below 0 counts as none."""
        binding, state = self._single(handle)
        low = finite(minimum, "an interval's minimum") - state.offset
        high = low + max(0.0, finite(extent, "an interval's range"))
        state.cyclic = bool(cyclic) and binding.kind == "hinge"
        self.forget_places()
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

    def intrinsic(self, handle: int) -> Pose:
        """Return the pose of any joint's moving frame in the fixed one, which follows from the joint value."""
        binding, state = self._any(handle)
        if binding.kind == "ball":
            return spherical_pose(binding, state, self._sim.data)
        return intrinsic_pose(binding, self.position(handle))

    def separation(self, handle: int) -> Pose:
        """Return how far the joint's parts are apart: the child's pose in the frame given by the joint values.

        MuJoCo's joints are exact, so this is the identity except for rounding.

        Raises:
            CommandError: the joint is a tendon joint.
        """
        binding, _ = self._any(handle)
        if binding.element == "tendon":
            raise CommandError(f"'{binding.name}' is driven through a tendon, which holds no parts together")
        self._sim.refresh()
        return joint_separation(self._sim, binding.body)

    def matrix(self, handle: int) -> list[float]:
        """Return `intrinsic` as 12 numbers, row-major 3 x 4."""
        return matrix12(self.intrinsic(handle))

    def set_spherical_matrix(self, handle: int, matrix: Sequence[float]) -> None:
        """Set a spherical joint to 12 numbers as above; the translation is ignored.

        Raises:
            CommandError: the joint is not spherical.
        """
        self._spherical(handle)
        if len(matrix) < 12 or not all(math.isfinite(v) for v in matrix):
            raise CommandError("a joint matrix is 12 finite numbers, row-major 3 x 4")
        self.set_spherical_rotation(handle, quat_of_matrix(matrix[:12]))

    def set_spherical_rotation(self, handle: int, quat_wxyz: Quaternion) -> None:
        """Set the rotation of a spherical joint, velocity zero.

        Raises:
            CommandError: the joint is not spherical.
        """
        _, state = self._spherical(handle)
        self.set_ball(handle, spherical_value(state, quat_wxyz))

    def set_ball(self, handle: int, value: Quaternion) -> None:
        """Set the value of a spherical joint as MuJoCo counts it, in its body's axes; velocity zero.

        Raises:
            CommandError: the joint is not spherical.
        """
        binding, state = self._spherical(handle)

        def turn() -> None:
            data = self._sim.data
            data.qpos[binding.qpos : binding.qpos + 4] = value
            data.qvel[binding.dof : binding.dof + 3] = 0.0

        self._place(handle, turn)
        if rule_of(binding, state) == Rule.KINEMATIC:
            self._rebuild()

    def state(self, handle: int) -> JointState:
        """Return the settings of a joint that has a single value; change them through `change` only."""
        return self._single(handle)[1]

    def spherical_state(self, handle: int) -> JointState:
        """Return the settings of a spherical joint.

        Raises:
            CommandError: the joint is not spherical.
        """
        return self._spherical(handle)[1]

    def change(self, handle: int, **settings: float | bool) -> None:
        """Change settings by field name (motor, control_loop, spring, lock, p, i, d, k, c, ...) and apply them."""
        _, state = self._single(handle)
        for name, value in settings.items():
            setattr(state, name, value)
        state.motor_was_set |= "motor" in settings
        self.forget_places()
        self._apply(handle)

    def is_coupled(self, handle: int) -> bool:
        """Return whether the model has the equality through which a dependent joint exchanges forces."""
        return self._single(handle)[0].equality >= 0

    def set_dependency(self, handle: int, **settings: float | int) -> None:
        """Change master (a handle, -1 for none), factor or shift of a joint in dependent mode; it moves at once.

        Raises:
            UnknownHandle, WrongKind: a handle is wrong.
            CommandError: another mode, a tendon, a circle of masters.
        """
        binding, state = self._single(handle)
        if state.mode != JointMode.DEPENDENT or binding.element != "joint":
            raise CommandError(
                f"'{binding.name}' is in {state.mode.name.lower()} mode; a joint that follows another is annotated "
                "mode=dependent"
            )
        above = int(settings.get("master", -1))
        if above != -1 and self._single(above)[0].element != "joint":
            raise CommandError(
                f"'{self._bindings[above].name}' is driven through a tendon and cannot be a master"
            )
        while above in self._states:
            if above == handle:
                raise CommandError(
                    f"'{binding.name}' cannot follow a joint that follows '{binding.name}' itself"
                )
            above = self._states[above].master
        for name, value in settings.items():
            setattr(state, name, value)
        self._apply(handle)
        self._place(handle, self._follow)

    def requests(self) -> list[tuple[int, Request]]:
        """Return the targets that scripts have to serve outside force mode, by handle."""
        return [
            (handle, state.request)
            for handle, state in self._states.items()
            if state.request is not None and self._is_served(handle)
        ]

    def request(self, handle: int, request: Request) -> None:
        """Have a script's call-back move a kinematic joint from the next simulation step on."""
        _, state = self._single(handle)
        state.request = request

    def _is_served(self, handle: int) -> bool:
        """Return whether a script's call-back serves the target of a joint, which is in kinematic mode."""
        return (
            handle in self._served
            and self._states[handle].mode == JointMode.PASSIVE
            and self._bindings[handle].element == "joint"
        )

    def moves_by_profile(self, handle: int) -> bool:
        """Return whether a target starts a motion profile: outside force mode, with a greatest acceleration."""
        return self._moves_by_profile(*self._single(handle))

    def _moves_by_profile(self, binding: Binding, state: JointState) -> bool:
        """Return whether a target starts a motion profile."""
        if state.acceleration <= 0 or binding.element != "joint" or state.mode == JointMode.FORCE:
            return False
        return rule_of(binding, state) in (Rule.KINEMATIC, Rule.PROFILE) and not state.inert

    def _start_motion(self, handle: int, goal: Goal) -> None:
        binding, state = self._single(handle)
        present = self._raw_position(binding)
        profiles.start(binding, state, self._sim.model, present, goal)
        self._apply(handle)
        self._sim.changed()

    def _end_motion(self, handle: int) -> None:
        state = self._states[handle]
        state.request = None
        if state.motion is not None:
            state.motion = None
            self._apply(handle)


def _position(binding: Binding, state: JointState) -> Position:
    return binding.qpos, state.offset, _is_cyclic(binding, state)


def position_in(numbers: memoryview[float], position: Position) -> float:
    """Return a joint's position from `qpos` or a copy of it."""
    index, offset, is_cyclic = position
    return _wrapped(numbers[index] + offset) if is_cyclic else numbers[index] + offset


def finite(value: float, what: str) -> float:
    """Return a number that must be finite. Raises CommandError."""
    number = float(value)
    if not math.isfinite(number):
        raise CommandError(f"{what} must be a finite number, not {number}")
    return number


def _point(state: JointState, direction: float) -> None:
    """Turn the maximum force to the sign of a number other than 0."""
    if direction:
        state.backwards = direction < 0
        if state.pushes:
            state.pushes = -1 if state.backwards else 1


def _is_cyclic(binding: Binding, state: JointState) -> bool:
    return state.cyclic and binding.kind == "hinge"


def _wrapped(angle: float) -> float:
    """Return the angle in -pi..pi; infinite values of diverged physics stay infinite."""
    if -math.pi <= angle <= math.pi or not math.isfinite(angle):
        return angle
    return math.remainder(angle, 2 * math.pi)
