"""The connections of this process by client id: the only global state of the legacy API."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from simx_client.calls.marshalling import Marshal
from simx_client.errors import ConnectionFailed
from simx_client.protocol import constants as c
from simx_client.protocol.kinds import to_int32

from .connection import Connection
from .timeouts import FLUSH_TIMEOUT

if TYPE_CHECKING:
    from simx_client.transport.direct import EmbeddedServer

logger = logging.getLogger(__name__)


class Clients:
    """The connections of this process by client id."""

    MAX_CLIENTS = 255
    """Number of ids in the shipped builds of the original library."""

    def __init__(self) -> None:
        self.by_id: dict[int, Connection] = {}
        self._lock = threading.RLock()  # reentrant: garbage collection may close a client at any time
        self._process: int | None = None
        """Id of the process that connects: Zenoh's threads run there and do not exist in a forked child."""

        self._of_parent: list[object] = []
        self._server: EmbeddedServer | None = None
        """The server in this process to which simxStart leads, if the user chose that."""

    def get(self, client_id: Any) -> Connection | None:
        """Return the connection with this id; ids may be numpy integers or bools."""
        try:
            return self.by_id.get(client_id)
        except TypeError:  # an array cannot be a dictionary key
            return self.by_id.get(to_int32(client_id))

    def add(self, connection: Connection) -> int:
        """Give a connection the lowest free id; -1 if no id is free or a connection to the same server
        exists."""
        try:
            with self._lock:
                self._refuse_second(connection)
                return self.admit(connection)
        except ConnectionFailed as error:
            logger.warning("%s", error)
            return -1

    def admit(self, connection: Connection) -> int:
        """Give a connection the lowest free id, even if another connection to the same server exists.

        Raises:
            ConnectionFailed: no id is free, or this process is a fork of a process that has connected.
        """
        with self._lock:
            if self._process not in (None, os.getpid()) and not connection.works_after_fork:
                raise ConnectionFailed(
                    f"no connection to {connection.where}: this process was forked from one that had connected "
                    "before, and Zenoh does not work after that; use multiprocessing's 'spawn' or 'forkserver', or "
                    "fork before the first connection"
                )
            if not connection.works_after_fork:
                self._process = os.getpid()
            for client_id in range(self.MAX_CLIENTS):
                if client_id not in self.by_id:
                    self.by_id[client_id] = connection
                    return client_id
        raise ConnectionFailed(f"all {self.MAX_CLIENTS} client ids are in use; call simxFinish(-1) first")

    def _refuse_second(self, connection: Connection) -> None:
        for client_id, other in self.by_id.items():
            if other.where == connection.where:
                raise ConnectionFailed(
                    f"client {client_id} is connected to {connection.where} already; "
                    f"call simxFinish({client_id}) or simxFinish(-1) first"
                )

    def id_of(self, connection: Connection) -> int:
        """Return the id of a connection, -1 when it has none."""
        with self._lock:
            return next((each for each, other in self.by_id.items() if other is connection), -1)

    def all(self) -> list[Connection]:
        """Return the connections that have an id, in the order of their ids."""
        with self._lock:
            return [each for _, each in sorted(self.by_id.items())]

    def remove(self, client_id: int) -> None:
        """Close one connection, or all with -1. Ignore unknown ids."""
        with self._lock:
            ids = list(self.by_id) if client_id == -1 else [client_id]
            connections = [self.by_id.pop(i) for i in ids if i in self.by_id]
        # Servers that do not answer share one time-out, whatever their number.
        deadline = time.monotonic() + FLUSH_TIMEOUT
        for connection in connections:
            connection.close(max(FLUSH_TIMEOUT / 10, deadline - time.monotonic()))

    def server_in_process(self, start: Callable[[], EmbeddedServer]) -> EmbeddedServer:
        """Return the one server in this process to which simxStart leads.

        Args:
            start: starts it, if there is none; raises ConnectionFailed.
        """
        with self._lock:
            if self._server is None:
                self._server = start()
            return self._server

    def end(self) -> None:
        """Close all connections and the server in this process, because the process ends."""
        self.remove(-1)
        server, self._server = self._server, None
        if server is not None:
            server.close()

    def discard(self, connection: Connection) -> None:
        """Close a connection and free its id, unless simxFinish did so and the id belongs to another
        connection."""
        with self._lock:
            for client_id, other in list(self.by_id.items()):
                if other is connection:
                    del self.by_id[client_id]
        connection.close()

    def forget_parent(self) -> None:
        """Remove the parent's connections in a forked child.

        They are kept alive: closing one would wait for threads that do not exist in the child.
        """
        self._lock = threading.RLock()
        self._of_parent += [self.by_id, self._server]
        self.by_id, self._server = {}, None


CLIENTS = Clients()
"""The legacy API has one table of clients per process."""

if hasattr(os, "register_at_fork"):  # Windows cannot fork
    os.register_at_fork(after_in_child=CLIENTS.forget_parent)


def invoke(marshal: Marshal, client_id: Any, arguments: tuple[Any, ...], mode: int) -> Any:
    """Execute a generated function."""
    try:
        connection = CLIENTS.by_id.get(client_id)
    except TypeError:
        connection = CLIENTS.get(client_id)
    if connection is None:
        return marshal.failure(c.simx_return_initialize_error_flag)
    return connection.invoke(marshal, arguments, mode)
