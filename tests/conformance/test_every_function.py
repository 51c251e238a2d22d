"""Common to all 133 functions: names, signatures, keys, and the results without data."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import pytest
from conforming import (
    BINDING,
    BLOCKING,
    BUFFER,
    DISCONTINUE,
    NOVALUE,
    OK,
    ONESHOT,
    REMOTE_ERROR,
    REMOVE,
    SCENE,
    STREAMING,
    Declaration,
    assert_types,
    covered,
    sample,
)
from real_world import RealWorld

import simx_client as v
from simx_client.protocol.commands import BY_NAME

pytestmark = pytest.mark.slow

REMOTE = [declaration for declaration in BINDING.values() if declaration.is_remote]
QUEUED = [declaration for declaration in REMOTE if declaration.name != "simxTransferFile"]
"""Sent by themselves; simxTransferFile reads a file on the client's side first."""

SUCCEEDS_WITHOUT_AN_OBJECT: dict[str, Any] = {
    "simxStartSimulation": 0,
    "simxPauseSimulation": 0,
    "simxStopSimulation": 0,
    "simxCloseScene": 0,
    "simxGetObjects": (0, []),
    "simxGetObjectParent": (0, -1),
    "simxGetObjectChild": (0, -1),
    "simxCopyPasteObjects": (0, []),
    "simxGetObjectSelection": (0, []),
    "simxSetObjectSelection": 0,
    "simxSetFloatSignal": 0,
    "simxClearFloatSignal": 0,
    "simxSetIntegerSignal": 0,
    "simxClearIntegerSignal": 0,
    "simxSetStringSignal": 0,
    "simxClearStringSignal": 0,
    "simxAppendStringSignal": 0,
    "simxGetLastErrors": (0, []),
    "simxAddStatusbarMessage": 0,
    "simxAuxiliaryConsoleClose": 0,
    "simxGetUIEventButton": (0, -1, [0, 0]),
}
"""Answers of the functions for which the reference names no remote error with a meaningless argument."""

GIVES_A_NEW_HANDLE = {"simxCreateDummy", "simxAuxiliaryConsoleOpen"}

REFUSED = [
    function
    for function in QUEUED
    if BY_NAME[function.name].name not in SUCCEEDS_WITHOUT_AN_OBJECT.keys() | GIVES_A_NEW_HANDLE
]
"""Functions that refuse arguments which mean nothing, and change nothing then."""


@pytest.fixture(scope="module")
def untouched(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWorld]:
    """A world whose loop never turns: no call of a client is executed, so tests can share it."""
    world = RealWorld(SCENE, workspace=tmp_path_factory.mktemp("workspace"))
    yield world
    world.close()


@pytest.fixture(scope="module")
def standing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWorld]:
    """A world for tests that hold whatever earlier ones have changed in it."""
    world = RealWorld(SCENE, workspace=tmp_path_factory.mktemp("workspace"))
    yield world
    world.close()


@pytest.fixture(params=["by messages", "embedded"])
def visitor(request: pytest.FixtureRequest, standing: RealWorld) -> Iterator[int]:
    """A new client of that world, in which no client has left anything to do."""
    standing.loop.turn()
    yield standing.embedded_client() if request.param == "embedded" else standing.client()
    v.simxFinish(-1)


@pytest.fixture(scope="module")
def refusing(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWorld]:
    """A world that all calls leave as it is, since it refuses them."""
    world = RealWorld(SCENE, workspace=tmp_path_factory.mktemp("workspace"))
    yield world
    world.close()


@pytest.fixture(params=["by messages", "embedded"])
def refused(request: pytest.FixtureRequest, refusing: RealWorld) -> Iterator[int]:
    """A new client of that world."""
    yield refusing.embedded_client() if request.param == "embedded" else refusing.client()
    v.simxFinish(-1)


@pytest.fixture(params=["by messages", "embedded"])
def waiting(request: pytest.FixtureRequest, untouched: RealWorld) -> Iterator[int]:
    """A new client of that world."""
    yield untouched.embedded_client() if request.param == "embedded" else untouched.client()
    v.simxFinish(-1)


def of_each(declarations: list[Declaration]) -> Any:
    return pytest.mark.parametrize("function", declarations, ids=lambda declaration: declaration.name)


def call(function: Declaration, client: int, mode: int) -> Any:
    return getattr(v, function.name)(client, *sample(function), mode)


def assert_is(value: Any, expected: Any) -> None:
    assert value == expected
    assert_types(value, expected)


def test_all_functions_of_the_original_are_there_and_only_new_ones_besides() -> None:
    there = {name for name in vars(v) if name.startswith("simx") and callable(getattr(v, name))}
    assert there >= set(BINDING)
    assert len(BINDING) == 133
    for name in there - set(BINDING):
        assert BY_NAME[name].legacy_id is None, f"{name} has a number of the original, which has no {name}"


def test_every_function_is_tested_by_a_test_of_its_own() -> None:
    assert covered() == {command.name for command in BY_NAME.values()}


@of_each(list(BINDING.values()))
def test_parameters_have_the_originals_names_and_order(function: Declaration) -> None:
    assert tuple(inspect.signature(getattr(v, function.name)).parameters) == function.parameters
    assert inspect.isfunction(getattr(v, function.name))


@of_each(REMOTE)
def test_the_key_is_made_of_the_originals_identification_data(function: Declaration) -> None:
    assert set(BY_NAME[function.name].key) == set(function.key)


@of_each(REMOTE)
def test_an_unknown_client_gives_64_and_defaults(function: Declaration) -> None:
    for mode in (ONESHOT, BLOCKING, STREAMING, BUFFER, DISCONTINUE, REMOVE):
        assert_is(call(function, 17, mode), function.failure(64))


@of_each(QUEUED)
def test_without_a_reply_every_mode_gives_novalue_and_defaults(waiting: int, function: Declaration) -> None:
    for mode in (BUFFER, BUFFER + 7, REMOVE, DISCONTINUE):
        assert_is(call(function, waiting, mode), function.failure(NOVALUE))


@of_each(QUEUED)
def test_the_first_oneshot_gives_novalue_and_the_next_the_earlier_reply(
    standing: RealWorld, visitor: int, function: Declaration
) -> None:
    if function.name == "simxGetVisionSensorImage":
        pytest.skip("a picture comes when it is drawn; see the tests of pictures")
    assert_is(call(function, visitor, ONESHOT), function.failure(NOVALUE))
    standing.loop.turn()
    second = call(function, visitor, ONESHOT)
    assert (second if isinstance(second, int) else second[0]) != NOVALUE


@of_each(QUEUED)
def test_the_first_streaming_call_gives_novalue(visitor: int, function: Declaration) -> None:
    assert_is(call(function, visitor, STREAMING), function.failure(NOVALUE))


@of_each(QUEUED)
def test_a_blocking_call_while_paused_gives_timeout_and_novalue(waiting: int, function: Declaration) -> None:
    v.simxPauseCommunication(waiting, True)
    rc = v.simx_return_timeout_flag | NOVALUE
    if function.name == "simxReadStringStream":
        rc = v.simx_return_illegal_opmode_flag
    assert_is(call(function, waiting, BLOCKING), function.failure(rc))


@of_each([function for function in QUEUED if BY_NAME[function.name].name in SUCCEEDS_WITHOUT_AN_OBJECT])
def test_a_function_that_needs_no_object_succeeds(cid: int, function: Declaration) -> None:
    assert_is(call(function, cid, BLOCKING), SUCCEEDS_WITHOUT_AN_OBJECT[BY_NAME[function.name].name])


@of_each(REFUSED)
def test_a_handle_name_or_file_that_is_not_there_gives_8_and_defaults(
    refused: int, function: Declaration
) -> None:
    result = call(function, refused, BLOCKING)
    if function.name == "simxReadStringStream":
        assert_is(result, function.failure(v.simx_return_illegal_opmode_flag))
        return
    assert_is(result, function.failure(REMOTE_ERROR))
    code, errors = v.simxGetLastErrors(refused, BLOCKING)
    assert code == OK
    assert len(errors) == 1, "the reason is told once"


@of_each([function for function in QUEUED if "handle" in str(function.arguments).lower()])
def test_negative_and_huge_handles_never_crash_the_server(visitor: int, function: Declaration) -> None:
    arguments = sample(function)
    for number in (-1, -11, -(2**31), 2**31 - 1, 0x400000, 2**32):
        if isinstance(arguments[0], list):
            arguments[0] = [number]
        elif isinstance(arguments[0], int):
            arguments[0] = number
        getattr(v, function.name)(visitor, *arguments, BLOCKING)
    assert not any("internal error" in text for text in v.simxGetLastErrors(visitor, BLOCKING)[1])
    assert v.simxGetPingTime(visitor)[0] == OK


@pytest.mark.parametrize("name", [command.name for command in BY_NAME.values() if command.aliases])
def test_aliases_are_the_same_command_with_the_same_inbox(
    standing: RealWorld, visitor: int, name: str
) -> None:
    command = BY_NAME[name]
    arguments = sample(BINDING[name])
    getattr(v, command.name)(visitor, *arguments, STREAMING)
    standing.loop.turn()
    answers = [getattr(v, alias)(visitor, *arguments, BUFFER) for alias in command.names]
    assert all(answer == answers[0] for answer in answers)
    assert (answers[0] if isinstance(answers[0], int) else answers[0][0]) in (OK, REMOTE_ERROR)
