"""Stock arms go where joint targets send them, by V-REP's tables and their makers' numbers, and as fast as V-REP's."""

from __future__ import annotations

import math
from collections.abc import Sequence

import arm_stock
import numpy as np
import pytest
from arm_stock import ARMS, SCENES
from model_checks import REVOLUTE, Stock, load_model, position_of, rotation_of
from real_world import BLOCKING, Open, handle_of, start_stepped, step

import simx_client as vrep

pytestmark = pytest.mark.slow


def turn(axis: Sequence[float], angle: float) -> np.ndarray:
    """(3, 3) rotation about an axis, by Rodrigues' formula."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * skew + (1 - math.cos(angle)) * skew @ skew


def from_table(rows: Sequence[Stock], values: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Where the table's axes put the arm's end: position, and rotation against the zero pose."""
    joints = [row for row in rows if row.kind == REVOLUTE]
    place, rotation = np.array(rows[-1].position), np.eye(3)
    for row, value in reversed(list(zip(joints, values, strict=True))):
        assert row.position is not None
        assert row.axis is not None
        turned = turn(row.axis, value - (row.position_q or 0.0))
        place = np.array(row.position) + turned @ (place - np.array(row.position))
        rotation = turned @ rotation
    return place, rotation


def ur_by_denavit_hartenberg(
    d: Sequence[float], a: Sequence[float], values: Sequence[float]
) -> tuple[np.ndarray, np.ndarray]:
    """The maker's table: flange in the base frame, whose axes are V-REP's. d: d1, d4, d5, d6; a: a2, a3 (positive)."""
    rows = zip(
        np.array(values) + np.radians([-90, -90, 0, -90, 0, 0]),
        (d[0], 0, 0, *d[1:]),
        (0, -a[0], -a[1], 0, 0, 0),
        np.radians([90, 0, 0, 90, -90, 0]),
        strict=True,
    )
    pose = np.eye(4)
    for theta, along, across, alpha in rows:
        step_pose = np.eye(4)
        step_pose[:3, :3] = turn((0, 0, 1), theta) @ turn((1, 0, 0), alpha)
        step_pose[:3, 3] = across * math.cos(theta), across * math.sin(theta), along
        pose = pose @ step_pose
    return pose[:3, 3], pose[:3, :3]


def set_joints(client: int, rows: Sequence[Stock], values: Sequence[float], seconds: float) -> list[float]:
    """Send target positions and wait; the positions that were reached."""
    handles = [handle_of(client, row.name) for row in rows if row.kind == REVOLUTE]
    for handle, value in zip(handles, values, strict=True):
        vrep.simxSetJointTargetPosition(client, handle, value, vrep.simx_opmode_oneshot)
    step(client, seconds)
    return [vrep.simxGetJointPosition(client, handle, BLOCKING)[1] for handle in handles]


@pytest.mark.parametrize("file", ARMS)
def test_joint_targets_put_the_end_where_the_table_says(world: Open, file: str) -> None:
    _, client = world("stock_kinect")
    rows = ARMS[file]
    load_model(client, file, (0.0, 0.0))
    end = handle_of(client, rows[-1].name)
    zero = rotation_of(client, end)
    start_stepped(client)
    rest = [row.position_q or 0.0 for row in rows if row.kind == REVOLUTE]
    for bend in (
        (0.5, 0.4, 0.7, -0.6, 0.8, 1.0, 0.3),
        (2.0, 0.6, 0.9, 0.9, 0.6, -1.1, 1.2),
    ):
        values = [value + change for value, change in zip(rest, bend, strict=False)]
        reached = set_joints(client, rows, values, 5.0)
        assert reached == pytest.approx(values, abs=5e-4)
        place, rotation = from_table(rows, values)
        # The tables give places to a tenth of a millimetre and axes to a thousandth, at an arm's length.
        assert math.dist(position_of(client, end), place) < 0.003
        assert np.abs(rotation_of(client, end) - rotation @ zero).max() < 0.005


def test_irb140_joints_are_set_as_those_of_kinematic_models(world: Open) -> None:
    _, client = world("stock_kinect")
    rows = arm_stock.IRB140
    load_model(client, "ABB IRB 140.ttm", (0.0, 0.0))
    end = handle_of(client, rows[-1].name)
    start = rotation_of(client, end)
    start_stepped(client)
    values = (0.6, -0.5, 0.4, 0.7, -0.9, 1.1)
    for row, value in zip((row for row in rows if row.kind == REVOLUTE), values, strict=True):
        assert vrep.simxSetJointPosition(client, handle_of(client, row.name), value, BLOCKING) == 0
    step(client, 4.0)
    place, rotation = from_table(rows, values)
    assert math.dist(position_of(client, end), place) < 0.002
    assert np.abs(rotation_of(client, end) - rotation @ start).max() < 0.005


def test_7_dof_manipulator_follows_its_target_by_itself(world: Open) -> None:
    _, client = world("stock_kinect")
    load_model(client, "7 DoF manipulator.ttm", (0.0, 0.0))
    load_model(client, "7 DoF manipulator.ttm", (1.0, 1.0))
    start_stepped(client)
    for suffix, way in (("", (-0.05, 0.1, 0.1)), ("#0", (0.02, -0.15, -0.1))):
        tip, target = (handle_of(client, f"redundantRob_{name}{suffix}") for name in ("tip", "target"))
        goal = [a + b for a, b in zip(position_of(client, target), way, strict=True)]
        vrep.simxSetObjectPosition(client, target, -1, goal, BLOCKING)
        step(client, 3.0)
        assert position_of(client, tip) == pytest.approx(goal, abs=1e-3)
        assert np.abs(rotation_of(client, tip) - rotation_of(client, target)).max() < 0.005


def test_franka_agrees_with_its_makers_numbers(world: Open) -> None:
    """Craig's form of the table: across and turn about the last axis's x, then along and turn about z."""
    _, client = world("stock_kinect")
    load_model(client, "FrankaEmikaPanda.ttm", (0.0, 0.0))
    end = handle_of(client, "Franka_connection")
    start_stepped(client)
    quarter = math.pi / 2
    table = zip(
        (0, 0, 0, 0.0825, -0.0825, 0, 0.088),
        (0, -quarter, quarter, quarter, -quarter, quarter, quarter),
        (0.333, 0, 0.316, 0, 0.384, 0, 0.107),
        strict=True,
    )
    values = (0.4, -0.6, 0.3, -1.9, 0.5, 1.4, -0.7)
    reached = set_joints(client, arm_stock.FRANKA, values, 4.0)
    assert reached == pytest.approx(values, abs=5e-4)
    place, rotation = np.zeros(3), np.eye(3)
    for (across, alpha, along), theta in zip(table, values, strict=True):
        place = place + rotation @ np.array([across, 0, 0])
        rotation = rotation @ turn((1, 0, 0), alpha) @ turn((0, 0, 1), theta)
        place = place + rotation @ np.array([0, 0, along])
    assert math.dist(position_of(client, end), place) < 1e-3
    assert rotation_of(client, end)[:, 2] == pytest.approx(rotation[:, 2], abs=2e-3)


@pytest.mark.parametrize(
    ("scene", "rows", "d", "a", "x", "hidden"),
    [
        ("ur3", arm_stock.UR3, (0.1519, 0.11235, 0.08535, 0.0819), (0.24365, 0.21325), 0.0, 0.00025),
        ("ur5", arm_stock.UR5, (0.089159, 0.10915, 0.09465, 0.0823), (0.425, 0.39225), 0.0, 0.00645),
        ("ur10", arm_stock.UR10, (0.128, 0.163941, 0.1157, 0.0922), (0.612, 0.5723), -0.0086, 0.007541),
    ],
)
def test_universal_robots_agree_with_their_makers_numbers(
    world: Open,
    scene: str,
    rows: Sequence[Stock],
    d: Sequence[float],
    a: Sequence[float],
    x: float,
    hidden: float,
) -> None:
    """x: of the shoulder's axis. hidden: how far behind the flange's face V-REP has its force sensor."""
    _, client = world(scene)
    end = handle_of(client, rows[-1].name)
    start_stepped(client)
    for values in ((0.3, 0.5, 0.9, -0.4, 1.1, 0.2), (-1.0, -0.6, 1.4, 0.8, -0.7, 2.0)):
        set_joints(client, rows, values, 4.0)
        flange, rotation = ur_by_denavit_hartenberg(d, a, values)
        expected = flange - hidden * rotation[:, 2] + (x, 0, 0)
        assert math.dist(position_of(client, end), expected) < 1e-4
        assert rotation_of(client, end)[:, 2] == pytest.approx(rotation[:, 2], abs=1e-3)


@pytest.mark.parametrize("scene", SCENES)
def test_a_step_of_one_joint_settles_as_vreps_does(world: Open, scene: str) -> None:
    """P = 0.1 is 20 / s: 2 % of the way is left after 0.2 s; no joint overshoots, the others hardly notice."""
    _, client = world(scene)
    rows = [row for row in SCENES[scene] if row.kind == REVOLUTE]
    handles = [handle_of(client, row.name) for row in rows]
    start_stepped(client)
    bend = [(row.position_q or 0.0) + (0.3, 0.5)[k % 2] for k, row in enumerate(rows)]
    start = set_joints(client, rows, bend, 4.0)
    for index, handle in enumerate(handles):
        vrep.simxSetJointTargetPosition(client, handle, bend[index] + math.radians(1), BLOCKING)
        highest = 0.0
        for number in range(12):
            step(client, 0.05)
            moved = vrep.simxGetJointPosition(client, handle, BLOCKING)[1] - start[index]
            highest = max(highest, moved)
            if number == 5:
                assert moved == pytest.approx(math.radians(1), rel=0.03), rows[index].name
        assert highest < math.radians(1.02), rows[index].name
        others = [
            abs(vrep.simxGetJointPosition(client, other, BLOCKING)[1] - start[k])
            for k, other in enumerate(handles)
            if k > index
        ]
        assert max(others, default=0.0) < math.radians(0.05)
        start[index] = vrep.simxGetJointPosition(client, handle, BLOCKING)[1]
