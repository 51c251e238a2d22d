"""A whole server in the test's own thread: real physics, real pictures, clients over the in-process way."""

from __future__ import annotations

import math
import uuid
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

from loopback import LoopbackTransport

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.embedded import EmbeddedConnection
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.protocol.messages import Pace
from simx_server.app.server import open_world
from simx_server.gateways.embedded.transport import EmbeddedTransport
from simx_server.gateways.embedded.turns import Turns
from simx_server.handlers import HANDLERS
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.service.clock import Pacer
from simx_server.service.loop import ServerLoop
from simx_server.service.service import build_service
from simx_server.settings.settings import Settings

BLOCKING = v.simx_opmode_blocking


def path_of(world: RealWorld) -> Path:
    """Return the file of the loaded scene."""
    path = world.simulation.scene.path
    assert path is not None
    return path


class _Unpaced(Turns):
    """Has no pacing thread until `paces` is set, so that a test decides when a step is made."""

    paces = False

    def note_change(self) -> None:
        if self.paces:
            super().note_change()


class RealWorld:
    """What `simx-server SCENE --speed max` is, without the network."""

    def __init__(self, scene: str | Path, *, speed: float = math.inf, workspace: Path | None = None) -> None:
        self._stack = ExitStack()
        self.turns: _Unpaced | None = None
        settings = Settings(scene=str(scene), workspace=cast(Path, workspace))  # None: without one
        self.parts = open_world(settings, self._stack)
        self.simulation = self.parts.simulation
        pacer = Pacer(speed)
        self.loop = ServerLoop(build_service(self.parts, HANDLERS, pacer))
        self.parts.parameters.served_by(pacer, lambda: self.loop.service.due.is_waiting_for_trigger)

    def client(self, pace: Pace = Pace.FREE, *, timeout: float = DEFAULT_TIMEOUT) -> int:
        transport = LoopbackTransport(self.loop)
        connection = Connection(lambda: transport, where=transport.client, pace=pace)
        connection.timeout = timeout
        client_id = CLIENTS.add(connection)
        connection.connect(1.0)
        return client_id

    def embedded_client(self, pace: Pace = Pace.FREE, *, timeout: float = DEFAULT_TIMEOUT) -> int:
        """A client whose calls its own thread executes; a test turns the loop for what happens without calls."""
        if self.turns is None:
            self.turns = _Unpaced(self.loop)
            self._stack.callback(self.turns.close)
        transport = EmbeddedTransport(self.loop, self.turns, uuid.uuid4().hex, "embedded", 0)
        connection = EmbeddedConnection(lambda: transport, where=transport.client, timeout=timeout, pace=pace)
        client_id = CLIENTS.add(connection)
        connection.connect(1.0)
        return client_id

    def let_time_pass(self) -> None:
        """Let things happen without calls of an embedded client, as they do for users."""
        if self.turns is not None:
            self.turns.paces = True

    def close(self) -> None:
        v.simxFinish(-1)
        self._stack.close()
        self.loop.service.queue.close_sockets()


def render_with(world: Any, thread: Any) -> None:
    """Have another render thread make the images of a world, which closes its first one."""
    if isinstance(world.parts.rendering, RenderThread):
        world.parts.rendering.close()
    object.__setattr__(world.parts, "rendering", thread)  # a world is frozen for everybody else
    world.parts.vision._rendering = thread


World = tuple[RealWorld, int]
"""A world, and a client of it."""

Open = Callable[[str], World]
"""Opens a scene by its name or path."""


def handle_of(client: int, name: str) -> int:
    """The handle of an object that must be there."""
    code, handle = v.simxGetObjectHandle(client, name, BLOCKING)
    assert code == v.simx_return_ok, name
    return handle


def step(client: int, seconds: float, time_step: float = 0.05) -> None:
    """Let so much simulated time pass in stepped mode."""
    for _ in range(round(seconds / time_step)):
        assert v.simxSynchronousTrigger(client) == v.simx_return_ok


def start_stepped(client: int) -> None:
    assert v.simxSynchronous(client, True) == v.simx_return_ok
    assert v.simxStartSimulation(client, BLOCKING) == v.simx_return_ok
