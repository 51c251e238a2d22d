"""Select the simulator that a command line names, and connect to it while the command runs."""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
from collections.abc import Generator

from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.discovery import find_servers, silent_servers
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.errors import ConnectionFailed, SimxError
from simx_client.legacy.local import simxFinish, simxStart
from simx_client.protocol import roster
from simx_client.transport.endpoints import CONNECT_VARIABLE, connect_endpoints
from simx_client.transport.zenoh_session import host_and_port

from .command_parser import program
from .discovery_flags import add_waiting

USUAL_PORT = 19997
"""Port of a simulator that runs permanently, for old scripts."""

VALID = "PORT, HOST:PORT, REALM or REALM@HOST:PORT"


class Unclear(SimxError):
    """The arguments do not select a single simulator."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    """Add ``--at``, ``--timeout`` and ``--json``."""
    parser.add_argument(
        "--at", metavar="SIMULATOR", help=f"{VALID}; else the one at port {USUAL_PORT}, or the only one here"
    )
    add_waiting(parser, "an answer", DEFAULT_TIMEOUT)


@contextlib.contextmanager
def connected(simulator: str | None, timeout: float) -> Generator[tuple[int, Connection]]:
    """Connect; yield the client id and the connection. Errors are logged to stderr as sentences.

    Raises:
        Unclear: the arguments do not select a single simulator.
        ConnectionFailed: it could not be reached; the log contains the reason.
    """
    logging.basicConfig(stream=sys.stderr, format="%(message)s")
    host, port = address(simulator, timeout)
    client = simxStart(host, port, True, True, max(1, int(timeout * 1000)), 5)
    connection = CLIENTS.get(client)
    if connection is None:
        raise ConnectionFailed(
            f"start one with simx-server, or name another with --at; {program()} list shows which are there"
        )
    connection.timeout = timeout
    try:
        yield client, connection
    finally:
        simxFinish(client)


def address(simulator: str | None, timeout: float) -> tuple[str, int]:
    """Return address and port as simxStart takes them. Raises Unclear."""
    if simulator is None:
        return _usual()
    realm, at, rest = simulator.rpartition("@")
    if rest.isdecimal() and int(rest) <= 65535:
        return f"{realm}{at}127.0.0.1", int(rest)
    host, colon, port = rest.rpartition(":")
    if colon and port.isdecimal() and int(port) <= 65535:
        return f"{realm}{at}{host or '127.0.0.1'}", int(port)
    if colon or at:
        raise Unclear(f"--at: {simulator!r} does not name a simulator; valid: {VALID}")
    return _called(simulator, timeout)


def _usual() -> tuple[str, int]:
    if connect_endpoints():
        return "", USUAL_PORT
    local = [found for each in roster.endpoints() if (found := host_and_port(each)) is not None]
    ports = [port for _, port in local]
    if USUAL_PORT in ports or not local:
        return "127.0.0.1", USUAL_PORT
    if len(local) == 1:
        return local[0]
    raise Unclear(
        f"there are {len(local)} simulators here, at the ports {', '.join(map(str, sorted(ports)))}; "
        "--at PORT says which one is meant"
    )


def _called(realm: str, timeout: float) -> tuple[str, int]:
    if connect_endpoints():
        return f"{realm}@", USUAL_PORT
    found, unreachable = find_servers(roster.endpoints(), timeout)
    for server in found:
        endpoint = host_and_port(server.endpoint)
        if server.realm == realm and endpoint is not None:
            return endpoint
    there = ", ".join(server.realm for server in found) or "none"
    silent = "".join(f"; {sentence}" for sentence in silent_servers(unreachable))
    raise Unclear(
        f"--at: no simulator of this host is called {realm!r}; there are: {there}{silent}; "
        f"others are found by REALM@HOST:PORT, or through the routers of {CONNECT_VARIABLE}"
    )
