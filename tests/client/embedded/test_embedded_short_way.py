"""Calls of an embedded client that take the short way give the results of calls that do not."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loopback import LoopbackTransport

import simx_client as v
from simx_client.client import Client
from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedded import EmbeddedConnection
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.precision import as_single
from simx_server.gateways.embedded import transport
from simx_server.world.world import World

BLOCKING, STREAMING, BUFFER = v.simx_opmode_blocking, v.simx_opmode_streaming, v.simx_opmode_buffer

SCENE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0" ref="0.25"/><geom name="link" size="0.05" pos="0.3 0 0"/>
      <body name="tip" pos="0.3 0 0"><joint name="slider" type="slide" axis="0 0 1"/><geom size="0.05"/></body>
    </body>
    <body name="wheel" pos="1 0 1"><joint name="axle" axis="0 0 1"/><geom size="0.1" pos="0.1 0 0"/></body>
    <body name="free" pos="2 0 3"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <custom><text name="simx:joint:axle" data="cyclic=yes"/></custom>
</mujoco>
"""

Call = Callable[[], Any]


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    file = tmp_path / "scene.xml"
    file.write_text(SCENE)
    with Client.embedded(str(file)) as made:
        yield made


def connection_of(client: Client) -> EmbeddedConnection:
    found = CLIENTS.get(client.id)
    assert isinstance(found, EmbeddedConnection)
    return found


def both_ways(client: Client, call: Call) -> tuple[Any, Any]:
    """The result of a call by the short way, where it has one, and by messages."""
    short = outcome(call)
    connection = connection_of(client)
    direct, connection._direct = connection._direct, None
    try:
        return short, outcome(call)
    finally:
        connection._direct = direct


def outcome(call: Call) -> Any:
    try:
        return call()
    except TypeError as error:
        return error


def reads(client: Client) -> list[Call]:
    """Every read that has a short way, with usual, unusual and wrong arguments."""
    names = ("hinge", "slider", "axle", "arm", "tip", "wheel", "free", "link")
    handles = [v.simxGetObjectHandle(client.id, name, BLOCKING)[1] for name in names]
    others: list[Any] = [-1, 12345, True, np.int64(handles[0]), float(handles[0])]
    signals = ("number", "real", "text", "missing", "")
    calls: list[Call] = []
    for each in (*handles, *others):
        calls.append(lambda each=each: v.simxGetJointPosition(client.id, each, BLOCKING))
        for frame in (-1, handles[3], handles[0], v.sim_handle_parent, 999):
            calls.append(
                lambda each=each, frame=frame: v.simxGetObjectPosition(client.id, each, frame, BLOCKING)
            )
    for name in signals:
        for read in (v.simxGetIntegerSignal, v.simxGetFloatSignal, v.simxGetStringSignal):
            calls.append(lambda name=name, read=read: read(client.id, name, BLOCKING))
    return calls


def compare(client: Client) -> None:
    for call in reads(client):
        for _ in range(2):  # the first call finds the address
            short, long = both_ways(client, call)
            assert type(short) is type(long)
            assert repr(short) == repr(long)


def test_reads_are_equal_bit_for_bit_at_rest_in_a_run_and_after_edits(client: Client) -> None:
    assert v.simxSetIntegerSignal(client.id, "number", -7, BLOCKING) == 0
    assert v.simxSetFloatSignal(client.id, "real", 0.1, BLOCKING) == 0
    assert v.simxSetStringSignal(client.id, "text", b"\x00text", BLOCKING) == 0
    compare(client)
    axle = v.simxGetObjectHandle(client.id, "axle", BLOCKING)[1]
    assert v.simxSetJointPosition(client.id, axle, 7.0, BLOCKING) == 0
    v.simxSynchronous(client.id, True)
    v.simxStartSimulation(client.id, BLOCKING)
    for _ in range(3):
        v.simxSynchronousTrigger(client.id)
        compare(client)
    v.simxStopSimulation(client.id, BLOCKING)
    compare(client)
    wheel = v.simxGetObjectHandle(client.id, "wheel", BLOCKING)[1]
    assert v.simxRemoveObject(client.id, wheel, BLOCKING) == 0
    code, copies = v.simxCopyPasteObjects(
        client.id, [v.simxGetObjectHandle(client.id, "free", BLOCKING)[1]], BLOCKING
    )
    assert code == 0
    assert v.simxSetObjectPosition(client.id, copies[0], -1, [1.0, 2.0, 3.0], BLOCKING) == 0
    compare(client)
    assert v.simxGetObjectPosition(client.id, copies[0], -1, BLOCKING) == (0, [1.0, 2.0, 3.0])


def test_what_is_set_is_read_at_once(client: Client) -> None:
    hinge, free = (v.simxGetObjectHandle(client.id, name, BLOCKING)[1] for name in ("hinge", "free"))
    for step in range(5):
        v.simxSetJointPosition(client.id, hinge, 0.125 * step, BLOCKING)
        assert v.simxGetJointPosition(client.id, hinge, BLOCKING) == (0, 0.125 * step)
        v.simxSetObjectPosition(client.id, free, -1, [0.5, 0.25 * step, 3.0], BLOCKING)
        assert v.simxGetObjectPosition(client.id, free, -1, BLOCKING) == (0, [0.5, 0.25 * step, 3.0])
        v.simxSetIntegerSignal(client.id, "step", step, v.simx_opmode_oneshot)
        assert v.simxGetIntegerSignal(client.id, "step", BLOCKING) == (0, step)
    v.simxClearIntegerSignal(client.id, "step", BLOCKING)
    assert v.simxGetIntegerSignal(client.id, "step", BLOCKING)[0] == v.simx_return_remote_error_flag


def position_of(client: Client, joint: str) -> float:
    simulation = connection_of(client)._direct._service.simulation  # type: ignore[union-attr]
    return float(simulation.data.joint(joint).qpos[0])


def simulated(client: Client) -> int:
    v.simxGetPingTime(client.id)
    return v.simxGetLastCmdTime(client.id)


def start_stepped(client: Client) -> None:
    assert v.simxSynchronous(client.id, True) == 0
    assert v.simxStartSimulation(client.id, BLOCKING) == 0


def test_each_trigger_is_one_step_with_streams_with_other_clients_and_alone(client: Client) -> None:
    hinge = v.simxGetObjectHandle(client.id, "hinge", BLOCKING)[1]
    start_stepped(client)
    for step in range(1, 4):
        assert v.simxSynchronousTrigger(client.id) == 0
        assert simulated(client) == 50 * step
    v.simxGetJointPosition(client.id, hinge, STREAMING)
    for step in range(4, 7):
        assert v.simxSynchronousTrigger(client.id) == 0
        newest = v.simxGetJointPosition(client.id, hinge, BUFFER)
        assert v.simxGetLastCmdTime(client.id) == 50 * step
        assert newest == (0, as_single(position_of(client, "hinge")))
    other = LoopbackTransport(connection_of(client)._direct._loop, name="other")  # type: ignore[union-attr]
    assert other.greet(1.0)
    assert v.simxSynchronousTrigger(client.id) == 0
    assert simulated(client) == 350
    assert v.simxStopSimulation(client.id, BLOCKING) == 0


def test_a_trigger_without_a_run_is_refused_and_says_why(client: Client) -> None:
    v.simxSynchronous(client.id, True)
    assert v.simxSynchronousTrigger(client.id) == v.simx_return_remote_error_flag
    assert "start it first" in v.simxGetLastErrors(client.id, BLOCKING)[1][0]


def test_a_step_that_cannot_be_made_answers_its_trigger_with_the_reason(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    start_stepped(client)
    assert v.simxSynchronousTrigger(client.id) == 0

    def fail(world: World) -> None:
        raise ZeroDivisionError("on purpose")

    monkeypatch.setattr(World, "step", fail)
    assert v.simxSynchronousTrigger(client.id) == v.simx_return_remote_error_flag
    assert "on purpose" in v.simxGetLastErrors(client.id, BLOCKING)[1][0]
    monkeypatch.undo()
    start_stepped(client)
    assert v.simxSynchronousTrigger(client.id) == 0


def test_reads_and_steps_of_two_threads_give_whole_values(client: Client) -> None:
    start_stepped(client)
    free = v.simxGetObjectHandle(client.id, "free", BLOCKING)[1]
    found: list[tuple[int, list[float]]] = []
    has_ended = threading.Event()

    def read() -> None:
        while not has_ended.is_set():
            found.append(v.simxGetObjectPosition(client.id, free, -1, BLOCKING))

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(20):
        assert v.simxSynchronousTrigger(client.id) == 0
    has_ended.set()
    reader.join()
    heights = [position[2] for code, position in found if code == 0]
    assert len(heights) == len(found) > 0
    assert heights == sorted(heights, reverse=True)


def test_streamed_positions_are_those_after_the_step_whatever_was_set_since(client: Client) -> None:
    hinge, slider = (v.simxGetObjectHandle(client.id, name, BLOCKING)[1] for name in ("hinge", "slider"))
    start_stepped(client)
    for joint in (hinge, slider):
        v.simxGetJointPosition(client.id, joint, STREAMING)
    for _ in range(3):
        assert v.simxSynchronousTrigger(client.id) == 0
    expected = [(0, as_single(position_of(client, name))) for name in ("hinge", "slider")]
    assert v.simxSetJointPosition(client.id, hinge, 0.5, BLOCKING) == 0
    assert [v.simxGetJointPosition(client.id, joint, BUFFER) for joint in (hinge, slider)] == expected


def test_a_value_of_a_stream_that_a_blocking_read_has_ended_is_not_there(client: Client) -> None:
    hinge = v.simxGetObjectHandle(client.id, "hinge", BLOCKING)[1]
    start_stepped(client)
    v.simxGetJointPosition(client.id, hinge, STREAMING)
    for _ in range(3):
        assert v.simxSynchronousTrigger(client.id) == 0
    assert v.simxGetJointPosition(client.id, hinge, BUFFER)[0] == 0
    assert v.simxSynchronousTrigger(client.id) == 0
    assert v.simxGetJointPosition(client.id, hinge, BLOCKING)[0] == 0
    assert v.simxGetJointPosition(client.id, hinge, BUFFER) == (v.simx_return_novalue_flag, 0.0)


def test_the_newest_header_is_that_of_what_the_client_has_read(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    hinge, slider = (v.simxGetObjectHandle(client.id, name, BLOCKING)[1] for name in ("hinge", "slider"))
    start_stepped(client)
    v.simxGetJointPosition(client.id, hinge, STREAMING)
    for _ in range(3):
        assert v.simxSynchronousTrigger(client.id) == 0
    v.simxGetJointPosition(client.id, slider, BLOCKING)
    seconds = itertools.count()
    monkeypatch.setattr(transport, "monotonic", lambda: float(next(seconds)))

    def newest() -> float:
        header = connection_of(client).last_header
        assert header is not None
        return header.server_time / 1000

    assert v.simxSynchronousTrigger(client.id) == 0
    triggered = newest()
    v.simxGetJointPosition(client.id, hinge, BUFFER)
    after_the_step = newest()
    v.simxGetJointPosition(client.id, slider, BLOCKING)
    read = newest()
    assert triggered < after_the_step < read
    v.simxGetJointPosition(client.id, hinge, BUFFER)  # it is older than what was read in between
    assert newest() == read


def test_a_viewer_sets_no_target_by_the_short_way(client: Client) -> None:
    hinge = v.simxGetObjectHandle(client.id, "hinge", BLOCKING)[1]
    start_stepped(client)
    for _ in range(2):
        assert v.simxSetJointTargetPosition(client.id, hinge, 0.25, BLOCKING) == 0
        assert v.simxSynchronousTrigger(client.id) == 0
    server = connection_of(client)._direct
    assert isinstance(server, transport.EmbeddedTransport)
    link = transport.EmbeddedTransport(server._loop, server._turns, "viewer-1", "viewer", 0)
    link.greet(1.0)
    command = BY_NAME["simxSetJointTargetPosition"]
    assert link.short_way(command, print) is None
    assert server.short_way(command, print) is not None
    reply = link.prepare(command)([hinge, -1.0], 1.0)
    assert reply is not None
    assert "who may only read" in reply.values[0]
    link.close()


def test_a_stream_in_process_counts_as_executed_after_each_step(client: Client) -> None:
    hinge = v.simxGetObjectHandle(client.id, "hinge", BLOCKING)[1]
    start_stepped(client)
    v.simxGetJointPosition(client.id, hinge, STREAMING)
    link = connection_of(client)._direct
    assert isinstance(link, transport.EmbeddedTransport)
    times = link._service.metrics.command_times
    before = sum(times["simxGetJointPosition"].counts)
    for _ in range(10):
        assert v.simxSynchronousTrigger(client.id) == 0
    assert sum(times["simxGetJointPosition"].counts) == before + 10
