"""Pictures, times and message headers in the operation modes: what is the newest, and what belongs to it."""

from concurrent.futures import Future
from typing import cast

from loopback import LoopbackTransport
from mode_world import GET, cid, world

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import decode_delivery

__all__ = ["cid", "world"]


def test_image_streams_travel_when_rendered_and_ask_for_one_at_a_time(world, cid):
    image = v.simxGetVisionSensorImage
    image(cid, 1, 0, v.simx_opmode_streaming)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    for _ in range(3):
        world.settle()
    assert len(world.simulation.pictures) == 1
    world.simulation.pictures[0].set_result(([1, 1], bytes([1, 1, 1])))
    world.settle()
    assert image(cid, 1, 0, v.simx_opmode_buffer) == (0, [1, 1], [1, 1, 1])
    world.simulation.pictures[1].set_result(([1, 1], bytes([2, 2, 2])))
    assert image(cid, 1, 0, v.simx_opmode_buffer) == (0, [1, 1], [2, 2, 2])


def test_an_image_asked_for_again_before_it_is_made_is_made_once(world, cid):
    image = v.simxGetVisionSensorImage
    for _ in range(5):
        assert image(cid, 1, 0, v.simx_opmode_oneshot)[0] == 1
        world.settle()
    assert len(world.simulation.pictures) == 1
    world.simulation.pictures[0].set_result(([1, 1], bytes([1, 1, 1])))
    assert image(cid, 1, 0, v.simx_opmode_oneshot) == (0, [1, 1], [1, 1, 1])
    world.settle()
    assert len(world.simulation.pictures) == 2


def test_an_image_that_is_given_up_or_no_image_is_an_error_and_no_time_out(world, cid):
    image = v.simxGetVisionSensorImage
    for end in (Future.cancel, lambda future: future.set_result(None)):
        image(cid, 1, 0, v.simx_opmode_oneshot)
        world.settle()
        end(world.simulation.pictures[-1])
        assert image(cid, 1, 0, v.simx_opmode_buffer) == (8, [], [])


def test_grey_and_colour_images_are_different_streams(world, cid):
    v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_oneshot)
    v.simxGetVisionSensorImage(cid, 1, 1, v.simx_opmode_oneshot)
    world.settle()
    world.simulation.pictures[1].set_result(([1, 1], bytes([9])))
    assert v.simxGetVisionSensorImage(cid, 1, 0, v.simx_opmode_buffer)[0] == 1
    assert v.simxGetVisionSensorImage(cid, 1, 1, v.simx_opmode_buffer) == (0, [1, 1], [9])


def test_last_command_time_is_simulated_milliseconds_of_the_reply_fetched(world, cid):
    assert v.simxGetLastCmdTime(cid) == 0
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    for _ in range(3):
        v.simxSynchronousTrigger(cid)
    GET(cid, 3, v.simx_opmode_blocking)
    assert v.simxGetLastCmdTime(cid) == 150
    v.simxStopSimulation(cid, v.simx_opmode_blocking)
    GET(cid, 3, v.simx_opmode_blocking)
    assert v.simxGetLastCmdTime(cid) == 0


def test_message_headers_tell_the_server_state(world, cid):
    state = v.simx_headeroffset_server_state
    v.simxGetPingTime(cid)
    assert v.simxGetInMessageInfo(cid, state) == (1, 0)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    assert v.simxGetInMessageInfo(cid, state)[1] & 1 == 1
    v.simxPauseSimulation(cid, v.simx_opmode_blocking)
    assert v.simxGetInMessageInfo(cid, state)[1] & 3 == 3
    v.simxStopSimulation(cid, v.simx_opmode_blocking)
    assert v.simxGetInMessageInfo(cid, state)[1] & 1 == 0
    assert v.simxGetInMessageInfo(cid, 0) == (-1, 0)
    assert v.simxGetOutMessageInfo(cid, v.simx_headeroffset_version) == (1, 11)
    assert v.simxGetOutMessageInfo(cid, v.simx_headeroffset_message_id)[0] == 1


def test_values_of_a_stream_from_before_do_not_put_the_message_header_back(world, cid):
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    world.loop.turn(max_wait=1.0)  # the idle pass
    of_before = world.transports[cid]._stream[-1]
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.transports[cid]._turns = False  # nothing newer comes
    world.transports[cid].put_values(of_before)
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state)[1] & 1 == 1


def test_a_script_that_reads_in_pauses_only_reads_the_newest(world):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    v.simxGetJointPosition(cid, 1, v.simx_opmode_streaming)
    seen = []
    for _ in range(3):
        world.simulation.joints[1] = float(len(seen))
        v.simxSynchronousTrigger(cid)
        v.simxPauseCommunication(cid, True)
        seen.append(v.simxGetJointPosition(cid, 1, v.simx_opmode_buffer))
        v.simxPauseCommunication(cid, False)
    assert seen == [(0, 0.0), (0, 1.0), (0, 2.0)]


def test_values_of_a_stream_are_not_followed_by_the_answer_that_armed_it(world, monkeypatch):
    cid = world.client()
    connection = CLIENTS.get(cid)
    assert connection is not None
    transport = cast(LoopbackTransport, connection._transport)
    receive, newest = transport.receive, transport.newest
    is_quiet = True

    def late_receive(timeout, **hint):
        return None if timeout <= 0 and is_quiet else receive(timeout)

    def newest_after_all_has_come():
        nonlocal is_quiet
        payload = newest()
        is_quiet = False  # between two looks both came
        return payload

    v.simxGetJointPosition(cid, 1, v.simx_opmode_streaming)
    world.settle()
    world.simulation.joints[1] = 5.0
    while not transport._stream or decode_delivery(transport._stream[-1]).replies[0][3] != [5.0]:
        world.loop.turn(max_wait=0.01)
    monkeypatch.setattr(transport, "receive", late_receive)
    monkeypatch.setattr(transport, "newest", newest_after_all_has_come)
    v.simxGetJointPosition(cid, 1, v.simx_opmode_buffer)
    assert v.simxGetJointPosition(cid, 1, v.simx_opmode_buffer) == (0, 5.0)
