"""Springs that are too stiff for their joints' inertia: as in V-REP, a motor moves the joint, with the spring's force.

V-REP's spring and damper is a motor at the joint's target velocity, towards the target. Its maximum force is that of
the spring in this dynamics step. So a spring of 1e6 N m/rad on a leg of 0.1 g moves it no faster than that. As a mere
force it would throw the leg beyond the target in one physics step, each time farther. Unlike V-REP's, this motor
stops at the target and does not go past it and back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.servo import MOST_VELOCITY, Entry, Rule, write_motor_force


class StiffSprings:
    """The springs of one model that act by motors, which `motors.py` puts into the physics step."""

    def __init__(self, model: mujoco.MjModel, entries: Sequence[Entry]) -> None:
        self._model = model
        self._springs = [(binding, state) for binding, state, rule in entries if rule == Rule.STIFF_SPRING]

    def __bool__(self) -> bool:
        return bool(self._springs)

    def control(self, data: mujoco.MjData) -> None:
        """Set the command and the maximum force of each motor for the next physics step."""
        step = self._model.opt.timestep
        for binding, state in self._springs:
            error = state.target_position - state.offset - float(data.qpos[binding.qpos])
            if state.cyclic:
                error = math.remainder(error, 2 * math.pi)
            force = state.k * error - state.c * float(data.qvel[binding.dof])
            most = min(abs(state.target_velocity), MOST_VELOCITY)
            data.ctrl[binding.ctrl] = float(np.clip(error / step, -most, most)) * binding.gear
            write_motor_force(binding, min(abs(force), state.max_force), self._model)
