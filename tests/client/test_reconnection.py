"""A server that goes away and comes back: waiting calls, reads meanwhile, and streams that go on automatically."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from plain_world import World
from processes import server, wait_until
from routers import free_port

import simx_client as v
from simx_client.connection.clients import CLIENTS as CONNECTIONS
from simx_client.errors import NoAnswer

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]

BLOCKING, BUFFER, STREAMING = v.simx_opmode_blocking, v.simx_opmode_buffer, v.simx_opmode_streaming
CLIENTS = 10
TIMEOUT = 20.0
Record = Callable[[str, object], None]


@pytest.fixture
def plain() -> Iterator[World]:
    world = World()
    yield world
    world.close()


def start(port: int, *, number: int = 1, once: bool = False) -> int:
    return v.simxStart(f"127.0.0.{number}", port, True, once, 5000, 5)


def streamed_joint(client: int) -> int:
    """The hinge's handle, once its values arrive."""
    code, hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)
    assert code == 0
    assert v.simxGetJointPosition(client, hinge, STREAMING) == (1, 0.0)
    assert wait_until(lambda: v.simxGetJointPosition(client, hinge, BUFFER)[0] == 0, TIMEOUT)
    return hinge


def test_ten_scripts_that_only_read_their_buffers_go_on_with_a_restarted_server(
    scene: Path, record_property: Record
) -> None:
    port = free_port()
    with server(scene, "--start", ports=(port,)) as first:
        clients = [start(port, number=number) for number in range(1, CLIENTS + 1)]
        assert clients == list(range(CLIENTS))
        hinges = {client: streamed_joint(client) for client in clients}
        killed = time.monotonic()
        first.kill()
        assert wait_until(lambda: {v.simxGetConnectionId(client) for client in clients} == {-1}, TIMEOUT)
        noticed = time.monotonic()
        for client, hinge in hinges.items():
            assert v.simxGetJointPosition(client, hinge, BUFFER) == (1, 0.0), "nothing old is given as new"
    with server(scene, "--start", ports=(port,)):
        ready = time.monotonic()
        waiting = set(clients)

        def all_read() -> bool:
            waiting.difference_update(
                [
                    client
                    for client in waiting
                    if v.simxGetJointPosition(client, hinges[client], BUFFER)[0] == 0
                ]
            )
            return not waiting

        assert wait_until(all_read, TIMEOUT)
        recovered = time.monotonic()
        assert [v.simxGetConnectionId(client) for client in clients] == [2] * CLIENTS
        # What they read now moves on: it is the new server's.
        before = v.simxGetJointPosition(0, hinges[0], BUFFER)
        v.simxSetJointTargetVelocity(0, hinges[0], 1.0, BLOCKING)
        assert wait_until(lambda: v.simxGetJointPosition(0, hinges[0], BUFFER) != before, TIMEOUT)
    record_property(
        "figures",
        f"a killed server is noticed by {CLIENTS} clients within {1000 * (noticed - killed):.0f} ms; once it is back, "
        f"all read streamed values again after {1000 * (recovered - ready):.0f} ms",
    )


def test_who_connects_only_once_is_told_so_for_ever_and_starts_anew_by_himself(scene: Path) -> None:
    port = free_port()
    with server(scene, ports=(port,)) as first:
        client = start(port, once=True)
        hinge = streamed_joint(client)
        first.kill()
        assert wait_until(lambda: v.simxGetConnectionId(client) == -1, TIMEOUT)
    with server(scene, ports=(port,)):
        other = start(port, number=2)
        assert v.simxGetPingTime(other)[0] == 0  # the server is there
        assert v.simxGetConnectionId(client) == -1
        assert v.simxGetJointPosition(client, hinge, BUFFER) == (1, 0.0)
        assert v.simxGetJointPosition(client, hinge, STREAMING) == (1, 0.0)
        assert v.simxGetJointPosition(client, hinge, BLOCKING) == (3, 0.0)
        assert v.simxGetConnectionId(client) == -1
        v.simxFinish(client)
        assert v.simxGetJointPosition(client, hinge, BUFFER) == (64, 0.0)
        assert start(port, once=True) == client
        assert v.simxGetConnectionId(client) == 1
        assert v.simxGetJointPosition(client, hinge, BLOCKING)[0] == 0


def test_a_blocking_call_in_a_gap_waits_for_the_server_and_is_answered_by_it(scene: Path) -> None:
    port = free_port()
    with server(scene, ports=(port,)) as first:
        client = v.simxStart("127.0.0.1", port, True, False, -20_000, 5)
        hinge = streamed_joint(client)
        first.kill()
        assert wait_until(lambda: v.simxGetConnectionId(client) == -1, TIMEOUT)
        v.simxSetIntegerSignal(client, "asked for in the gap", 7, v.simx_opmode_oneshot)
    with server(scene, ports=(port,)):
        assert v.simxGetJointPosition(client, hinge, BLOCKING)[0] == 0
        assert v.simxGetConnectionId(client) == 2
        assert v.simxGetIntegerSignal(client, "asked for in the gap", BLOCKING) == (0, 7)


def lose_and_find(world: World, client: int, meanwhile: Callable[[], object] = lambda: None) -> None:
    transport = world.transports[client]
    transport.lose()
    assert v.simxGetConnectionId(client) == -1
    meanwhile()
    transport._connected = True  # a server is there again
    assert v.simxGetConnectionId(client) == 2
    world.settle()


def streams_of(world: World) -> list[tuple[list[object], float]]:
    """Arguments and delay of what the server streams to its only client."""
    [session] = world.loop.sessions.values()
    return [(stream.arguments, stream.delay) for stream in session.streams.by_id.values()]


def test_streams_are_armed_again_in_their_order_with_their_arguments(plain: World) -> None:
    client = plain.client()
    for handle in (3, 1, 2):
        v.simxGetJointPosition(client, handle, STREAMING + 40)
    plain.settle()
    before = streams_of(plain)
    assert [arguments for arguments, _ in before] == [[3], [1], [2]]
    lose_and_find(plain, client)
    assert streams_of(plain) == before
    assert v.simxGetJointPosition(client, 1, BUFFER)[0] == 0


def test_a_stream_that_was_ended_before_or_in_the_gap_stays_ended(plain: World) -> None:
    client = plain.client()
    for handle in (1, 2, 3):
        v.simxGetJointPosition(client, handle, STREAMING)
    v.simxGetJointPosition(client, 1, v.simx_opmode_discontinue)
    plain.settle()
    lose_and_find(plain, client, lambda: v.simxGetJointPosition(client, 2, v.simx_opmode_discontinue))
    assert [arguments for arguments, _ in streams_of(plain)] == [[3]]


def test_who_does_not_reconnect_has_no_streams_left(plain: World) -> None:
    client = plain.client(may_reconnect=False)
    v.simxGetJointPosition(client, 1, STREAMING)
    plain.settle()
    plain.transports[client].lose()
    plain.transports[client]._connected = True  # a server is there again, and not wanted
    assert v.simxGetConnectionId(client) == -1
    assert plain.loop.sessions == {}
    assert v.simxGetJointPosition(client, 1, BUFFER) == (1, 0.0)


def test_images_are_streamed_again(plain: World) -> None:
    client = plain.client()
    v.simxGetVisionSensorImage(client, 5, 0, STREAMING)
    plain.settle()
    lose_and_find(plain, client)
    plain.simulation.pictures[-1].set_result(([1, 1], b"\1\2\3"))
    assert wait_until(
        lambda: v.simxGetVisionSensorImage(client, 5, 0, BUFFER)[0] == 0, TIMEOUT, turn=plain.settle
    )


def test_stepped_mode_is_not_asked_for_again_as_it_is_the_servers(plain: World) -> None:
    client = plain.client()
    v.simxSynchronous(client, True)
    lose_and_find(plain, client)
    [session] = plain.loop.sessions.values()
    assert not session.is_stepping


def test_a_client_that_missed_the_return_of_its_server_finds_it(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SIMX_LOCAL", "0")
    with server(scene, ports=(0,)) as running:
        client = start(running.port)
        connection = CONNECTIONS.get(client)
        assert connection is not None
        lanes: Any = connection._transport
        transport = lanes.zenoh
        # As if the token of the new server had come before the old one's end.
        transport._on_server(SimpleNamespace(kind=transport._zenoh.SampleKind.DELETE))
        assert v.simxGetConnectionId(client) == -1
        assert wait_until(lambda: v.simxGetConnectionId(client) > 0, TIMEOUT)
        assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
        v.simxFinish(client)


class Busy:
    """A transport to a server that came back and does not answer greetings."""

    was_lost = is_connected = True
    client = "busy"

    def __init__(self) -> None:
        self.time_outs: list[float] = []

    def greet(self, timeout: float) -> None:
        self.time_outs.append(timeout)
        raise NoAnswer("it does not answer")

    def close(self) -> None:
        """Nothing is open."""


def test_greetings_of_a_busy_server_that_came_back_wait_longer_each_time(
    plain: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    connection = CONNECTIONS.get(plain.client())
    assert connection is not None
    busy = Busy()
    monkeypatch.setattr(connection, "_transport", busy)
    while len(busy.time_outs) < 6:
        connection._next_greeting = 0.0
        assert connection.connection_id == -1
    assert busy.time_outs == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.0, 1.0])
