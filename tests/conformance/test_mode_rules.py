"""Rules of the operation modes (the reference's 5) that no other test names; the rest is in `test_modes.py`."""

from __future__ import annotations

from typing import Any

import pytest
from conforming import (
    BLOCKING,
    BUFFER,
    DISCONTINUE,
    NO_OBJECT,
    NOVALUE,
    OK,
    ONESHOT,
    REMOTE_ERROR,
    REMOVE,
    STREAMING,
)

import simx_client as v


@pytest.fixture(autouse=True)
def running(cid: int) -> None:
    """Each turn of the engine is a pass then."""
    assert v.simxStartSimulation(cid, BLOCKING) == OK


def test_streaming_again_with_equal_arguments_leaves_the_stream_as_it_is(
    world: Any, cid: int, handle: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    falling = handle("falling")
    v.simxGetObjectPosition(cid, falling, -1, STREAMING)
    world.loop.turn()
    sent = []
    monkeypatch.setattr(world.loop.service.queue, "submit", lambda *arguments: sent.append(arguments))
    values = []
    for _ in range(3):
        values.append(v.simxGetObjectPosition(cid, falling, -1, STREAMING)[1][2])
        world.loop.turn()
    assert sent == []
    assert values[0] > values[1] > values[2], "each read has the newest value"


def test_streaming_again_with_another_value_replaces_the_stream(world: Any, cid: int, handle: Any) -> None:
    rail = handle("rail")
    for value in (0.25, 0.75):
        v.simxSetJointPosition(cid, rail, value, STREAMING)
        for _ in range(3):
            world.loop.turn()
        assert v.simxGetJointPosition(cid, rail, BLOCKING)[1] == pytest.approx(value, abs=1e-3)


@pytest.mark.parametrize("function", [v.simxGetLastErrors, v.simxGetObjectSelection])
def test_commands_without_a_key_are_forgotten_after_discontinue_like_all_others(
    world: Any, cid: int, function: Any
) -> None:
    function(cid, STREAMING)
    world.loop.turn()
    assert function(cid, BUFFER) == (OK, [])
    assert function(cid, DISCONTINUE) == (OK, []), "the last value once more"
    world.loop.turn()
    assert function(cid, BUFFER) == (NOVALUE, [])


@pytest.mark.parametrize("mode", [v.simx_opmode_oneshot_split, v.simx_opmode_streaming_split])
def test_an_error_in_a_split_mode_is_seen(world: Any, cid: int, mode: int) -> None:
    for _ in range(2):
        code = v.simxSetObjectPosition(cid, NO_OBJECT, -1, [0, 0, 0], mode + 200)
        world.loop.turn()
    assert code == REMOTE_ERROR


def test_remove_tells_whether_there_was_a_value_and_needs_the_exact_number(
    world: Any, cid: int, handle: Any
) -> None:
    lid = handle("lid")
    v.simxGetObjectPosition(cid, lid, -1, ONESHOT)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, lid, -1, BUFFER)[0] == OK
    assert v.simxGetObjectPosition(cid, lid, -1, REMOVE) == (OK, [0.0] * 3)
    assert v.simxGetObjectPosition(cid, lid, -1, REMOVE) == (NOVALUE, [0.0] * 3)


def test_a_stream_that_begins_to_fail_gives_8_until_it_recovers(world: Any, cid: int) -> None:
    v.simxGetIntegerSignal(cid, "s", STREAMING)
    world.loop.turn()
    assert v.simxGetIntegerSignal(cid, "s", BUFFER) == (REMOTE_ERROR, 0)
    v.simxSetIntegerSignal(cid, "s", 5, BLOCKING)
    world.loop.turn()
    assert v.simxGetIntegerSignal(cid, "s", BUFFER) == (OK, 5)
    v.simxClearIntegerSignal(cid, "s", BLOCKING)
    world.loop.turn()
    assert v.simxGetIntegerSignal(cid, "s", BUFFER) == (REMOTE_ERROR, 0)


def test_set_functions_leave_other_streams_of_the_object_alone(world: Any, cid: int, handle: Any) -> None:
    lid = handle("lid")
    v.simxGetObjectPosition(cid, lid, -1, STREAMING)
    v.simxSetObjectPosition(cid, lid, -1, [1, 2, 3], BLOCKING)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, lid, -1, BUFFER) == (OK, [1.0, 2.0, 3.0])


def test_results_are_fresh_lists_that_may_be_changed(world: Any, cid: int, handle: Any) -> None:
    lid = handle("lid")
    v.simxGetObjectPosition(cid, lid, -1, STREAMING)
    world.loop.turn()
    position = v.simxGetObjectPosition(cid, lid, -1, BUFFER)[1]
    position[2] += 100
    assert v.simxGetObjectPosition(cid, lid, -1, BUFFER)[1][2] < 1


def test_every_argument_may_be_given_by_keyword(cid: int) -> None:
    code, found = v.simxGetObjectHandle(clientID=cid, objectName="lid", operationMode=BLOCKING)
    assert code == OK
    result = v.simxGetObjectPosition(
        clientID=cid, objectHandle=found, relativeToObjectHandle=-1, operationMode=BLOCKING
    )
    assert result[0] == OK
