"""From an address to a connection, with the reason as an exception when there is none."""

from __future__ import annotations

import re

from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.endpoints import find_place
from simx_client.errors import ConnectionFailed
from simx_client.transport.zenoh import ZenohTransport

DEFAULT_PORT = 19997
"""Where V-REP's continuous service listened, and a server of this project does."""


def split_port(address: str, port: int | None) -> tuple[str, int]:
    """Host, or realm and host, and port; the port may stand in the address: ``lab-3@router:7447``, ``[::1]:19997``.

    Raises:
        ValueError: the port stands in both places, or is no port.
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
    """Connect; a server that goes away is not waited for.

    Raises:
        ConnectionFailed: with what was tried, what was found and what to do.
        ValueError: the address or a variable of the environment cannot be read.
    """
    place = find_place(address, port)
    connection = Connection(
        lambda: ZenohTransport(place, connect_timeout=timeout, retry=False, asked_port=port),
        where=f"{address}:{port}",
        timeout=timeout,
        may_reconnect=False,
    )
    CLIENTS.admit(connection)
    try:
        connection.connect(timeout)
    except ConnectionFailed as error:
        CLIENTS.discard(connection)
        raise ConnectionFailed(f"no connection: tried {place} over Zenoh; {error}") from None
    except BaseException:
        CLIENTS.discard(connection)
        raise
    return connection
