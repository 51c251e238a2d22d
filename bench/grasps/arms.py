"""RLBench's arms: each carries a box in its gripper, its joints swing at up to 1 rad/s, then it holds the box."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .closing import Fingers
from .grippers import GRIPPERS
from .program import Program
from .trial import STEP, Held, summed_up

_MOTOR, _CONTROL_LOOP, _STATIC = 2000, 2001, 3003
_CUBOID, _RESPONDABLE = 0, 8

SIZE, MASS = 0.05, 0.2
"""Of the box, m and kg."""

FASTEST, PERIOD, SWINGING = 1.0, 4.0, 16.0
"""Greatest speed of the joints in rad/s, period and duration of their swing in s."""


@dataclass(frozen=True)
class Arm:
    """An arm with its gripper, a model of RLBench."""

    file: str
    """In RLBench's folder `robot_ttms`."""
    joints: tuple[str, ...]
    gripper: str
    """Of `GRIPPERS`."""


def _arm(file: str, name: str, joints: int, gripper: str) -> Arm:
    return Arm(file, tuple(f"{name}_joint{number}" for number in range(1, joints + 1)), gripper)


ARMS = {
    "Panda": _arm("panda.ttm", "Panda", 7, "Panda"),
    "UR5, Robotiq 85": _arm("ur5.ttm", "UR5", 6, "Robotiq 85"),
    "Jaco": _arm("jaco.ttm", "Jaco", 6, "Jaco"),
    "Mico": _arm("mico.ttm", "Mico", 6, "Mico"),
    "Sawyer, Baxter's gripper": _arm("sawyer.ttm", "Sawyer", 7, "Baxter"),
}


def swing(arm: Arm, robots: Path, *, seconds: float = 30.0) -> Held:
    """Let an arm carry a box of 200 g.

    Args:
        robots: RLBench's folder `robot_ttms`.
        seconds: how long the box is held at last.
    """
    gripper = GRIPPERS[arm.gripper]
    with Program() as program:
        program.call("loadModel", str(robots / arm.file))
        hand, joints = program.handle(gripper.base), [program.handle(name) for name in arm.joints]
        for joint in joints:
            program.call("setObjectInt32Parameter", joint, _CONTROL_LOOP, 0)
            program.call("setObjectInt32Parameter", joint, _MOTOR, 1)
        fingers = Fingers(program, gripper, keeps_closing=True)

        def step(velocity: float = 0.0) -> None:
            for number, joint in enumerate(joints):
                program.call("setJointTargetVelocity", joint, velocity * (-0.3 if number % 2 else 1.0))
            fingers.command()
            program.step()

        program.call("startSimulation")
        fingers.open()
        for _ in range(40):
            step()
        box = program.call("createPureShape", _CUBOID, _RESPONDABLE, [SIZE] * 3, MASS)
        pose = program.pose(hand)
        turn, place = pose[:, :3], pose[:, :3] @ gripper.grip + pose[:, 3]
        program.set_pose(box, np.column_stack((turn @ gripper.turned_down().T, place)))
        program.call("setObjectInt32Parameter", box, _STATIC, 1)
        fingers.close()
        for _ in range(60):
            step()
        program.call("setObjectInt32Parameter", box, _STATIC, 0)
        poses = [program.pose(box, hand)]
        count = round(SWINGING / STEP)
        for number in range(count + round((1.0 + seconds) / STEP)):
            swings = FASTEST * math.sin(2 * math.pi * number * STEP / PERIOD)
            step(swings if number < count else 0.0)
            poses.append(program.pose(box, hand))
    return summed_up(poses[0], poses[1 : 1 + count], poses[1 + count :], gripper)
