"""Addresses of a class: where seats and page listen, and by which address students reach them."""

from __future__ import annotations

import os
import socket
from contextlib import ExitStack
from ipaddress import ip_address

_NOWHERE = ("192.0.2.1", 9)
"""An address that is reserved for documentation. A datagram socket that is connected to it sends nothing, but has the
address of this machine on the way out of it."""


class AddressError(ValueError):
    """An address or port cannot be used; the text has the reason and the next step."""


def resolve(host: str, flag: str) -> str:
    """Return the IP address of a host's name on this machine.

    Raises:
        AddressError: the name is unknown.
    """
    try:
        found = socket.getaddrinfo(host.strip("[]"), None, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise AddressError(
            f"{flag}: {host!r} is not an address of this machine; valid: 127.0.0.1 for this machine alone, "
            "0.0.0.0 for all its networks, or the address of one of them"
        ) from None
    return str(found[0][4][0])


def is_loopback(address: str) -> bool:
    """Return whether only programs of this machine reach an IP address."""
    return ip_address(address).is_loopback


def shown_address(address: str) -> str:
    """Return the address by which others reach what listens at an IP address: for "any", that of the first network."""
    if not ip_address(address).is_unspecified:
        return address
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_NOWHERE)
            found = str(probe.getsockname()[0])
        except OSError:  # this machine has no network
            return "127.0.0.1"
    return found


def in_url(address: str) -> str:
    """Return an address in the form that addresses with a port need."""
    return f"[{address}]" if ":" in address else address


def listen(address: str, port: int, flag: str) -> socket.socket:
    """Return a listening TCP socket.

    Raises:
        AddressError: the port is taken, or the address is not one of this machine.
    """
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    try:
        return socket.create_server((address, port), family=family)
    except OSError as error:
        raise AddressError(
            f"cannot listen at {in_url(address)}:{port}: {os.strerror(error.errno or 0)}; choose another port with "
            f"{flag} (0 finds a free one), or another address with --host"
        ) from None


def claim(address: str, first: int, count: int, flag: str) -> list[int]:
    """Return this many ports in a row that are free now; with 0 any free ones.

    Raises:
        AddressError: one of them is taken, or they are beyond 65535.
    """
    if first and first + count - 1 > 65535:
        raise AddressError(
            f"{flag}: {count} seats need the ports {first} to {first + count - 1}; valid: at most {65536 - count}"
        )
    with ExitStack() as held:  # all at the same time, so that they differ
        listeners = [
            held.enter_context(listen(address, first and first + number, flag)) for number in range(count)
        ]
        return [int(each.getsockname()[1]) for each in listeners]
