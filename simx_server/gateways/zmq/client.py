"""One client of the ZeroMQ remote API: a session, a script without text, and its connections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces

from .peer import Peer

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World


class OpenConnection(Protocol):
    """A connection of a client; `connection.Connection` documents the methods."""

    peer: Peer

    @property
    def client(self) -> Client: ...
    @property
    def is_waiting(self) -> bool: ...
    def receive(self, payload: bytes) -> None: ...
    def go_on(self) -> None: ...
    def fail(self, problem: str) -> None: ...
    def end(self) -> None: ...
    def call_back(self, name: str, arguments: tuple[Any, ...]) -> list[Any]: ...


class Client:
    """One client: everything that its connections share."""

    def __init__(self, world: World, key: str, name: str, handle: int) -> None:
        self.key, self.name, self.world = key, name, world
        self.script = Script(handle, ScriptKind.CUSTOMIZATION, -1, name, full_results=True)
        self.namespaces = Namespaces(world, self.script)
        self.level = 0
        """How often it has called sim.setStepping(True) more than sim.setStepping(False)."""

        self.locks = 0
        """How often it has called sim.acquireLock more than sim.releaseLock."""

        self.is_leaving = False
        """Its last connection has ended; what it has sent is executed still."""

        self.session: ClientSession
        self.connections: dict[int, OpenConnection] = {}
        self.acting: OpenConnection | None = None
        """The connection whose call is being executed."""

    def forget_lost_stepping(self) -> None:
        """Count from 0 again, if the server has ended the stepped mode."""
        if self.session.take_lost_stepping():
            self.level = self.locks = 0

    def set_stepping(self) -> None:
        """Have the simulation wait for this client, or not, as its level and its locks require."""
        wanted = self.level > 0 or self.locks > 0
        if wanted != self.session.is_stepping:
            self.session.set_stepping(wanted)
