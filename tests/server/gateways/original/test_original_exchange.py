"""How messages, streams and pieces of the original's protocol follow each other: byte by byte over a socket."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
from original_peer import (
    BLOCKING,
    DISCONTINUE,
    ONESHOT,
    ONESHOT_SPLIT,
    STREAMING,
    STREAMING_SPLIT,
    Peer,
    Served,
    command,
    floats,
    ints,
    message,
    packed,
    peer,
    served,
    text,
)

from simx_client.protocol.messages import Pace

SCENE = Path(__file__).parents[3] / "conformance" / "scene.xml"
PING = command(0x1021, ints(1))


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Served]:
    with served(SCENE, tmp_path) as server:
        yield server


@pytest.fixture
def client(server: Served) -> Iterator[Peer]:
    with peer(server.port) as client:
        yield client


def test_an_empty_message_is_answered_by_a_header_that_says_that_nothing_was_executed(client: Peer) -> None:
    answer = client.exchange()
    assert (answer.number, answer.replies, answer.packets) == (-1, [], [18])


def test_a_blocking_call_is_answered_in_its_own_exchange(client: Peer) -> None:
    client.exchange()
    answer = client.exchange(PING)
    assert answer.number == 1
    assert answer.client_time == 1234
    assert [each.id for each in answer.replies] == [0x1021]


def test_a_stream_value_is_not_taken_for_the_answer_to_a_call_that_still_waits(client: Peer) -> None:
    """The trigger is answered after the step of both clients, so this one's call waits."""
    assert not client.call(0x0001).has_failed
    client.call(0x1007, ints(0))
    client.call(0x3014, text("i"), ints(1))
    client.until(0x3011, command(0x3011, text("i"), mode=STREAMING))
    number = client.number
    with peer(client.socket.getpeername()[1]) as other:
        other.call(0x0001)
        seen = [client.exchange(command(0x0003))]
        other.call(0x3014, text("i"), ints(2))
        # Streams are sent meanwhile; an answer from before the change may still have the old value.
        while not any(reply.payload == ints(2) for reply in seen[-1].replies):
            seen.append(client.exchange())
        assert all(each.number < number for each in seen), "but nothing as new as the trigger's message"
        assert not other.call(0x0003).has_failed
        assert not client.until(0x0003).has_failed


def test_the_last_of_equal_commands_of_one_message_is_executed_in_the_place_of_the_first(
    server: Served, client: Peer
) -> None:
    signal = text("s")
    client.exchange(
        command(0x3014, text("i"), ints(1), ONESHOT),
        command(0x3016, signal, b"a", ONESHOT, keeps_equal=True),
        command(0x3016, signal, b"b", ONESHOT, keeps_equal=True),
        command(0x3014, text("i"), ints(2), ONESHOT),
    )
    assert client.call(0x3011, text("i")).payload == ints(2)
    assert client.call(0x3012, signal).payload == b"ab", "these are all executed"
    assert [each.id for each in client.seen].count(0x3014) == 1


def test_a_stream_goes_on_until_it_is_discontinued_and_the_end_is_echoed(client: Peer) -> None:
    client.call(0x0001)
    client.call(0x1007, ints(0))
    client.until(0x1021, command(0x1021, ints(1), mode=STREAMING), mode=STREAMING)
    for step in (1, 2, 3):
        client.call(0x0003)
        assert [each.time_ms for each in client.seen if each.id == 0x1021][-1] == 50 * step
    client.exchange(command(0x1021, ints(1), mode=DISCONTINUE))
    echoes = [each for each in client.seen if each.mode == DISCONTINUE]
    assert [(each.id, each.payload, each.has_failed) for each in echoes] == [(0x1021, b"", False)]
    del client.seen[:]
    client.call(0x0003)
    assert [each.id for each in client.seen] == [0x0003]


def test_a_blocking_call_ends_the_stream_of_its_key(client: Peer) -> None:
    client.call(0x0001)
    client.call(0x1007, ints(0))
    client.until(0x1021, command(0x1021, ints(1), mode=STREAMING), mode=STREAMING)
    client.call(0x1021, ints(1))
    del client.seen[:]
    client.call(0x0003)
    assert [each.id for each in client.seen] == [0x0003]


def test_a_stream_with_a_delay_comes_no_more_often(client: Peer) -> None:
    client.call(0x0001)
    client.call(0x1007, ints(0))
    client.until(0x1021, command(0x1021, ints(1), mode=STREAMING, low=60_000), mode=STREAMING)
    del client.seen[:]
    for _ in range(3):
        client.call(0x0003)
    assert {each.time_ms for each in client.seen if each.id == 0x1021} <= {0}


def test_unread_parts_of_a_string_stream_are_joined(client: Peer) -> None:
    client.until(0x3018, command(0x3018, text("s"), mode=STREAMING))
    del client.seen[:]
    client.call(0x0001)
    client.call(0x1007, ints(0))
    for part in (b"ab", b"cd", b"ef"):
        client.call(0x3016, text("s"), part, keeps_equal=True)
        client.call(0x0003)
    assert b"".join(each.payload for each in client.seen if each.id == 0x3018) == b"abcdef"


def test_get_and_clear_streams_until_its_hit(client: Peer) -> None:
    assert client.until(0x3017, command(0x3017, text("s"), mode=STREAMING)).has_failed
    client.call(0x3015, text("s"), b"one")
    while not (hits := [each for each in client.seen if each.id == 0x3017 and not each.has_failed]):
        client.exchange()  # the hit may have come with an answer to the call already
    assert [hit.payload for hit in hits] == [b"one"]
    client.call(0x3015, text("s"), b"two")
    assert client.call(0x3012, text("s")).payload == b"two", "the stream has ended"


def test_a_command_in_pieces_is_executed_when_it_is_complete(client: Peer) -> None:
    data, ident = bytes(range(250)) * 4, text("s")
    for at in range(0, 1000, 300):
        part = data[at : at + 300]
        if at:
            assert client.call(0x3012, ident).has_failed, "not complete"
        client.exchange(command(0x3015, ident, part, ONESHOT_SPLIT, 300, full=1000, offset=at))
    assert client.call(0x3012, ident).payload == data


def test_pieces_of_another_size_begin_a_command_again(client: Peer) -> None:
    ident = text("s")
    client.exchange(command(0x3015, ident, b"a" * 100, ONESHOT_SPLIT, 100, full=250, offset=0))
    client.exchange(command(0x3015, ident, b"b" * 100, ONESHOT_SPLIT, 100, full=150, offset=0))
    client.exchange(command(0x3015, ident, b"c" * 50, ONESHOT_SPLIT, 100, full=150, offset=100))
    assert client.call(0x3012, ident).payload == b"b" * 100 + b"c" * 50
    client.exchange(command(0x3015, ident, b"d" * 50, ONESHOT_SPLIT, 100, full=150, offset=50))
    assert client.call(0x3012, ident).payload == b"b" * 100 + b"c" * 50, "a piece without its beginning"


@pytest.mark.parametrize("mode", [ONESHOT_SPLIT, STREAMING_SPLIT])
def test_a_reply_comes_in_pieces_one_for_each_message(client: Peer, mode: int) -> None:
    data, ident = bytes(range(250)) * 4, text("s")
    client.call(0x3015, ident, data)
    pieces = [client.until(0x3012, command(0x3012, ident, mode=mode, low=300))]
    while len(pieces) < 4:
        answer = client.exchange()
        assert answer.number == -1, "nothing was executed"
        pieces += answer.replies
    assert [each.offset for each in pieces] == [0, 300, 600, 900]
    assert {(each.full_size, each.low, each.mode) for each in pieces} == {(26 + len(ident) + 1000, 300, mode)}
    assert b"".join(each.payload for each in pieces) == data
    if mode == ONESHOT_SPLIT:
        assert client.exchange().replies == []
    else:
        assert client.until(0x3012).offset == 0, "the stream goes on"
        client.exchange(command(0x3012, ident, mode=DISCONTINUE))
        assert client.seen[-1].payload == b""


def test_a_long_answer_has_packets_of_one_size_and_a_shorter_last_one(client: Peer) -> None:
    data = bytes(200_000)
    client.call(0x3015, text("s"), data)
    answer = client.exchange(command(0x3012, text("s")))
    while not answer.replies:
        answer = client.exchange()
    assert answer.replies[0].payload == data
    assert len(answer.packets) > 1
    assert set(answer.packets[:-1]) == {29_994}
    assert answer.packets[-1] <= 29_994


def test_the_last_command_of_a_client_is_executed_before_it_leaves(server: Served, client: Peer) -> None:
    client.exchange(command(0x3014, text("i"), ints(5), ONESHOT), command(0x000A, bytes(4), b"", ONESHOT))
    assert client.is_cut()
    with peer(server.port) as other:
        assert other.call(0x3011, text("i")).payload == ints(5)


def test_a_client_that_leaves_ends_its_stepped_mode(server: Served, client: Peer) -> None:
    with peer(server.port) as other:
        other.call(0x0001)
        other.call(0x1007, ints(0))
        assert other.call(0x1021, ints(1)).time_ms == 0
    while client.call(0x1021, ints(1)).time_ms == 0:
        pass


def test_several_clients_use_one_port_and_one_simulation(server: Served, client: Peer) -> None:
    with peer(server.port) as other:
        client.call(0x3013, text("f"), floats(2.5))
        assert other.call(0x3010, text("f")).payload == floats(2.5)
        assert len({session.name for session in server.world.loop.service.clients.sessions.values()}) == 2


def test_a_message_in_single_bytes_is_read(client: Peer) -> None:
    for byte in packed(message(0, PING), size=7):
        client.socket.sendall(bytes((byte,)))
    answer = client.read()
    assert [each.id for each in answer.replies] == [0x1021]


def test_a_client_that_repeats_a_stream_starts_it_once(server: Served, client: Peer) -> None:
    for _ in range(50):
        client.exchange(command(0x1021, ints(1), mode=STREAMING))
    (session,) = server.world.loop.service.clients.sessions.values()
    assert session.called["simxGetIntegerParameter"] == 1
    assert len(session.streams.by_id) == 1


def test_ids_of_messages_go_on_over_a_reconnection(server: Served) -> None:
    with peer(server.port) as client:
        client.number = 1000
        assert client.exchange(PING).number == 1000
        assert struct.unpack("<i", client.call(0x1021, ints(1)).payload)[0] > 0


def test_a_mode_that_does_not_exist_is_oneshot(client: Peer) -> None:
    client.exchange(command(0x3014, text("i"), ints(3), 0x90000))
    assert client.until(0x3014).mode == 0x90000
    assert client.call(0x3011, text("i")).payload == ints(3)
    assert BLOCKING == 0x10000


def test_a_repeated_blocking_call_waits_for_the_next_step_as_in_the_original(tmp_path: Path) -> None:
    with served(SCENE, tmp_path, Pace.REPEAT) as server, peer(server.port) as client:
        client.call(0x1007, ints(0))
        times = [client.call(0x1021, ints(1)).time_ms for _ in range(20)]
        assert sorted(set(times)) == times, "no two calls of one step"


def test_blocking_calls_of_a_stopped_or_stepped_simulation_wait_for_no_step(tmp_path: Path) -> None:
    with served(SCENE, tmp_path, Pace.EVERY) as server, peer(server.port) as client:
        for _ in range(3):
            assert client.call(0x1021, ints(1)).time_ms == 0
        client.call(0x0001)
        client.call(0x1007, ints(0))
        client.call(0x0003)
        for _ in range(3):
            assert client.call(0x1021, ints(1)).time_ms == 50
