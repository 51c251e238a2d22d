"""A world for pieces of old scripts: ``vrep.simxStart`` and all that follows, in the test's own process.

Only the network is left out. The scene is that of the conformance suite, which has one of each.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from loopback import LoopbackTransport
from real_world import RealWorld

import simx_client as vrep
from simx_client.errors import ConnectionFailed
from simx_client.legacy import local
from simx_client.transport.endpoints import ServerAddress

SCENE = Path(__file__).parents[2] / "conformance" / "scene.xml"
PORTS = (19997, 19999)


class IdiomWorld(RealWorld):
    """Answers ``simxStart`` on the usual ports, whatever loopback address is named."""

    def __init__(self, *, own_thread: bool = False) -> None:
        """`own_thread`: the server loop runs in a thread, for scripts with threads; else it turns while they wait."""
        super().__init__(SCENE)
        self.ports = list(PORTS)
        self.transports: list[LoopbackTransport] = []
        self._thread = threading.Thread(target=self.loop.run) if own_thread else None
        if self._thread is not None:
            self._thread.start()

    def open(self, place: ServerAddress, **_: Any) -> LoopbackTransport:
        port = place.host_and_port[1] if place.host_and_port else 0
        if port not in self.ports:
            raise ConnectionFailed(f"nothing listens at {place}")
        transport = LoopbackTransport(self.loop, port=port, turns=self._thread is None)
        self.transports.append(transport)
        return transport

    def settle(self, turns: int = 3) -> None:
        """Pass the time between two calls of a script: the server goes on."""
        for _ in range(turns):
            self.loop.turn(max_wait=0.05)

    def close(self) -> None:
        vrep.simxFinish(-1)
        self.loop.service.ending.request()
        if self._thread is not None:
            self._thread.join(10)
        super().close()


@contextmanager
def idiom_world(*, own_thread: bool = False) -> Iterator[IdiomWorld]:
    """A world that is there for every ``simxStart`` in this process."""
    world = IdiomWorld(own_thread=own_thread)
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(local, "open_link", world.open)
            yield world
    finally:
        world.close()


def connect(port: int = 19997) -> int:
    """The first three lines of nearly every script."""
    vrep.simxFinish(-1)
    clientID = vrep.simxStart("127.0.0.1", port, True, True, 5000, 5)
    assert clientID != -1
    return clientID


def handle(clientID: int, name: str) -> int:
    return vrep.simxGetObjectHandle(clientID, name, vrep.simx_opmode_oneshot_wait)[1]


def start_stepped(clientID: int) -> None:
    vrep.simxSynchronous(clientID, True)
    vrep.simxStartSimulation(clientID, vrep.simx_opmode_blocking)
    vrep.simxSynchronousTrigger(clientID)
    vrep.simxGetPingTime(clientID)
