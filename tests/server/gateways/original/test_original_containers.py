"""Commands and replies of one original client, without sockets: what waits, what was dropped, message ids."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from original_peer import BLOCKING, ONESHOT, STREAMING, command, floats, ints, message, text

from simx_client.protocol.messages import Batch, Delivery, Operation, Reply
from simx_server.gateways.original import containers, messages, packets
from simx_server.gateways.original.containers import Containers
from simx_server.gateways.original.splitting import Incoming
from simx_server.limits import Limits

GET, SET, IMAGE = 0x1001, 0x1002, 0x1004


@pytest.fixture
def kept() -> Containers:
    return Containers(Limits)


def receive(kept: Containers, number: int, *commands: bytes) -> None:
    kept.receive(messages.read(message(number, *commands), 1000))


def batch_of(kept: Containers) -> Batch:
    batch = kept.take_batch()
    assert batch is not None
    return batch


def answer(kept: Containers, batch: Batch, *values: list[Any], status: int = 0, state: int = 0) -> None:
    replies = [
        Reply(call.call_id, status, 50, list(value)) for call, value in zip(batch.calls, values, strict=True)
    ]
    kept.absorb(Delivery(batch.message_id, batch.client_time, 99, 0x12345, state, replies))


def sent(kept: Containers) -> tuple[int, list[tuple[int, int, bytes, bool]]]:
    """The id of the next message, and its replies: id, mode, payload, failure."""
    data = kept.message()
    number, found, at = struct.unpack_from("<i", data, 3)[0], [], 18
    while at < len(data):
        size, _, ident, _, cmd, _, _, status, _ = struct.unpack_from("<iiHiiHiBB", data, at)
        found.append((cmd & 0xFFFF, cmd & 0x7FFF0000, data[at + 26 + ident : at + size], bool(status & 1)))
        at += size
    return number, found


def test_a_command_becomes_a_call_of_the_table_and_its_answer_a_reply(kept: Containers) -> None:
    receive(kept, 5, command(GET, ints(7)))
    batch = batch_of(kept)
    ((call_id, operation, delay, name, arguments),) = batch.calls
    assert (operation, delay, name, arguments) == (Operation.EXECUTE, 0, "simxGetJointPosition", [7])
    assert call_id > 0
    assert kept.is_waited_for
    answer(kept, batch, [0.5], state=5)
    assert not kept.is_waited_for
    data = kept.message()
    assert struct.unpack_from("<HBiiiHB", data) == (0, 11, 5, 1234, 99, 0x2345, 5)
    assert sent(kept) == (-1, [])


def test_commands_wait_and_replace_equal_ones_while_much_is_under_way(kept: Containers) -> None:
    batches = []
    for number in range(containers.MOST_UNDER_WAY):
        receive(kept, number, command(GET, ints(number), mode=ONESHOT))
        batches.append(batch_of(kept))
    for number in range(100, 110):
        receive(
            kept, number, command(SET, ints(7), floats(number), ONESHOT), command(GET, ints(7), mode=ONESHOT)
        )
        assert kept.take_batch() is None
    answer(kept, batches[0], [0.5])
    batch = batch_of(kept)
    assert [(call.command, call.arguments) for call in batch.calls] == [
        ("simxSetJointPosition", [7, 109.0]),
        ("simxGetJointPosition", [7]),
    ]


def test_images_and_steps_under_way_keep_nothing_back(kept: Containers) -> None:
    for number in range(3 * containers.MOST_UNDER_WAY):
        receive(kept, number, command(IMAGE, ints(number), mode=ONESHOT), command(0x0003))
        assert len(batch_of(kept).calls) == 2


def test_two_split_commands_that_are_equal_leave_the_first(kept: Containers) -> None:
    split = 0x30000
    receive(kept, 0, command(SET, ints(7), floats(1), split), command(SET, ints(7), floats(2), split))
    assert [call.arguments for call in batch_of(kept).calls] == [[7, 1.0]]


def test_a_client_is_slowed_down_when_much_of_it_waits(kept: Containers) -> None:
    for number in range(containers.MOST_UNDER_WAY):
        receive(kept, number, command(GET, ints(number), mode=ONESHOT))
        batch_of(kept)
    for number in range(2):
        assert not kept.is_full
        add = command(0x3016, text("s"), b"x", ONESHOT, keeps_equal=True)
        receive(kept, number, *[add] * (containers.MUCH_WAITING // 2 + 1))
    assert kept.is_full
    receive(kept, 9, command(0x3015, text("s"), bytes(10)))


def test_calls_that_the_server_loop_has_dropped_are_errors(kept: Containers) -> None:
    receive(kept, 3, command(GET, ints(1)))
    dropped = batch_of(kept)
    receive(kept, 4, command(GET, ints(2)))
    answer(kept, batch_of(kept), [0.5])
    number, replies = sent(kept)
    assert number == 4
    assert sorted(failed for _, _, _, failed in replies) == [False, True]
    answer(kept, dropped, [0.5])
    assert sent(kept) == (-1, []), "what comes after all is not sent twice"


def test_one_answer_to_many_sets_answers_each(kept: Containers) -> None:
    receive(kept, 0, *(command(SET, ints(joint), floats(1), ONESHOT) for joint in range(3)))
    batch = batch_of(kept)
    kept.absorb(Delivery(batch.message_id, 0, 0, 0, 0, [Reply(batch.calls[0].call_id, 0, 0, [3])]))
    assert len(sent(kept)[1]) == 3


def test_a_new_value_of_a_stream_replaces_an_unsent_one(kept: Containers) -> None:
    receive(kept, 0, command(GET, ints(7), mode=STREAMING, low=20))
    batch = batch_of(kept)
    assert (batch.calls[0].operation, batch.calls[0].delay_ms) == (Operation.STREAM, 20)
    for value in (1.0, 2.0, 3.0):
        answer(kept, batch, [value])
    assert sent(kept) == (0, [(GET, STREAMING, floats(3.0), False)])
    receive(kept, 1, command(GET, ints(7), mode=STREAMING, low=30))
    cancel, stream = batch_of(kept).calls
    assert (cancel.operation, cancel.arguments) == (Operation.CANCEL, [batch.calls[0].call_id])
    assert (stream.operation, stream.delay_ms) == (Operation.STREAM, 30)
    answer(kept, batch, [4.0])
    assert sent(kept)[1] == [], "a value of the old stream is no value of the new one"


def test_a_result_that_does_not_fit_the_protocol_is_an_error(kept: Containers) -> None:
    receive(kept, 0, command(GET, ints(7)))
    answer(kept, batch_of(kept), [1e300])
    assert sent(kept)[1] == [(GET, BLOCKING, b"", True)]


def test_pieces_beyond_the_limit_push_out_older_ones() -> None:
    incoming = Incoming(1500)
    whole = messages.read(message(0, command(0x3015, text("s"), bytes(600), 0x30000, full=900)), 9).requests[
        0
    ]
    assert incoming.add(whole) is None
    assert incoming.add(whole._replace(ident=text("t"))) is None
    assert incoming.add(whole._replace(payload=bytes(300), offset=600)) is None, "its beginning was forgotten"


def test_packets_of_a_message_have_one_size_but_the_last() -> None:
    assert [len(each) for each in packets.packets(bytes(100), 56)] == [56, 56]
    assert [len(each) for each in packets.packets(bytes(101), 56)] == [56, 56, 7]
    assert list(packets.packets(b"x")) == [b"\1\0\1\0\0\0x"]
