"""The geometry of Ackermann steering: angles of the steered wheels, and the speeds of the driven ones.

The base turns about a point on the line through the axle that is not steered. With a speed v and a turn rate w a wheel
at (x, y) from the middle of that axle moves with (v - w y, w x).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

STEEPEST = 0.75
"""Greatest mean steering angle, rad; a command that wants more turns as tightly as this."""


class Steer(NamedTuple):
    """A steered wheel."""

    handle: int
    x: float
    """Place before the axle that is not steered, metres."""

    y: float
    sign: float
    """1 if the joint turns to the left for greater positions, else -1."""


def limited(steers: Sequence[Steer], v: float, w: float) -> tuple[float, float]:
    """Return speed and turn rate that a car can have: no turn on the spot, and none tighter than its steering."""
    if not v:
        return 0.0, 0.0
    base = max(abs(steer.x) for steer in steers)
    most = abs(v) * math.tan(STEEPEST) / base
    return v, min(max(w, -most), most)


def angle(steer: Steer, v: float, w: float) -> float:
    """Return the position of a steering joint, rad."""
    return steer.sign * math.atan(w * steer.x / (v - w * steer.y)) if v else 0.0


def speed(x: float, y: float, v: float, w: float) -> float:
    """Return the speed of a steered wheel along its own direction, m/s."""
    along = v - w * y
    return math.copysign(math.hypot(along, w * x), along)
