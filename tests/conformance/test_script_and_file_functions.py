"""Script functions, errors, the status bar, files on the server (the reference's 3.8 and 8)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conforming import BLOCKING, BUFFER, NOVALUE, OK, ONESHOT, REMOTE_ERROR, STREAMING, assert_types, of

import simx_client as v

CHILD = v.sim_scripttype_childscript
FAILED = (REMOTE_ERROR, [], [], [], bytearray())
MISSING = v.simx_return_local_error_flag


@pytest.fixture
def running(cid: int) -> int:
    pytest.importorskip("lupa")
    assert v.simxStartSimulation(cid, BLOCKING) == OK
    return cid


@of("simxCallScriptFunction")
@pytest.mark.parametrize("buffer", [b"a\0b", bytearray(b"a\0b"), "a\0b"])
def test_a_script_function_takes_and_returns_four_lists(running: int, simx: Any, buffer: Any) -> None:
    inputs = ([1, -2], np.array([0.5, 0.25]), ["x", "ü"], buffer)
    result = simx(running, "robot", CHILD, "echo", *inputs, BLOCKING)
    assert result == (OK, [1, -2], [0.5, 0.25], ["x", "ü"], bytearray(b"a\0b"))
    assert_types(result, (0, [1], [0.5], [""], bytearray()))
    assert simx(running, "robot", 1, "echo", [], [], [], b"", BLOCKING) == (OK, [], [], [], bytearray())


@of("simxCallScriptFunction")
@pytest.mark.parametrize(
    ("where", "function"),
    [("robot", "nested.echo"), ("", "echo@robot"), (b"robot", b"echo"), ("/robot", "echo")],
)
def test_the_function_may_be_dotted_and_its_object_a_path_or_in_the_name(
    running: int, simx: Any, where: Any, function: Any
) -> None:
    assert simx(running, where, CHILD, function, [7], [], [], b"", BLOCKING)[:2] == (OK, [7])


@of("simxCallScriptFunction")
@pytest.mark.parametrize(
    ("where", "kind", "function"),
    [
        ("robot", CHILD, "fails"),
        ("robot", CHILD, "too_few"),
        ("robot", CHILD, "no_such_function"),
        ("cube", CHILD, "echo"),
        ("nobody", CHILD, "echo"),
        ("robot", 99, "echo"),
    ],
)
def test_every_trouble_in_a_script_call_is_8_with_a_text(
    running: int, simx: Any, where: str, kind: int, function: str
) -> None:
    assert simx(running, where, kind, function, [1], [0.5], ["x"], b"", BLOCKING) == FAILED
    assert len(v.simxGetLastErrors(running, BLOCKING)[1]) >= 1
    assert simx(running, "robot", CHILD, "echo", [1], [], [], b"", BLOCKING)[:2] == (OK, [1]), "it goes on"


@of("simxCallScriptFunction")
def test_child_scripts_exist_only_while_the_simulation_runs(running: int, simx: Any) -> None:
    v.simxStopSimulation(running, BLOCKING)
    assert simx(running, "robot", CHILD, "echo", [], [], [], b"", BLOCKING) == FAILED


@of("simxCallScriptFunction")
def test_script_calls_stream_and_their_reply_can_be_removed(world: Any, running: int, simx: Any) -> None:
    arguments = ("robot", CHILD, "echo", [3], [], [], b"")
    simx(running, *arguments, STREAMING)
    world.loop.turn()
    assert simx(running, *arguments, BUFFER)[:2] == (OK, [3])
    assert simx(running, *arguments, v.simx_opmode_remove)[0] == OK, "the original never found it"
    simx(running, *arguments, v.simx_opmode_discontinue)


@of("simxGetLastErrors")
def test_errors_are_told_once_oldest_first_at_most_50_and_to_their_own_client(
    world: Any, cid: int, simx: Any
) -> None:
    assert simx(cid, BLOCKING) == (OK, [])
    for number in range(55):
        v.simxGetObjectPosition(cid, 10_000 + number, -1, BLOCKING)
    assert simx(world.client(), BLOCKING) == (OK, [])
    code, errors = simx(cid, BLOCKING)
    assert (code, len(errors)) == (OK, 50)
    assert "10005" in errors[0]
    assert "10054" in errors[-1]
    assert_types(errors, [""])
    assert simx(cid, BLOCKING) == (OK, [])


@of("simxAddStatusbarMessage")
def test_every_status_message_is_taken_also_equal_ones(world: Any, cid: int, simx: Any, caplog: Any) -> None:
    caplog.set_level("INFO")
    assert simx(cid, "hello world", BLOCKING) == OK
    v.simxPauseCommunication(cid, True)
    for _ in range(2):
        assert simx(cid, "again", ONESHOT) == NOVALUE
    v.simxPauseCommunication(cid, False)
    v.simxGetPingTime(cid)
    assert caplog.text.count("again") == 2


@of("simxTransferFile")
def test_a_local_file_lands_under_a_plain_name_at_the_server(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path, cid: int, simx: Any
) -> None:
    mine = tmp_path_factory.mktemp("client") / "data.bin"
    content = bytes(range(256)) * 1000
    mine.write_bytes(content)
    for name in ("stored.bin", b"as bytes.bin"):
        assert simx(cid, str(mine), name, 5000, BLOCKING) == OK
    assert [file.read_bytes() for file in tmp_path.rglob("*.bin")] == [content, content]
    assert simx(cid, str(mine.with_name("missing")), "x.bin", 5000, BLOCKING) == MISSING
    assert simx(99, str(mine), "x.bin", 5000, BLOCKING) == 64


@of("simxTransferFile")
@pytest.mark.parametrize("name", ["../outside.bin", "/tmp/outside.bin", "..", "", "a/../../outside.bin"])
def test_a_file_never_lands_outside_the_servers_folder(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path, cid: int, simx: Any, name: str
) -> None:
    mine = tmp_path_factory.mktemp("client") / "data.bin"
    mine.write_bytes(b"data")
    before = set(tmp_path.parent.glob("*"))
    simx(cid, str(mine), name, 5000, BLOCKING)
    assert set(tmp_path.parent.glob("*")) == before
    assert not Path("/tmp/outside.bin").exists()


@of("simxEraseFile")
def test_a_transferred_file_is_erased_once(
    tmp_path_factory: pytest.TempPathFactory, cid: int, simx: Any
) -> None:
    mine = tmp_path_factory.mktemp("client") / "data.bin"
    mine.write_bytes(b"data")
    assert v.simxTransferFile(cid, str(mine), "stored.bin", 5000, BLOCKING) == OK
    assert simx(cid, "stored.bin", BLOCKING) == OK
    assert simx(cid, "stored.bin", BLOCKING) == REMOTE_ERROR
    assert simx(cid, "../scene.xml", BLOCKING) == REMOTE_ERROR
    assert mine.exists()
