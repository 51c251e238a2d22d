"""The fast laser scanner: V-REP's by name and place; it measures, and rides on a robot's force sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from model_checks import load_model, position_of
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step
from scanner_stock import FAR, NEAR

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

World = tuple[RealWorld, int]
FILE = "models/components/sensors/Hokuyo URG 04LX UG01_Fast.ttm"


@pytest.fixture
def world() -> Iterator[World]:
    opened = RealWorld("pioneer_p3dx")
    yield opened, opened.client()
    opened.close()


def distances(client: int, sensor: str) -> list[float]:
    """Metres along the sensor's axis, from left to right."""
    code, resolution, buffer = vrep.simxGetVisionSensorDepthBuffer(
        client, handle_of(client, sensor), BLOCKING
    )
    assert (code, resolution) == (vrep.simx_return_ok, [256, 1])
    return [NEAR + share * (FAR - NEAR) for share in buffer]


def test_scanner_on_a_robot_measures_the_room_and_rides_along(world: World) -> None:
    _, client = world
    scanner = load_model(client, FILE, (0.0, 0.0))
    robot = handle_of(client, "Pioneer_p3dx")
    assert (
        vrep.simxSetObjectPosition(client, scanner, -1, [0.0445, 0, 0.2741], BLOCKING) == vrep.simx_return_ok
    )
    mount = handle_of(client, "Pioneer_p3dx_connection1")
    assert vrep.simxSetObjectParent(client, scanner, mount, True, BLOCKING) == vrep.simx_return_ok
    start_stepped(client)
    step(client, 0.1)

    # Sensor 2 looks to the left, 60 degrees from ahead: its middle at the north wall, its right end at the east wall.
    left = distances(client, "fastHokuyo_sensor2")
    assert (left[127] + left[128]) / 2 == pytest.approx(2.4 / math.sin(math.pi / 3), rel=0.02)
    assert left[255] == pytest.approx((2.4 - 0.0445) * math.cos(math.pi / 3), rel=0.02)
    # Sensor 1 looks to the right; the cylinder at (0.8, -1.2) is 58 degrees from ahead, 0.15 m thick.
    right = distances(client, "fastHokuyo_sensor1")
    assert min(right[120:136]) == pytest.approx(math.hypot(0.7555, 1.2) - 0.15, rel=0.02)

    for name in ("Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor"):
        vrep.simxSetJointTargetVelocity(client, handle_of(client, name), 3.0, vrep.simx_opmode_oneshot)
    step(client, 2.0)
    assert position_of(client, robot)[0] > 0.4
    assert position_of(client, scanner, robot) == pytest.approx([0.0445, 0, 0.1353], abs=0.001)
    east = distances(client, "fastHokuyo_sensor2")[255]
    assert east == pytest.approx((2.4 - position_of(client, scanner)[0]) / 2, rel=0.03)
