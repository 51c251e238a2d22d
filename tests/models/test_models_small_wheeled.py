"""The small stock robots: they are V-REP's by name and place, stand still, and drive where their wheels say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from model_checks import Stock, load_model, position_of, rotation_of
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step
from small_wheeled_stock import DR12, K_JUNIOR, KHEPERA, LUMIBOT

import simx_client as vrep

pytestmark = pytest.mark.slow

World = tuple[RealWorld, int]


@dataclass(frozen=True)
class Robot:
    """What a script must know to drive one."""

    file: str
    rows: tuple[Stock, ...]
    left: str
    right: str
    radius: float
    track: float
    """Metres."""
    ahead: tuple[float, float, float]
    """In the world, before it has turned."""


ROBOTS = {
    "dr12": Robot("dr12.ttm", DR12, "dr12_leftJoint_", "dr12_rightJoint_", 0.043, 0.163, (1, 0, 0)),
    "lumibot": Robot(
        "lumibot.ttm", LUMIBOT, "lumibot_leftMotor", "lumibot_rightMotor", 0.025, 0.0886, (0, -1, 0)
    ),
    "K-Junior": Robot(
        "K-Junior.ttm", K_JUNIOR, "KJunior_motorLeft", "KJunior_motorRight", 0.0156, 0.0996, (0, -1, 0)
    ),
    "Khepera III": Robot(
        "Khepera III.ttm", KHEPERA, "K3_leftWheelMotor", "K3_rightWheelMotor", 0.0209, 0.0859, (0, 1, 0)
    ),
}


@pytest.fixture
def world() -> Iterator[World]:
    opened = RealWorld("stock_kinect")
    yield opened, opened.client()
    opened.close()


@pytest.mark.parametrize("name", ROBOTS)
def test_copy_drives_and_turns_as_far_as_its_wheels_say(world: World, name: str) -> None:
    _, client = world
    robot = ROBOTS[name]
    load_model(client, robot.file, (0.0, 0.0))
    base = load_model(client, robot.file, (0.5, 0.5))
    motors = [handle_of(client, robot.left + "#0"), handle_of(client, robot.right + "#0")]
    start_stepped(client)
    step(client, 0.5)

    def drive(left: float, right: float, seconds: float) -> None:
        for motor, velocity in zip(motors, (left, right), strict=True):
            vrep.simxSetJointTargetVelocity(client, motor, velocity, vrep.simx_opmode_oneshot)
        step(client, seconds)

    begin = np.array(position_of(client, base))
    drive(4.0, 4.0, 3.0)
    way = np.array(position_of(client, base)) - begin
    length = 4.0 * 3.0 * robot.radius
    assert way @ np.array(robot.ahead) == pytest.approx(length, rel=0.03)
    assert np.linalg.norm(np.cross(way, robot.ahead)) < 0.03 * length

    drive(-2.0, 2.0, 0.5)
    before = rotation_of(client, base)
    drive(-2.0, 2.0, 2.0)
    after = rotation_of(client, base)
    turned = math.acos((np.trace(after @ before.T) - 1) / 2)
    assert turned == pytest.approx(2 * 2.0 * 2.0 * robot.radius / robot.track, rel=0.02)
    moved = vrep.simxGetObjectPosition(client, handle_of(client, robot.rows[0].name), -1, BLOCKING)[1]
    assert math.hypot(moved[0], moved[1]) < 0.005
