"""Answers of the operation modes when something goes wrong: remote errors, time-outs, invalid clients."""

from mode_world import GET, SET, cid, world

import simx_client as v
from simx_client.connection import connection

__all__ = ["cid", "world"]


def test_a_remote_error_gives_8_and_defaults_and_its_text_once(world, cid):
    assert GET(cid, -5, v.simx_opmode_blocking) == (8, 0.0)
    code, errors = v.simxGetLastErrors(cid, v.simx_opmode_blocking)
    assert code == 0
    assert errors == ["simxGetJointPosition: no object with handle -5"]
    assert v.simxGetLastErrors(cid, v.simx_opmode_blocking) == (0, [])


def test_at_most_50_errors_are_kept_the_newest(cid):
    for handle in range(1, 61):
        GET(cid, -handle, v.simx_opmode_blocking)
    errors = v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1]
    assert len(errors) == 50
    assert errors[-1].endswith("-60")


def test_the_reason_of_a_remote_error_is_logged_once(cid, caplog):
    for _ in range(3):
        GET(cid, -5, v.simx_opmode_blocking)
    told = [r for r in caplog.records if r.name.startswith("simx_client")]
    assert len(told) == 1
    assert "no object with handle -5" in told[0].message


def test_a_function_that_comes_later_exists_and_says_so(cid):
    assert v.simxLoadUI(cid, "x.ttb", 0, v.simx_opmode_blocking) == (8, [])
    errors = v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1]
    assert "simxLoadUI is not available in this version" in errors[0]


def test_an_unknown_client_gives_64_and_defaults():
    assert GET(17, 3, v.simx_opmode_blocking) == (64, 0.0)
    assert GET(-1, 3, v.simx_opmode_streaming) == (64, 0.0)
    assert SET(17, 3, 1.0, v.simx_opmode_oneshot) == 64
    assert v.simxGetPingTime(17) == (0, 0)
    assert v.simxSynchronous(17, True) == v.simxSynchronousTrigger(17) == 64
    assert v.simxPauseCommunication(17, True) == 64
    assert v.simxGetConnectionId(17) == -1
    assert v.simxGetConnectionId(17 != -1) == -1
    assert v.simxGetInMessageInfo(17, v.simx_headeroffset_server_state) == (-1, 0)
    v.simxFinish(17)


def test_a_time_out_is_3_and_the_late_reply_waits_in_the_inbox(world):
    cid = world.client(timeout=0.01)
    code, resolution, image = v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_blocking)
    assert (code, resolution, image) == (3, [], [])
    world.simulation.pictures[0].set_result(([1, 1], bytes([1, 2, 255])))
    assert v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_buffer) == (0, [1, 1], [1, 2, -1])


def test_a_time_out_with_an_older_reply_is_2_and_removes_it(world):
    cid = world.client(timeout=0.01)
    v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_oneshot)
    world.settle()
    world.simulation.pictures[0].set_result(([1, 1], bytes(3)))
    assert v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_buffer)[0] == 0
    assert v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_blocking)[0] == 2
    assert v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_buffer)[0] == 1


def test_a_message_that_is_too_large_is_not_sent_and_each_call_says_so(cid, monkeypatch, caplog):
    """The server would close the connection."""
    monkeypatch.setattr(connection, "MAX_BATCH", 1000)
    assert (
        v.simxSetStringSignal(cid, "s", bytes(2000), v.simx_opmode_blocking)
        == v.simx_return_remote_error_flag
    )
    assert "at most 1000 are" in caplog.text
    v.simxPauseCommunication(cid, True)
    for _ in range(3):
        SET(cid, 3, 1.0, v.simx_opmode_oneshot)
    v.simxSetStringSignal(cid, "s", bytes(2000), v.simx_opmode_oneshot)
    v.simxPauseCommunication(cid, False)
    assert SET(cid, 3, 1.0, v.simx_opmode_buffer) == v.simx_return_remote_error_flag
    assert GET(cid, 3, v.simx_opmode_blocking)[0] == 0
