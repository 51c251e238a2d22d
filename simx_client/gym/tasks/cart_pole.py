"""Cart-pole: a cart is pushed so that its pole stays upright.

Reward: 1 for each step of 20 ms. The episode ends when the pole leans by more than 12 degrees or the cart is more than
2.4 m off the middle, as in Gymnasium's own cart-pole; the force is continuous.
"""

from __future__ import annotations

import math
from typing import Any

from simx_client.gym.task import State, Task
from simx_client.randomization import Uniform

FORCE = 10.0
"""Largest force on the cart in N."""

MOST_ANGLE = math.radians(12.0)
MOST_OFFSET = 2.4
"""Largest distance of the cart from the middle in metres."""

_TILT = 0.05
"""Largest angle of the pole at the start in radians."""


def _is_over(now: State) -> Any:
    return (abs(now["pole_joint.position"]) > MOST_ANGLE) | (abs(now["action.position"]) > MOST_OFFSET)


def _reward(now: State) -> float:
    return 1.0


TASK = Task(
    scene="cart_pole",
    observations=["action.position", "action.velocity", "pole_joint.position", "pole_joint.velocity"],
    actions={"action.force": (-FORCE, FORCE)},
    start={
        "action.force": 0.0,
        "action.position": Uniform(-_TILT, _TILT),
        "pole_joint.position": Uniform(-_TILT, _TILT),
    },
    reward=_reward,
    done=_is_over,
    vectorized=True,
    time_step=0.02,
    camera="viewer",
)
