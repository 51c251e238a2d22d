"""The clients of the ZeroMQ remote API, on the physics thread: each has a session and a script without text.

The namespaces of that script are those of the scene's scripts, so a client gets the same functions and numbers. Calls
that wait for simulation steps are continued here after each step, and while the simulation is stopped.
"""

from __future__ import annotations

import logging
import re
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_server.limits import LimitReached
from simx_server.scripting.interpreter import TIMEOUT
from simx_server.service.answers.link import Link
from simx_server.service.clients.admission.entrance import Entrance
from simx_server.service.watcher import Watcher

from .client import Client, OpenConnection
from .connection import Connection
from .functions import described
from .peer import Peer, SocketPeer, with_number
from .wire.messages import language_of
from .work import MessageWork

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

FIRST_HANDLE = 3_000_003
"""Handles of clients' scripts are above those of the scene's scripts."""

ONE_CALL = 5.0
"""Seconds after which a client that has made one call only gives its place to another one, if all are taken."""

LEAST_REST = 0.05
"""Seconds that functions of a client may hold others in one call without consequences: a simulation step."""

Answer = Callable[[Peer, Any], None]

REPEAT: Mapping[str, Any] = {"func": "_*repeat*_", "args": []}
"""Makes a client send its last message again."""


class _Link(Link):
    """The link of a session: answers take another way, and the protocol has no streams."""

    def __init__(self, closed: Callable[[], object]) -> None:
        self._closed = closed

    def close(self) -> None:
        self._closed()


class ZmqClients(Watcher):
    """All clients of one gateway. Physics thread."""

    def __init__(
        self,
        service: Service,
        peers: Mapping[int, Peer],
        answer: Callable[[Peer, Any], object],
        *,
        first_handle: int = FIRST_HANDLE,
        gateway: str = "",
    ) -> None:
        """Make an empty list.

        Args:
            peers: the open connections by number.
            answer: sends a message to a connection.
            first_handle: that of the first client's script.
            gateway: its name.
        """
        self._gateway = gateway
        self.service, self.world = service, service.world
        self.answer = answer
        self._peers = peers
        self._clients: dict[str, Client] = {}
        self._next_handle = first_handle
        self._waiting: dict[OpenConnection, None] = {}
        """Connections whose call waits for a simulation step, in the order of their calls."""

        self._resting: dict[str, float] = {}
        """Clients that are not served, and until when."""

        service.metrics.count_also(_Functions())
        service.watchers.add(self)

    # --- coming and going ------------------------------------------------------------------------

    def welcome(self, peer: SocketPeer, payload: bytes, port: int) -> Mapping[str, Any] | None:
        """Accept a client with its message, unless it is there already; return the answer if it must not be queued.

        Args:
            peer: the connection by which it comes.
            port: the gateway's.
        """
        key, entrance = peer.key, Entrance(self._gateway, peer.address)
        client = self._clients.get(key)
        if client is not None:
            return REPEAT if client.is_leaving else None  # it has come back at once
        try:
            self.join(key, _name(key, payload), port, entrance)
        except LimitReached as problem:
            return REPEAT if self._frees_place() else {"err": str(problem)}
        return None

    def _frees_place(self) -> bool:
        """Have the client leave that has been silent for longest since its only call, which has changed nothing.

        It loses nothing: with its next message it joins again. Return whether a client is about to leave.
        """
        if any(client.is_leaving for client in self._clients.values()):
            return True
        before = time.perf_counter() - ONE_CALL
        for key, client in self._clients.items():
            peers = [connection.peer for connection in client.connections.values()]
            if (
                len(peers) == 1
                and isinstance(peer := peers[0], SocketPeer)
                and peer.answered < before
                and not peer.unanswered
                and sum(client.session.called.values()) == 1
                and all(described(name).only_reads for name in client.session.called)
            ):
                peer.break_off("its client has made one call, and others need its place")
                self.part_from(key)
                return True
        return False

    def join(self, key: str, name: str, port: int, entrance: Entrance | None = None) -> Client:
        """Add a client and return it; no entrance: it has a place already. Raises LimitReached."""
        client = Client(self.world, key, name, self._next_handle)
        self._next_handle += 1
        self._clients[key] = client
        link = _Link(partial(self._forget, client))
        try:
            client.session = self.service.clients.join(
                key, name, port, link, calls_sim=True, entrance=entrance
            )
        except LimitReached:
            del self._clients[key]
            self._next_handle -= 1
            raise
        client.level = int(client.session.is_stepping)  # it came back to the successor of a crashed server
        return client

    def peer(self, number: int) -> Peer | None:
        """Return an open connection."""
        return self._peers.get(number)

    def steppers(self) -> list[str]:
        """Return the clients for which the simulation waits now and then."""
        return [key for key, client in self._clients.items() if client.session.is_stepping]

    def part_from(self, key: str) -> None:
        """Let a client leave after what it has sent is executed."""
        client = self._clients.get(key)
        if client is not None:
            client.is_leaving = True
            self.service.clients.depart(key)

    def _forget(self, client: Client) -> None:
        for connection in client.connections.values():
            connection.end()
            self._waiting.pop(connection, None)
        if self._clients.get(client.key) is client:
            del self._clients[client.key]
            self._resting.pop(client.key, None)
            owner = client.script.signal_owner
            self.world.simulation.parts.tell(lambda part: part.script_ended(owner))

    # --- messages --------------------------------------------------------------------------------

    def work(self, number: int, payload: bytes) -> MessageWork:
        """Return a message of a connection as work."""
        return MessageWork(number, payload, self.serve)

    def serve(self, key: str, number: int, payload: bytes) -> None:
        """Execute a message of a client that came by a connection."""
        client, peer = self._clients.get(key), self.peer(number)
        if client is None or peer is None:
            return
        connection = client.connections.get(number)
        if connection is None:
            client.connections = {n: each for n, each in client.connections.items() if not each.peer.is_gone}
            connection = client.connections[number] = self._connect(client, peer)
        connection.receive(payload)

    def _connect(self, client: Client, peer: Peer) -> Connection:
        """Return a new connection of a client."""
        return Connection(self, client, peer)

    def pass_on(self, connection: Connection, payload: bytes) -> None:
        """Queue a message that came within a function of the client, and is not for it."""
        self.service.queue.submit(connection.client.key, self.work(connection.peer.number, payload))

    def note(self, connection: Connection, payload: bytes) -> None:
        """Record a message that is going to be executed."""
        for react in self.service.watchers.batch_comes:
            react(connection.client.key, with_number(connection.peer.number, payload))

    def next_message(self, connection: Connection, queue: deque[bytes | None], name: str) -> bytes:
        """Return the next message of a client that runs a function for the server; others are served meanwhile.

        Args:
            queue: receives its messages, and None when it has left.
            name: the function.

        Raises:
            ScriptError: it takes too long, or the client has left.
        """
        message = self._await(connection, queue, name)
        self.world.simulation.interruptions.script_point()
        for react in self.service.watchers.function_answered:
            react(connection.client.key, message)
        if isinstance(message, str):
            raise connection.broken(message)
        return message

    def _await(self, connection: Connection, queue: deque[bytes | None], name: str) -> bytes | str:
        """Wait for the next message; return why none is waited for any longer, if none comes."""
        simulation = self.world.simulation
        while not connection.is_late() and not simulation.is_ending:
            if queue:
                connection.has_answered()
                return queue.popleft() or f"the client has left within its function {name}"
            began = time.perf_counter()
            self.service.queue.open_sockets().poll(TIMEOUT)
            seconds = time.perf_counter() - began
            connection.has_waited(
                seconds, others_wait=self.service.clients.others_wait_for(connection.client.key)
            )
            if not queue and not simulation.physics_calls.is_in_step:
                simulation.interruptions.serve_others()
        return "the server ends" if simulation.is_ending else connection.too_long(name)

    def has_held_others(self, client: Client, seconds: float) -> None:
        """Have a client rest for as long as others have waited for its functions in one call, or one step of it.

        Else a client that calls again at once would leave them one simulation step a call.
        """
        if seconds > LEAST_REST and not client.session.is_stepping:
            self._resting[client.key] = time.monotonic() + seconds
            self.service.queue.suspend(client.key, True)

    def look(self) -> None:
        """Go on with the clients that have rested; now and then."""
        now = time.monotonic()
        for key in [key for key, until in self._resting.items() if until <= now]:
            del self._resting[key]
            self.service.queue.suspend(key, False)

    # --- calls that wait -------------------------------------------------------------------------

    def wait(self, connection: Connection) -> None:
        """Continue a connection's call after the next simulation step, which its client allows if it steps.

        The step may come much later: the call may have started before the run, or in a pause.
        """
        self._waiting[connection] = None
        connection.client.session.allow_steps(True)

    def _continue(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for connection in waiting:
            connection.client.session.allow_steps(False)
            self.service.queue.put_first(connection.client.key, partial(self._go_on, connection))

    def _go_on(self, connection: OpenConnection) -> None:
        if connection.is_waiting:
            for react in self.service.watchers.call_goes_on:
                react(connection.client.key, connection.peer.number)
            connection.go_on()

    def step_finished(self) -> None:
        self._continue()

    def run_stopped(self) -> None:
        """End the stepping of every client, as the server loop does, and let waiting calls find out, or fail."""
        failure = self.world.simulation.failure
        for client in self._clients.values():
            client.level = client.locks = 0
            for connection in client.connections.values() if failure else ():
                connection.fail(failure)
        self._continue()

    def run_paused(self) -> None:
        self._continue()

    @property
    def wants_idle(self) -> bool:
        """Return whether calls wait while no simulation step is due."""
        return bool(self._waiting)

    def idle(self) -> None:
        """Continue the calls that wait while the simulation is stopped or paused."""
        self._continue()


def _name(key: str, payload: bytes) -> str:
    """Return how a client is called in messages: its language and the start of its identity."""
    language = re.sub(r"[^a-z0-9+]", "", language_of(payload).lower())[:12]
    return f"{language or 'client'}-{key.rpartition('/')[2][:8]}"


class _Functions:
    """The names of all functions, for the metrics."""

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and described(name).is_known
