"""Signals and string streams as clients use them: every operation mode, two clients, limits."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator

import numpy as np
import pytest
from handler_calls import World
from observing import observe
from real_world import BLOCKING, RealWorld

import simx_client as v
from simx_server.errors import CommandError
from simx_server.limits import Limits

STREAMING, BUFFER, ONESHOT = v.simx_opmode_streaming, v.simx_opmode_buffer, v.simx_opmode_oneshot
SPLIT = v.simx_opmode_streaming_split + 4000
EVERY_BYTE = bytes(range(256))


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWorld]:
    scene = tmp_path_factory.mktemp("scene") / "scene.xml"
    scene.write_text("<mujoco/>", encoding="utf-8")
    world = RealWorld(scene, workspace=scene.parent)
    yield world
    world.close()


@pytest.fixture
def cid(world: RealWorld) -> Iterator[int]:
    client = world.client()
    yield client
    for clear in (v.simxClearStringSignal, v.simxClearIntegerSignal, v.simxClearFloatSignal):
        clear(client, "", BLOCKING)
    v.simxStopSimulation(client, BLOCKING)
    v.simxFinish(client)


@pytest.mark.parametrize(
    "value",
    [
        EVERY_BYTE,
        bytearray(EVERY_BYTE),
        memoryview(EVERY_BYTE),
        (ctypes.c_ubyte * 256).from_buffer_copy(EVERY_BYTE),
        np.frombuffer(EVERY_BYTE, np.uint8),
    ],
    ids=lambda value: type(value).__name__,
)
def test_every_byte_arrives_whatever_holds_it(cid: int, value: object) -> None:
    assert v.simxSetStringSignal(cid, "s", value, BLOCKING) == 0  # type: ignore[arg-type]
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (0, bytearray(EVERY_BYTE))


def test_streamed_signal_follows_its_value_and_fails_while_it_is_missing(world: RealWorld, cid: int) -> None:
    writer = world.client()
    assert v.simxGetIntegerSignal(cid, "n", STREAMING) == (1, 0)
    v.simxStartSimulation(cid, BLOCKING)
    for value in (3, -4):
        v.simxSetInt32Signal(writer, "n", value, BLOCKING)
        world.loop.turn()
        assert v.simxGetIntegerSignal(cid, "n", BUFFER) == (0, value)
    v.simxClearIntegerSignal(writer, "n", BLOCKING)
    world.loop.turn()
    assert v.simxGetIntegerSignal(cid, "n", BUFFER) == (8, 0)
    v.simxGetIntegerSignal(cid, "n", v.simx_opmode_discontinue)
    v.simxGetPingTime(cid)
    assert v.simxGetIntegerSignal(cid, "n", BUFFER) == (1, 0)
    v.simxFinish(writer)


def test_streamed_set_is_applied_again_after_each_step(world: RealWorld, cid: int) -> None:
    other = world.client()
    v.simxSetFloatSignal(cid, "x", 1.5, STREAMING)
    v.simxStartSimulation(cid, BLOCKING)
    v.simxSetFloatSignal(other, "x", 2.5, BLOCKING)
    world.loop.turn()
    assert v.simxGetFloatSignal(other, "x", BLOCKING) == (0, 1.5)
    v.simxSetFloatSignal(cid, "x", 3.5, BLOCKING)
    world.loop.turn()
    assert v.simxGetFloatSignal(other, "x", BLOCKING) == (0, 3.5), "blocking ended the stream"
    v.simxFinish(other)


def test_empty_names_set_nothing_are_missing_and_clear_all_of_a_kind(cid: int) -> None:
    v.simxSetFloatSignal(cid, "f", 1.0, BLOCKING)
    for name in ("a", "b"):
        v.simxSetStringSignal(cid, name, b"x", BLOCKING)
    assert v.simxSetStringSignal(cid, "", b"x", BLOCKING) == 0
    assert v.simxAppendStringSignal(cid, "", b"x", BLOCKING) == 0
    assert v.simxGetStringSignal(cid, "", BLOCKING) == (8, bytearray())
    assert v.simxClearStringSignal(cid, "", BLOCKING) == 0
    assert [v.simxGetStringSignal(cid, name, BLOCKING)[0] for name in "ab"] == [8, 8]
    assert v.simxGetFloatSignal(cid, "f", BLOCKING) == (0, 1.0)


@pytest.mark.parametrize("mode", [STREAMING, SPLIT, STREAMING + 1])
def test_string_stream_loses_nothing_between_reads(world: RealWorld, cid: int, mode: int) -> None:
    writer = world.client()
    v.simxReadStringStream(cid, "s", mode)
    v.simxStartSimulation(cid, BLOCKING)
    got = bytearray()
    for number in range(20):
        v.simxWriteStringStream(writer, "s", bytes([number, 0]), ONESHOT)
        v.simxGetPingTime(writer)
        if number % 3 == 0:
            code, data = v.simxReadStringStream(cid, "s", BUFFER)
            assert code in (0, 1)
            got += data
    deadline = 1000
    while len(got) < 40 and deadline:
        world.loop.turn(max_wait=0.001)
        got += v.simxReadStringStream(cid, "s", BUFFER)[1]
        deadline -= 1
    assert got == bytes(byte for number in range(20) for byte in (number, 0))
    v.simxFinish(writer)


def test_string_stream_in_the_other_modes(world: RealWorld, cid: int) -> None:
    assert v.simxReadStringStream(cid, "s", BLOCKING) == (4, bytearray())
    assert v.simxReadStringStream(cid, "s", BUFFER) == (1, bytearray())
    v.simxAppendStringSignal(cid, "s", b"one", BLOCKING)
    assert v.simxReadStringStream(cid, "s", ONESHOT) == (1, bytearray())
    v.simxGetPingTime(cid)
    assert v.simxReadStringStream(cid, "s", ONESHOT) == (0, bytearray(b"one"))
    v.simxGetPingTime(cid)
    assert v.simxReadStringStream(cid, "s", v.simx_opmode_remove) == (0, bytearray())
    assert v.simxReadStringStream(cid, "s", v.simx_opmode_remove) == (1, bytearray())
    v.simxReadStringStream(cid, "s", STREAMING)
    v.simxAppendStringSignal(cid, "s", b"two", BLOCKING)
    v.simxStartSimulation(cid, BLOCKING)
    world.loop.turn()
    assert v.simxReadStringStream(cid, "s", v.simx_opmode_discontinue) == (0, bytearray(b"two"))
    v.simxGetPingTime(cid)
    assert v.simxReadStringStream(cid, "s", BUFFER) == (1, bytearray())
    v.simxAppendStringSignal(cid, "s", b"three", BLOCKING)
    world.loop.turn()
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (0, bytearray(b"three")), "nobody takes it any more"


def test_data_on_its_way_survives_another_rate_of_the_stream(world: RealWorld, cid: int) -> None:
    writer = world.client()
    v.simxStartSimulation(cid, BLOCKING)
    v.simxReadStringStream(cid, "s", STREAMING)
    v.simxGetPingTime(cid)
    v.simxPauseCommunication(cid, True)
    v.simxReadStringStream(cid, "s", STREAMING + 1)
    for number in range(3):
        v.simxAppendStringSignal(writer, "s", bytes([number]), BLOCKING)
        world.loop.turn()
    v.simxPauseCommunication(cid, False)
    v.simxAppendStringSignal(writer, "s", b"\3", BLOCKING)
    got = v.simxReadStringStream(cid, "s", ONESHOT)[1]
    v.simxGetPingTime(cid)
    assert got + v.simxReadStringStream(cid, "s", BUFFER)[1] == bytes(range(4))
    v.simxFinish(writer)


def test_two_readers_of_a_stream_share_its_data_and_none_is_doubled(world: RealWorld, cid: int) -> None:
    other = world.client()
    v.simxStartSimulation(cid, BLOCKING)
    for client in (cid, other):
        v.simxReadStringStream(client, "s", STREAMING)
    for number in range(10):
        v.simxAppendStringSignal(cid, "s", bytes([number]), BLOCKING)
        world.loop.turn()
    for client in (cid, other):
        v.simxGetPingTime(client)
    got = b"".join(bytes(v.simxReadStringStream(client, "s", BUFFER)[1]) for client in (cid, other))
    assert sorted(got) == list(range(10))
    v.simxFinish(other)


def test_get_and_clear_in_blocking_mode_takes_it_from_everybody(world: RealWorld, cid: int) -> None:
    other = world.client()
    v.simxSetStringSignal(cid, "s", b"\0", BLOCKING)
    assert v.simxGetAndClearStringSignal(other, "s", BLOCKING) == (0, bytearray(b"\0"))
    assert v.simxGetAndClearStringSignal(cid, "s", BLOCKING) == (8, bytearray())
    v.simxFinish(other)


def test_signals_outlive_start_stop_and_a_scene(world: RealWorld, cid: int) -> None:
    v.simxSetStringSignal(cid, "s", b"x", BLOCKING)
    v.simxStartSimulation(cid, BLOCKING)
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxCloseScene(cid, BLOCKING) == 0
    assert v.simxLoadScene(cid, "scene.xml", 0, BLOCKING) == 0
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (0, bytearray(b"x"))


def test_query_clears_an_old_answer_and_says_why_it_failed(world: RealWorld, cid: int) -> None:
    v.simxSetStringSignal(cid, "answer", b"old", BLOCKING)
    assert v.simxQuery(cid, "ask", b"1", "answer", 0) == (2, bytearray())
    assert v.simxGetStringSignal(cid, "answer", BLOCKING)[0] == 8, "the old answer was cleared first"
    assert v.simxGetStringSignal(cid, "ask", BLOCKING) == (0, bytearray(b"1"))
    assert v.simxQuery(-1, "ask", b"1", "answer", 0) == (64, bytearray())
    v.simxPauseCommunication(cid, True)
    assert v.simxQuery(cid, "ask", b"2", "answer", 1000) == (3, bytearray()), (
        "nothing can be set while paused"
    )
    v.simxPauseCommunication(cid, False)
    v.simxStartSimulation(cid, BLOCKING)
    v.simxSetStringSignal(cid, "answer", b"late", BLOCKING)
    world.loop.turn()
    assert v.simxGetStringSignal(cid, "answer", BLOCKING) == (0, bytearray(b"late")), "nobody waits any more"


def test_query_after_a_query_gets_its_own_answer(world: RealWorld, cid: int) -> None:
    store = world.parts.signals

    def echo() -> None:
        asked = store.take_string("ask")
        if asked is not None:
            store.set_string("answer", asked[::-1])

    echoing = observe(world.simulation, step_finished=echo)
    try:
        v.simxStartSimulation(cid, BLOCKING)
        for text in (b"ab", b"cd\0", b""):
            assert v.simxQuery(cid, "ask", text, "answer", 5000) == (0, bytearray(text[::-1]))
    finally:
        world.simulation.parts.detach(echoing)


def test_packing_takes_what_scripts_give_and_unpacking_what_signals_hold(cid: int) -> None:
    assert v.simxPackInts((1, True, np.int64(-2))) == b"\1\0\0\0\1\0\0\0\xfe\xff\xff\xff"
    assert v.simxPackFloats(np.array([[1, 2.5]])) == b"\0\0\x80?\0\0 @"
    for made in (v.simxPackInts([]), v.simxPackFloats(range(3))):
        assert type(made) is bytearray
    packed = v.simxPackFloats([0.1, -2])
    v.simxSetStringSignal(cid, "s", packed, BLOCKING)
    data = v.simxGetStringSignal(cid, "s", BLOCKING)[1]
    assert v.simxUnpackFloats(data) == pytest.approx([0.1, -2])
    for form in (bytes(packed), packed, packed.decode("latin-1"), packed + b"123"):
        assert v.simxUnpackFloats(form) == v.simxUnpackFloats(data)
    assert v.simxUnpackInts(v.simxPackInts([2**31 - 1, -(2**31)]).decode("latin-1")) == [
        2147483647,
        -2147483648,
    ]
    assert v.simxUnpackInts(b"\1\0\0") == v.simxUnpackFloats("") == []


def test_too_many_or_too_large_signals_are_refused() -> None:
    world = World()
    world.sim.limits = Limits(signals=2, signal_bytes=4)
    for name in ("a", "b"):
        world.call("simxSetIntegerSignal", name, 1)
    world.call("simxSetIntegerSignal", "a", 2)
    with pytest.raises(CommandError, match="at most 2 signals"):
        world.call("simxSetIntegerSignal", "c", 1)
    world.call("simxSetStringSignal", "a", b"123")
    world.call("simxSetStringSignal", "a", b"4321")
    with pytest.raises(CommandError, match="in all string signals together"):
        world.call("simxAppendStringSignal", "b", b"5")


@pytest.mark.parametrize(
    ("kind", "first", "second"), [("integer", 1, 2), ("float", 1.0, 2.0), ("string", b"1", b"2")]
)
def test_a_signal_dies_with_the_script_that_set_it_last(kind: str, first: object, second: object) -> None:
    signals = World("<mujoco/>").parts.signals
    put, get = getattr(signals, f"set_{kind}"), getattr(signals, f"get_{kind}")
    put("overwritten by a client", first, "script")
    put("overwritten by a client", second)
    put("overwritten by another script", first, "script")
    put("overwritten by another script", second, "another script")
    put("taken back", second, "another script")
    put("taken back", first, "script")
    signals.clear_owned("script")
    assert get("overwritten by a client") == second
    assert get("overwritten by another script") == second
    assert get("taken back") is None
    signals.clear_owned("another script")
    assert get("overwritten by another script") is None
