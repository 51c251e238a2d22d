"""Pick and place: a UR5 grasps a cube and puts it on a mark.

The agent moves the target of the arm's inverse kinematics, and opens or closes the gripper. Reward: minus the distance
in metres between gripper and cube, minus twice the distance between cube and mark; 10 when the cube lies on the mark,
which ends the episode.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from simx_client.gym.actions import Increment
from simx_client.gym.task import State, Task
from simx_client.randomization import Uniform

TIP, CUBE, MARK = "UR5_tip.position", "Cube.position", "Mark.position"

START = tuple(math.radians(angle) for angle in (110.0, 15.0, 65.0, 10.0, -90.0, 20.0))
"""Joint angles: the gripper points down, 0.3 m above the floor."""

INCREMENT = 0.02
"""Way in metres that an action of 1 moves the gripper along an axis within a step of 50 ms."""

LOW, HIGH = (-0.35, -0.15, 0.02), (0.0, 0.3, 0.4)
"""Range of the gripper's target in the world in metres."""

NEAR = 0.03
"""Distance in metres at which the cube lies on the mark."""

HALF_CUBE = 0.025
"""Half of the cube's side in metres."""

_ON_FLOOR = HALF_CUBE + 0.005


def placed(now: State) -> bool:
    """Return whether the cube lies on the floor at the mark, and the gripper has left it."""
    way = now[CUBE] - now[MARK]
    is_there = math.hypot(way[0], way[1]) < NEAR and now[CUBE][2] < _ON_FLOOR
    return is_there and float(np.linalg.norm(now[TIP] - now[CUBE])) > 2 * HALF_CUBE


def _reward(now: State) -> float:
    way = float(np.linalg.norm(now[TIP] - now[CUBE])) + 2 * float(np.linalg.norm(now[CUBE] - now[MARK]))
    return 10.0 * placed(now) - way


def _info(now: State) -> dict[str, Any]:
    return {"is_success": placed(now)}


TASK = Task(
    scene="pick_place",
    observations=[TIP, CUBE, MARK, "RG2_openCloseJoint.position", "RG2_openCloseJoint.velocity"],
    actions={
        "UR5_target.position": Increment(INCREMENT, LOW, HIGH),
        "RG2_open.int_signal": (0.0, 1.0),
    },
    start={
        **{f"UR5_joint{number + 1}.position": angle for number, angle in enumerate(START)},
        **{f"UR5_joint{number + 1}.target_position": angle for number, angle in enumerate(START)},
        "UR5_target.position in UR5_tip": (0.0, 0.0, 0.0),
        "UR5_target.quaternion in UR5_tip": (0.0, 0.0, 0.0, 1.0),
        "RG2_open.int_signal": 1.0,
        "Cube.position": Uniform((-0.3, -0.08, HALF_CUBE), (-0.15, 0.05, HALF_CUBE)),
        "Mark.position": Uniform((-0.3, 0.15, 0.001), (-0.15, 0.25, 0.001)),
    },
    reward=_reward,
    done=placed,
    info=_info,
    camera="observer",
)
