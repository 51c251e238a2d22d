"""Why no connection could be made: what is at a place, and what to do about it."""

from __future__ import annotations

import socket

from .places import Place
from .session import host_and_port, why_closed


def diagnose(place: Place, deadline: float) -> str:
    """Look at a place where no connection could be made, and say what is there and what to do."""
    if place.host_and_port is None:
        refusals = [
            f"; {each} {refusal}" for each in place.endpoints if (refusal := _refusal_at(each, deadline))
        ]
        return (
            f"nothing that lets this client in was found at {', '.join(place.endpoints)}{''.join(refusals)}; "
            "check SIMX_CONNECT, and that the router or server runs"
        )
    address, port = place.host_and_port
    what_to_do = (
        f"start a server there (simx-server --port {port}), or pass the address and port of one that runs"
    )
    try:
        if refusal := why_closed(address, port, deadline=deadline):
            return f"{address}:{port} {refusal}"
        return (
            f"something listens at {address}:{port} but does not speak Zenoh, so it is not a simx-server "
            f"(a CoppeliaSim, perhaps); {what_to_do}"
        )
    except ConnectionRefusedError:
        return f"nothing listens at {address}:{port}; {what_to_do}"
    except socket.gaierror:
        return f"the host name {address!r} is not known; check its spelling, or pass an IP address"
    except TimeoutError:
        return f"{address}:{port} does not answer; check the address and the firewall, or {what_to_do}"
    except (OSError, OverflowError) as error:
        return f"{address}:{port} cannot be reached ({error}); {what_to_do}"


def _refusal_at(endpoint: str, deadline: float) -> str | None:
    """Why an endpoint where something listens may have refused; None when nothing does."""
    found = host_and_port(endpoint)
    try:
        return why_closed(*found, endpoint.startswith("tls/"), deadline) if found else None
    except (OSError, OverflowError):
        return None
