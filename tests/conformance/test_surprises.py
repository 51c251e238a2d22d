"""The fifteen surprises of the original (the reference's 0.1), each as this server has it.

Where the answer differs from the original on purpose, ``simx_client/protocol/differences.py`` says so by number.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from conforming import BLOCKING, BUFFER, FOLDER, NO_OBJECT, NOVALUE, OK, ONESHOT, REMOTE_ERROR, STREAMING
from real_world import start_stepped, step

import simx_client as v
from simx_client.protocol.commands import BY_NAME
from simx_server.simulation.simulation import SimulationState

pytestmark = [pytest.mark.slow, pytest.mark.gl]


def test_01_the_code_is_that_of_the_previous_reply_and_values_are_defaults(world: Any, cid: int) -> None:
    assert v.simxGetObjectPosition(cid, NO_OBJECT, -1, ONESHOT) == (NOVALUE, [0.0] * 3)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, NO_OBJECT, -1, ONESHOT) == (REMOTE_ERROR, [0.0] * 3)
    assert v.simxGetObjectHandle(cid, "nobody", BLOCKING) == (REMOTE_ERROR, 0)


def test_02_a_blocking_call_ends_the_stream_of_its_key_and_empties_the_inbox(
    world: Any, cid: int, handle: Any
) -> None:
    lid = handle("lid")
    v.simxStartSimulation(cid, BLOCKING)
    v.simxGetObjectPosition(cid, lid, -1, STREAMING)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, lid, -1, BUFFER)[0] == OK
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[0] == OK
    for _ in range(3):
        world.loop.turn()
    assert v.simxGetObjectPosition(cid, lid, -1, BUFFER)[0] == NOVALUE


def test_02_a_oneshot_call_ends_the_stream_and_its_value_stays(world: Any, cid: int, handle: Any) -> None:
    falling = handle("falling")
    v.simxStartSimulation(cid, BLOCKING)
    v.simxGetObjectPosition(cid, falling, -1, STREAMING)
    world.loop.turn()
    v.simxGetObjectPosition(cid, falling, -1, ONESHOT)
    world.loop.turn()
    first = v.simxGetObjectPosition(cid, falling, -1, BUFFER)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, falling, -1, BUFFER) == first


def test_03_of_unsent_sets_of_one_object_only_the_last_survives_whatever_it_is_relative_to(
    cid: int, handle: Any
) -> None:
    lid = handle("lid")
    v.simxPauseCommunication(cid, True)
    v.simxSetObjectPosition(cid, lid, -1, [9, 9, 9], ONESHOT)
    v.simxSetObjectPosition(cid, lid, v.sim_handle_parent, [0, 0, 1], ONESHOT)
    v.simxPauseCommunication(cid, False)
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([-2, -3, 1.3], abs=1e-6)


def test_03_without_a_pause_every_call_is_sent_at_once_and_executed(
    world: Any, cid: int, handle: Any
) -> None:
    lid = handle("lid")
    v.simxSetObjectPosition(cid, lid, -1, [5, 5, 5], ONESHOT)
    v.simxSetObjectPosition(cid, lid, lid, [0, 0, 1], ONESHOT)
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([5, 5, 6], abs=1e-6)


@pytest.mark.parametrize("name", ["simxAppendStringSignal", "simxWriteStringStream"])
def test_03_calls_of_the_functions_that_never_overwrite_are_all_sent(cid: int, name: str) -> None:
    v.simxPauseCommunication(cid, True)
    for _ in range(3):
        getattr(v, name)(cid, "s", "x", ONESHOT)
        v.simxCreateDummy(cid, 0.1, None, ONESHOT)
    v.simxPauseCommunication(cid, False)
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (OK, bytearray(b"xxx"))
    dummies = v.simxGetObjects(cid, v.sim_object_dummy_type, BLOCKING)[1]
    assert len(dummies) == 1 + 3


def test_03_these_functions_never_overwrite() -> None:
    assert {name for name, command in BY_NAME.items() if command.keeps_every_call} == {
        "simxAddStatusbarMessage", "simxCreateDummy", "simxCallScriptFunction", "simxAuxiliaryConsolePrint",
        "simxCopyPasteObjects", "simxAppendStringSignal", "simxWriteStringStream",
    }  # fmt: skip


def test_04_a_blocking_script_call_returns_its_own_outputs(cid: int) -> None:
    pytest.importorskip("lupa")
    v.simxStartSimulation(cid, BLOCKING)
    call = v.simxCallScriptFunction
    call(cid, "robot", 1, "echo", [1], [], [], b"", ONESHOT)
    assert call(cid, "robot", 1, "echo", [2], [], [], b"", BLOCKING)[1] == [2]


def test_05_blocking_calls_are_answered_between_steps(world: Any, cid: int, handle: Any) -> None:
    lid = handle("lid")
    start_stepped(cid)
    for _ in range(10):
        assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[0] == OK
    assert world.simulation.step_count == 0


def test_06_a_trigger_answers_after_its_pass_and_trigger_with_ping_still_works(cid: int, handle: Any) -> None:
    falling = handle("falling")
    assert v.simxSynchronousTrigger(cid) == REMOTE_ERROR
    start_stepped(cid)
    for ping in (False, True):
        before = v.simxGetObjectPosition(cid, falling, -1, BLOCKING)[1][2]
        assert v.simxSynchronousTrigger(cid) == OK
        if ping:
            assert v.simxGetPingTime(cid)[0] == OK
        assert v.simxGetObjectPosition(cid, falling, -1, BLOCKING)[1][2] < before


def test_07_a_stop_ends_stepped_mode_and_it_must_be_asked_for_again(world: Any, cid: int) -> None:
    start_stepped(cid)
    v.simxStopSimulation(cid, BLOCKING)
    v.simxStartSimulation(cid, BLOCKING)
    for _ in range(3):
        world.loop.turn()
    assert world.simulation.step_count >= 3
    assert v.simxSynchronousTrigger(cid) == REMOTE_ERROR
    assert v.simxSynchronous(cid, True) == OK, "every service is enabled for it here"


def test_08_stop_has_happened_when_it_returns(world: Any, cid: int) -> None:
    v.simxStartSimulation(cid, BLOCKING)
    world.loop.turn()
    assert v.simxStopSimulation(cid, BLOCKING) == OK
    assert world.simulation.state is SimulationState.STOPPED
    v.simxGetPingTime(cid)
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state)[1] & 1 == 0


def test_09_message_info_is_1_for_success_and_moves_only_with_replies(world: Any, cid: int) -> None:
    state = v.simx_headeroffset_server_state
    v.simxGetPingTime(cid)
    assert v.simxGetInMessageInfo(cid, state) == (1, 0)
    world.simulation.start()
    world.loop.turn()
    assert v.simxGetInMessageInfo(cid, state) == (1, 0), "no reply has come since"
    v.simxGetPingTime(cid)
    assert v.simxGetInMessageInfo(cid, state) == (1, 1)


def test_10_images_are_bottom_row_first_signed_and_seen_along_plus_z(cid: int, handle: Any) -> None:
    sensor = handle("colour")
    _, size, image = v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)
    rows = np.array(image).reshape(size[1], size[0], 3)
    assert rows[0, 0].tolist() == [-1, 0, 0], "below left there is red"
    seen = v.simxGetObjectPosition(cid, handle("wall"), sensor, BLOCKING)[1]
    assert seen[2] == pytest.approx(1.1, abs=1e-5), "the wall is ahead along +z"
    v.simxSetObjectPosition(cid, handle("crate"), sensor, [0.3, 0, 1.0], BLOCKING)
    _, _, again = v.simxGetVisionSensorImage(cid, sensor, 0, BLOCKING)
    changed = np.any(np.array(again).reshape(rows.shape) != rows, axis=2)
    assert changed[:, :4].any(), "x in the sensor's frame goes to the left of the picture"
    assert not changed[:, 4:].any()
    wide = v.simxGetObjectFloatParameter(cid, sensor, v.sim_visionfloatparam_perspective_angle, BLOCKING)[1]
    assert wide > math.radians(60), "the angle belongs to the larger side"


def test_11_quaternions_end_with_the_scalar_and_angular_velocity_is_euler_rates_unless_flagged(
    cid: int, handle: Any
) -> None:
    lid, upper = handle("lid"), handle("upper")
    v.simxSetObjectOrientation(cid, lid, -1, [0.5, 0.0, 0.0], BLOCKING)
    expected = [math.sin(0.25), 0, 0, math.cos(0.25)]
    assert v.simxGetObjectQuaternion(cid, lid, -1, BLOCKING)[1] == pytest.approx(expected, abs=1e-6)
    v.simxSetObjectOrientation(cid, handle("robot"), -1, [0.7, 0.0, 0.0], BLOCKING)
    start_stepped(cid)
    v.simxSetJointTargetVelocity(cid, handle("shoulder"), 2.0, BLOCKING)
    step(cid, 0.5)
    rates = v.simxGetObjectVelocity(cid, upper, BLOCKING)[2]
    turn = v.simxGetObjectVelocity(cid, upper + 0x400000, BLOCKING)[2]
    assert turn == pytest.approx([0, -2 * math.sin(0.7), 2 * math.cos(0.7)], abs=0.03)
    assert rates != pytest.approx(turn, abs=1e-3)


def test_12_a_joint_as_reference_is_its_moving_frame_and_its_own_pose_ignores_its_value(
    cid: int, handle: Any
) -> None:
    elbow, lower = handle("elbow"), handle("lower")
    pose = v.simxGetObjectOrientation(cid, elbow, -1, BLOCKING)
    seen = v.simxGetObjectQuaternion(cid, lower, elbow, BLOCKING)[1]
    v.simxSetJointPosition(cid, elbow, 1.0, BLOCKING)
    assert v.simxGetObjectOrientation(cid, elbow, -1, BLOCKING) == pose
    assert v.simxGetObjectQuaternion(cid, lower, elbow, BLOCKING)[1] == pytest.approx(seen, abs=1e-6)


def test_13_is_about_connecting_and_held_over_the_network() -> None:
    text = (FOLDER / "test_over_zenoh.py").read_text(encoding="utf-8")
    assert "def test_13_" in text


def test_14_missing_signals_are_8_streams_are_not_and_parents_never_fail(world: Any, cid: int) -> None:
    assert v.simxGetIntegerSignal(cid, "missing", BLOCKING) == (REMOTE_ERROR, 0)
    assert v.simxReadStringStream(cid, "s", BLOCKING) == (4, bytearray())
    v.simxReadStringStream(cid, "s", ONESHOT)
    world.loop.turn()
    assert v.simxReadStringStream(cid, "s", BUFFER) == (OK, bytearray())
    assert v.simxGetObjectParent(cid, NO_OBJECT, BLOCKING) == (OK, -1)
    assert v.simxGetObjectChild(cid, NO_OBJECT, 0, BLOCKING) == (OK, -1)


def test_15_a_time_out_is_3_and_an_unknown_client_64_except_for_the_ping(cid: int) -> None:
    v.simxPauseCommunication(cid, True)
    assert v.simxGetObjects(cid, v.sim_handle_all, BLOCKING) == (3, [])
    assert v.simxGetObjects(99, v.sim_handle_all, BLOCKING) == (64, [])
    assert v.simxGetPingTime(99) == (0, 0)
