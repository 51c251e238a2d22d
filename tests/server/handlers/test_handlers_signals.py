"""Signals and string streams, as clients use them."""

from __future__ import annotations

from typing import Any

import pytest
from handler_calls import World

from simx_client.protocol.kinds import MAX_BYTES
from simx_server.errors import CommandError


@pytest.fixture
def world() -> World:
    return World()


@pytest.mark.parametrize(("kind", "value"), [("Integer", -7), ("Float", 0.25), ("String", b"a\0b\xff")])
def test_signal_is_set_read_and_cleared(world: World, kind: str, value: Any) -> None:
    with pytest.raises(CommandError, match=f"no {kind.lower()} signal 'x'; set are: none"):
        world.call(f"simxGet{kind}Signal", "x")
    world.call(f"simxSet{kind}Signal", "x", value)
    assert world.call(f"simxGet{kind}Signal", "x") == value
    with pytest.raises(CommandError, match="set are: 'x'"):
        world.call(f"simxGet{kind}Signal", "y")
    world.call(f"simxClear{kind}Signal", "y")
    world.call(f"simxClear{kind}Signal", "x")
    with pytest.raises(CommandError):
        world.call(f"simxGet{kind}Signal", "x")


def test_kinds_of_signals_do_not_mix_and_empty_name_clears_one_kind(world: World) -> None:
    world.call("simxSetIntegerSignal", "x", 1)
    world.call("simxSetFloatSignal", "x", 2.0)
    world.call("simxSetIntegerSignal", "y", 3)
    world.call("simxSetIntegerSignal", "", 4)
    world.call("simxClearIntegerSignal", "")
    assert world.call("simxGetFloatSignal", "x") == 2.0
    assert not world.parts.signals.integers


def test_clients_signals_survive_start_and_stop(world: World) -> None:
    world.call("simxSetFloatSignal", "x", 2.0)
    world.run()
    world.call("simxStopSimulation")
    assert world.call("simxGetFloatSignal", "x") == 2.0


def test_appended_string_is_read_once_and_an_empty_stream_is_no_error(world: World) -> None:
    assert world.call("simxReadStringStream", "s") == b""
    world.call("simxAppendStringSignal", "s", b"ab")
    world.call("simxWriteStringStream", "s", b"\0c")
    assert world.call("simxReadStringStream", "s") == b"ab\0c"
    assert world.call("simxReadStringStream", "s") == b""
    world.call("simxSetStringSignal", "s", b"once")
    assert world.call("simxGetAndClearStringSignal", "s") == b"once"
    with pytest.raises(CommandError):
        world.call("simxGetAndClearStringSignal", "s")


def test_a_stream_that_nobody_reads_stops_growing(world: World) -> None:
    world.call("simxSetStringSignal", "s", bytes(MAX_BYTES))
    with pytest.raises(CommandError, match="read it more often"):
        world.call("simxAppendStringSignal", "s", b"x")
