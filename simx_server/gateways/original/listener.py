"""Listen for original clients at one or more ports; each connection has a thread."""

from __future__ import annotations

import contextlib
import logging
import socket
import threading
import time
from collections.abc import Sequence

from simx_client.protocol.messages import Pace
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.exposure import plain_exposure
from simx_server.gateways.outsider_log import OutsiderLog
from simx_server.service.server_loop import ServerLoop

from .connection import DOOR, Connection

logger = logging.getLogger(__name__)

FLAG = "--legacy-port"

BACKLOG = 10
"""Connections that the system keeps until they are accepted, as in the original."""

CLOSE_TIMEOUT = 2.0
"""Seconds for the threads of the connections to end."""

LOOK = 1.0
"""Seconds after which a thread that waits for clients checks whether the port is closed."""

RETRY = 0.1
"""Seconds until a port accepts again after an error, such as no free file descriptors."""


class LegacyGateway:
    """Ports with the original's protocol, for one server loop. Several clients may use a port at the same time."""

    def __init__(self, loop: ServerLoop, addresses: Sequence[str], pace: Pace = Pace.FREE) -> None:
        """Listen at once.

        Args:
            addresses: ``HOST:PORT`` each, IPv4 as the original's clients; port 0 asks the system for a free one.
            pace: of blocking calls while the simulation runs.

        Raises:
            GatewayError: an address cannot be used.
        """
        self._loop, self._pace = loop, pace
        self._log = OutsiderLog(logger)
        self._lock = threading.Lock()
        self._connections: dict[Connection, None] = {}
        """In the order in which they came."""

        self._threads: set[threading.Thread] = set()
        self._is_closed = False
        self._listeners: list[socket.socket] = []
        try:
            for address in addresses:
                self._listeners.append(_listen(address))
        except GatewayError:
            self._close_listeners()
            raise
        places = [listener.getsockname()[:2] for listener in self._listeners]
        self.ports: list[int] = [port for _, port in places]
        self.endpoints = [f"{host}:{port}" for host, port in places]
        if warning := plain_exposure(self.endpoints):
            logger.warning("%s", warning)
        if self.ports:
            loop.places.open(DOOR)
        for listener, port in zip(self._listeners, self.ports, strict=True):
            thread = threading.Thread(
                target=self._accept, args=(listener, port), name="simx-legacy-port", daemon=True
            )
            self._threads.add(thread)
            thread.start()

    def _accept(self, listener: socket.socket, port: int) -> None:
        while not self._is_closed:
            try:
                connected, peer = listener.accept()
            except TimeoutError:
                continue
            except OSError as error:
                if self._is_closed:
                    return
                logger.warning("port %d cannot accept a client at present: %s", port, error)
                time.sleep(RETRY)
                continue
            self._serve(connected, f"{peer[0]}:{peer[1]}", port)

    def _serve(self, connected: socket.socket, peer: str, port: int) -> None:
        """Start the thread of a connection, unless there are too many."""
        connection = Connection(self._loop, connected, peer, port, self._pace, log=self._log)
        thread = threading.Thread(target=self._run, args=(connection,), name="simx-legacy", daemon=True)
        with self._lock:
            is_refused = self._is_closed or not self._has_room()
            if not is_refused:
                self._connections[connection] = None
                self._threads.add(thread)
                thread.start()  # under the lock, because `close` waits only for threads that have started
        if is_refused:
            text = "%s at port %d is refused: there are too many connections"
            self._log.say(logging.WARNING, text, connection.name, port)
            connected.close()

    def _has_room(self) -> bool:
        """Return whether there is a place for one more; the longest one without a client is closed. Under the lock."""
        if len(self._connections) < self._loop.simulation.limits.clients:
            return True
        longest = next((each for each in self._connections if not each.has_joined), None)
        if longest is None:
            return False
        del self._connections[longest]
        longest.break_off("it has sent nothing, and others need its place")
        return True

    def _run(self, connection: Connection) -> None:
        try:
            connection.run()
        finally:
            with self._lock:
                self._connections.pop(connection, None)
                self._threads.discard(threading.current_thread())

    def close(self) -> None:
        """Stop listening and end all connections. Any thread; not the physics thread while clients are served."""
        with self._lock:
            self._is_closed = True
            connections, threads = list(self._connections), list(self._threads)
        self._close_listeners()
        for connection in connections:
            connection.close()
        end = time.monotonic() + CLOSE_TIMEOUT
        for thread in threads:
            if thread is not threading.current_thread():
                thread.join(max(0.0, end - time.monotonic()))

    leave = close

    def _close_listeners(self) -> None:
        for listener in self._listeners:
            with contextlib.suppress(OSError):  # wakes up the thread in accept, except on macOS
                listener.shutdown(socket.SHUT_RDWR)
            listener.close()


def _listen(address: str) -> socket.socket:
    """Return a socket that listens. Raises GatewayError."""
    host, _, port = address.rpartition(":")
    try:
        listener = socket.create_server((host, int(port)), backlog=BACKLOG)
    except PermissionError:
        raise GatewayError(f"port {port} needs more rights; choose one above 1023 with {FLAG}") from None
    except OSError as error:
        raise GatewayError(
            f"the original's protocol cannot listen at {address} ({error.strerror or error}), perhaps another "
            f"simx-server or a V-REP does; stop that one, or choose another port with {FLAG} N (0 finds a free one)"
        ) from None
    listener.settimeout(LOOK)
    return listener
