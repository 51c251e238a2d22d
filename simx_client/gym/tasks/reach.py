"""Reach: a UR5 brings its hand camera over a ball that lies elsewhere in each episode.

Reward: minus the distance in metres between the ball and the point 0.35 m in front of the camera.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from simx_client.gym.actions import Increment
from simx_client.gym.task import State, Task
from simx_client.randomization import Uniform

JOINTS = tuple(f"UR5_joint{number}" for number in range(1, 7))
BALL = "Target.position in kinect_rgb"

START = tuple(math.radians(angle) for angle in (90.0, -45.0, 90.0, 0.0, -100.0, 0.0))
"""Joint angles from which the camera sees the ball; the tutorial's."""

REACH = 0.9
"""Largest angle in radians between a joint's target and its start: within it the arm does not meet itself."""

INCREMENT = 0.05
"""Angle in radians by which an action of 1 moves a joint's target within a step of 50 ms."""

HEIGHT = 0.35
"""Wanted distance between camera and ball in metres: the gripper's fingers stay clear of the ball."""

BALL_LOW, BALL_HIGH = (-0.55, -0.15, 0.075), (-0.35, 0.12, 0.075)
"""Range of the ball's position in the world in metres: reachable, and free of the loose solids."""


def distance(ball: Any) -> float:
    """Return the distance in metres between the ball and its goal, both in the camera's frame."""
    return float(np.linalg.norm(np.asarray(ball) - (0.0, 0.0, HEIGHT)))


def _reward(now: State) -> float:
    return -distance(now[BALL])


def _info(now: State) -> dict[str, Any]:
    return {"distance": distance(now[BALL])}


TASK = Task(
    scene="reach",
    observations=[*(f"{joint}.position" for joint in JOINTS), BALL],
    actions={
        f"{joint}.target_position": Increment(INCREMENT, angle - REACH, angle + REACH)
        for joint, angle in zip(JOINTS, START, strict=True)
    },
    start={
        **{f"{joint}.position": angle for joint, angle in zip(JOINTS, START, strict=True)},
        **{f"{joint}.target_position": angle for joint, angle in zip(JOINTS, START, strict=True)},
        "Target.position": Uniform(BALL_LOW, BALL_HIGH),
    },
    reward=_reward,
    info=_info,
    camera="observer",
)
