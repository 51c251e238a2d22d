"""Open a connection for an address; raise an exception with the reason when that fails."""

from __future__ import annotations

import re
from collections.abc import Sequence

from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.embedded import EmbeddedConnection
from simx_client.connection.embedding import start_server
from simx_client.errors import ConnectionFailed
from simx_client.transport.direct import EmbeddedServer
from simx_client.transport.endpoints import find_address
from simx_client.transport.lanes import open_link
from simx_client.transport.zenoh_session import client_name, program_name

DEFAULT_PORT = 19997
"""Port of V-REP's continuous service and of a server of this project."""


def split_port(address: str, port: int | None) -> tuple[str, int]:
    """Return host (or realm and host) and port; the address may contain the port: ``lab-3@router:7447``,
    ``[::1]:19997``.

    Raises:
        ValueError: the port is given twice, or is not valid.
    """
    written = re.fullmatch(r"(.*[^:]):(\d+)", address) if address.count(":") == 1 or "]:" in address else None
    if written is not None:
        if port is not None and port != int(written[2]):
            raise ValueError(f"{address!r} names a port, and so does port={port}; leave one out")
        address, port = written[1], int(written[2])
    port = DEFAULT_PORT if port is None else port
    if not 0 < port < 65536:
        raise ValueError(f"the port must be 1..65535, not {port}")
    return address, port


def open_connection(address: str, port: int, timeout: float) -> Connection:
    """Connect to a server. The connection does not wait for a server that exits.

    Args:
        timeout: time-out in seconds.

    Raises:
        ConnectionFailed: with what was tried, what was found and what to do.
        ValueError: the address or a variable of the environment cannot be read.
    """
    server = find_address(address, port)
    connection = Connection(
        lambda: open_link(server, connect_timeout=timeout, retry=False, asked_port=port),
        where=f"{address}:{port}",
        timeout=timeout,
        may_reconnect=False,
    )
    _make(connection, timeout, f"tried {server} over Zenoh")
    return connection


def open_embedded(arguments: Sequence[str], timeout: float) -> tuple[EmbeddedConnection, EmbeddedServer]:
    """Start a server in this process and connect to it.

    Args:
        arguments: those of ``simx-server``.
        timeout: time-out of calls in seconds.

    Raises:
        ConnectionFailed: with the reason and what to do.
    """
    server = start_server(arguments)
    connection = EmbeddedConnection(
        lambda: server.connect(client_name(), program_name(), DEFAULT_PORT),
        where=f"{arguments[0] if arguments else 'the default scene'} in this process",
        timeout=timeout,
    )
    try:
        _make(connection, timeout, "the simulation is in this process")
    except BaseException:
        server.close()
        raise
    return connection, server


def _make(connection: Connection, timeout: float, attempt: str) -> None:
    """Connect and give the connection an id; `attempt` is the part of the error text that says what was tried."""
    CLIENTS.admit(connection)
    try:
        connection.connect(timeout)
    except ConnectionFailed as error:
        CLIENTS.discard(connection)
        raise ConnectionFailed(f"no connection: {attempt}; {error}") from None
    except BaseException:
        CLIENTS.discard(connection)
        raise
