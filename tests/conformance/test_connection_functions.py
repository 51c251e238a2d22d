"""Connection and client helpers (the reference's 3.1), over the in-process transport where one is needed.

simxStart itself needs a network: see ``test_over_zenoh.py`` and ``tests/server/gateways/zenoh/test_zenoh.py``.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
from conforming import BLOCKING, BUFFER, NOVALUE, OK, ONESHOT, REMOTE_ERROR, STREAMING, of
from real_world import start_stepped

import simx_client as v
from simx_client.connection.clients import CLIENTS, Clients
from simx_client.connection.connection import Connection
from simx_client.errors import ConnectionFailed
from simx_client.protocol.kinds import MAX_ITEMS, MAX_TEXT
from simx_server.limits import Limits

STATE = v.simx_headeroffset_server_state


@of("simxStart")
@pytest.mark.parametrize("port", [0, -1, 70_000])
def test_start_gives_minus_1_for_a_port_that_cannot_be(simx: Any, port: int) -> None:
    client = simx("127.0.0.1", port, True, True, 200, 5)
    assert client == -1
    assert type(client) is int


def test_the_lowest_of_255_ids_is_given_and_minus_1_when_all_are_used() -> None:
    def unreachable() -> Any:
        raise ConnectionFailed("nobody there")

    clients = Clients()
    connections = [Connection(unreachable, where=str(number)) for number in range(256)]
    assert [clients.add(each) for each in connections[:255]] == list(range(255))
    assert clients.add(connections[255]) == -1
    clients.remove(7)
    clients.remove(3)
    assert clients.add(connections[0]) == -1, "this place has one already"
    assert clients.add(connections[255]) == 3
    clients.remove(-1)
    assert clients.get(0) is None


@of("simxStart")
def test_start_names_an_argument_of_a_wrong_kind(simx: Any) -> None:
    with pytest.raises(TypeError, match="simxStart: connectionPort needs an integer, got str '19997'"):
        simx("127.0.0.1", "19997", True, True, 5000, 5)
    with pytest.raises(TypeError, match="simxStart: connectionAddress needs a string"):
        simx(None, 19997, True, True, 5000, 5)


@of("simxFinish")
def test_finish_gives_none_frees_the_id_and_calls_then_give_64(world: Any, simx: Any) -> None:
    first, second = world.client(), world.client()
    assert (first, second) == (0, 1)
    assert simx(first) is None
    assert v.simxGetObjects(first, v.sim_handle_all, BLOCKING) == (64, [])
    assert v.simxGetObjects(second, v.sim_handle_all, BLOCKING)[0] == OK
    assert world.client() == 0
    assert simx(-1) is None
    assert v.simxGetConnectionId(1) == -1
    for unknown in (-1, -2, 255, 12):
        assert simx(unknown) is None


@of("simxFinish")
def test_finish_lets_the_oneshots_before_it_be_executed(world: Any, cid: int, simx: Any) -> None:
    v.simxSetIntegerSignal(cid, "last", 7, ONESHOT)
    simx(cid)
    assert v.simxGetIntegerSignal(world.client(), "last", BLOCKING) == (OK, 7)


@of("simxGetConnectionId")
def test_connection_id_is_1_minus_1_while_lost_and_counts_reconnections(world: Any, simx: Any) -> None:
    cid = world.client()  # an embedded one cannot be lost
    assert simx(cid) == 1
    assert type(simx(cid)) is int
    assert simx(99) == -1
    v.simxGetObjects(cid, v.sim_handle_all, STREAMING)
    world.loop.turn()
    assert v.simxGetObjects(cid, v.sim_handle_all, BUFFER)[0] == OK
    connection = CLIENTS.get(cid)
    assert connection is not None
    transport: Any = connection._transport
    transport.lose()
    assert simx(cid) == -1
    assert v.simxGetObjects(cid, v.sim_handle_all, BUFFER) == (NOVALUE, []), "and it is not 64"
    assert v.simxGetInMessageInfo(cid, STATE) == (-1, 0)
    transport._connected = True  # a server is there again
    assert simx(cid) == 2
    world.loop.turn()
    assert v.simxGetObjects(cid, v.sim_handle_all, BUFFER)[0] == OK, "the stream is armed again"
    assert v.simxGetObjects(cid, v.sim_handle_all, BLOCKING)[0] == OK


@of("simxGetPingTime")
def test_ping_gives_milliseconds_and_0_0_for_an_unknown_client(cid: int, simx: Any) -> None:
    code, milliseconds = simx(cid)
    assert (code, type(milliseconds)) == (OK, int)
    assert 0 <= milliseconds < 1000
    assert simx(99) == (0, 0)


@of("simxGetPingTime")
def test_ping_returns_when_everything_sent_before_has_been_executed(cid: int, simx: Any) -> None:
    for value in range(5):
        v.simxSetIntegerSignal(cid, f"s{value}", value, ONESHOT)
    simx(cid)
    assert [v.simxGetIntegerSignal(cid, f"s{value}", BLOCKING) for value in range(5)] == [
        (0, n) for n in range(5)
    ]


@of("simxGetPingTime")
def test_ping_takes_nothing_away_that_a_script_has_asked_for(cid: int, simx: Any) -> None:
    """The original's was a blocking read of the version, so a script's own read of that had no value afterwards."""
    v.simxGetIntegerParameter(cid, v.sim_intparam_program_version, ONESHOT)
    simx(cid)
    assert v.simxGetIntegerParameter(cid, v.sim_intparam_program_version, BUFFER) == (0, 30602)


@of("simxGetPingTime")
def test_an_answer_to_a_ping_that_comes_too_late_is_nobodys(cid: int, simx: Any) -> None:
    v.simxPauseCommunication(cid, True)
    assert simx(cid)[0] == v.simx_return_timeout_flag | NOVALUE
    v.simxPauseCommunication(cid, False)
    for mode in (BUFFER, ONESHOT, STREAMING, BUFFER):
        code, version = v.simxGetIntegerParameter(cid, v.sim_intparam_program_version, mode)
        assert (code, version) in ((v.simx_return_novalue_flag, 0), (0, 30602))
    assert simx(cid)[0] == OK


@of("simxGetLastCmdTime")
def test_last_command_time_is_simulated_milliseconds_of_the_reply_fetched_last(cid: int, simx: Any) -> None:
    assert simx(cid) == 0
    start_stepped(cid)
    for _ in range(3):
        v.simxSynchronousTrigger(cid)
    assert v.simxGetIntegerSignal(cid, "missing", BLOCKING)[0] == REMOTE_ERROR
    assert simx(cid) == 150, "error replies count too"
    assert type(simx(cid)) is int
    v.simxGetIntegerSignal(cid, "other", BUFFER)
    assert simx(cid) == 150, "a call that found no reply changes nothing"
    v.simxStopSimulation(cid, BLOCKING)
    v.simxGetPingTime(cid)
    assert simx(cid) == 0
    assert simx(99) == 0


@of("simxPauseCommunication")
def test_what_was_called_while_paused_arrives_together_and_only_the_last_of_a_key(
    world: Any, cid: int, simx: Any, handle: Any
) -> None:
    cube, lid = handle("cube"), handle("lid")
    assert simx(cid, True) == OK
    v.simxSetObjectPosition(cid, cube, -1, [5, 5, 5], ONESHOT)
    v.simxSetObjectPosition(cid, lid, -1, [1, 1, 1], ONESHOT)
    v.simxSetObjectPosition(cid, cube, lid, [0, 0, 1], ONESHOT)
    assert world.simulation.data.body("cube").xpos[0] == 2
    assert simx(cid, False) == OK
    assert v.simxGetObjectPosition(cid, cube, -1, BLOCKING)[1] == pytest.approx([1, 1, 2], abs=1e-6)
    assert simx(99, True) == 64


@of("simxPauseCommunication")
def test_what_is_read_while_paused_is_of_the_instant_of_the_pause(
    world: Any, cid: int, simx: Any, handle: Any
) -> None:
    falling = handle("falling")
    v.simxStartSimulation(cid, BLOCKING)
    v.simxGetObjectPosition(cid, falling, -1, STREAMING)
    world.loop.turn()
    simx(cid, True)
    at_pause = v.simxGetObjectPosition(cid, falling, -1, BUFFER)
    state = v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_time)
    for _ in range(3):
        world.loop.turn()
        assert v.simxGetObjectPosition(cid, falling, -1, BUFFER) == at_pause
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_time) == state
    simx(cid, False)
    assert v.simxGetObjectPosition(cid, falling, -1, BUFFER)[1][2] < at_pause[1][2]


@of("simxPauseCommunication")
def test_two_pauses_need_two_resumes_and_a_ping_meanwhile_is_3(cid: int, simx: Any) -> None:
    assert (simx(cid, True), simx(cid, True)) == (OK, OK)
    assert simx(cid, False) == OK
    code, milliseconds = v.simxGetPingTime(cid)
    assert (code, type(milliseconds)) == (3, int)
    assert simx(cid, False) == OK
    assert v.simxGetPingTime(cid)[0] == OK


@of("simxSynchronous")
def test_stepped_mode_holds_time_until_a_trigger(world: Any, cid: int, simx: Any) -> None:
    assert simx(cid, True) == OK
    v.simxStartSimulation(cid, BLOCKING)
    for _ in range(3):
        world.loop.turn()
    assert world.simulation.step_count == 0
    assert v.simxGetBoolParam(cid, v.sim_boolparam_waiting_for_trigger, BLOCKING) == (OK, True)
    assert simx(cid, False) == OK
    world.loop.turn()
    assert world.simulation.step_count > 0
    assert type(simx(cid, 1)) is int
    assert simx(99, True) == 64


@of("simxSynchronousTrigger")
def test_a_trigger_is_one_pass_and_8_when_there_can_be_none(world: Any, cid: int, simx: Any) -> None:
    assert simx(cid) == REMOTE_ERROR, "not enabled"
    v.simxSynchronous(cid, True)
    assert simx(cid) == REMOTE_ERROR, "stopped"
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid) == OK
    assert world.simulation.step_count == 1
    v.simxPauseSimulation(cid, BLOCKING)
    assert simx(cid) == REMOTE_ERROR, "paused"
    assert simx(99) == 64


@of("simxGetInMessageInfo")
def test_the_header_of_the_newest_reply_tells_the_servers_state(cid: int, simx: Any) -> None:
    v.simxGetPingTime(cid)
    assert simx(cid, STATE) == (1, 0)
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, STATE)[1] & 3 == 1
    v.simxPauseSimulation(cid, BLOCKING)
    assert simx(cid, STATE)[1] & 3 == 3
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, STATE)[1] & 3 == 0
    for field in (2, 3, 7, 11, 15, 17):
        result, value = simx(cid, field)
        assert (result, type(result), type(value)) == (1, int, int)
    assert simx(cid, 2) == (1, 11)
    assert simx(cid, 0) == (-1, 0)
    assert simx(99, STATE) == (-1, 0)


@of("simxGetInMessageInfo")
def test_the_header_tells_whether_simulated_time_follows_the_clock(world: Any, cid: int, simx: Any) -> None:
    assert v.simxSetBoolParam(cid, v.sim_boolparam_realtime_simulation, True, BLOCKING) == OK
    v.simxGetPingTime(cid)
    assert simx(cid, STATE)[1] & 4 == 4


@of("simxGetOutMessageInfo")
def test_the_header_of_the_next_message_counts_up(cid: int, simx: Any) -> None:
    assert simx(cid, v.simx_headeroffset_version) == (1, 11)
    before = simx(cid, v.simx_headeroffset_message_id)
    v.simxGetPingTime(cid)
    assert simx(cid, v.simx_headeroffset_message_id) == (1, before[1] + 1)
    result, now = simx(cid, v.simx_headeroffset_client_time)
    assert result == 1
    assert 0 <= now < 2**26
    assert simx(99, v.simx_headeroffset_version) == (1, 11)
    assert simx(99, v.simx_headeroffset_client_time)[0] == 1
    assert simx(99, v.simx_headeroffset_message_id) == (-1, 0)
    assert simx(cid, v.simx_headeroffset_server_state) == (-1, 0)


@of("simxCreateBuffer")
def test_a_buffer_holds_so_many_bytes(simx: Any) -> None:
    buffer = simx(4)
    buffer[3] = 255
    assert bytes(buffer[:4]) == b"\0\0\0\xff"


@of("simxReleaseBuffer")
def test_releasing_a_buffer_gives_none(simx: Any) -> None:
    assert simx(v.simxCreateBuffer(4)) is None


@of("simxPackInts")
def test_ints_are_packed_as_little_endian_int32(simx: Any) -> None:
    packed = simx([1, -2, 2**32 + 3])
    assert type(packed) is bytearray
    assert packed == struct.pack("<3i", 1, -2, 3)
    assert simx([]) == bytearray()


@of("simxUnpackInts")
@pytest.mark.parametrize("kind", [bytes, bytearray])
def test_unpacking_ints_ignores_trailing_bytes(simx: Any, kind: Any) -> None:
    assert simx(kind(struct.pack("<2i", 5, -6) + b"xyz")) == [5, -6]
    assert simx("\x01\0\0\0") == [1]
    assert simx(b"") == []


@of("simxPackFloats")
def test_floats_are_packed_as_little_endian_float32(simx: Any) -> None:
    packed = simx((0.5, -1))
    assert type(packed) is bytearray
    assert packed == struct.pack("<2f", 0.5, -1.0)


@of("simxUnpackFloats")
@pytest.mark.parametrize("kind", [bytes, bytearray])
def test_unpacking_floats_ignores_trailing_bytes(simx: Any, kind: Any) -> None:
    assert simx(kind(struct.pack("<2f", 0.5, -1.0) + b"xyz")) == [0.5, -1.0]
    assert simx(v.simxPackFloats([0.1])) == [0.10000000149011612]
    assert simx(b"") == []


def test_numbers_come_back_in_single_precision_and_ints_wrap(cid: int) -> None:
    v.simxSetFloatSignal(cid, "f", 0.1, BLOCKING)
    assert v.simxGetFloatSignal(cid, "f", BLOCKING) == (OK, 0.10000000149011612)
    v.simxSetIntegerSignal(cid, "i", 2**32 + 5, BLOCKING)
    assert v.simxGetIntegerSignal(cid, "i", BLOCKING) == (OK, 5)
    with pytest.raises(TypeError, match="signalValue needs an integer"):
        v.simxSetIntegerSignal(cid, "i", 1.5, BLOCKING)  # pyright: ignore[reportArgumentType] - is tested


@pytest.mark.parametrize("mode", [None, 65536.0, "blocking"])
def test_a_mode_that_is_no_integer_is_refused_by_name(cid: int, mode: Any) -> None:
    calls: list[Any] = [
        (v.simxGetObjects, [v.sim_handle_all]), (v.simxLoadModel, ["x.ttm", 1]),
        (v.simxTransferFile, ["x.ttm", "x.ttm", 5000]),
    ]  # fmt: skip
    for function, arguments in calls:
        with pytest.raises(TypeError, match=f"{function.__name__}: operationMode needs an integer"):
            function(cid, *arguments, mode)
    assert v.simxGetObjects(cid, v.sim_handle_all, np.int64(BLOCKING))[0] == OK


def test_names_end_at_a_nul_and_bytes_are_taken_as_they_are(cid: int) -> None:
    v.simxSetIntegerSignal(cid, "name\0more", 1, BLOCKING)
    assert v.simxGetIntegerSignal(cid, b"name", BLOCKING) == (OK, 1)


def test_short_vectors_are_filled_with_zeros_and_long_ones_refused(cid: int, handle: Any) -> None:
    lid = handle("lid")
    assert v.simxSetObjectPosition(cid, lid, -1, [1.0], BLOCKING) == OK
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING) == (OK, [1.0, 0.0, 0.0])
    with pytest.raises(IndexError):
        v.simxSetObjectPosition(cid, lid, -1, [1, 2, 3, 4], ONESHOT)


def test_a_stream_with_a_rate_and_modes_with_unknown_bits_are_accepted(world: Any, cid: int) -> None:
    v.simxGetObjects(cid, v.sim_handle_all, STREAMING + 10)
    world.loop.turn()
    assert v.simxGetObjects(cid, v.sim_handle_all, BUFFER)[0] == OK
    v.simxGetObjects(cid, v.sim_object_joint_type, 0x80000)
    world.loop.turn()
    assert v.simxGetObjects(cid, v.sim_object_joint_type, BUFFER)[0] == OK


def test_what_is_beyond_the_limits_is_an_error_and_the_server_goes_on(world: Any, cid: int) -> None:
    assert v.simxAddStatusbarMessage(cid, "x" * (MAX_TEXT + 1), BLOCKING) == REMOTE_ERROR
    assert v.simxSetObjectSelection(cid, [1] * (MAX_ITEMS + 1), BLOCKING) == REMOTE_ERROR
    world.simulation.limits = Limits(streams=3)
    v.simxStartSimulation(cid, BLOCKING)
    for number in range(4):
        v.simxSetIntegerSignal(cid, f"s{number}", 1, BLOCKING)
        v.simxGetIntegerSignal(cid, f"s{number}", STREAMING)
    world.loop.turn()
    for number in range(4):
        v.simxSetIntegerSignal(cid, f"s{number}", 2, BLOCKING)
    world.loop.turn()
    values = [v.simxGetIntegerSignal(cid, f"s{number}", BUFFER) for number in range(4)]
    assert values == [(OK, 2)] * 3 + [(OK, 1)], "the fourth was executed once"
    assert "at most 3 streams" in v.simxGetLastErrors(cid, BLOCKING)[1][-1]
