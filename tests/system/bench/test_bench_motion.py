"""What `docs/internals/motion.md` says of robots holds: the fast rows of its tables."""

from __future__ import annotations

import pytest

from bench.motion.__main__ import ARMS, DRIVES, SCENES
from bench.motion.arms import arm
from bench.motion.cars import CARS, drive
from bench.motion.drives import differential, mecanum
from bench.motion.holding.grasps import trial
from bench.motion.holding.hands import SHIPPED

pytestmark = pytest.mark.slow


def test_a_robot_on_two_wheels_drives_straight_and_turns_as_its_wheels_say() -> None:
    found = differential(DRIVES["Pioneer P3-DX"])
    assert (found.speed, found.turning) == pytest.approx((1.0, 1.0), abs=0.005)
    assert found.side < 0.002
    assert found.yaw < 0.001
    assert found.wheels < 0.001


def test_a_mecanum_base_follows_its_kinematics_without_jitter() -> None:
    base = mecanum()
    assert base.error < 0.03
    assert base.jump < 0.002


def test_a_car_turns_about_the_point_where_its_wheels_axes_meet() -> None:
    name = "simple Ackermann steering"
    found = drive(SCENES / "models" / f"{name.replace(' ', '_').lower()}.xml", CARS[name])
    assert found.radius == pytest.approx(found.geometry, rel=0.003)
    assert found.geometry == pytest.approx(2.5772 / 0.4228, rel=0.003), "wheelbase / tan(0.4)"
    assert found.side < 0.001


def test_an_arm_lags_by_vreps_law_and_reports_the_inverse_dynamics() -> None:
    found = arm(ARMS["UR5"])
    assert found.lag < 1e-5
    assert found.force < 0.01
    assert found.peak < 0.5


def test_a_gripper_carries_a_cup_upside_down() -> None:
    held = trial(SCENES / "models" / "rg2.xml", SHIPPED["rg2.xml"], "cup", 0.2, seconds=2.0)
    assert not held.lost
    assert held.shift < 1
    assert held.creep < 0.1
    ((force, spread),) = held.force.values()
    assert abs(force) == pytest.approx(20, abs=0.1)
    assert spread < 0.01
