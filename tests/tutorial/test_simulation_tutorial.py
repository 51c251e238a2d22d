"""The tutorial's scene through Simulation: the arm settles, the gripper strokes, a ball is grasped, held, attached."""

from __future__ import annotations

import math

import pytest
from scenes_for_tests import world_of

from simx_server.files.library import find_scene
from simx_server.scene.editing import editing
from simx_server.scene.poses import frames

pytestmark = pytest.mark.slow

GRASP = (78.0, 12.2, 110.7, -32.9, -90.0, -12.0)
"""Degrees; the pads are around a ball of 50 mm on the floor, pointing down."""

RESET = (90.0, -45.0, 90.0, 0.0, -100.0, 0.0)


class Robot:
    """The UR5 with its gripper, in words."""

    def __init__(self, scene: str) -> None:
        self.parts = world_of(find_scene(scene))
        self.sim = self.parts.simulation
        self.arm = [self.sim.scene.resolve(f"UR5_joint{i}") for i in range(1, 7)]
        self.gripper = self.sim.scene.resolve("RG2_openCloseJoint")
        self.sim.start()

    def aim(self, degrees: tuple[float, ...]) -> None:
        for joint, angle in zip(self.arm, degrees, strict=True):
            self.sim.joints.set_target_position(joint, math.radians(angle))

    def grip(self, velocity: float, force: float = 20) -> None:
        self.sim.joints.set_max_force(self.gripper, force)
        self.sim.joints.set_target_velocity(self.gripper, velocity)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / self.sim.time_step)):
            self.parts.step()

    @property
    def opening(self) -> float:
        return self.sim.joints.position(self.gripper)


@pytest.mark.parametrize("index", range(6))
def test_step_of_one_degree_settles_within_a_quarter_second_without_overshoot(index: int) -> None:
    robot = Robot("ur5_rg2_kinect")
    robot.aim(RESET)
    robot.wait(2)
    start = [math.degrees(robot.sim.joints.position(joint)) for joint in robot.arm]
    target = list(RESET)
    target[index] += 1
    robot.aim(tuple(target))
    course = []
    for _ in range(20):
        robot.parts.step()
        course.append(math.degrees(robot.sim.joints.position(robot.arm[index])) - start[index])
    assert course[3] == pytest.approx(0.9817, abs=0.01)  # 1 - exp(-20 / s * 0.2 s)
    assert course[4] == pytest.approx(1, abs=0.02)
    assert max(course) < 1.001
    others = [math.degrees(robot.sim.joints.position(j)) - s for j, s in zip(robot.arm, start, strict=True)]
    assert max(abs(value) for i, value in enumerate(others) if i != index) < 0.02


def test_arm_moves_at_its_speed_limit_and_holds_still() -> None:
    robot = Robot("ur5_rg2_kinect")
    robot.aim(RESET)
    robot.wait(0.4)
    assert max(abs(robot.sim.joints.velocity(joint)) for joint in robot.arm) < 1.1 * math.pi
    robot.wait(1.6)
    for joint, angle in zip(robot.arm, RESET, strict=True):
        assert math.degrees(robot.sim.joints.position(joint)) == pytest.approx(angle, abs=0.03)


def test_gripper_strokes_between_the_positions_scripts_wait_for() -> None:
    robot = Robot("ur5_rg2_kinect")
    assert robot.opening == pytest.approx(0, abs=1e-9)
    robot.grip(0.05)
    robot.wait(1.5)
    assert 0.0536 < robot.opening < 0.0542
    assert robot.sim.joints.force(robot.gripper) == pytest.approx(-20)
    robot.grip(-0.05)
    robot.wait(2.5)
    assert -0.0477 < robot.opening < -0.047
    robot.grip(0.5)  # faster than the gripper can: 0.11 m/s
    robot.wait(0.5)
    assert robot.opening == pytest.approx(-0.0472 + 0.11 * 0.5, abs=0.004)
    robot.grip(0)
    stopped = robot.opening
    robot.wait(2)
    assert robot.opening == pytest.approx(stopped, abs=5e-4)


def test_ball_is_grasped_lifted_held_and_released() -> None:
    robot = Robot("ur5_rg2_kinect_ball")
    sim, ball = robot.sim, robot.sim.scene.resolve("Ball")
    place = frames.get_position(sim, ball)
    frames.set_position(sim, ball, -1, [0, 1.5, 0.025])
    robot.grip(0.11)
    robot.aim(GRASP)
    robot.wait(2)
    frames.set_position(sim, ball, -1, place)
    robot.grip(-0.05)
    robot.wait(1.5)
    assert robot.opening == pytest.approx(0.0022, abs=5e-4)  # 50 mm - 47.2 mm, less what the pads give
    assert sim.joints.force(robot.gripper) == pytest.approx(20)
    robot.aim((78.0, -15.0, 110.7, -32.9, -90.0, -12.0))
    robot.wait(2)
    assert frames.get_position(sim, ball)[2] > 0.2
    hand = sim.scene.resolve("RG2")
    held = frames.get_position(sim, ball, hand)
    robot.wait(5)
    assert math.dist(held, frames.get_position(sim, ball, hand)) < 1e-4
    robot.grip(0.05)
    robot.wait(1.5)
    assert frames.get_position(sim, ball)[2] < 0.05


def test_ball_attached_to_the_attach_point_stays_when_the_fingers_open() -> None:
    robot = Robot("ur5_rg2_kinect_ball")
    sim, ball = robot.sim, robot.sim.scene.resolve("Ball")
    home, model = frames.get_position(sim, ball), sim.model
    hand = sim.scene.resolve("RG2")
    frames.set_position(sim, ball, hand, [0, 0, 0.187])
    editing.set_parent(sim, ball, sim.scene.resolve("RG2_attachPoint"), True)
    robot.grip(0.05)
    robot.aim(RESET)
    robot.wait(2)
    assert frames.get_position(sim, ball, hand) == pytest.approx([0, 0, 0.187], abs=1e-9)
    editing.set_parent(sim, ball, -1, True)
    robot.wait(2)
    assert frames.get_position(sim, ball)[2] < 0.3
    sim.stop()
    assert sim.model is model
    assert frames.get_position(sim, ball) == home
