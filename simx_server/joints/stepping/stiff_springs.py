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

from .indices import Columns


class StiffSprings:
    """The springs of one model that act by motors, which `motors.py` puts into the physics step."""

    def __init__(self, model: mujoco.MjModel, entries: Sequence[Entry]) -> None:
        self._model = model
        chosen = self._springs = [(b, s) for b, s, rule in entries if rule == Rule.STIFF_SPRING]
        self._k = np.array([s.k for _, s in chosen])
        self._c = np.array([s.c for _, s in chosen])
        self._target, self._force, self._velocity = np.zeros((3, len(chosen)))
        self.refresh()

    def __bool__(self) -> bool:
        return bool(self._springs)

    def refresh(self) -> None:
        """Take over the settings that change without new controllers; call it before physics steps."""
        for place, (_, state) in enumerate(self._springs):
            self._target[place] = state.target_position
            self._force[place] = state.max_force
            self._velocity[place] = state.target_velocity

    @property
    def columns(self) -> Columns:
        """Return the arrays by name, for the compiled form."""
        springs = self._springs
        return {
            "stiff.joint": np.array([b.id for b, _ in springs], dtype=np.intp),
            "stiff.qpos": np.array([b.qpos for b, _ in springs], dtype=np.intp),
            "stiff.dof": np.array([b.dof for b, _ in springs], dtype=np.intp),
            "stiff.ctrl": np.array([b.ctrl for b, _ in springs], dtype=np.intp),
            "stiff.gear": np.array([b.gear for b, _ in springs]),
            "stiff.cyclic": np.array([s.cyclic for _, s in springs], dtype=np.intp),
            "stiff.offset": np.array([s.offset for _, s in springs]),
            "stiff.friction": np.array([b.friction for b, _ in springs]),
            "stiff.target": self._target,
            "stiff.k": self._k,
            "stiff.c": self._c,
            "stiff.force": self._force,
            "stiff.velocity": self._velocity,
        }

    def control(self, data: mujoco.MjData) -> None:
        """Set the command and the maximum force of each motor for the next physics step."""
        step = self._model.opt.timestep
        settings = (self._k, self._c, self._target, self._force, self._velocity)
        for (binding, state), (k, c, target, most_force, velocity) in zip(
            self._springs, zip(*(each.tolist() for each in settings), strict=True), strict=True
        ):
            error = target - state.offset - float(data.qpos[binding.qpos])
            if state.cyclic and math.isfinite(error):
                error = math.remainder(error, 2 * math.pi)
            force = k * error - c * float(data.qvel[binding.dof])
            most = min(abs(velocity), MOST_VELOCITY)
            data.ctrl[binding.ctrl] = float(np.clip(error / step, -most, most)) * binding.gear
            write_motor_force(binding, min(abs(force), most_force), self._model)
