"""Stock wheeled robots do what scripts drive them for: keep off walls, turn away; and they are as V-REP has them."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from model_checks import load_model, position_of, rotation_of
from real_world import BLOCKING, Open, RealWorld, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = pytest.mark.slow


COPIES = {
    "pioneer p3dx.ttm": ("Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor", 0.0975),
    "bubbleRob.ttm": ("bubbleRob_leftMotor", "bubbleRob_rightMotor", 0.04),
    "remoteApiControlledBubbleRob.ttm": (
        "remoteApiControlledBubbleRobLeftMotor",
        "remoteApiControlledBubbleRobRightMotor",
        0.04,
    ),
    "line follower.ttm": ("DynamicLeftJoint", "DynamicRightJoint", 0.027),
}
"""File to left motor, right motor, and the wheels' radius in metres."""


@pytest.mark.parametrize("file", COPIES)
def test_copy_drives_by_its_own_motors_and_the_first_one_stays(world: Open, file: str) -> None:
    _, client = world("stock_kinect")
    first, copy = load_model(client, file, (0.0, 0.0)), load_model(client, file, (0.0, 0.8))
    left, right, radius = COPIES[file]
    start_stepped(client)
    step(client, 0.5)
    before = position_of(client, first), position_of(client, copy)
    for motor in (left, right):
        vrep.simxSetJointTargetVelocity(
            client, handle_of(client, motor + "#0"), 4.0, vrep.simx_opmode_oneshot
        )
    step(client, 4.0)
    assert math.dist(position_of(client, first), before[0]) < 0.001
    x, y, _ = position_of(client, copy)
    assert x - before[1][0] == pytest.approx(16.0 * radius, rel=0.03)
    assert y == pytest.approx(before[1][1], abs=0.02)


class Drive:
    """A robot with two wheels, as scripts drive it: by target velocities, and odometry from the joints."""

    def __init__(self, client: int, base: str, left: str, right: str, radius: float, track: float) -> None:
        self.client = client
        self.base = handle_of(client, base)
        self.motors = handle_of(client, left), handle_of(client, right)
        self._radius, self._track = radius, track
        self._angles = self._wheels()
        self.path = 0.0
        """Metres by odometry."""
        self.x = self.y = self.heading = 0.0
        """Where odometry has the point between the wheels, from where it began."""

    def _wheels(self) -> list[float]:
        return [vrep.simxGetJointPosition(self.client, motor, BLOCKING)[1] for motor in self.motors]

    def set(self, left: float, right: float) -> None:
        for motor, velocity in zip(self.motors, (left, right), strict=True):
            vrep.simxSetJointTargetVelocity(self.client, motor, velocity, vrep.simx_opmode_oneshot)

    def count(self) -> None:
        """Take the wheels' turn since the last time into account."""
        angles = self._wheels()
        # Positions of cyclic joints jump by a whole turn.
        left, right = (
            self._radius * math.remainder(new - old, 2 * math.pi)
            for new, old in zip(angles, self._angles, strict=True)
        )
        self._angles = angles
        middle = self.heading + (right - left) / self._track / 2
        self.x += (left + right) / 2 * math.cos(middle)
        self.y += (left + right) / 2 * math.sin(middle)
        self.heading += (right - left) / self._track
        self.path += abs(left + right) / 2


def heading_of(client: int, base: int) -> float:
    rotation = rotation_of(client, base)
    return math.atan2(rotation[1, 0], rotation[0, 0])


def read_distances(client: int, sensors: list[int], beyond: float) -> list[float]:
    """Metres to what each sensor detects; `beyond` where it detects nothing."""
    found = []
    for sensor in sensors:
        _, state, point, _, _ = vrep.simxReadProximitySensor(client, sensor, BLOCKING)
        found.append(math.dist(point, (0, 0, 0)) if state else beyond)
    return found


def place_of(client: int, base: int, ahead: float) -> tuple[float, float]:
    """The point so far in front of a robot's base, on the floor."""
    x, y, _ = position_of(client, base)
    heading = heading_of(client, base)
    return x + ahead * math.cos(heading), y + ahead * math.sin(heading)


def test_pioneer_drives_by_its_sensors_and_its_odometry_holds(
    world: Open, record_property: Callable[[str, str], None]
) -> None:
    opened, client = world("pioneer_p3dx")
    robot = Drive(client, "Pioneer_p3dx", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor", 0.0975, 0.331)
    sensors = [handle_of(client, f"Pioneer_p3dx_ultrasonicSensor{number}") for number in range(1, 17)]
    start_stepped(client)
    step(client, 0.2)
    places = [place_of(client, robot.base, 0.0445)]
    robot.x, robot.y = places[0]
    nearest = 9.0
    for _ in range(120):
        distances = read_distances(client, sensors, 1.0)
        nearest = min(nearest, *distances)
        robot.set(*pioneer_velocities(distances))
        for _ in range(5):
            step(client, 0.05)
            robot.count()
            places.append(place_of(client, robot.base, 0.0445))
            assert_nothing_touched(opened)
    path = sum(math.dist(a, b) for a, b in pairwise(places))
    error = math.dist((robot.x, robot.y), places[-1])
    record_property(
        "figures",
        f"pioneer: {path:.1f} m, nothing nearer than {nearest:.2f} m, odometry off by {error:.3f} m",
    )
    assert path > 4.0
    assert max(x for x, _ in places) - min(x for x, _ in places) > 1.5
    assert robot.path == pytest.approx(path, rel=0.02)
    assert error < 0.02 * path


def pioneer_velocities(distances: list[float]) -> tuple[float, float]:
    """Ahead where it is free, else away from the nearer side; on the spot when something is close."""
    left, right = min(distances[0:4]), min(distances[4:8])
    lean = left - right
    if min(distances[1:7]) < 0.45:
        turn = -1.5 if lean > 0 else 1.5
        return turn, -turn
    if min(left, right) > 0.7:
        return 4.0, 4.0
    return 2.5 - 3.0 * lean, 2.5 + 3.0 * lean


def test_level_sonar_does_not_take_the_floor_for_an_obstacle(world: Open) -> None:
    """The cone's lower edge meets the floor 0.8 m away, within its range."""
    _, client = world("pioneer_p3dx")
    start_stepped(client)
    step(client, 0.1)
    sides = [handle_of(client, f"Pioneer_p3dx_ultrasonicSensor{number}") for number in (1, 8, 9, 16)]
    assert read_distances(client, sides, math.inf) == [math.inf] * 4


def test_pioneer_turns_as_far_as_its_wheels_say(world: Open) -> None:
    _, client = world("pioneer_p3dx")
    robot = Drive(client, "Pioneer_p3dx", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor", 0.0975, 0.331)
    start_stepped(client)
    turned, last = 0.0, heading_of(client, robot.base)
    robot.set(-2.0, 2.0)
    for _ in range(160):
        step(client, 0.05)
        robot.count()
        heading = heading_of(client, robot.base)
        turned += math.remainder(heading - last, 2 * math.pi)
        last = heading
    assert turned > 9.0
    assert robot.heading == pytest.approx(turned, rel=0.02)


def assert_nothing_touched(world: RealWorld) -> None:
    """All contacts are those of the floor."""
    model, data = world.simulation.model, world.simulation.data
    floor = model.body("ResizableFloor_5_25_element").id
    bodies = model.geom_bodyid[data.contact.geom]
    assert (bodies == floor).any(axis=1).all(), {model.body(b).name for b in bodies.ravel()}


@pytest.mark.parametrize(
    ("scene", "base", "left", "right", "nose"),
    [
        ("bubblerob", "remoteApiControlledBubbleRob", "LeftMotor", "RightMotor", "SensingNose"),
        ("bubblerob_tutorial", "bubbleRob", "_leftMotor", "_rightMotor", "_sensingNose"),
    ],
)
def test_bubble_rob_turns_away_from_what_is_before_its_nose(
    world: Open, scene: str, base: str, left: str, right: str, nose: str
) -> None:
    opened, client = world(scene)
    robot = Drive(client, base, base + left, base + right, 0.04, 0.2)
    sensor = handle_of(client, base + nose)
    vrep.simxReadProximitySensor(client, sensor, vrep.simx_opmode_streaming)
    start_stepped(client)
    step(client, 0.1)
    begin = place_of(client, robot.base, 0.05)
    (robot.x, robot.y), robot.heading = begin, heading_of(client, robot.base)
    met, back_until = 0, 0.0
    for number in range(200):
        now = number * 0.05
        _, state, point, detected, _ = vrep.simxReadProximitySensor(client, sensor, vrep.simx_opmode_buffer)
        if state and now > back_until:
            back_until = now + 3.0
            met += 1
            assert 0.0 < math.hypot(*point) <= 0.155
            assert detected == handle_of(client, "Cylinder")
        robot.set(*((-3.5, -1.5) if now < back_until else (4.0, 4.0)))
        step(client, 0.05)
        robot.count()
        assert_nothing_touched(opened)
    assert met == 1
    assert abs(heading_of(client, robot.base)) > 0.5
    end = place_of(client, robot.base, 0.05)
    assert math.dist(begin, end) > 0.3
    # Twice the wheels spin until they have turned the robot round: 0.3 m/s at about 4 m/s^2 is 1 cm each time.
    assert math.dist((robot.x, robot.y), end) < 0.025 * robot.path
