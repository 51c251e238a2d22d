"""The Quadricopter: how far it sinks after the start, and how far from its target it comes to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.motion.opened import running


@dataclass(frozen=True)
class Hover:
    """How the Quadricopter flies."""

    dip: float
    """Greatest height that it loses after the start, m."""
    error: float
    """Distance from its target at rest, m."""
    arrival: float
    """Distance from a target that was moved by half a metre, after 20 s, m."""
    share: float


def hover() -> Hover:
    """Hover for 10 s, then fly half a metre aside."""
    with running("", "quadricopter") as one:
        scene = one.world.simulation.scene
        base, target = scene.get(one.handle("Quadricopter")), scene.get(one.handle("Quadricopter_target"))
        apart = one.data.xpos[base.body] - one.data.xpos[target.body]
        start = float(one.data.xpos[base.body][2])
        lowest = start
        for _ in range(200):
            one.step(1)
            lowest = min(lowest, float(one.data.xpos[base.body][2]))
        error = float(np.linalg.norm(one.data.xpos[base.body] - one.data.xpos[target.body] - apart))
        one.model.body_pos[target.body, 0] += 0.5
        one.world.simulation.changed()
        one.step(400)
        arrival = float(np.linalg.norm(one.data.xpos[base.body] - one.data.xpos[target.body] - apart))
        return Hover(start - lowest, error, arrival, one.share)
