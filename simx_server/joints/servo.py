"""Write a joint's settings into the model: gain, bias and force limit of its actuator, or its motor."""

from __future__ import annotations

from enum import Enum

import mujoco
import numpy as np

from .state import UNLIMITED, VREP_DYNAMICS_STEP, Binding, JointMode, JointState, Native


class Rule(Enum):
    """The rule by which a joint moves during a simulation step."""

    FREE = "nothing"
    SPRING = "a spring and damper towards the target"
    STIFF_SPRING = "the same, stiffer than physics steps resolve: its motor, with the spring's force"
    VELOCITY = "its motor keeps a constant velocity"
    POSITION = "its motor keeps the velocity that V-REP's position controller commands in each physics step"
    HOLD = "the same, towards the position where it stopped"
    KINEMATIC = "nothing moves it"
    MOTION = "it moves at its target velocity whatever is in the way"
    DEPENDENT = "it follows its master"
    PROFILE = "it moves by a motion profile, whatever is in the way"


UNDRIVEN = (Rule.FREE, Rule.KINEMATIC, Rule.MOTION, Rule.DEPENDENT, Rule.PROFILE)
"""Rules under which the motor does nothing."""

MOST_VELOCITY = 1e4
"""rad/s or m/s, beyond what any joint reaches: a motor that wants this velocity always acts with its maximum force.

Commands are limited to it, since MuJoCo's solver would lose digits to greater numbers.
"""

_LEAST_FORCE = 1e-12
"""Maximum force in N or N m that stands for none: MuJoCo has no constraint for a friction loss of 0."""

_STIFFEST = 40.0
"""K h^2 / inertia from which on a spring is a motor. A free joint swings ever farther from 4 on; loops and what the
joint carries add to its least inertia, so that fingers of hands with 4.4 do not.
"""

_SOFTNESS = 1e-4
"""How soft a motor is: part of the inverse inertia of its joint. A load of 50 N m on a light joint, 5 rad/s^2 per
N m, costs it 1e-4 rad/s.
"""

_IMPEDANCE = (1.0 - _SOFTNESS, 1.0 - _SOFTNESS, 0.001, 0.5, 2.0)


def is_motor(binding: Binding, state: JointState, rule: Rule) -> bool:
    """Return whether V-REP's motor (`stepping/motors.py`) drives the joint, and not the file's own servo."""
    return rule in (Rule.VELOCITY, Rule.POSITION, Rule.HOLD, Rule.STIFF_SPRING) and state.rigid


def is_immovable(binding: Binding, rule: Rule) -> bool:
    """Return whether physics must not influence the joint's motion."""
    if rule == Rule.DEPENDENT:
        return binding.equality < 0
    return rule in (Rule.KINEMATIC, Rule.MOTION, Rule.PROFILE)


Entry = tuple[Binding, JointState, Rule]
"""A joint with its settings and the rule by which it moves."""


def rule_of(binding: Binding, state: JointState) -> Rule:
    """Return the rule that follows from the settings."""
    is_moved = state.motion is not None and state.mode != JointMode.FORCE
    if (state.inert or (state.fixed and not is_moved)) and binding.element == "joint":
        return Rule.KINEMATIC
    if binding.kind == "ball":
        return Rule.FREE if state.mode == JointMode.FORCE else Rule.KINEMATIC
    if state.mode != JointMode.FORCE:
        # A tendon has no position that could be held: only its motor can hold it.
        if binding.actuator >= 0 and (state.hybrid or binding.element == "tendon"):
            return Rule.POSITION
        if state.mode == JointMode.DEPENDENT and state.master >= 0:
            return Rule.DEPENDENT
        if is_moved:
            return Rule.PROFILE
        return Rule.MOTION if state.mode == JointMode.MOTION else Rule.KINEMATIC
    if not state.motor or binding.actuator < 0:
        return Rule.FREE
    if state.control_loop:
        if not state.spring:
            return Rule.POSITION
        return Rule.STIFF_SPRING if _is_stiff(binding, state) else Rule.SPRING
    if state.pushes:
        return Rule.VELOCITY
    return Rule.HOLD if state.lock and state.target_velocity == 0.0 else Rule.VELOCITY


def _is_stiff(binding: Binding, state: JointState) -> bool:
    """Return whether a spring of V-REP's throws its joint farther beyond the target in each dynamics step."""
    return state.rigid and state.k * VREP_DYNAMICS_STEP**2 > _STIFFEST * binding.inertia


def write_actuator(
    binding: Binding, state: JointState, rule: Rule, model: mujoco.MjModel, data: mujoco.MjData
) -> None:
    """Make the model's actuator act by the rule; constant commands are written here, once."""
    index = binding.actuator
    if index < 0:
        return
    is_driven = is_motor(binding, state, rule)
    _write_friction(binding, is_driven, model)
    if rule == Rule.SPRING:
        _write_spring(binding, state, model, data)
    elif rule in UNDRIVEN:
        data.ctrl[binding.ctrl] = 0.0
        if binding.native == Native.MOTOR and rule == Rule.FREE:
            # A torque motor at control 0 exerts no force: the file's own actuator may stay.
            _restore(binding, model)
            return
        model.actuator_gainprm[index] = 0.0
        model.actuator_biasprm[index] = 0.0
    else:
        if not is_driven:
            _restore(binding, model)
        else:
            _write_affine(index, 0.0, (0.0, 0.0, 0.0), model)
        # The file's control range was in other units (torque, angle).
        model.actuator_ctrllimited[index] = 0
        if rule == Rule.VELOCITY:
            data.ctrl[binding.ctrl] = commanded_velocity(binding, state) * binding.gear
    write_force_limit(binding, state, rule, model)


def commanded_velocity(binding: Binding, state: JointState) -> float:
    """Return the target velocity; a tendon's is limited to its upper velocity, the limit of its transmission.

    A joint's is not limited: scripts command a torque by a huge velocity under a force limit.
    """
    if state.pushes and binding.element != "tendon":
        return MOST_VELOCITY if state.pushes > 0 else -MOST_VELOCITY
    most = min(state.upper_velocity, MOST_VELOCITY) if binding.element == "tendon" else MOST_VELOCITY
    return min(max(state.target_velocity, -most), most)


def spring_control(binding: Binding, state: JointState) -> float:
    """Return the control that makes a spring's actuator pull towards the target."""
    return (state.target_position - state.offset) * binding.gear


def write_force_limit(binding: Binding, state: JointState, rule: Rule, model: mujoco.MjModel) -> None:
    """Write the maximum force, converted to the actuator's end of the gear; that of a motor to its constraint."""
    index = binding.actuator
    if index < 0:
        return
    if is_motor(binding, state, rule):
        model.actuator_forcelimited[index] = False
        write_motor_force(binding, state.max_force, model)
        return
    if state.max_force == binding.force_limit and binding.native in (Native.POSITION, Native.VELOCITY):
        model.actuator_forcelimited[index] = binding.force_limited
        model.actuator_forcerange[index] = binding.force_range
        return
    limited = state.max_force < UNLIMITED
    model.actuator_forcelimited[index] = limited
    if limited:
        limit = state.max_force / abs(binding.gear)
        model.actuator_forcerange[index] = (-limit, limit)


def write_motor_force(binding: Binding, most: float, model: mujoco.MjModel) -> None:
    """Write the maximum force of a motor, N or N m; a limit of the joint itself in the file holds too.

    A motor below the joint's own friction becomes a constraint with the force of the friction (`stepping/motors.py`).
    """
    most = max(most, binding.friction)
    if binding.element == "tendon":
        model.tendon_frictionloss[binding.id] = max(most, _LEAST_FORCE)
        return
    if model.jnt_actfrclimited[binding.id]:
        most = min(most, float(np.abs(model.jnt_actfrcrange[binding.id]).max()))
    model.dof_frictionloss[binding.dof] = max(most, _LEAST_FORCE)


def _write_friction(binding: Binding, is_driven: bool, model: mujoco.MjModel) -> None:
    """Make the friction of a joint or tendon a motor's constraint, or again what the file says."""
    # `solref` has no meaning for a motor: `stepping/motors.py` writes the reference accelerations.
    impedance = _IMPEDANCE if is_driven else binding.friction_impedance
    if binding.element == "tendon":
        losses, at = model.tendon_frictionloss, binding.id
        model.tendon_solimp_fri[at] = impedance
    else:
        losses, at = model.dof_frictionloss, binding.dof
        model.dof_solimp[at] = impedance
    if not is_driven:
        losses[at] = binding.friction


def _write_spring(binding: Binding, state: JointState, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Write a spring: force = K (target - position) - C velocity, which is what a position actuator is."""
    if binding.native == Native.POSITION:
        _restore(binding, model)
    else:
        model.actuator_ctrllimited[binding.actuator] = 0
    if binding.native != Native.POSITION or (state.k, state.c) != binding.file_spring:
        gear = binding.gear * binding.gear
        _write_affine(binding.actuator, state.k / gear, (0.0, -state.k / gear, -state.c / gear), model)
    data.ctrl[binding.ctrl] = spring_control(binding, state)


def _write_affine(index: int, gain: float, bias: tuple[float, float, float], model: mujoco.MjModel) -> None:
    model.actuator_gaintype[index] = mujoco.mjtGain.mjGAIN_FIXED
    model.actuator_gainprm[index] = 0.0
    model.actuator_gainprm[index, 0] = gain
    model.actuator_biastype[index] = mujoco.mjtBias.mjBIAS_AFFINE
    model.actuator_biasprm[index] = 0.0
    model.actuator_biasprm[index, :3] = bias


def _restore(binding: Binding, model: mujoco.MjModel) -> None:
    index = binding.actuator
    model.actuator_gaintype[index] = binding.gain_type
    model.actuator_gainprm[index] = binding.gain
    model.actuator_biastype[index] = binding.bias_type
    model.actuator_biasprm[index] = binding.bias
    model.actuator_ctrllimited[index] = binding.ctrl_limited
    model.actuator_forcelimited[index] = binding.force_limited
    model.actuator_forcerange[index] = binding.force_range
