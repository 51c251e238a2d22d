"""The fast laser scanner: V-REP's by name and place; it measures, and rides on a robot's force sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from model_checks import (
    DUMMY,
    REVOLUTE,
    SHAPE,
    VISION,
    Stock,
    check_copies,
    check_idle,
    load_model,
    position_of,
)
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

World = tuple[RealWorld, int]
FILE = "models/components/sensors/Hokuyo URG 04LX UG01_Fast.ttm"
NEAR, FAR = 0.009, 5.0


def _half(number: int, turn: float) -> tuple[Stock, Stock]:
    place = (0.0, 0.0, 0.063)
    return (
        Stock(
            f"fastHokuyo_joint{number}", REVOLUTE, place, (0, 0, 1),
            interval="cyclic", mode=5, position_q=turn, max_force=2.5, upper_velocity=6.28,
        ),
        Stock(
            f"fastHokuyo_sensor{number}", VISION, place, (math.cos(turn), math.sin(turn), 0), up=(0, 0, 1),
            resolution=(256, 1), angle_deg=120, near=NEAR, far=FAR,
        ),
    )  # fmt: skip


SCANNER = (
    Stock("fastHokuyo", SHAPE, (0, 0, 0.035), euler_deg=(0, 0, 0), mass=0.2),
    *_half(1, -math.pi / 3),
    *_half(2, math.pi / 3),
    Stock("fastHokuyo_ref", DUMMY, (0, 0, 0)),
)


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


def test_model_and_its_copy_are_vreps_and_stand_still(world: World) -> None:
    opened, client = world
    check_copies(opened, client, FILE, SCANNER)
    start_stepped(client)
    check_idle(client, ("fastHokuyo#0", "fastHokuyo_sensor1#0"))


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
