"""The LineTracer follows its track by what its three eyes detect."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bench.motion.opened import running

_MIDDLE = (0.084, 0.7)
"""Of the track, m: its radius is 0.62 + 0.08 cos(4 bearing)."""
_VELOCITY = 0.12 / 0.027
"""rad/s of the wheels, of 27 mm."""


@dataclass(frozen=True)
class Line:
    """How the LineTracer follows its line for 30 s."""

    farthest: float
    """Greatest distance of its base from the line, m."""
    way: float
    """Way along the track, as an angle about its middle, rad."""
    share: float


def follow() -> Line:
    """Turn away from the side whose eye sees the dark line, for 30 s."""
    with running("line_tracer") as one:
        world = one.world
        base = world.simulation.scene.get(one.handle("LineTracer")).body
        eyes = [one.handle(name) for name in ("LeftSensor", "MiddleSensor", "RightSensor")]
        wheels = [one.handle(name) for name in ("DynamicLeftJoint", "DynamicRightJoint")]
        farthest = way = 0.0
        before: float | None = None
        one.step(1)
        for _ in range(600):
            bright = [world.vision.read(eye).result(10)[0] for eye in eyes]
            for wheel, sees in zip(wheels, (bright[0], bright[2]), strict=True):
                world.simulation.joints.set_target_velocity(wheel, _VELOCITY * (1.0 if sees else 0.3))
            one.step(1)
            x, y = (one.data.xpos[base][:2] - _MIDDLE).tolist()
            bearing = math.atan2(y, x)
            farthest = max(farthest, abs(math.hypot(x, y) - (0.62 + 0.08 * math.cos(4 * bearing))))
            if before is not None:
                way += math.remainder(bearing - before, 2 * math.pi)
            before = bearing
        return Line(farthest, abs(way), one.share)
