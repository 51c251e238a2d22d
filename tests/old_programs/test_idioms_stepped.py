"""Stepped mode and torque as old control loops use them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest
from idiom_world import IdiomWorld, connect, handle, idiom_world, start_stepped

import simx_client as vrep

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[IdiomWorld]:
    with idiom_world() as world:
        yield world


@pytest.fixture
def clientID(world: IdiomWorld) -> int:
    return connect()


@pytest.mark.parametrize("enable", [1, True])
@pytest.mark.parametrize("when", ["before start", "after start"])
def test_stepped_mode_is_entered_before_or_after_start(clientID: int, when: str, enable: int) -> None:
    if when == "before start":
        assert vrep.simxSynchronous(clientID, enable) == 0
    vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot_wait)
    if when == "after start":
        assert vrep.simxSynchronous(clientID, enable) == 0
    times = []
    for _ in range(3):
        assert vrep.simxSynchronousTrigger(clientID) == 0
        vrep.simxGetPingTime(clientID)
        times.append(vrep.simxGetLastCmdTime(clientID))
    assert times[1] - times[0] == times[2] - times[1] == 50


@pytest.mark.parametrize("ping", [True, False])
def test_what_is_read_after_a_trigger_is_of_the_new_step(clientID: int, ping: bool) -> None:
    """With the ping and from the buffer, or without it and by blocking calls: both are in the field."""
    rail = handle(clientID, "falling")
    vrep.simxGetObjectPosition(clientID, rail, -1, vrep.simx_opmode_streaming)
    start_stepped(clientID)
    heights = []
    for _ in range(4):
        vrep.simxSynchronousTrigger(clientID)
        if ping:
            vrep.simxGetPingTime(clientID)
        mode = vrep.simx_opmode_buffer if ping else vrep.simx_opmode_blocking
        heights.append(vrep.simxGetObjectPosition(clientID, rail, -1, mode)[1][2])
    drops = [above - below for above, below in itertools.pairwise(heights)]
    assert drops == sorted(drops)
    assert drops[1] - drops[0] == pytest.approx(
        9.81 * 0.05**2, rel=0.02
    )  # one step of free fall, no more, no less


def test_a_value_set_between_two_triggers_counts_for_the_next_step(clientID: int) -> None:
    shoulder = handle(clientID, "shoulder")
    start_stepped(clientID)
    before = vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1]
    vrep.simxSetJointTargetVelocity(clientID, shoulder, 1.0, vrep.simx_opmode_oneshot)
    still = vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1]
    vrep.simxSynchronousTrigger(clientID)
    after = vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1]
    assert still == before
    assert after - before > 0.03


def test_the_last_command_time_is_the_clock(clientID: int) -> None:
    shoulder = handle(clientID, "shoulder")
    vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_streaming)
    start_stepped(clientID)
    clock = []
    for _ in range(3):
        vrep.simxSynchronousTrigger(clientID)
        vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_buffer)
        clock.append(vrep.simxGetLastCmdTime(clientID))
    assert clock == [100, 150, 200]


@pytest.mark.parametrize("dt", [0.001, 0.005, 0.05])
def test_the_client_sets_the_time_step(clientID: int, dt: float) -> None:
    parameter = vrep.sim_floatparam_simulation_time_step
    vrep.simxSetFloatingParameter(clientID, parameter, dt, vrep.simx_opmode_oneshot)
    vrep.simxSynchronous(clientID, True)
    vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot)
    assert vrep.simxGetFloatingParameter(clientID, parameter, vrep.simx_opmode_blocking) == (
        0,
        pytest.approx(dt),
    )
    for _ in range(20):
        vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)
    assert vrep.simxGetLastCmdTime(clientID) == pytest.approx(20_000 * dt, abs=1)


def test_a_time_step_of_ten_seconds_is_answered_and_not_fatal(clientID: int) -> None:
    vrep.simxSetFloatingParameter(
        clientID, vrep.sim_floatparam_simulation_time_step, 10.0, vrep.simx_opmode_oneshot
    )
    start_stepped(clientID)
    assert vrep.simxGetPingTime(clientID)[0] == 0


def test_a_paused_block_of_sets_arrives_in_one_step(clientID: int) -> None:
    shoulder, elbow = handle(clientID, "shoulder"), handle(clientID, "elbow")
    start_stepped(clientID)
    for target in (0.2, 0.4):
        vrep.simxPauseCommunication(clientID, True)
        vrep.simxSetJointTargetVelocity(clientID, shoulder, target, vrep.simx_opmode_oneshot)
        vrep.simxSetJointTargetPosition(clientID, elbow, target, vrep.simx_opmode_oneshot)
        vrep.simxPauseCommunication(clientID, False)
        before = [
            vrep.simxGetJointPosition(clientID, j, vrep.simx_opmode_blocking)[1] for j in (shoulder, elbow)
        ]
        vrep.simxSynchronousTrigger(clientID)
        after = [
            vrep.simxGetJointPosition(clientID, j, vrep.simx_opmode_blocking)[1] for j in (shoulder, elbow)
        ]
        assert all(now - then > 0.005 for now, then in zip(after, before, strict=True))


def test_torque_is_a_velocity_out_of_reach_and_a_force_limit(clientID: int) -> None:
    """Constant torque on a free body: half of it turns the arm half as far; what is read is its reverse."""
    shoulder = handle(clientID, "shoulder")
    angles = []
    for torque in (0.2, 0.4, -0.4):
        start_stepped(clientID)
        for _ in range(10):
            velocity = 1000 if torque > 0 else -1000
            vrep.simxSetJointTargetVelocity(clientID, shoulder, velocity, vrep.simx_opmode_oneshot)
            vrep.simxSetJointForce(clientID, shoulder, abs(torque), vrep.simx_opmode_oneshot)
            vrep.simxSynchronousTrigger(clientID)
        angles.append(vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1])
        _, force = vrep.simxGetJointForce(clientID, shoulder, vrep.simx_opmode_blocking)
        assert force == pytest.approx(-torque, rel=0.05)
        vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)
    assert angles[0] > 0.01
    assert angles[1] == pytest.approx(2 * angles[0], rel=0.02)
    assert angles[2] == pytest.approx(-angles[1], rel=0.02)


@pytest.mark.parametrize("function", ["simxSetJointForce", "simxSetJointMaxForce"])
@pytest.mark.parametrize("speed", [1000, 9999.0])
def test_torque_and_sign_may_change_every_step(clientID: int, function: str, speed: float) -> None:
    shoulder = handle(clientID, "shoulder")
    set_force = getattr(vrep, function)
    start_stepped(clientID)
    for step in range(8):
        torque = 0.3 if step % 2 == 0 else -0.6
        wanted = speed if torque > 0 else -speed
        vrep.simxSetJointTargetVelocity(clientID, shoulder, wanted, vrep.simx_opmode_streaming)
        set_force(clientID, shoulder, abs(torque), vrep.simx_opmode_streaming)
        vrep.simxSynchronousTrigger(clientID)
        vrep.simxGetPingTime(clientID)
        _, force = vrep.simxGetJointForce(clientID, shoulder, vrep.simx_opmode_blocking)
        assert force == pytest.approx(-torque, rel=0.05)
