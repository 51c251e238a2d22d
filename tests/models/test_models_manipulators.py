"""The youBot is as V-REP has it, drives as its four mecanum wheels say, and picks things up."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from model_checks import load_model, position_of, rotation_of
from real_world import BLOCKING, Open, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = pytest.mark.slow

ONESHOT = vrep.simx_opmode_oneshot


WHEELS = ("fl", "rl", "rr", "fr")
RADIUS, REACH = 0.05, 0.228 + 0.1585
"""Of the wheels, metres; half the wheelbase and half the track together."""
UPPER_ARM, FORE_ARM, HAND = 0.155, 0.1349, 0.1936
"""Metres from joint 1 to joint 2, on to joint 3, on to the tip."""
SHOULDER = (0.1992, 0.2459)
"""Joint 1: metres ahead of the platform's middle and above the floor."""


class YouBot:
    """A youBot as scripts use it: wheels by V-REP's signs, the arm by joint positions, the gripper by both joints."""

    def __init__(self, client: int, suffix: str = "") -> None:
        self.client = client
        self.middle, self.tip = self._handle("youBot_ref", suffix), self._handle("youBot_positionTip", suffix)
        self._wheels = [self._handle(f"rollingJoint_{corner}", suffix) for corner in WHEELS]
        self.arm = [self._handle(f"youBotArmJoint{number}", suffix) for number in range(5)]
        self.fingers = [self._handle(f"youBotGripperJoint{number}", suffix) for number in (1, 2)]

    def _handle(self, name: str, suffix: str) -> int:
        return handle_of(self.client, name + suffix)

    def drive(self, ahead: float, right: float, clockwise: float) -> None:
        """All in rad/s of a wheel."""
        left_side, right_side = -ahead - clockwise, -ahead + clockwise
        velocities = (left_side - right, left_side + right, right_side - right, right_side + right)
        vrep.simxPauseCommunication(self.client, True)
        for wheel, velocity in zip(self._wheels, velocities, strict=True):
            vrep.simxSetJointTargetVelocity(self.client, wheel, velocity, ONESHOT)
        vrep.simxPauseCommunication(self.client, False)

    def place(self) -> tuple[float, float, float]:
        """x, y and heading of the middle, 0 when it faces +Y."""
        x, y, _ = position_of(self.client, self.middle)
        rotation = rotation_of(self.client, self.middle)
        return x, y, math.atan2(rotation[1, 0], rotation[0, 0])

    def drive_to(self, x: float, y: float) -> None:
        for _ in range(400):
            here_x, here_y, heading = self.place()
            if math.dist((here_x, here_y), (x, y)) < 0.001:
                break
            # Near the goal slower: an error goes away at 2/s.
            right, ahead = (max(-3.0, min(3.0, 2 * error / RADIUS)) for error in (x - here_x, y - here_y))
            self.drive(ahead, right, 2 * heading * REACH / RADIUS)
            step(self.client, 0.05)
        self.drive(0, 0, 0)
        step(self.client, 0.2)

    def reach(self, ahead: float, height: float) -> None:
        """Bring the tip there, pointing down, metres from the middle and above the floor."""
        y, z = ahead - SHOULDER[0], height + HAND - SHOULDER[1]
        elbow = math.acos((y * y + z * z - UPPER_ARM**2 - FORE_ARM**2) / (2 * UPPER_ARM * FORE_ARM))
        inner = math.atan2(FORE_ARM * math.sin(elbow), UPPER_ARM + FORE_ARM * math.cos(elbow))
        shoulder = math.atan2(y, z) - inner
        for joint, goal in zip(self.arm, (0, -shoulder, -elbow, shoulder + elbow - math.pi, 0), strict=True):
            vrep.simxSetJointPosition(self.client, joint, goal, ONESHOT)
        step(self.client, 1.5)

    def move_fingers(self, velocity: float) -> None:
        """Joint 2 moves, joint 1 keeps the middle between the fingers where it is, as in V-REP's own script."""
        one, two = self.fingers
        vrep.simxSetJointTargetVelocity(self.client, two, velocity, ONESHOT)
        for _ in range(30):
            _, opening = vrep.simxGetJointPosition(self.client, two, BLOCKING)
            vrep.simxSetJointTargetPosition(self.client, one, -opening / 2, ONESHOT)
            step(self.client, 0.05)


@pytest.mark.parametrize(
    "command",
    [(2, 0, 0), (-4, 0, 0), (0, 2, 0), (0, -4, 0), (0, 0, 2), (0, 0, -4), (1.5, 1.5, 0), (2, -1, 0.5)],
)
def test_platform_moves_as_its_wheels_say(world: Open, command: tuple[float, float, float]) -> None:
    _, client = world("youbot")
    robot = YouBot(client)
    start_stepped(client)
    step(client, 0.5)
    robot.drive(*command)
    step(client, 0.5)
    x, y, heading = robot.place()
    travelled = [0.0, 0.0, 0.0]
    for _ in range(40):
        step(client, 0.05)
        new_x, new_y, new_heading = robot.place()
        turned = math.remainder(new_heading - heading, 2 * math.pi)
        middle = heading + turned / 2
        travelled[0] += math.cos(middle) * (new_y - y) - math.sin(middle) * (new_x - x)
        travelled[1] += math.cos(middle) * (new_x - x) + math.sin(middle) * (new_y - y)
        travelled[2] -= turned
        x, y, heading = new_x, new_y, new_heading
    ahead, right, clockwise = command
    goals = 2 * RADIUS * ahead, 2 * RADIUS * right, 2 * RADIUS / REACH * clockwise
    for distance, goal in zip(travelled, goals, strict=True):
        assert distance == pytest.approx(goal, rel=0.01, abs=0.001)


def test_youbot_drives_to_a_cube_and_carries_it_away(
    world: Open, record_property: Callable[[str, str], None]
) -> None:
    _, client = world("youbot")
    robot = YouBot(client)
    cube = handle_of(client, "Cube")
    start_stepped(client)
    step(client, 0.5)
    x, y, height = position_of(client, cube)
    robot.drive_to(x, y - 0.4)
    robot.reach(0.4, height + 0.08)
    robot.reach(0.4, height)
    assert math.dist(position_of(client, robot.tip), (x, y, height)) < 0.005
    robot.move_fingers(0.04)
    robot.reach(0.4, height + 0.12)
    robot.drive_to(x - 0.3, y - 0.8)
    grip = position_of(client, cube, robot.tip)
    lifted = []
    for _ in range(60):
        step(client, 0.05)
        lifted.append(position_of(client, cube)[2] - height)
    slipped = math.dist(grip, position_of(client, cube, robot.tip))
    assert min(lifted) > 0.05
    assert slipped < 0.001
    record_property("figures", f"youbot: cube {min(lifted):.3f} m up, slipped {slipped * 1e6:.0f} um in 3 s")
    robot.move_fingers(-0.04)
    assert position_of(client, cube)[2] < height


def test_copy_of_a_youbot_drives_and_moves_its_arm(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "KUKA YouBot.ttm", (0.0, -1.0))
    load_model(client, "KUKA YouBot.ttm", (1.0, 1.5))
    first, second = YouBot(client), YouBot(client, "#0")
    start_stepped(client)
    second.drive(2, 2, 0)
    second.reach(0.4, 0.2)
    step(client, 0.5)
    # The arm swings while the wheels start, which turns the platform a little.
    assert second.place() == pytest.approx((1.2, 1.7, 0), abs=0.02)
    x, y, z = position_of(client, second.tip, second.middle)
    assert (x, y, z) == pytest.approx((0, 0.4, 0.2), abs=0.005)
    assert first.place() == pytest.approx((0, -1, 0), abs=0.001)
