"""Bytes that are not a message, or one that our clients never send: one kind of error, and others notice nothing."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import msgpack
import pytest
from fuzz import codec as target
from fuzz.calls import Victim
from loopback import LoopbackTransport
from plain_world import World

from simx_client.protocol import codec
from simx_client.protocol.codec import CodecError, decode_batch, decode_callers, encode
from simx_client.protocol.kinds import KINDS
from simx_client.protocol.messages import STATUS_REMOTE_ERROR, Batch, Call
from simx_server.limits import Limits

pytestmark = pytest.mark.slow

CASES = 6000


@pytest.fixture
def victim(tmp_path: Path) -> Iterator[Victim]:
    each = Victim(tmp_path)
    yield each
    each.close()


def test_no_bytes_are_more_than_an_error(tmp_path: Path) -> None:
    source = random.Random(1)
    for _ in range(CASES):
        data = bytes([source.choice((0, 1, 1, 1, 2, 3, 4, 6))]) + source.randbytes(source.randrange(60))
        try:
            target.one(data, tmp_path)
        except Exception as error:
            raise AssertionError(f"python tests/fuzz/run.py codec -r {data.hex()}") from error
    for seed in target.SEEDS:
        target.one(seed, tmp_path)
        for cut in range(len(seed)):
            target.one(seed[:cut], tmp_path)


def test_a_server_lives_through_bytes_that_are_no_message(victim: Victim) -> None:
    source = random.Random(2)
    good = encode(Batch(1, 2, [Call(3, 0, 0, "simxGetObjectHandle", ["arm"])]))
    for _ in range(300):
        data = bytearray(good)
        for _ in range(source.randrange(4)):
            data[source.randrange(len(data))] = source.randrange(256)
        victim.send(bytes(data[: source.randrange(len(data) + 1)]))


def test_lists_a_thousand_deep_are_a_wrong_argument_like_any_other(victim: Victim) -> None:
    head = b"\x93\x01\x02\x91\x95\x07\x00\x00" + msgpack.packb("simxGetObjectHandle") + b"\x91"
    for depth in (10, 500, 1010):
        victim.attacker.send(head + b"\x91" * depth + b"\x90")
        victim.world.loop.turn()
        victim.check(depth)
    [error, *_] = victim.world.loop.sessions[victim.attacker.client].errors
    assert "must be a text" in error


def test_a_wrong_value_is_told_in_a_line_however_large_it_is() -> None:
    large = [0] * 1_000_000
    for value in (
        "x" * 2_000_000,
        bytes(2_000_000),
        large,
        [large],
        [["x" * 2_000_000]],
        {"x" * 2_000_000: large},
    ):
        target.check_all(value)
    assert KINDS


def test_an_error_is_as_long_as_a_page_at_most(victim: Victim) -> None:
    name = "x" * 1_000_000
    [reply] = victim.endure([(0, 0, "simxGetIntegerSignal", [name])])
    assert len(reply.values[0]) < 5000
    [reply] = victim.endure([(0, 0, name, [])])
    assert len(reply.values[0]) < 5000
    assert all(len(error) < 5000 for error in victim.world.loop.sessions[victim.attacker.client].errors)


def test_a_byte_for_each_value_does_not_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(codec, "MOST_VALUES", 100_000)
    for filling in (b"\x90", b"\x00", b"\x80", b"\xa0", b"\xc0"):
        one = b"\xdd" + (90_000).to_bytes(4, "big") + filling * 90_000
        with pytest.raises(CodecError):
            decode_batch(b"\x93\x01\x02\x93" + one * 3)
    with pytest.raises(CodecError):
        decode_batch(
            b"\xdf"
            + (70_000).to_bytes(4, "big")
            + b"".join(msgpack.packb(f"{n}") + b"\x00" for n in range(70_000))
        )


def test_callers_are_found_without_reading_what_they_ask() -> None:
    calls = [Call(number, 0, 0, "simxSetStringSignal", ["a", bytes(1000), [[1.5]]]) for number in range(100)]
    assert decode_callers(encode(Batch(7, 8, calls)), 10) == (7, 8, list(range(10)))
    with pytest.raises(CodecError, match="cut off"):
        decode_callers(encode(Batch(7, 8, calls))[:-1], 1000)


def test_more_calls_than_a_message_may_have_are_each_refused() -> None:
    world = World()
    world.simulation.limits = Limits(calls=2)
    link = LoopbackTransport(world.loop)
    link.greet(1.0)
    link.send(encode(Batch(1, 2, [Call(number, 0, 0, "simxStartSimulation", []) for number in (5, 6, 7)])))
    answer = link.receive(1.0)
    assert answer is not None
    replies = codec.decode_delivery(answer).replies
    assert [(reply.call_id, reply.status) for reply in replies] == [(5, 8), (6, 8), (7, STATUS_REMOTE_ERROR)]
    assert "--limit calls=N" in replies[0].values[0]
    assert world.simulation.log == []


def test_an_operation_that_there_is_not_is_refused(victim: Victim) -> None:
    for operation in (3, -1, 2**63):
        [reply] = victim.endure([(operation, 0, "simxStartSimulation", [])])
        assert reply.status == STATUS_REMOTE_ERROR
        assert "no operation" in reply.values[0]
    assert not victim.world.simulation.is_running


def test_large_numbers_in_a_map_become_infinity_as_elsewhere() -> None:
    packed = encode(Batch(1, 2, [Call(3, 0, 0, "", [{"a": 1e300, "b": [1e300]}])]))
    assert decode_batch(packed).calls[0].arguments == [{"a": float("inf"), "b": [float("inf")]}]
