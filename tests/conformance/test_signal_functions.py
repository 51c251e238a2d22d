"""Signals and string streams (the reference's 3.7)."""

from __future__ import annotations

import ctypes
from typing import Any

import pytest
from conforming import BLOCKING, BUFFER, NOVALUE, OK, ONESHOT, REMOTE_ERROR, STREAMING, assert_types, of
from observing import observe

import simx_client as v

ILLEGAL = v.simx_return_illegal_opmode_flag


@of("simxSetFloatSignal")
def test_a_float_signal_is_set_and_an_empty_name_does_nothing(cid: int, simx: Any) -> None:
    assert simx(cid, "gyroX", 1, BLOCKING) == OK
    assert v.simxGetFloatSignal(cid, "gyroX", BLOCKING) == (OK, 1.0)
    assert simx(cid, "", 2.0, BLOCKING) == OK
    assert v.simxGetFloatSignal(cid, "", BLOCKING) == (REMOTE_ERROR, 0.0)


@of("simxGetFloatSignal")
def test_a_missing_float_signal_is_8_and_kinds_are_name_spaces_of_their_own(cid: int, simx: Any) -> None:
    v.simxSetIntegerSignal(cid, "s", 1, BLOCKING)
    assert simx(cid, "s", BLOCKING) == (REMOTE_ERROR, 0.0)
    v.simxSetFloatSignal(cid, "s", 0.5, BLOCKING)
    assert simx(cid, "s", BLOCKING) == (OK, 0.5)
    assert_types(simx(cid, "s", BLOCKING), (0, 0.0))


@of("simxClearFloatSignal")
def test_a_float_signal_is_cleared_alone_or_with_all_others(cid: int, simx: Any) -> None:
    _clears(cid, simx, v.simxSetFloatSignal, v.simxGetFloatSignal, 0.5)


def _clears(cid: int, clear: Any, put: Any, get: Any, value: Any) -> None:
    for name in ("a", "b", "c"):
        put(cid, name, value, BLOCKING)
    assert clear(cid, "a", BLOCKING) == OK
    assert clear(cid, "a", BLOCKING) == OK, "a missing one is no error"
    assert [get(cid, name, BLOCKING)[0] for name in "abc"] == [REMOTE_ERROR, OK, OK]
    assert clear(cid, "", BLOCKING) == OK
    assert [get(cid, name, BLOCKING)[0] for name in "abc"] == [REMOTE_ERROR] * 3


@of("simxSetIntegerSignal")
def test_setting_an_integer_signal_returns_the_code_under_both_names(cid: int, simx: Any) -> None:
    assert simx(cid, "n", 7, ONESHOT) == NOVALUE
    assert simx(cid, "n", -7, BLOCKING) == OK
    assert v.simxGetIntegerSignal(cid, "n", BLOCKING) == (OK, -7)
    assert simx(cid, "", 1, BLOCKING) == OK


@of("simxGetIntegerSignal")
def test_getting_an_integer_signal_returns_the_pair_under_both_names(cid: int, simx: Any) -> None:
    assert simx(cid, "n", BLOCKING) == (REMOTE_ERROR, 0)
    v.simxSetIntegerSignal(cid, "n", 7, BLOCKING)
    assert simx(cid, "n", BLOCKING) == (OK, 7)
    assert_types(simx(cid, "n", BLOCKING), (0, 0))


@of("simxClearIntegerSignal")
def test_an_integer_signal_is_cleared_alone_or_with_all_others(cid: int, simx: Any) -> None:
    _clears(cid, simx, v.simxSetIntegerSignal, v.simxGetIntegerSignal, 7)


@of("simxSetStringSignal")
@pytest.mark.parametrize(
    "value", [b"a\0b", bytearray(b"a\0b"), "a\0b", (ctypes.c_ubyte * 3).from_buffer_copy(b"a\0b")]
)
def test_a_string_signal_is_binary_safe_from_any_kind_of_bytes(cid: int, simx: Any, value: Any) -> None:
    assert simx(cid, "name with # and blanks", value, BLOCKING) == OK
    assert v.simxGetStringSignal(cid, "name with # and blanks", BLOCKING) == (OK, bytearray(b"a\0b"))


@of("simxGetStringSignal")
def test_a_string_signal_comes_as_bytearray_and_a_missing_one_is_8(cid: int, simx: Any) -> None:
    assert simx(cid, "s", BLOCKING) == (REMOTE_ERROR, bytearray())
    v.simxSetStringSignal(cid, "s", "grüße", BLOCKING)
    code, value = simx(cid, "s", BLOCKING)
    assert (code, type(value), value.decode("utf-8")) == (OK, bytearray, "grüße")
    v.simxSetStringSignal(cid, "s", b"", BLOCKING)
    assert simx(cid, "s", BLOCKING) == (OK, bytearray()), "empty is not missing"


@of("simxClearStringSignal")
def test_a_string_signal_is_cleared_alone_or_with_all_others(cid: int, simx: Any) -> None:
    _clears(cid, simx, v.simxSetStringSignal, v.simxGetStringSignal, b"x")


@of("simxAppendStringSignal")
def test_every_append_counts_also_in_one_batch(cid: int, simx: Any) -> None:
    v.simxPauseCommunication(cid, True)
    for text in ("a", "b", "b"):
        simx(cid, "s", text, ONESHOT)
    v.simxPauseCommunication(cid, False)
    assert simx(cid, "s", b"c", BLOCKING) == OK
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (OK, bytearray(b"abbc"))


@of("simxReadStringStream")
def test_a_string_stream_refuses_blocking_loses_nothing_and_never_fails(
    world: Any, cid: int, simx: Any
) -> None:
    assert simx(cid, "s", BLOCKING) == (ILLEGAL, bytearray())
    assert simx(cid, "s", BUFFER) == (NOVALUE, bytearray())
    v.simxStartSimulation(cid, BLOCKING)
    simx(cid, "s", STREAMING)
    world.loop.turn()
    assert simx(cid, "s", BUFFER) == (OK, bytearray()), "absent means no data, not an error"
    for text in (b"one ", b"two ", b"three"):
        v.simxWriteStringStream(cid, "s", text, BLOCKING)
        world.loop.turn()
    assert simx(cid, "s", BUFFER) == (OK, bytearray(b"one two three"))
    assert v.simxGetStringSignal(cid, "s", BLOCKING)[0] == REMOTE_ERROR, "reading cleared it"


@of("simxReadStringStream")
def test_each_fetch_takes_the_data(world: Any, cid: int, simx: Any) -> None:
    v.simxWriteStringStream(cid, "s", "once", BLOCKING)
    simx(cid, "s", ONESHOT)
    world.loop.turn()
    assert simx(cid, "s", BUFFER) == (OK, bytearray(b"once"))
    assert simx(cid, "s", BUFFER) == (NOVALUE, bytearray())


@of("simxGetAndClearStringSignal")
def test_a_hit_clears_the_signal_ends_the_stream_and_leaves_the_inbox(
    world: Any, cid: int, simx: Any
) -> None:
    simx(cid, "s", STREAMING)
    world.loop.turn()
    assert simx(cid, "s", BUFFER) == (REMOTE_ERROR, bytearray()), "absent"
    v.simxStartSimulation(cid, BLOCKING)
    v.simxSetStringSignal(cid, "s", b"hit", BLOCKING)
    world.loop.turn()
    assert simx(cid, "s", BUFFER) == (OK, bytearray(b"hit"))
    assert simx(cid, "s", BUFFER) == (NOVALUE, bytearray())
    v.simxSetStringSignal(cid, "s", b"stays", BLOCKING)
    world.loop.turn()
    assert v.simxGetStringSignal(cid, "s", BLOCKING) == (OK, bytearray(b"stays"))
    assert simx(cid, "s", BLOCKING) == (OK, bytearray(b"stays"))
    assert simx(cid, "s", BLOCKING) == (REMOTE_ERROR, bytearray())


@of("simxQuery")
def test_a_query_without_an_answer_is_2_after_its_time_out(cid: int, simx: Any) -> None:
    assert simx(cid, "question", b"?", "answer", 20) == (v.simx_return_timeout_flag, bytearray())
    assert v.simxGetStringSignal(cid, "question", BLOCKING) == (OK, bytearray(b"?"))
    assert simx(99, "question", b"?", "answer", 20) == (64, bytearray())


@of("simxQuery")
def test_a_query_gives_what_is_put_into_the_other_signal(world: Any, cid: int, simx: Any) -> None:
    v.simxSetStringSignal(cid, "answer", b"stale", BLOCKING)
    signals = world.parts.signals
    observe(
        world.simulation,
        step_finished=lambda: signals.strings.get("question") and signals.set_string("answer", b"fresh"),
    )
    world.let_time_pass()
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, "question", b"?", "answer", 5000) == (OK, bytearray(b"fresh"))


def test_signals_of_a_client_outlive_stop_and_start(cid: int) -> None:
    v.simxSetIntegerSignal(cid, "n", 7, BLOCKING)
    v.simxStartSimulation(cid, BLOCKING)
    assert v.simxGetIntegerSignal(cid, "n", BLOCKING) == (OK, 7)
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxGetIntegerSignal(cid, "n", BLOCKING) == (OK, 7)


def test_a_number_that_no_float32_holds_is_8_and_the_next_call_is_answered(cid: int) -> None:
    assert v.simxSetFloatSignal(cid, "f", 1e300, BLOCKING) == REMOTE_ERROR
    assert v.simxSetFloatSignal(cid, "f", 1e30, BLOCKING) == OK
