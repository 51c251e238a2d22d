"""Arms follow the target dummies that public scripts move; hands and grippers grasp; a gripper is mounted on an arm."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from model_checks import position_of, rotation_of
from real_world import BLOCKING, Open, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = pytest.mark.slow

ONESHOT = vrep.simx_opmode_oneshot


def bend(client: int, arm: str, values: Sequence[float]) -> None:
    for number, value in enumerate(values, 1):
        joint = handle_of(client, f"{arm}_joint{number}")
        vrep.simxSetJointTargetPosition(client, joint, value, ONESHOT)
    step(client, 4.0)


def quaternion_after(turn: Sequence[float], angle: float, first: Sequence[float]) -> list[float]:
    """x, y, z, w of a turn about a world axis after the rotation `first`."""
    axis = np.array(turn) / np.linalg.norm(turn) * math.sin(angle / 2)
    vector, scalar = np.array(first[:3]), first[3]
    w = math.cos(angle / 2)
    return [*(w * vector + scalar * axis + np.cross(axis, vector)), w * scalar - float(axis @ vector)]


def miss(client: int, tip: int, target: int) -> tuple[float, float]:
    """Metres and degrees between the two."""
    apart = float(np.linalg.norm(rotation_of(client, tip) - rotation_of(client, target))) / math.sqrt(8)
    return math.dist(position_of(client, tip), position_of(client, target)), math.degrees(
        2 * math.asin(apart)
    )


UR_BENT = (0.0, 0.6, 1.2, 0.0, 1.2, 0.0)
IIWA_BENT = (0.0, 0.6, 0.0, -1.3, 0.0, 1.0, 0.0)
JACO_BENT = (2.5, 3.9, 1.3, 3.3, 5.6, 2.7)

GOALS = (
    ((0.05, 0.04, 0.03), (0, 0, 1), 0.3),
    ((-0.06, 0.05, -0.04), (1, 0, 0), 0.25),
    ((0.03, -0.06, 0.02), (0, 1, 0), -0.3),
    ((0.0, 0.07, -0.06), (1, 1, 0), 0.2),
    ((-0.04, -0.03, -0.07), (0, 1, 1), -0.4),
)
"""Ways from where the bent arm's tip is: metres, and a turn in rad about an axis."""


@pytest.mark.parametrize(
    ("scene", "arm", "tip_name", "target_name", "bent"),
    [
        ("ur3", "UR3", "UR3_tip", "UR3_target", UR_BENT),
        ("ur5", "UR5", "UR5_ikTip", "UR5_ikTarget", UR_BENT),
        ("ur5", "UR5", "UR5_tip", "UR5_target", UR_BENT),
        ("ur10", "UR10", "UR10_tip", "UR10_target", UR_BENT),
        ("lbr_iiwa_7_r800", "LBR_iiwa_7_R800", "LBR_iiwa_7_R800_tip", "LBR_iiwa_7_R800_target", IIWA_BENT),
        ("jaco", "Jaco", "Jaco_tip", "Jaco_target", JACO_BENT),
    ],
)
def test_arm_follows_its_target_dummy(
    world: Open,
    scene: str,
    arm: str,
    tip_name: str,
    target_name: str,
    bent: Sequence[float],
    record_property: Callable[[str, str], None],
) -> None:
    _, client = world(scene)
    tip, target = handle_of(client, tip_name), handle_of(client, target_name)
    assert miss(client, tip, target)[0] < 1e-3
    assert miss(client, tip, target)[1] < 0.1
    start_stepped(client)
    bend(client, arm, bent)
    assert miss(client, tip, target)[0] > 0.1, "joint targets count until the target is moved"
    start = position_of(client, tip)
    _, turned = vrep.simxGetObjectQuaternion(client, tip, -1, BLOCKING)
    worst = [0.0, 0.0]
    for way, axis, angle in GOALS:
        place = [a + b for a, b in zip(start, way, strict=True)]
        vrep.simxSetObjectPosition(client, target, -1, place, ONESHOT)
        vrep.simxSetObjectQuaternion(client, target, -1, quaternion_after(axis, angle, turned), ONESHOT)
        step(client, 3.0)
        error = miss(client, tip, target)
        worst = [max(pair) for pair in zip(worst, error, strict=True)]
        assert position_of(client, target) == pytest.approx(place, abs=1e-5)
        assert error[0] < 0.001, (way, error)
        assert error[1] < 0.5, (way, error)
    record_property("figures", f"{target_name}: worst {worst[0] * 1000:.3f} mm, {worst[1]:.4f} deg")


def test_arm_obeys_joint_targets_again_after_a_stop(world: Open) -> None:
    _, client = world("ur10")
    target, elbow = handle_of(client, "UR10_target"), handle_of(client, "UR10_joint3")
    start_stepped(client)
    bend(client, "UR10", UR_BENT)
    vrep.simxSetObjectPosition(client, target, -1, [-0.3, 0.4, 0.8], BLOCKING)
    step(client, 2.0)
    reached = vrep.simxGetJointPosition(client, elbow, BLOCKING)[1]
    assert vrep.simxSetJointTargetPosition(client, elbow, 0.2, BLOCKING) == vrep.simx_return_ok
    step(client, 1.0)
    assert vrep.simxGetJointPosition(client, elbow, BLOCKING)[1] == pytest.approx(
        reached, abs=0.01
    )  # IK decides
    assert vrep.simxStopSimulation(client, BLOCKING) == vrep.simx_return_ok
    start_stepped(client)
    bend(client, "UR10", UR_BENT)
    assert vrep.simxGetJointPosition(client, elbow, BLOCKING)[1] == pytest.approx(1.2, abs=1e-3)


def test_jaco_grasps_the_cylinder_from_above_and_lifts_it(
    world: Open, record_property: Callable[[str, str], None]
) -> None:
    _, client = world("jaco")
    target, hand, cylinder = (handle_of(client, name) for name in ("Jaco_target", "JacoHand", "Cylinder"))
    motors = [
        handle_of(client, f"JacoHand_{fingers}_motor{number}")
        for fingers in ("fingers12", "finger3")
        for number in (1, 2)
    ]

    def move(begin: float, end: float) -> None:
        for share in np.linspace(0, 1, 16):
            height = begin + (end - begin) * float(share)
            vrep.simxSetObjectPosition(client, target, -1, [0.3, 0.3, height], ONESHOT)
            step(client, 0.1)

    start_stepped(client)
    bend(client, "Jaco", (2.356, 2.3, 1.4, 3.14, 3.14, 3.14))
    vrep.simxSetObjectPosition(client, target, -1, [0.3, 0.3, 0.25], ONESHOT)
    vrep.simxSetObjectOrientation(client, target, -1, [math.pi, 0, 0], ONESHOT)
    step(client, 3.0)
    move(0.25, 0.1)
    resting = position_of(client, cylinder)
    assert resting == pytest.approx([0.3, 0.3, 0.06], abs=1e-3), "nothing has touched it yet"
    for motor in motors:
        vrep.simxSetJointTargetVelocity(client, motor, -0.04, ONESHOT)
    step(client, 2.0)
    move(0.1, 0.3)
    step(client, 0.5)
    held = position_of(client, cylinder, hand)
    step(client, 3.0)
    slip = math.dist(held, position_of(client, cylinder, hand))
    lifted = position_of(client, cylinder)[2] - resting[2]
    record_property("figures", f"Jaco: lifted {lifted * 1000:.0f} mm, slip in 3 s {slip * 1000:.2f} mm")
    assert lifted > 0.18
    assert slip < 0.002
    for motor in motors:
        vrep.simxSetJointTargetVelocity(client, motor, 0.04, ONESHOT)
    step(client, 2.0)
    assert position_of(client, cylinder)[2] < 0.1


def test_rg2_obeys_its_signal(world: Open) -> None:
    _, client = world("stock_kinect")
    code, _ = vrep.simxLoadModel(client, "models/components/grippers/RG2.ttm", 0, BLOCKING)
    assert code == vrep.simx_return_ok
    opening = handle_of(client, "RG2_openCloseJoint")
    start_stepped(client)
    for signal, place in ((1, 0.0538), (0, -0.0472), (1, 0.0538)):
        vrep.simxSetIntegerSignal(client, "RG2_open", signal, BLOCKING)
        step(client, 2.5)
        assert vrep.simxGetJointPosition(client, opening, BLOCKING)[1] == pytest.approx(place, abs=1e-3)


def test_rg2_mounted_by_a_script_rides_on_a_ur10(world: Open) -> None:
    """V-REP's way: load the gripper, put it onto the flange, give it the flange's force sensor as parent."""
    _, client = world("ur10")
    _, gripper = vrep.simxLoadModel(client, "RG2.ttm", 0, BLOCKING)
    flange, opening = handle_of(client, "UR10_connection"), handle_of(client, "RG2_openCloseJoint")
    vrep.simxSetObjectPosition(client, gripper, flange, [0, 0, 0.012], BLOCKING)
    vrep.simxSetObjectOrientation(client, gripper, flange, [0, 0, 0], BLOCKING)
    assert vrep.simxSetObjectParent(client, gripper, flange, True, BLOCKING) == vrep.simx_return_ok
    start_stepped(client)
    vrep.simxSetIntegerSignal(client, "RG2_open", 0, BLOCKING)
    bend(client, "UR10", UR_BENT)
    assert position_of(client, gripper, flange) == pytest.approx([0, 0, 0.012], abs=1e-4)
    assert vrep.simxGetJointPosition(client, opening, BLOCKING)[1] < -0.045
    for number, value in enumerate(UR_BENT, 1):
        joint = handle_of(client, f"UR10_joint{number}")
        assert vrep.simxGetJointPosition(client, joint, BLOCKING)[1] == pytest.approx(value, abs=2e-3)
