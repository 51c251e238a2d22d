"""Look at the TCP connections of this process that a library has opened; Linux only."""

from __future__ import annotations

import contextlib
import ipaddress
import os
import re
import socket
import struct
import sys
from collections.abc import Collection, Generator
from typing import NamedTuple

_ENDPOINT = re.compile(r"\w+/\[?([^]%]+)(?:%\w+)?\]?:(\d+)(?:[?#].*)?")
"""As Zenoh writes it: ``tcp/127.0.0.1:19997``, ``tls/[fe80::1%2]:7447``."""

_RECEIVED = struct.Struct("=128xQ")
"""``tcpi_bytes_received`` in Linux's ``struct tcp_info``."""


class Connection(NamedTuple):
    """A TCP connection of this process."""

    port: int
    peer: str
    """Address of the other end."""

    peer_port: int

    def __str__(self) -> str:
        return f"{self.peer}, port {self.peer_port}"

    @classmethod
    def of(cls, here: str, there: str) -> Connection | None:
        """Return the connection between two endpoints of Zenoh; None if they are something else."""
        ends = _ENDPOINT.fullmatch(here), _ENDPOINT.fullmatch(there)
        if ends[0] is None or ends[1] is None:
            return None
        return cls(int(ends[0][2]), _plain(ends[1][1]), int(ends[1][2]))


def find(connections: Collection[Connection]) -> dict[Connection, int | None]:
    """Return the descriptors of connections that others have opened to this process; None for all other ones."""
    open_ones: dict[Connection, int] = {}
    listening: set[int] = set()
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError), _copy(int(name)) as found:
            if found.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
                listening.add(found.getsockname()[1])
            else:
                open_ones[_ends(found)] = int(name)
    return {each: open_ones.get(each) if each.port in listening else None for each in connections}


def received(descriptor: int, connection: Connection) -> int | None:
    """Return how many bytes this process has read from a connection; None if it is closed."""
    if sys.platform != "linux":
        return None
    import fcntl  # Windows has neither of them
    import termios

    with contextlib.suppress(OSError), _copy(descriptor) as found:
        if _ends(found) == connection:
            info = found.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _RECEIVED.size)
            unread = fcntl.ioctl(found, termios.FIONREAD, bytes(4))
            return int(_RECEIVED.unpack(info)[0]) - int.from_bytes(unread, sys.byteorder)
    return None


def close(connection: Connection) -> None:
    """End a connection that others have opened; the library that has it closes the descriptor."""
    if (descriptor := find([connection])[connection]) is not None:
        with contextlib.suppress(OSError), _copy(descriptor) as found:
            if _ends(found) == connection:
                found.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def _copy(descriptor: int) -> Generator[socket.socket]:
    """Give a TCP socket within the block, whose descriptor stays open. Raises OSError: it is none."""
    copy = os.dup(descriptor)
    try:
        found = socket.socket(fileno=copy)
    except OSError:
        os.close(copy)
        raise
    with found:
        if found.family not in (socket.AF_INET, socket.AF_INET6) or found.type != socket.SOCK_STREAM:
            raise OSError("not TCP")
        yield found


def _ends(found: socket.socket) -> Connection:
    peer, peer_port = found.getpeername()[:2]
    return Connection(found.getsockname()[1], _plain(peer), peer_port)


def _plain(address: str) -> str:
    """Return an address in one form, whatever family its socket has."""
    plain = ipaddress.ip_address(address.partition("%")[0])
    mapped = plain.ipv4_mapped if isinstance(plain, ipaddress.IPv6Address) else None
    return str(mapped or plain)
