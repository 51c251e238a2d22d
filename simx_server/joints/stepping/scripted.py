"""Joints whose motor a script controls: before each physics step it returns the velocity and the maximum force.

V-REP's joint callback: for a joint in force mode with motor and control loop on, in place of the position
controller.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco

from simx_server.joints.servo import MOST_VELOCITY, Entry, Rule, write_motor_force
from simx_server.joints.state import UNLIMITED

Ask = Callable[[dict[str, Any]], Mapping[str, Any] | None]
"""Receives the state of the joint; returns ``velocity`` (rad/s, m/s) and the maximum ``force`` (N m, N), or None."""


class ScriptedJoints:
    """The scripted joints of one model; positions and velocities are V-REP's, at the joint."""

    def __init__(self, model: mujoco.MjModel, entries: Sequence[Entry], asked: Mapping[int, Ask]) -> None:
        self._model = model
        self._joints = [
            (binding, state, asked[binding.handle])
            for binding, state, rule in entries
            if rule == Rule.POSITION and binding.handle in asked
        ]
        self._is_first = True

    def __bool__(self) -> bool:
        return bool(self._joints)

    def control(self, data: mujoco.MjData, index: int, count: int) -> None:
        """Set the motors before physics step `index` (from 0) of the `count` of a simulation step.

        Values that a script leaves out stay as they are.
        """
        for binding, state, ask in self._joints:
            is_tendon = binding.element == "tendon"
            position = (
                float(data.ten_length[binding.id] if is_tendon else data.qpos[binding.qpos]) + state.offset
            )
            is_limited, limits = (False, (0.0, 0.0)) if is_tendon else self._limits(binding.id)
            low, high = (float(limit) + state.offset for limit in limits)
            answer = ask(
                {
                    "first": self._is_first,
                    "revolute": binding.kind == "hinge",
                    "cyclic": state.cyclic or not is_limited,
                    "handle": binding.handle,
                    "lowLimit": low,
                    "highLimit": high,
                    "passCnt": index + 1,
                    "totalPasses": count,
                    "currentPos": position,
                    "targetPos": state.target_position,
                    "errorValue": state.target_position - position,
                    "effort": binding.reported_force(self._model, data.actuator_force),
                    "dynStepSize": float(self._model.opt.timestep),
                    "targetVel": state.target_velocity,
                    "maxForce": state.max_force,
                    "velUpperLimit": state.upper_velocity,
                }
            )
            if answer is None:
                continue
            velocity = number(answer.get("velocity", answer.get("vel")))
            if velocity is not None:
                data.ctrl[binding.ctrl] = min(max(velocity, -MOST_VELOCITY), MOST_VELOCITY) * binding.gear
            force = number(answer.get("force"))
            if force is not None:
                write_motor_force(binding, min(abs(force), UNLIMITED), self._model)
        self._is_first = False

    def _limits(self, joint: int) -> tuple[bool, Sequence[float]]:
        return bool(self._model.jnt_limited[joint]), self._model.jnt_range[joint]


def number(value: Any) -> float | None:
    """Return a script's number; None for anything that cannot be a force or velocity."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if abs(value) < float("inf") else None
