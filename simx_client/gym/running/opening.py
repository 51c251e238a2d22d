"""Simulations for environments: embedded ones, or servers that run already."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack

from simx_client.client.opening import open_connection, open_embedded, split_port
from simx_client.client.servers import Servers
from simx_client.client.worlds import Worlds
from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedding import as_arguments


def open_alone(
    scene: str | os.PathLike[str] | None, timeout: float, settings: Mapping[str, object], stack: ExitStack
) -> tuple[Servers, str]:
    """Start one simulation in this process.

    Args:
        scene, timeout, settings: as for ``Client.embedded``.
        stack: its end ends the simulation.

    Returns:
        The simulation, and the address of its web viewer (empty without one).
    """
    connection, server = open_embedded(as_arguments(scene, dict(settings)), timeout)
    stack.callback(server.close)
    stack.callback(CLIENTS.discard, connection)
    return Servers((CLIENTS.id_of(connection),), timeout=timeout), server.view_address


def open_addresses(addresses: Sequence[str], timeout: float, stack: ExitStack) -> Servers:
    """Connect to servers.

    Args:
        addresses: ``HOST:PORT``, or ``REALM@ROUTER:PORT`` for a server by its name behind a router.
        stack: its end closes the connections.

    Raises:
        ConnectionFailed: one of them cannot be reached.
        ValueError: an address cannot be read.
    """
    clients: list[int] = []
    for address in addresses:
        connection = open_connection(*split_port(address, None), timeout)
        stack.callback(CLIENTS.discard, connection)
        clients.append(CLIENTS.id_of(connection))
    return Servers(clients, timeout=timeout)


def open_many(
    scene: str | os.PathLike[str] | None,
    count: int,
    processes: int | None,
    timeout: float,
    settings: Mapping[str, object],
    stack: ExitStack,
) -> Servers:
    """Start several simulations, in worker processes or in this process; see `Worlds` for the arguments."""
    worlds = Worlds(scene, count, processes=processes, timeout=timeout, **dict(settings))
    stack.callback(worlds.close)
    return worlds


def check_place(address: object, settings: Mapping[str, object]) -> None:
    """Raise ValueError for settings of a simulation that is not started here."""
    if address is not None and settings:
        raise ValueError(
            f"the server at {address} has its own settings; leave out {', '.join(settings)}, "
            "or leave out the address to start a simulation here"
        )
