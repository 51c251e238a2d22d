"""The quadricopter and the cars are as V-REP has them, and do what scripts make them do."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from model_checks import check_idle, load_model, position_of, rotation_of
from real_world import BLOCKING, Open, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ONESHOT = vrep.simx_opmode_oneshot


# The quadricopter: clients move the target, the model's own script flies.


class Flight:
    """A quadricopter and its target."""

    def __init__(self, client: int, suffix: str = "") -> None:
        self.client = client
        self.body, self.base, self.target = (
            handle_of(client, name + suffix)
            for name in ("Quadricopter", "Quadricopter_base", "Quadricopter_target")
        )

    def lead(self, goal: Sequence[float]) -> None:
        vrep.simxSetObjectPosition(self.client, self.target, -1, list(goal), ONESHOT)

    def error(self) -> float:
        """Metres between the base and the target."""
        return math.dist(position_of(self.client, self.base), position_of(self.client, self.target))

    def heading(self) -> float:
        rotation = rotation_of(self.client, self.body)
        return math.atan2(rotation[1, 0], rotation[0, 0])

    def upright(self) -> float:
        """1 when level, -1 upside down."""
        return float(rotation_of(self.client, self.body)[2, 2])


def test_quadricopter_hovers_then_comes_to_where_the_target_is_put(world: Open) -> None:
    _, client = world("quadricopter")
    flight = Flight(client)
    start_stepped(client)
    assert vrep.simxGetObjectParent(client, flight.target, BLOCKING)[1] == -1
    for _ in range(20):
        step(client, 0.1)
        assert flight.error() < 0.002
    flight.lead((1.0, -0.7, 1.4))
    step(client, 6.0)
    for _ in range(20):
        step(client, 0.1)
        assert flight.error() < 0.02


def test_quadricopter_follows_a_moving_target_within_5_cm(world: Open) -> None:
    """Half a figure of eight, from rest to 0.29 m/s, up and down; the target is set every second pass only."""
    _, client = world("quadricopter")
    flight = Flight(client)
    start_stepped(client)
    errors = []
    for tick in range(240):
        time = tick * 0.1
        angle = 0.2 * (time - 4 if time > 8 else time * time / 16)
        flight.lead((math.sin(angle), math.sin(2 * angle) / 2, 0.5 + 0.3 * math.sin(angle / 2)))
        step(client, 0.1)
        errors.append(flight.error())
    assert max(errors) < 0.05


def test_quadricopter_turns_as_the_target_is_turned(world: Open) -> None:
    _, client = world("quadricopter")
    flight = Flight(client)
    start_stepped(client)
    for goal in (0.5, 3.0, -2.5):  # the last one the short way, over pi
        vrep.simxSetObjectOrientation(client, flight.target, -1, [0, 0, goal], ONESHOT)
        step(client, 5.0)
        assert abs(math.remainder(flight.heading() - goal, 2 * math.pi)) < math.radians(1)
        assert flight.error() < 0.02


def test_quadricopter_recovers_from_upside_down_and_carries_a_load(world: Open) -> None:
    opened, client = world("quadricopter")
    flight = Flight(client)
    start_stepped(client)
    flight.lead((0, 0, 5))
    step(client, 6.0)
    vrep.simxSetObjectOrientation(client, flight.body, -1, [3.0, 0.0, 0.0], ONESHOT)
    body = opened.simulation.model.body("Quadricopter").id
    opened.simulation.model.body_mass[body] += 0.1
    step(client, 12.0)
    assert flight.upright() > 0.999
    assert flight.error() < 0.02


def test_two_quadricopters_fly_and_a_stop_brings_the_targets_back(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "Quadricopter.ttm", (0.0, 1.0))
    load_model(client, "Quadricopter.ttm", (1.0, 0.0))
    flights = [Flight(client), Flight(client, "#0")]
    start_stepped(client)
    for flight, goal in zip(flights, ((0, 1, 1), (1, 0, 1.5)), strict=True):
        flight.lead(goal)
    step(client, 6.0)
    assert all(flight.error() < 0.02 for flight in flights)
    vrep.simxStopSimulation(client, BLOCKING)
    for flight in flights:
        assert vrep.simxGetObjectParent(client, flight.target, BLOCKING)[1] == flight.body
        assert flight.error() < 1e-6


@pytest.mark.parametrize("time_step", [0.01, 0.02])
def test_quadricopter_flies_at_other_lengths_of_a_step(world: Open, time_step: float) -> None:
    _, client = world("quadricopter")
    vrep.simxSetFloatingParameter(client, vrep.sim_floatparam_simulation_time_step, time_step, BLOCKING)
    flight = Flight(client)
    start_stepped(client)
    flight.lead((0.5, 0.5, 1.0))
    step(client, 5.0, time_step)
    assert flight.error() < 0.02


# The cars.

WHEELBASE, HALF_TRACK = 2.5772, 0.7552


def steer(client: int, left: int, right: int, angle: float) -> None:
    """Each wheel across its own way around the centre of the bend."""
    tangent = math.tan(angle)
    for joint, side in ((left, -HALF_TRACK), (right, HALF_TRACK)):
        goal = math.atan(WHEELBASE * tangent / (WHEELBASE + side * tangent))
        vrep.simxSetJointTargetPosition(client, joint, goal, ONESHOT)


def off_the_line(x: float, y: float) -> float:
    """Metres from the course of the scene: straight, two bends of 10 m radius, straight."""
    turn = 10 * math.sin(math.radians(60))
    if y > -9:
        return abs(x)
    if y > -9 - turn:
        return abs(math.hypot(x - 10, y + 9) - 10)
    if y > -9 - 2 * turn:
        return abs(math.hypot(x, y + 9 + 2 * turn) - 10)
    return abs(x - 10)


def test_ackermann_car_follows_the_whole_line_by_its_camera(world: Open) -> None:
    """Signed grey values as V-REP gives them: what is brighter than medium is negative."""
    _, client = world("ackermann_line")
    car, camera, steering_left, steering_right, motor_left, motor_right = (
        handle_of(client, name)
        for name in (
            "nakedAckermannSteeringCar", "Vision_sensor", "nakedCar_steeringLeft", "nakedCar_steeringRight",
            "nakedCar_motorLeft", "nakedCar_motorRight",
        )
    )  # fmt: skip
    start_stepped(client)
    vrep.simxGetVisionSensorImage(client, camera, 1, vrep.simx_opmode_streaming)
    step(client, 1.0)
    for motor in (motor_left, motor_right):
        vrep.simxSetJointTargetVelocity(client, motor, 14.0, ONESHOT)
    farthest, y = 0.0, 0.0
    for _ in range(240):
        code, (width, height), image = vrep.simxGetVisionSensorImage(
            client, camera, 1, vrep.simx_opmode_buffer
        )
        assert code == vrep.simx_return_ok
        assert (width, height) == (64, 32)
        dark = [column for column, grey in enumerate(image[8 * width : 9 * width]) if 0 <= grey < 60]
        if not dark:
            break
        steer(client, steering_left, steering_right, 0.025 * ((width - 1) / 2 - sum(dark) / len(dark)))
        step(client, 0.05)
        x, y, _ = position_of(client, car)
        farthest = max(farthest, off_the_line(x, y))
    assert y < -31  # where the line leaves the picture
    assert farthest < 0.6


def radius_of(points: Sequence[Sequence[float]]) -> float:
    """Of the circle through points of the plane, by least squares."""
    xy = np.array(points)
    a, b, c = np.linalg.lstsq(np.column_stack([2 * xy, np.ones(len(xy))]), (xy**2).sum(axis=1))[0]
    return math.sqrt(c + a * a + b * b)


def test_ackermann_car_drives_as_fast_and_as_round_as_its_wheels_say(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "simple Ackermann steering.ttm", (20.0, 20.0))
    left, right, rear = (
        handle_of(client, f"nakedCar_{name}") for name in ("steeringLeft", "steeringRight", "lineSegmentRear")
    )
    start_stepped(client)
    for side in ("Left", "Right"):
        vrep.simxSetJointTargetVelocity(client, handle_of(client, f"nakedCar_motor{side}"), 5.0, ONESHOT)
    step(client, 4.0)
    start = position_of(client, rear)
    step(client, 2.0)
    assert math.dist(start, position_of(client, rear)) == pytest.approx(2 * 5 * 0.317, rel=0.01)
    steer(client, left, right, 0.3)
    step(client, 2.0)
    points = []
    for _ in range(20):
        step(client, 0.4)
        points.append(position_of(client, rear)[:2])
    assert radius_of(points) == pytest.approx(WHEELBASE / math.tan(0.3), rel=0.02)


def test_manta_steers_like_ackermann_drives_through_a_differential_and_brakes(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "Manta with differential.ttm", (-20.0, 20.0))
    car = load_model(client, "Manta with differential.ttm", (20.0, 20.0))
    motor, steering = handle_of(client, "motor_joint#0"), handle_of(client, "steer_joint#0")
    start_stepped(client)
    check_idle(client, ("Manta", "Manta#0"))
    vrep.simxSetJointTargetVelocity(client, motor, 8.0, ONESHOT)
    vrep.simxSetJointTargetPosition(client, steering, 0.4, ONESHOT)
    step(client, 3.0)
    points = []
    for _ in range(40):
        step(client, 0.2)
        points.append((np.array(position_of(client, car)) - 0.2753 * rotation_of(client, car)[:, 1])[:2])
    radius = radius_of(points)
    assert radius == pytest.approx(0.6 / math.tan(0.4), rel=0.03)
    slow, fast = (
        vrep.simxGetObjectFloatParameter(client, handle_of(client, f"b{side}_brake_joint#0"), 2012, BLOCKING)[
            1
        ]
        for side in "lr"
    )
    assert (slow + fast) / 2 == pytest.approx(8.0, rel=0.02)
    assert fast / slow == pytest.approx((radius + 0.175) / (radius - 0.175), rel=0.03)
    vrep.simxSetJointForce(client, motor, 0.0, ONESHOT)
    for wheel in ("fl", "fr", "bl", "br"):
        vrep.simxSetJointForce(client, handle_of(client, f"{wheel}_brake_joint#0"), 100.0, ONESHOT)
    step(client, 1.0)
    stood = position_of(client, car)
    step(client, 1.0)
    assert math.dist(stood, position_of(client, car)) < 0.001
    assert math.dist(stood[:2], points[-1]) < 0.4  # of which 0.28 is from the rear axle to the middle
