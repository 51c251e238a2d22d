"""Batches: many calls in one message, many servers in lock-step; over the in-process way and with real processes."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plain_world import World
from processes import ROOT, ServerProcess, server, wait_until

import simx_client as v
from simx_client import batch
from simx_client.connection.clients import CLIENTS
from simx_client.errors import ConnectionFailed
from simx_client.legacy import stubs
from simx_client.protocol.codec import decode_batch, decode_delivery
from simx_client.protocol.messages import Reply

pytestmark = pytest.mark.slow

BLOCKING = v.simx_opmode_blocking


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


@pytest.fixture
def worlds() -> Iterator[list[World]]:
    worlds = [World(), World(), World()]
    yield worlds
    v.simxFinish(-1)


def sent_by(world: World, client: int) -> list[int]:
    """The number of calls in each message of a client, from now on."""
    transport, sizes = world.transports[client], []
    send = transport.send

    def counted(payload: bytes, deadline: float) -> None:
        sizes.append(len(decode_batch(payload).calls))
        send(payload, deadline)

    transport.send = counted  # type: ignore[method-assign]
    return sizes


def stepped(worlds: list[World]) -> batch.Servers:
    servers = batch.Servers([world.client() for world in worlds], timeout=2.0)
    servers.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
    return servers


# --- one server ----------------------------------------------------------------------------------


def test_many_calls_are_one_message_in_their_order(world: World) -> None:
    client = world.client()
    sizes = sent_by(world, client)
    with batch.Batch(client) as calls:
        before = calls.simxGetJointPosition(3)
        calls.simxSetJointPosition(3, 0.5)
        after = calls.simxGetJointPosition(3)
        calls.simxSetJointPosition(3, 0.75)
    assert (before.value, after.value) == (0.0, 0.5)
    assert sizes == [4]
    assert world.simulation.log == [("set", 3, 0.5), ("set", 3, 0.75)]


def test_results_have_the_shape_of_their_function(world: World) -> None:
    with batch.Batch(world.client()) as calls:
        nothing = calls.simxSetJointPosition(3, 0.5)
        one = calls.simxGetIntegerParameter(2)
        several = calls.simxCallScriptFunction("there", 1, "echo", [1], [0.5], ["a"], bytearray(b"b"))
        a_list = calls.simxGetObjects(3)
    assert nothing.value is None
    assert one.value == 40002
    assert several.value == ([1], [0.5], ["a"], bytearray(b"b"))
    assert a_list.value == [0, 1, 2]


def test_numpy_numbers_are_taken_as_arguments(world: World) -> None:
    with batch.Batch(world.client()) as calls:
        calls.simxSetJointPosition(np.int32(3), np.float32(0.5))
        position = calls.simxGetJointPosition(np.int64(3))
    assert position.value == 0.5


def test_a_refused_call_is_told_with_server_call_and_reason(world: World) -> None:
    client = world.client()
    calls = (leaving := batch.Batch(client)).__enter__()
    good = calls.simxGetJointPosition(3)
    calls.simxGetJointPosition(-1)
    with pytest.raises(
        batch.CallsFailed, match=r"simxGetJointPosition\(-1\): no object with handle -1"
    ) as told:
        leaving.__exit__(None, None, None)
    (failure,) = told.value.failures
    assert failure.code == v.simx_return_remote_error_flag
    assert failure.where == world.transports[client].client
    assert good.value == 0.0


def test_unchecked_answers_tell_their_code_and_raise_when_used(world: World) -> None:
    with batch.Batch(world.client(), check=False) as calls:
        answer = calls.simxGetJointPosition(-1)
    assert answer.code == 8
    with pytest.raises(batch.CallsFailed, match="no object with handle -1"):
        _ = answer.value


def test_an_answer_used_inside_the_block_says_that_nothing_was_sent(world: World) -> None:
    with batch.Batch(world.client()) as calls:
        answer = calls.simxGetJointPosition(3)
        with pytest.raises(batch.CallsFailed, match="has not been sent yet"):
            _ = answer.value


def test_a_refusal_without_a_text_says_that_the_first_step_brings_the_value(world: World) -> None:
    with batch.Batch(world.client()) as calls:
        answer = calls.simxReadProximitySensor(3)
        calls.noted.clear()
    answer.take(Reply(1, v.simx_return_remote_error_flag, 0, []))
    assert answer.failure.reason == "there is no value yet; the first simulation step brings it"


def test_a_wrong_argument_names_the_function_and_sends_nothing(world: World) -> None:
    client = world.client()
    sizes = sent_by(world, client)
    calls: Any
    with pytest.raises(TypeError, match="simxSetJointPosition"), batch.Batch(client) as calls:
        [calls.simxSetJointPosition(3, value) for value in (0.5, "far")]
    assert sizes == []


def test_an_empty_batch_is_no_message(world: World) -> None:
    client = world.client()
    sizes = sent_by(world, client)
    with batch.Batch(client):
        pass
    assert sizes == []


def test_no_such_client_is_said_before_anything_is_noted() -> None:
    with pytest.raises(ValueError, match="no client 7"):
        batch.Batch(7)


def test_streams_and_paused_calls_of_the_legacy_functions_are_left_alone(world: World) -> None:
    client = world.client()
    v.simxGetJointPosition(client, 3, v.simx_opmode_streaming)
    with batch.Batch(client) as calls:
        calls.simxSetJointPosition(3, 0.5)
        assert calls.simxGetJointPosition(3).code != 0
    assert wait_until(
        lambda: v.simxGetJointPosition(client, 3, v.simx_opmode_buffer) == (0, 0.5), 2.0, world.settle
    )
    v.simxPauseCommunication(client, True)
    with pytest.raises(batch.CallsFailed, match="paused"), batch.Batch(client) as calls:
        calls.simxGetJointPosition(3)
    v.simxPauseCommunication(client, False)


def test_what_follows_a_trigger_is_executed_after_its_pass_and_answered_together(world: World) -> None:
    client = world.client()
    start_stepped(client)
    transport, answers = world.transports[client], []
    receive = transport.receive

    def counted(timeout: float, **hint: bool) -> bytes | None:
        payload = receive(timeout, **hint)
        answers.extend([] if payload is None else [len(decode_delivery(payload).replies)])
        return payload

    transport.receive = counted  # type: ignore[method-assign]
    with batch.Batch(client) as calls:
        for position in (0.25, 0.5):
            calls.simxSetJointPosition(3, position)
            calls.simxSynchronousTrigger()
        last = calls.simxGetJointPosition(3)
    assert world.simulation.log == [("set", 3, 0.25), ("pass", 1), ("set", 3, 0.5), ("pass", 2)]
    assert last.value == 0.5
    assert last.reply is not None
    assert last.reply.time_ms == 100
    assert answers == [5]


def start_stepped(client: int) -> None:
    with batch.Batch(client) as calls:
        calls.simxSynchronous(True)
        calls.simxStartSimulation()


def test_the_next_batch_comes_after_one_whose_pass_does_not_come(world: World) -> None:
    one, other = world.client(), world.client()
    start_stepped(one)
    start_stepped(other)
    refused = pytest.raises(batch.CallsFailed, match=r"no answer within 0\.05 s")
    with refused, batch.Batch(one, timeout=0.05) as calls:  # the other client does not trigger
        calls.simxSynchronousTrigger()
        calls.simxSetJointPosition(3, 0.5)
    assert world.simulation.log == []
    assert v.simxGetJointPosition(one, 3, BLOCKING) == (0, 0.5)
    assert v.simxStopSimulation(one, BLOCKING) == 0
    assert world.simulation.log == [("set", 3, 0.5)]


def test_a_stop_by_another_client_lets_an_interrupted_batch_go_on(world: World) -> None:
    one, other = world.client(), world.client()
    start_stepped(one)
    start_stepped(other)
    transport = world.transports[one]
    receive = transport.receive

    def stop_first(timeout: float) -> bytes | None:
        transport.receive = receive  # type: ignore[method-assign]
        world.settle()  # the trigger has arrived, on a busy machine too
        assert v.simxStopSimulation(other, BLOCKING) == 0
        return receive(timeout)

    with batch.Batch(one) as calls:
        calls.simxSynchronousTrigger()
        position = calls.simxGetJointPosition(3)
        world.settle()
        transport.receive = (  # type: ignore[method-assign]
            lambda timeout, **_: stop_first(timeout) if timeout > 0 else receive(timeout)
        )
    assert position.value == 0.0
    assert world.simulation.passes == 0


def test_a_client_that_leaves_in_the_middle_of_a_batch_has_the_rest_dropped(world: World) -> None:
    one, other = world.client(), world.client()
    start_stepped(one)
    start_stepped(other)
    refused = pytest.raises(batch.CallsFailed)
    with refused, batch.Batch(one, timeout=0.05) as calls:
        calls.simxSynchronousTrigger()
        calls.simxSetJointPosition(3, 0.5)
    world.transports[one].lose()
    assert v.simxSynchronousTrigger(other) == 0
    world.settle()
    assert ("set", 3, 0.5) not in world.simulation.log


def test_what_is_not_answered_in_time_is_told_as_that(world: World) -> None:
    client = world.client()
    refused = pytest.raises(batch.CallsFailed, match=r"no answer within 0\.05 s")
    with refused as told, batch.Batch(client, timeout=0.05) as calls:
        calls.simxGetVisionSensorImage(1, 0)  # nobody renders it
    assert told.value.failures[0].code == v.simx_return_timeout_flag
    assert v.simxGetJointPosition(client, 3, BLOCKING)[0] == 0


# --- many servers --------------------------------------------------------------------------------


def test_a_step_writes_passes_and_reads_with_one_message_per_server(worlds: list[World]) -> None:
    servers = stepped(worlds)
    at_first = servers.watch(lambda calls, _: [calls.simxGetJointPosition(joint) for joint in (3, 4)])
    assert at_first.tolist() == [[0.0, 0.0]] * 3
    sizes = [sent_by(world, client) for world, client in zip(worlds, servers.clients, strict=True)]
    wanted = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])

    def write(calls: batch.Calls, place: int) -> None:
        for joint, value in zip((3, 4), wanted[place], strict=True):
            calls.simxSetJointTargetPosition(joint, value)

    seen = servers.step(write)
    assert seen.dtype == np.float64
    assert np.array_equal(seen, wanted)
    assert sizes == [[5], [5], [5]]
    for world in worlds:
        assert [entry[0] for entry in world.simulation.log] == ["set", "set", "pass"]
    assert np.array_equal(servers.observations, wanted)


def test_all_servers_are_sent_to_before_any_is_waited_for(worlds: list[World]) -> None:
    servers = batch.Servers([world.client() for world in worlds])
    order: list[tuple[str, int]] = []
    for place, (world, client) in enumerate(zip(worlds, servers.clients, strict=True)):
        transport = world.transports[client]

        def send(payload: bytes, deadline: float, send=transport.send, place: int = place) -> None:
            order.append(("send", place))
            send(payload, deadline)

        def receive(
            timeout: float, *, is_soon: bool = False, receive=transport.receive, place: int = place
        ) -> bytes | None:
            if timeout > 0:
                order.append(("wait", place))
            return receive(timeout)

        transport.send, transport.receive = send, receive  # type: ignore[method-assign]
    servers.each(lambda calls, _: calls.simxGetJointPosition(3))
    assert [what for what, _ in order[:4]] == ["send", "send", "send", "wait"]


def test_each_gives_back_what_was_noted_with_its_answers(worlds: list[World]) -> None:
    servers = batch.Servers([world.client() for world in worlds])
    for place, world in enumerate(worlds):
        world.simulation.joints[3] = float(place)
    answers = servers.each(lambda calls, _: calls.simxGetJointPosition(3))
    assert [answer.value for answer in answers] == [0.0, 1.0, 2.0]


def test_watching_something_else_replaces_what_was_watched(worlds: list[World]) -> None:
    servers = stepped(worlds)
    servers.watch(lambda calls, _: [calls.simxGetJointPosition(joint) for joint in range(5)])
    servers.watch(lambda calls, _: [calls.simxGetJointPosition(4)])
    assert servers.step().shape == (3, 1)


def test_a_step_without_anything_watched_is_an_array_without_columns(worlds: list[World]) -> None:
    servers = stepped(worlds)
    with pytest.raises(RuntimeError, match="watch"):
        _ = servers.observations
    assert servers.step().shape == (3, 0)


def test_what_is_no_number_cannot_be_watched(worlds: list[World]) -> None:
    servers = stepped(worlds)
    with pytest.raises(ValueError, match="simxCallScriptFunction"):
        servers.watch(
            lambda calls, _: [calls.simxCallScriptFunction("a", 1, "b", [], [], ["text"], bytearray())]
        )


def test_rows_of_different_length_are_refused(worlds: list[World]) -> None:
    servers = stepped(worlds)
    with pytest.raises(ValueError, match=r"equally long.*\[1, 2, 3\]"):
        servers.watch(lambda calls, place: [calls.simxGetJointPosition(joint) for joint in range(place + 1)])


def test_a_call_that_fails_on_one_server_is_told_and_the_others_step(worlds: list[World]) -> None:
    servers = stepped(worlds)
    servers.watch(lambda calls, _: [calls.simxGetJointPosition(3)])
    worlds[1].simulation.removed.add(3)
    worlds[2].simulation.joints[3] = 0.25
    with pytest.raises(batch.CallsFailed, match=r"^server 1 .*simxGetJointPosition\(3\): no object") as told:
        servers.step()
    assert [failure.server for failure in told.value.failures] == [1]
    assert math.isnan(servers.observations[1, 0])
    assert servers.observations[2, 0] == 0.25
    assert [world.simulation.passes for world in worlds] == [1, 1, 1]
    assert servers.lost == {}


def test_a_lost_server_is_told_once_and_left_out_afterwards(worlds: list[World]) -> None:
    servers = stepped(worlds)
    servers.watch(lambda calls, _: [calls.simxGetJointPosition(3)])
    worlds[0].transports[servers.clients[0]].lose()
    with pytest.raises(batch.CallsFailed, match=r"server 0 .*the server went away"):
        servers.step()
    assert list(servers.lost) == [0]
    seen = servers.step()
    assert np.isnan(seen[:, 0]).tolist() == [True, False, False]
    assert [world.simulation.passes for world in worlds[1:]] == [2, 2]
    with pytest.raises(batch.CallsFailed, match="left out, since the server went away"):
        _ = servers.each(lambda calls, _: calls.simxGetJointPosition(3))[0].value


def test_a_step_without_stepped_mode_says_what_to_do(worlds: list[World]) -> None:
    servers = batch.Servers([world.client() for world in worlds])
    with pytest.raises(batch.CallsFailed, match="simxSynchronous"):
        servers.step()


# --- real processes ------------------------------------------------------------------------------


@pytest.fixture
def two(scene: Path) -> Iterator[list[ServerProcess]]:
    with server(scene) as one, server(scene) as other:
        yield [one, other]
    assert not CLIENTS.by_id


def test_two_real_servers_in_step_see_what_a_single_one_sees(two: list[ServerProcess]) -> None:
    def run(servers: batch.Servers) -> np.ndarray:
        servers.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        (hinge, *_) = [a.value for a in servers.each(lambda calls, _: calls.simxGetObjectHandle("hinge"))]
        servers.watch(lambda calls, _: [calls.simxGetJointPosition(hinge)])
        rows = [
            servers.step(lambda calls, _, speed=speed: calls.simxSetJointTargetVelocity(hinge, speed))
            for speed in (0.5, 1.0, -2.0)
        ]
        servers.each(lambda calls, _: calls.simxStopSimulation())
        return np.array(rows)[:, :, 0]

    with batch.Servers.connect(server.port for server in two) as servers:
        together = run(servers)
    with batch.Servers.connect([("127.0.0.1", two[1].port)]) as servers:
        alone = run(servers)
    assert np.all(np.diff(together[:2], axis=0) > 0)
    assert np.array_equal(together[:, 0], together[:, 1])
    assert np.array_equal(together[:, :1], alone)


def step_until_it_fails(servers: batch.Servers) -> None:
    for _ in range(1000):
        servers.step()


def test_a_killed_server_is_told_at_once_and_the_other_goes_on(two: list[ServerProcess]) -> None:
    with batch.Servers.connect([server.port for server in two], timeout=60.0) as servers:
        servers.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        servers.step()
        two[0].kill()
        # The test's own time limit is what fails if this waits for the time-out instead of the loss.
        with pytest.raises(batch.CallsFailed, match=f"server 0 .*:{two[0].port}.*went away"):
            step_until_it_fails(servers)
        assert list(servers.lost) == [0]
        assert servers.step().shape == (2, 0)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be frozen here")
def test_a_frozen_server_costs_the_time_out_once(two: list[ServerProcess]) -> None:
    with batch.Servers.connect([server.port for server in two]) as servers:
        servers.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        servers.watch(lambda calls, _: [calls.simxGetIntegerParameter(v.sim_intparam_program_version)])
        two[0].process.send_signal(signal.SIGSTOP)
        servers.timeout = 0.5
        with pytest.raises(batch.CallsFailed, match=r"server 0 .*no answer within 0\.5 s"):
            servers.step()
        servers.timeout = 60.0  # the test's own time limit fails if this is waited for
        for _ in range(3):
            assert np.isnan(servers.step()[:, 0]).tolist() == [True, False]


def test_a_server_that_is_not_there_leaves_no_connection(two: list[ServerProcess]) -> None:
    two[1].kill()
    with pytest.raises(ConnectionFailed, match=f"server 1 at 127.0.0.1:{two[1].port}"):
        batch.Servers.connect([server.port for server in two])


# --- the surroundings ----------------------------------------------------------------------------


def test_the_stub_of_the_recorder_is_fresh() -> None:
    assert stubs.CALLS_PATH.read_text(encoding="utf-8") == stubs.render_calls(), (
        "run: python -m simx_client.legacy.stubs"
    )


def test_importing_the_client_or_its_batches_loads_neither_numpy_nor_zenoh() -> None:
    code = (
        "import sys, simx_client; assert 'simx_client.batch' not in sys.modules; import simx_client.batch;"
        "print([name for name in ('numpy', 'zenoh', 'mujoco', 'cv2') if name in sys.modules])"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert ended.stdout.strip() == "[]"


def test_two_interrupted_batches_are_executed_in_their_order(world: World) -> None:
    one, other = world.client(), world.client()
    start_stepped(one)
    start_stepped(other)
    refused = pytest.raises(batch.CallsFailed)
    with refused, batch.Batch(one, timeout=0.05) as calls:  # the other client does not trigger
        for value in (0.25, 0.5):
            calls.simxSynchronousTrigger()
            calls.simxSetJointPosition(3, value)
    with refused, batch.Batch(one, timeout=0.05) as calls:
        calls.simxGetVisionSensorImage(1, 0)  # comes later
        calls.simxSetJointPosition(3, 0.75)
    assert world.simulation.log == [("set", 3, 0.25), ("set", 3, 0.5), ("set", 3, 0.75)]
