"""The e-puck and the NAO are as V-REP has them; one keeps off the walls of its maze, one stands; both see."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from model_checks import (
    FORCE,
    REVOLUTE,
    load_model,
    position_of,
    rotation_of,
)
from real_world import BLOCKING, Open, handle_of, start_stepped, step
from small_stock import NAO

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ONESHOT = vrep.simx_opmode_oneshot


class Epuck:
    """An e-puck by its joints and sensors."""

    def __init__(self, client: int, suffix: str = "") -> None:
        self.client = client
        self.base = handle_of(client, "ePuck_base" + suffix)
        self._motors = [handle_of(client, f"ePuck_{side}Joint{suffix}") for side in ("left", "right")]
        self.sensors = [handle_of(client, f"ePuck_proxSensor{number}{suffix}") for number in range(1, 9)]

    def drive(self, left: float, right: float) -> None:
        for motor, velocity in zip(self._motors, (left, right), strict=True):
            vrep.simxSetJointTargetVelocity(self.client, motor, velocity, ONESHOT)

    def place(self) -> tuple[float, float]:
        x, y, _ = position_of(self.client, self.base)
        return x, y

    def heading(self) -> float:
        rotation = rotation_of(self.client, self.base)
        return math.atan2(rotation[1, 0], rotation[0, 0])

    def nearness(self) -> list[float]:
        """Per sensor 1 for what touches it, 0 for nothing within its range."""
        found = []
        for sensor in self.sensors:
            _, state, point, _, _ = vrep.simxReadProximitySensor(
                self.client, sensor, vrep.simx_opmode_streaming
            )
            found.append(1 - math.hypot(*point) / 0.04 if state else 0.0)
        return found


def test_wheels_drive_as_far_and_turn_as_much_as_they_say(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "e-puck.ttm", (1.0, 1.0))
    robot = Epuck(client)
    start_stepped(client)
    robot.drive(2.0, 2.0)
    step(client, 0.5)
    begin = robot.place()
    step(client, 5)
    assert robot.place() == pytest.approx((1.0, begin[1] + 2.0 * 0.0212 * 5), abs=0.002)
    robot.drive(-1.0, 1.0)
    step(client, 0.5)
    heading = robot.heading()
    step(client, 2)
    assert robot.heading() - heading == pytest.approx(2 * 0.0212 * 2.0 / 0.054, rel=0.02)


def test_e_puck_keeps_off_the_walls_of_its_maze(
    world: Open, record_property: Callable[[str, str], None]
) -> None:
    opened, client = world("e_puck")
    robot = Epuck(client)
    floor = opened.simulation.model.body("ResizableFloor_5_25_element").id
    start_stepped(client)
    step(client, 0.1)
    places, met = [robot.place()], 0
    for _ in range(300):
        near = robot.nearness()
        met += any(near)
        left, right = near[0] * 0.5 + near[1] + near[2], near[3] + near[4] + near[5] * 0.5
        if near[2] + near[3] > 0.6:
            # Straight ahead it is closed: turn to where there is more room, on the spot.
            robot.drive(*((1.5, -1.5) if left >= right else (-1.5, 1.5)))
        else:
            robot.drive(2.0 + 2.5 * (left - right), 2.0 - 2.5 * (left - right))
        step(client, 0.05)
        places.append(robot.place())
        bodies = opened.simulation.model.geom_bodyid[opened.simulation.data.contact.geom]
        assert (bodies == floor).any(axis=1).all(), f"it touches a wall at {places[-1]}"
    path = sum(math.dist(a, b) for a, b in pairwise(places))
    record_property("figures", f"e-puck: {path:.2f} m, a wall in sight in {met / 3:.0f} % of the passes")
    assert path > 0.3
    assert met > 30


def test_e_puck_turns_until_its_camera_has_the_red_mark_ahead(world: Open) -> None:
    _, client = world("e_puck")
    robot = Epuck(client)
    camera = handle_of(client, "ePuck_camera")
    vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_streaming)
    start_stepped(client)
    robot.drive(2.0, -2.0)
    columns: list[int] = []
    for _ in range(60):
        step(client, 0.1)
        code, (width, height), image = vrep.simxGetVisionSensorImage(
            client, camera, 0, vrep.simx_opmode_buffer
        )
        assert (code, width, height) == (vrep.simx_return_ok, 128, 128)
        row = [value & 255 for value in image[3 * 64 * width : 3 * 65 * width]]
        columns = [x for x in range(width) if row[3 * x] > 100 and row[3 * x + 1] < 60]
        if columns and abs(sum(columns) / len(columns) - 63.5) < 12:
            break
    assert len(columns) > 20
    robot.drive(0, 0)
    step(client, 0.2)
    assert abs(math.remainder(robot.heading() - math.pi, 2 * math.pi)) < math.radians(12)


def test_light_sensor_tells_a_black_patch_from_the_floor(world: Open) -> None:
    _, client = world("e_puck")
    eye, robot = handle_of(client, "ePuck_lightSensor"), handle_of(client, "ePuck")
    start_stepped(client)
    for (x, y), dark in (((0.0, 0.0), False), ((-0.22, 0.36), True)):
        vrep.simxSetObjectPosition(client, robot, -1, [x, y, 0.0191], BLOCKING)
        step(client, 0.2)
        code, size, image = vrep.simxGetVisionSensorImage(client, eye, 1, BLOCKING)
        assert (code, size) == (vrep.simx_return_ok, [16, 2])
        assert all((value & 255 < 60) == dark for value in image)


def joint_positions(client: int) -> dict[str, float]:
    names = [row.name for row in NAO if row.kind == REVOLUTE]
    return {name: vrep.simxGetJointPosition(client, handle_of(client, name), BLOCKING)[1] for name in names}


def test_nao_stands_with_its_weight_on_the_sensors_of_its_feet(world: Open) -> None:
    opened, client = world("nao")
    body = handle_of(client, "NAO")
    begin = joint_positions(client)
    assert len(begin) == 24
    start_stepped(client)
    step(client, 10)
    for name, position in joint_positions(client).items():
        assert position == pytest.approx(begin[name], abs=0.02), name
    assert rotation_of(client, body)[2, 2] > 0.9995
    load = 0.0
    for foot in (row.name for row in NAO if row.kind == FORCE):
        code, state, force, _ = vrep.simxReadForceSensor(client, handle_of(client, foot), BLOCKING)
        assert (code, state & 1) == (vrep.simx_return_ok, 1)
        assert abs(force[2]) > 1.0, foot
        load += abs(force[2])
    model = opened.simulation.model
    pads = sum(
        model.body(f"NAO_{foot}Pad{place}").mass[0] for foot in "RL" for place in ("RR", "FR", "RL", "FL")
    )
    mass = model.body("NAO").subtreemass[0] - pads
    assert load == pytest.approx(9.81 * mass, rel=0.02)


def test_nao_turns_its_head_and_follows_a_ball_with_its_lower_camera(world: Open) -> None:
    _, client = world("nao")
    camera = handle_of(client, "NAO_vision2")
    yaw, pitch = handle_of(client, "HeadYaw"), handle_of(client, "HeadPitch")
    start_stepped(client)
    columns, rows = {}, {}
    for turn, nod in ((0.0, 0.0), (0.3, 0.0), (0.0, 0.2)):
        vrep.simxSetJointTargetPosition(client, yaw, turn, ONESHOT)
        vrep.simxSetJointTargetPosition(client, pitch, nod, ONESHOT)
        step(client, 1.0)
        for joint, goal in ((yaw, turn), (pitch, nod)):
            assert vrep.simxGetJointPosition(client, joint, BLOCKING)[1] == pytest.approx(goal, abs=0.01)
        code, (width, height), image = vrep.simxGetVisionSensorImage(client, camera, 0, BLOCKING)
        assert (code, width, height) == (vrep.simx_return_ok, 640, 480)
        picture = np.array(image, dtype=np.uint8).reshape(height, width, 3).astype(int)
        red = (picture[:, :, 0] > 100) & (picture[:, :, 1] < 80)
        assert red.sum() > 500
        rows[turn, nod], columns[turn, nod] = (float(axis.mean()) for axis in np.nonzero(red))
    # The whole head turned left moves the ball to the right; the first row of a picture is its lowest.
    assert columns[0, 0] == pytest.approx(320, abs=10)
    assert columns[0.3, 0] > 400
    assert rows[0, 0.2] > rows[0, 0] + 50


def test_nao_moves_its_arms_and_keeps_standing(world: Open) -> None:
    _, client = world("nao")
    goals = {"LShoulderPitch3": 1.4, "RShoulderPitch3": 1.4, "LShoulderRoll3": 0.3, "RShoulderRoll3": -0.3}
    start_stepped(client)
    for name, goal in goals.items():
        vrep.simxSetJointTargetPosition(client, handle_of(client, name), goal, ONESHOT)
    step(client, 3)
    found = joint_positions(client)
    assert {name: found[name] for name in goals} == pytest.approx(goals, abs=0.03)
    assert rotation_of(client, handle_of(client, "NAO"))[2, 2] > 0.999
