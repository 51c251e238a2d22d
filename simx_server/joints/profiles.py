"""Joints outside force mode that move to a target position or velocity by a motion profile, as in CoppeliaSim 4."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco

from simx_server.errors import CommandError
from simx_server.motion_profiles import Goal, Limits, Profile, State

from .servo import Entry, Rule
from .state import Binding, JointState


class Profiles:
    """The joints of one model that a profile moves; their states hold the profiles and their times."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        self._step = model.opt.timestep
        self._moving = [
            (binding, state, state.motion, _limits(model, binding.id))
            for binding, state, rule in entries
            if rule == Rule.PROFILE and state.motion is not None
        ]
        for binding, state, motion, _ in self._moving:
            # Contacts of the first physics step must feel the velocity too.
            data.qvel[binding.dof] = motion.at(state.motion_time).velocity[0]

    def __bool__(self) -> bool:
        return bool(self._moving)

    def advance(self, data: mujoco.MjData) -> None:
        """Move each joint on by a physics step; at a limit of its interval it stays."""
        for binding, state, motion, (low, high) in self._moving:
            before = min(max(motion.at(state.motion_time).position[0], low), high)
            state.motion_time += self._step
            after = min(max(motion.at(state.motion_time).position[0], low), high)
            data.qpos[binding.qpos] = after
            data.qvel[binding.dof] = (after - before) / self._step


def start(binding: Binding, state: JointState, model: mujoco.MjModel, present: float, goal: Goal) -> None:
    """Let a joint move to a goal from where it is, with the velocity that it has.

    Args:
        present: its position in the model.
        goal: a position in the model, or None and a velocity.

    Raises:
        CommandError: it has no limits of velocity and acceleration, or no motion is possible within them.
    """
    if state.acceleration <= 0 or state.upper_velocity <= 0:
        raise CommandError(
            f"'{binding.name}' moves by a profile outside force mode, but has no greatest acceleration; give it with "
            "the target, as {velocity, acceleration, jerk}, or annotate the joint with upper_acceleration"
        )
    first = State([present], [0.0], [0.0])
    if state.motion is not None:
        now = state.motion.at(state.motion_time)
        low, high = _limits(model, binding.id)
        if low < now.position[0] < high:
            first = State([present], now.velocity, now.acceleration)
    limits = Limits([state.upper_velocity], [state.acceleration], [state.jerk])
    if goal.position is None:
        limits = Limits([max(abs(goal.velocity[0]), state.upper_velocity)], limits.acceleration, limits.jerk)
    state.motion, state.motion_time = Profile(first, goal, limits), 0.0


def limit(binding: Binding, state: JointState, settings: Sequence[float]) -> None:
    """Set the greatest velocity, acceleration and jerk of a joint, as many as given; those not above 0 stay.

    Raises:
        CommandError: there are too many numbers, or one is not finite.
    """
    names = ("upper_velocity", "acceleration", "jerk")
    if len(settings) > len(names) or not all(math.isfinite(each) for each in settings):
        raise CommandError(
            f"the motion of '{binding.name}' is limited by up to three finite numbers: velocity, acceleration, jerk"
        )
    for name, value in zip(names, settings, strict=False):
        if value > 0:
            setattr(state, name, float(value))


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    if not model.jnt_limited[joint]:
        return -math.inf, math.inf
    low, high = model.jnt_range[joint].tolist()
    return low, high
