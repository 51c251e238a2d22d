"""Listen for original clients at one or more ports; each connection has a thread."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.messages import Pace
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.exposure import plain_exposure
from simx_server.gateways.listening import Listening

from .connection import GATEWAY, Connection

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

FLAG = "--legacy-port"

BACKLOG = 10
"""Connections that the system keeps until they are accepted, as in the original."""

CLOSE_TIMEOUT = 2.0
"""Seconds for the threads of the connections to end."""


class OriginalGateway(Listening[Connection]):
    """Ports with the original's protocol, for one server loop. Several clients may use a port at the same time."""

    crowded = "it has sent nothing, and others need its place"

    def __init__(self, service: Service, addresses: Sequence[str], pace: Pace = Pace.FREE) -> None:
        """Listen at once.

        Args:
            addresses: ``HOST:PORT`` each, IPv4 as the original's clients; port 0 asks the system for a free one.
            pace: of blocking calls while the simulation runs.

        Raises:
            GatewayError: an address cannot be used.
        """
        self._pace = pace
        self._threads: dict[Connection, threading.Thread] = {}
        listeners: list[socket.socket] = []
        try:
            for address in addresses:
                listeners.append(_listen(address))
        except GatewayError:
            for listener in listeners:
                listener.close()
            raise
        places = [listener.getsockname()[:2] for listener in listeners]
        self.ports = [port for _, port in places]
        addresses = [f"{host}:{port}" for host, port in places]
        self.endpoints = [f"legacy/{address}" for address in addresses]
        if warning := plain_exposure(addresses):
            logger.warning("%s", warning)
        super().__init__(service, listeners, logger, GATEWAY)

    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> Connection:
        connected.setblocking(True)  # its thread reads it
        port: int = listener.getsockname()[1]
        connection = Connection(self._service, connected, _name(address), port, self._pace, log=self._log)
        thread = threading.Thread(target=self._run, args=(connection,), name="simx-legacy", daemon=True)
        thread.start()
        self._threads[connection] = thread
        return connection

    def _run(self, connection: Connection) -> None:
        try:
            connection.run()
        finally:
            self._service.queue.post(partial(self._ended, connection))

    def _ended(self, connection: Connection) -> None:
        self._peers.pop(connection, None)
        self._threads.pop(connection, None)

    def _crowd(self, host: str) -> Sequence[Connection]:
        return list(self._peers) if len(self._peers) >= self._service.simulation.limits.clients else ()

    def _refuse(self, listener: socket.socket, address: Any) -> None:
        text, port = "%s at port %d is refused: there are too many connections", listener.getsockname()[1]
        self._log.say(logging.WARNING, text, f"legacy {_name(address)}", port)

    def _cut(self, peer: Connection, why: str) -> None:
        del self._peers[peer]
        peer.break_off(why)

    def _end(self, peer: Connection) -> None:
        peer.close()

    @property
    def is_closing(self) -> bool:
        return any(thread.is_alive() for thread in self._threads.values())

    def leave(self) -> None:
        """Close the ports and their connections, whose threads have their clients leave."""
        super().close()

    def close(self) -> None:
        """Stop listening and end all connections."""
        super().close()
        end = time.monotonic() + CLOSE_TIMEOUT
        for thread in list(self._threads.values()):
            thread.join(max(0.0, end - time.monotonic()))


def _name(address: tuple[str, int]) -> str:
    host, port = address
    return f"{host}:{port}"


def _listen(address: str) -> socket.socket:
    """Return a socket that listens. Raises GatewayError."""
    host, _, port = address.rpartition(":")
    try:
        return socket.create_server((host, int(port)), backlog=BACKLOG)
    except PermissionError:
        raise GatewayError(f"port {port} needs more rights; choose one above 1023 with {FLAG}") from None
    except OSError as error:
        raise GatewayError(
            f"the original's protocol cannot listen at {address} ({error.strerror or error}), perhaps another "
            f"simx-server or a V-REP does; stop that one, or choose another port with {FLAG} N (0 finds a free one)"
        ) from None
