"""Clients for which the simulation waits, and that are frozen or think: ZMTP's PING tells one from the other."""

from __future__ import annotations

import socket
from typing import Any

import pytest
from zmq_world import ZmqWorld, cbor2

from simx_server.gateways.zmq import connection
from simx_server.gateways.zmq.clients import LEAST_REST
from simx_server.gateways.zmq.connection import Connection
from simx_server.gateways.zmq.gateway import RETRY
from simx_server.gateways.zmq.wire.zmtp import GREETING, READY, framed
from simx_server.service.clients.sessions import FROZEN

LOOKS = int(FROZEN / RETRY)
"""Looks of the gateway for which a client may be silent."""


class Frozen:
    """A client that answers no PING, as if its process did not run between its calls."""

    def __init__(self, port: int, minor: int = 1) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), 20.0)
        greeting = bytearray(GREETING)
        greeting[11] = minor
        self.socket.sendall(bytes(greeting) + READY.replace(b"ROUTER", b"DEALER"))
        self._unread = b""
        self._read_until(READY)

    def ask(self, function: str, *arguments: Any) -> Any:
        """Make a call and return its answer, which is short."""
        message = cbor2.dumps({"func": function, "args": list(arguments), "uuid": "frozen"})
        self.socket.sendall(framed(message))
        self._read_until(b"\x01\x00\x00")
        while not self._unread or len(self._unread) <= self._unread[0]:
            self._unread += self.socket.recv(4096)
        size = self._unread[0]
        answer, self._unread = self._unread[1 : 1 + size], self._unread[1 + size :]
        return cbor2.loads(answer)

    def _read_until(self, what: bytes) -> None:
        while what not in self._unread:
            self._unread += self.socket.recv(4096)
        self._unread = self._unread.partition(what)[2]


def look(server: ZmqWorld) -> None:
    """Let a second pass for the gateway."""

    def now() -> None:
        server.gateway._next_look = 0.0
        server.gateway.look()

    server.on_server(now)


def time_passes(server: ZmqWorld) -> bool:
    before = server.on_server(lambda: server.simulation.step_count)
    return server.wait_until(lambda: server.simulation.step_count > before + 2)


def start_stepping(client: Any) -> None:
    assert client.ask("sim.setStepping", True) == {"ret": [0]}
    assert "ret" in client.ask("sim.startSimulation")
    assert client.ask("sim.step") == {"ret": []}


def test_a_frozen_client_loses_its_stepping_and_is_told_so(server: ZmqWorld) -> None:
    client = Frozen(server.port)
    start_stepping(client)
    for _ in range(LOOKS):
        look(server)
    assert server.on_server(lambda: server.loop.service.due.is_waiting_for_trigger), "it may still come"
    look(server)
    assert time_passes(server)
    assert "nothing was heard of it for 4 s; call sim.setStepping(True)" in client.ask("sim.step")["err"]
    assert client.ask("sim.setStepping", True) == {"ret": [0]}
    assert client.ask("sim.step") == {"ret": []}
    client.socket.close()


def test_a_client_that_thinks_keeps_its_stepping(server: ZmqWorld) -> None:
    """Its library answers, also while the program computes or stands at a breakpoint."""
    client = server.raw()
    start_stepping(client)
    (peer,) = server.gateway._peers
    for _ in range(2 * LOOKS):
        look(server)
        if peer.silent_looks > 1:
            assert server.wait_until(lambda: peer.silent_looks == 0)
    assert server.on_server(lambda: server.loop.service.due.is_waiting_for_trigger)


def test_a_library_without_ping_keeps_its_stepping(server: ZmqWorld) -> None:
    """Its silence says nothing."""
    client = Frozen(server.port, minor=0)
    start_stepping(client)
    for _ in range(2 * LOOKS):
        look(server)
    assert server.on_server(lambda: server.loop.service.due.is_waiting_for_trigger)
    client.socket.close()


@pytest.mark.parametrize(
    ("answered", "others_wait", "least", "most"),
    [(0, False, 0.0, 1.0), (10, False, 0.15, 1.15), (600, False, 9.0, 10.0), (600, True, 0.9, 1.1)],
)
def test_functions_of_a_client_have_a_second_and_a_little_more_for_each_answer(
    server: ZmqWorld, answered: int, others_wait: bool, least: float, most: float
) -> None:
    """While others wait, many slow answers together have hardly more."""
    server.raw().ask("sim.getSimulationTime")
    (client,) = server.gateway._clients._clients.values()
    (its,) = client.connections.values()
    assert isinstance(its, Connection)

    def seconds_until_late() -> float:
        spent = 0.0
        for turn in range(10_000):
            its.has_waited(0.015, others_wait=others_wait)
            if its.is_late():
                break
            spent += 0.015
            if turn < answered:
                its.has_answered()
        return spent

    assert least <= server.on_server(lambda: its._act(seconds_until_late)) <= most


def test_a_client_whose_function_held_others_rests_as_long(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else it would leave them one simulation step for each second."""
    monkeypatch.setattr(connection, "SILENCE", 2 * LEAST_REST)
    rests: list[bool] = []
    suspend = server.loop.service.queue.suspend

    def noted(client: str, is_behind: bool) -> None:
        rests.append(is_behind)
        suspend(client, is_behind)

    monkeypatch.setattr(server.loop.service.queue, "suspend", noted)
    slow, other = server.raw(), server.raw()
    other.ask("sim.startSimulation")
    assert "func" in slow.ask("sim.testCB", 1, "f_0@func", 2, 1)
    assert "ret" in other.ask("sim.createDummy", 0.1), "it waits for the end of the call"
    assert "while other clients wait" in slow.ask("_*executed*_", 3)["err"]
    assert rests == [True, False], "its message was read after a rest"
