"""Jitter: the fastest part of a robot that nobody commands."""

from __future__ import annotations

import mujoco
import numpy as np

from bench.motion.opened import Running


def jitter(robot: Running, settle: float = 4.0, watch: float = 2.0) -> float:
    """Return the greatest speed, m/s, of any body that physics moves, after `settle` seconds, for `watch` seconds."""
    step = robot.world.simulation.time_step
    robot.step(round(settle / step))
    fastest = 0.0
    velocity = np.zeros(6)
    for _ in range(round(watch / step)):
        robot.step(1)
        model, data = robot.model, robot.data
        for body in range(1, model.nbody):
            if model.body_weldid[body] and model.body_invweight0[body, 0]:
                mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
                fastest = max(fastest, float(np.linalg.norm(velocity[3:])))
    return fastest
