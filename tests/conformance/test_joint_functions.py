"""Joints (the reference's 3.4): radians and metres, N m and N; the z axis of the joint's frame."""

from __future__ import annotations

import math
from typing import Any

import pytest
from conforming import BLOCKING, NO_OBJECT, OK, ONESHOT, REMOTE_ERROR, STREAMING, assert_types, of
from real_world import start_stepped, step

import simx_client as v


@pytest.fixture
def shoulder(handle: Any) -> int:
    return handle("shoulder")


@pytest.fixture
def elbow(handle: Any) -> int:
    return handle("elbow")


@pytest.fixture
def rail(handle: Any) -> int:
    return handle("rail")


@pytest.fixture
def ball(handle: Any) -> int:
    return handle("ball")


@pytest.fixture
def wrong(handle: Any, ball: int) -> list[int]:
    """Objects without a single joint value: a shape, no object, a spherical joint."""
    return [handle("cube"), NO_OBJECT, ball]


@of("simxGetJointPosition")
def test_a_position_is_radians_or_metres_and_8_for_what_has_none(
    cid: int, simx: Any, elbow: int, rail: int, wrong: list[int]
) -> None:
    v.simxSetJointPosition(cid, elbow, 0.5, BLOCKING)
    v.simxSetJointPosition(cid, rail, 0.25, BLOCKING)
    assert simx(cid, elbow, BLOCKING) == (OK, 0.5)
    assert simx(cid, rail, BLOCKING) == (OK, 0.25)
    assert_types(simx(cid, elbow, BLOCKING), (0, 0.0))
    for each in wrong:
        assert simx(cid, each, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxSetJointPosition")
def test_a_position_is_kept_inside_the_limits_and_a_cyclic_one_normalised(
    cid: int, simx: Any, shoulder: int, elbow: int, rail: int, wrong: list[int]
) -> None:
    for joint, value, kept in (
        (elbow, 3.0, 2.0),
        (elbow, -9.0, -2.0),
        (rail, 9.0, 1.5),
        (rail, -9.0, -0.5),
        (shoulder, 4.0, 4.0 - math.tau),
        (shoulder, -7.0, math.tau - 7.0),
    ):
        assert simx(cid, joint, value, BLOCKING) == OK
        assert v.simxGetJointPosition(cid, joint, BLOCKING)[1] == pytest.approx(kept, abs=1e-6)
    for each in wrong:
        assert simx(cid, each, 0.0, BLOCKING) == REMOTE_ERROR


@of("simxSetJointPosition")
def test_a_passive_joint_is_moved_while_the_simulation_runs_and_may_be_streamed(
    cid: int, simx: Any, rail: int
) -> None:
    start_stepped(cid)
    simx(cid, rail, 0.4, STREAMING)
    step(cid, 0.1)
    assert v.simxGetJointPosition(cid, rail, BLOCKING)[1] == pytest.approx(0.4, abs=1e-3)


@of("simxGetJointMatrix")
def test_the_matrix_turns_about_or_moves_along_z(
    cid: int, simx: Any, handle: Any, elbow: int, rail: int, ball: int
) -> None:
    v.simxSetJointPosition(cid, elbow, 0.5, BLOCKING)
    v.simxSetJointPosition(cid, rail, 0.25, BLOCKING)
    s, c = math.sin(0.5), math.cos(0.5)
    assert simx(cid, elbow, BLOCKING)[1] == pytest.approx([c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0], abs=1e-6)
    assert simx(cid, rail, BLOCKING)[1] == pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.25], abs=1e-6)
    assert simx(cid, ball, BLOCKING)[1] == pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], abs=1e-6)
    assert_types(simx(cid, elbow, BLOCKING), (0, [0.0]))
    for wrong in (NO_OBJECT, handle("cube")):
        assert simx(cid, wrong, BLOCKING) == (REMOTE_ERROR, [0.0] * 12)


@of("simxSetSphericalJointMatrix")
def test_a_spherical_joint_takes_a_rotation_and_ignores_the_translation(
    cid: int, simx: Any, ball: int, elbow: int
) -> None:
    turned = [0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7]
    assert simx(cid, ball, turned, BLOCKING) == OK
    expected = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]
    assert v.simxGetJointMatrix(cid, ball, BLOCKING)[1] == pytest.approx(expected, abs=1e-6)
    assert simx(cid, elbow, turned, BLOCKING) == REMOTE_ERROR
    assert simx(cid, NO_OBJECT, turned, BLOCKING) == REMOTE_ERROR


@of("simxSetJointTargetVelocity")
def test_a_motor_without_control_loop_follows_its_target_velocity(
    cid: int, simx: Any, shoulder: int, wrong: list[int]
) -> None:
    start_stepped(cid)
    assert simx(cid, shoulder, 0.5, BLOCKING) == OK
    step(cid, 1.0)
    assert v.simxGetJointPosition(cid, shoulder, BLOCKING)[1] == pytest.approx(0.5, abs=0.02)
    assert v.simxGetObjectFloatParameter(cid, shoulder, 2012, BLOCKING)[1] == pytest.approx(0.5, abs=0.01)
    assert simx(cid, shoulder, -0.5, BLOCKING) == OK
    step(cid, 1.0)
    assert v.simxGetJointPosition(cid, shoulder, BLOCKING)[1] == pytest.approx(0.0, abs=0.03)
    for each in wrong:
        assert simx(cid, each, 0.5, BLOCKING) == REMOTE_ERROR


@of("simxSetJointTargetVelocity")
def test_a_target_velocity_is_accepted_by_a_passive_joint_without_effect(
    cid: int, simx: Any, rail: int
) -> None:
    start_stepped(cid)
    assert simx(cid, rail, 1.0, BLOCKING) == OK
    step(cid, 0.2)
    assert v.simxGetJointPosition(cid, rail, BLOCKING)[1] == pytest.approx(0.0, abs=1e-3)


@of("simxSetJointTargetPosition")
def test_a_motor_with_control_loop_goes_to_its_target(
    cid: int, simx: Any, elbow: int, rail: int, wrong: list[int]
) -> None:
    start_stepped(cid)
    assert simx(cid, elbow, 1.0, BLOCKING) == OK
    step(cid, 2.0)
    assert v.simxGetJointPosition(cid, elbow, BLOCKING)[1] == pytest.approx(1.0, abs=0.01)
    assert simx(cid, rail, 1.0, BLOCKING) == REMOTE_ERROR, "not in force mode"
    for each in wrong:
        assert simx(cid, each, 1.0, BLOCKING) == REMOTE_ERROR


@of("simxGetJointForce")
def test_the_force_is_0_while_stopped_and_the_motors_torque_in_a_run(
    cid: int, simx: Any, shoulder: int, wrong: list[int]
) -> None:
    assert simx(cid, shoulder, BLOCKING) == (OK, 0.0)
    assert_types(simx(cid, shoulder, BLOCKING), (0, 0.0))
    start_stepped(cid)
    assert simx(cid, shoulder, BLOCKING) == (OK, 0.0), "no pass was made yet"
    v.simxSetJointForce(cid, shoulder, 2.0, BLOCKING)
    v.simxSetJointTargetVelocity(cid, shoulder, 10000.0, BLOCKING)
    step(cid, 0.1)
    assert simx(cid, shoulder, BLOCKING)[1] == pytest.approx(-2.0, rel=0.05), "it pushes the child upwards"
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, shoulder, BLOCKING) == (OK, 0.0)
    for each in wrong:
        assert simx(cid, each, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxGetJointMaxForce")
def test_the_largest_force_is_read(cid: int, simx: Any, elbow: int, wrong: list[int]) -> None:
    assert simx(cid, elbow, BLOCKING) == (OK, 50.0)
    for each in wrong:
        assert simx(cid, each, BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxSetJointForce")
def test_the_largest_force_limits_the_motor_and_both_signs_of_velocity_turn_it(
    cid: int, simx: Any, shoulder: int, wrong: list[int]
) -> None:
    start_stepped(cid)
    speeds = []
    for sign in (1.0, -1.0):
        v.simxPauseCommunication(cid, True)
        v.simxSetJointTargetVelocity(cid, shoulder, sign * 10000.0, ONESHOT)
        simx(cid, shoulder, 1.0, ONESHOT)
        v.simxPauseCommunication(cid, False)
        step(cid, 0.1)
        speeds.append(v.simxGetObjectFloatParameter(cid, shoulder, 2012, BLOCKING)[1])
    assert v.simxGetJointMaxForce(cid, shoulder, BLOCKING) == (OK, 1.0)
    assert speeds[0] > 0.1
    assert abs(speeds[1]) < speeds[0] / 2, "the same torque the other way for the same time"
    for each in wrong:
        assert simx(cid, each, 1.0, BLOCKING) == REMOTE_ERROR
