"""Find the endpoint of a connection: a port of a host, or a simulator by its name through Zenoh routers.

``simxStart("lab@router", 7447, ...)`` looks for the realm ``lab`` at the Zenoh router on ``router:7447``. For scripts
that cannot be edited ``SIMX_CONNECT`` names the routers and ``SIMX_REALM`` the simulator; then the address and port in
the script have no effect.
"""

from __future__ import annotations

import os
import re

from simx_client.protocol.zenoh.keys import check_chunk

from ..protocol.python.light_dataclass import dataclass
from .redirect import redirected

CONNECT_VARIABLE = "SIMX_CONNECT"
REALM_VARIABLE = "SIMX_REALM"


@dataclass(frozen=True)
class ServerAddress:
    """Endpoints and realm by which a transport finds its server."""

    endpoints: tuple[str, ...]
    """Zenoh endpoints; the first that can be reached is used."""

    realm: str | None
    """The simulator's name; None where the endpoint has only one simulator."""

    host_and_port: tuple[str, int] | None
    """None if the endpoints came from the variable."""

    def __str__(self) -> str:
        through = "{}:{}".format(*self.host_and_port) if self.host_and_port else ", ".join(self.endpoints)
        return through if self.realm is None else f"realm {self.realm} at {through}"

    @classmethod
    def at(cls, host: str, port: int, realm: str | None = None) -> ServerAddress:
        return cls(tuple(_endpoints(host, port)), realm, (host, port))


def find_address(address: str, port: int) -> ServerAddress:
    """Return the server's address for the arguments of simxStart.

    A redirected port has precedence, then a realm and host in the address, then the two variables. ``lab@``
    alone is the realm ``lab`` at the routers of the variable.

    Raises:
        ValueError: the address or a variable cannot be read; the text says what is valid.
    """
    host, target = redirected(address, port)
    is_redirected = (host, target) != (address, port)
    name, at, host = host.rpartition("@")
    realm = check_chunk(name) if at else None
    if is_redirected:
        return ServerAddress.at(host, target, realm)
    if realm is None and (wanted := os.environ.get(REALM_VARIABLE, "").strip()):
        try:
            realm = check_chunk(wanted)
        except ValueError as error:
            raise ValueError(f"{REALM_VARIABLE}: {error}") from None
    if at and host:
        return ServerAddress.at(host, target, realm)
    routers = connect_endpoints()
    return (
        ServerAddress(routers, realm, None)
        if routers
        else ServerAddress.at(host or "127.0.0.1", target, realm)
    )


def connect_endpoints() -> tuple[str, ...]:
    """Return the Zenoh endpoints that ``SIMX_CONNECT`` names; empty if it is not set.

    Raises:
        ValueError: one of them is not an endpoint.
    """
    words = re.split(r"[,\s]+", os.environ.get(CONNECT_VARIABLE, "").strip(" ,"))
    return tuple(check_endpoint(word, CONNECT_VARIABLE) for word in words if word)


def check_endpoint(text: str, origin: str) -> str:
    """Return the text; raise ValueError unless it looks like a Zenoh endpoint."""
    if not re.fullmatch(r"[a-z][a-z0-9-]*/\S+", text):
        raise ValueError(f"{origin}: {text!r} is not PROTOCOL/ADDRESS, as in tcp/router:7447")
    return text


def _endpoints(address: str, port: int) -> list[str]:
    """Return the endpoints for a host and port. Any loopback address is this host, where a server listens on
    127.0.0.1."""
    host = f"[{address}]" if ":" in address and not address.startswith("[") else address
    endpoints = [f"tcp/{host}:{port}"]
    if address.startswith("127.") and address != "127.0.0.1":
        endpoints.append(f"tcp/127.0.0.1:{port}")
    return endpoints
