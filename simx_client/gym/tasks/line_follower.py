"""Line follower: a robot with two wheels and three light sensors drives along a closed black line.

Reward: metres along the line within the step. The episode ends when the robot is off the line.
"""

from __future__ import annotations

import math
from typing import Any

from simx_client.gym.task import State, Task
from simx_client.randomization import Uniform

SENSORS = ("LeftSensor", "MiddleSensor", "RightSensor")
ROBOT = "LineTracer.position"

MIDDLE = (0.084, 0.7)
"""Middle of the line in metres; `radius` is measured from it."""

MOST_OFFSET = 0.08
"""Largest distance between robot and line in metres: it then sees the line no more."""

SPEED = 8.0
"""Largest velocity of a wheel in rad/s: 0.22 m/s on the floor."""


def radius(bearing: float) -> float:
    """Return the distance of the line from its middle in metres, in a direction in radians."""
    return 0.62 + 0.08 * math.cos(4 * bearing)


def _polar(position: Any) -> tuple[float, float]:
    x, y = position[0] - MIDDLE[0], position[1] - MIDDLE[1]
    return math.hypot(x, y), math.atan2(y, x)


def offset(position: Any) -> float:
    """Return the distance between a position and the line in metres, along the radius."""
    distance, bearing = _polar(position)
    return abs(distance - radius(bearing))


def progress(before: Any, after: Any) -> float:
    """Return the way along the line between two positions in metres, counterclockwise."""
    _, bearing = _polar(before)
    _, then = _polar(after)
    turned = math.remainder(then - bearing, 2 * math.pi)
    slope = -0.32 * math.sin(4 * bearing)  # the derivative of the radius
    return turned * math.hypot(radius(bearing), slope)


def _reward(now: State) -> float:
    return 0.0 if now.before is None else progress(now.before[ROBOT], now[ROBOT])


def _is_over(now: State) -> bool:
    return offset(now[ROBOT]) > MOST_OFFSET


def _info(now: State) -> dict[str, Any]:
    return {"offset": offset(now[ROBOT])}


TASK = Task(
    scene="line_follower",
    observations=[f"{sensor}.brightness" for sensor in SENSORS],
    actions={
        "DynamicLeftJoint.target_velocity": (-SPEED, SPEED),
        "DynamicRightJoint.target_velocity": (-SPEED, SPEED),
    },
    start={"LineTracer.position": Uniform((-0.01, -0.01, 0.0275), (0.01, 0.01, 0.0275))},
    reward=_reward,
    done=_is_over,
    measures=[ROBOT],
    info=_info,
    camera="observer",
)
