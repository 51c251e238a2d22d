"""Find out why no connection could be made: what listens at an endpoint, and what to do."""

from __future__ import annotations

import socket

from simx_client.errors import ConnectionFailed, NoAnswer
from simx_client.protocol import roster

from .endpoints import ServerAddress
from .zenoh_session import Unanswered, host_and_port, why_closed


def diagnose(server: ServerAddress, deadline: float) -> ConnectionFailed:
    """Examine an endpoint at which no connection could be made.

    Returns:
        The error to raise: what listens there and what to do. `NoAnswer` if a server may only be slow.
    """
    if server.host_and_port is None:
        refusals = [
            f"; {each} {refusal}" for each in server.endpoints if (refusal := _refusal_at(each, deadline))
        ]
        return ConnectionFailed(
            f"nothing that lets this client in was found at {', '.join(server.endpoints)}{''.join(refusals)}; "
            "check SIMX_CONNECT, and that the router or server runs"
        )
    address, port = server.host_and_port
    what_to_do = (
        f"start a server there (simx-server --port {port}), or pass the address and port of one that runs"
    )
    try:
        if refusal := why_closed(address, port, deadline=deadline):
            return ConnectionFailed(f"{address}:{port} {refusal}")
        return ConnectionFailed(
            f"something listens at {address}:{port} but does not speak Zenoh, so it is not a simx-server "
            f"(a CoppeliaSim, perhaps); {what_to_do}"
        )
    except ConnectionRefusedError:
        return ConnectionFailed(f"nothing listens at {address}:{port}; {what_to_do}")
    except socket.gaierror:
        return ConnectionFailed(
            f"the host name {address!r} is not known; check its spelling, or pass an IP address"
        )
    except (Unanswered, TimeoutError) as error:
        return NoAnswer(_silence(server, accepts=isinstance(error, Unanswered), what_to_do=what_to_do))
    except (OSError, OverflowError) as error:
        return ConnectionFailed(f"{address}:{port} cannot be reached ({error}); {what_to_do}")


def busy_server(server: ServerAddress) -> str | None:
    """Describe the simx-server of this host at an endpoint that does not answer; None if no server is noted
    there."""
    if not any(roster.is_noted(each) for each in server.endpoints):
        return None
    return (
        f"the simx-server at {server} is there but did not answer in time; it is busy or frozen: try again, "
        "with a longer time-out"
    )


def _silence(server: ServerAddress, *, accepts: bool, what_to_do: str) -> str:
    """Describe a silent endpoint: on this host a server has left a note, elsewhere it may be any program."""
    if busy := busy_server(server):
        return busy
    if accepts:
        return (
            f"something listens at {server} but did not answer in time: a simx-server that is busy, or a program "
            f"that is not a simx-server (a CoppeliaSim, perhaps); try again with a longer time-out, or {what_to_do}"
        )
    return f"{server} did not answer in time; check the address and the firewall, or {what_to_do}"


def _refusal_at(endpoint: str, deadline: float) -> str | None:
    """Return why a listening endpoint may have refused; None if nothing listens."""
    found = host_and_port(endpoint)
    try:
        return why_closed(*found, endpoint.startswith("tls/"), deadline) if found else None
    except (OSError, OverflowError):
        return None
