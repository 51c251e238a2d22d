"""A stop from a client of any gateway ends a search that holds the physics thread; others are served meanwhile."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from loopback import LoopbackTransport
from original_peer import ints, peer
from zmq_world import RawClient, ZmqWorld, zmq_world

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.gateways.zmq.gateway import ZmqGateway
from simx_server.simulation.simulation import SimulationState

LONGEST = 20.0
"""Seconds of a search that nobody ends, after which the test fails."""

BLOCKING, ONESHOT = v.simx_opmode_blocking, v.simx_opmode_oneshot
STOP = 0x1007, ints(2)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ZmqWorld]:
    with zmq_world(tmp_path) as opened:
        yield opened


class Search:
    """A search on the physics thread, as planners make them."""

    def __init__(self, server: ZmqWorld) -> None:
        self._server = server
        self.has_begun, self._is_over = threading.Event(), threading.Event()
        self.is_wanted = True
        """Cleared by a test that ends it otherwise."""

        self.was_given_up = False
        server.loop.post(self._run)
        assert self.has_begun.wait(LONGEST)

    def _run(self) -> None:
        interruptions = self._server.simulation.interruptions
        self._server.simulation.start()
        self._server.simulation.settle()
        end = time.monotonic() + LONGEST
        while self.is_wanted and time.monotonic() < end:
            self.has_begun.set()
            if not interruptions.may_go_on():
                self.was_given_up = True
                break
        self._is_over.set()

    def wait(self) -> bool:
        """Return whether it was given up for a stop."""
        assert self._is_over.wait(2 * LONGEST)
        return self.was_given_up


def is_stopped(server: ZmqWorld) -> bool:
    return server.wait_until(lambda: server.simulation.state is SimulationState.STOPPED)


@pytest.fixture
def own(server: ZmqWorld) -> Iterator[int]:
    made = Connection(
        lambda: LoopbackTransport(server.loop, name="own", port=19997, turns=False),
        where="",
        timeout=LONGEST,
    )
    number = CLIENTS.add(made)
    made.connect(LONGEST)
    yield number
    v.simxFinish(number)


@pytest.fixture
def original_port(server: ZmqWorld) -> Iterator[int]:
    gateway = OriginalGateway(server.loop, ["127.0.0.1:0"])
    yield gateway.ports[0]
    gateway.close()


def test_a_stop_of_an_own_client_ends_a_search(server: ZmqWorld, own: int) -> None:
    search = Search(server)
    v.simxStopSimulation(own, ONESHOT)
    assert search.wait()
    assert is_stopped(server)


def test_a_stop_behind_a_call_that_waits_ends_a_search(server: ZmqWorld, own: int) -> None:
    search = Search(server)
    v.simxCreateDummy(own, 0.1, None, ONESHOT)
    v.simxStopSimulation(own, ONESHOT)
    assert search.wait()


def test_a_stop_of_an_original_client_ends_a_search(server: ZmqWorld, original_port: int) -> None:
    search = Search(server)
    with peer(original_port) as original:
        assert not original.call(*STOP).has_failed
    assert search.wait()
    assert is_stopped(server)


def test_a_stop_of_a_zmq_client_ends_a_search(server: ZmqWorld) -> None:
    search = Search(server)
    assert server.raw().ask("sim.stopSimulation") == {"ret": [1]}
    assert search.wait()
    assert is_stopped(server)


def test_a_stop_of_a_viewer_which_is_refused_ends_no_search(server: ZmqWorld) -> None:
    viewers = ZmqGateway(server.loop, "127.0.0.1:0", may_only_read=True)
    viewer = RawClient(viewers.port)
    try:
        search = Search(server)
        viewer.send("sim.stopSimulation")
        assert server.raw().ask("sim.getSimulationTime")["ret"] == [0.0], "it comes behind the viewer's"
        search.is_wanted = False
        assert not search.wait()
        assert "viewer" in viewer.answer()["err"]
    finally:
        viewer.close()
        server.on_server(viewers.close)


def test_zmq_clients_read_and_set_signals_during_a_search(server: ZmqWorld) -> None:
    search, raw = Search(server), server.raw()
    assert raw.ask("sim.setInt32Signal", "found", 7) == {"ret": [1]}
    assert raw.ask("sim.getInt32Signal", "found") == {"ret": [7]}
    assert not search._is_over.is_set()
    search.is_wanted = False
    assert not search.wait()
