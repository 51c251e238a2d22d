"""Look at the TCP connections that Zenoh has opened in this process, and change how they close; Linux only."""

from __future__ import annotations

import contextlib
import os
import re
import socket
import struct
import sys
from collections.abc import Collection, Generator
from typing import Any, NamedTuple

_ENDPOINT = re.compile(r"\w+/\[?([^]%]+)(?:%\w+)?\]?:(\d+)(?:[?#].*)?")
"""As Zenoh writes it: ``tcp/127.0.0.1:19997``, ``tls/[fe80::1%2]:7447``."""

_RECEIVED = struct.Struct("=128xQ")
"""``tcpi_bytes_received`` in Linux's ``struct tcp_info``."""

_NO_WAIT = struct.pack("ii", 0, 0)
"""A ``struct linger`` of Linux that is switched off."""


class Connection(NamedTuple):
    """A TCP connection of this process."""

    port: int
    peer: str
    """Address of the other end."""

    peer_port: int

    def __str__(self) -> str:
        return f"{self.peer}, port {self.peer_port}"

    @classmethod
    def of(cls, link: Any) -> Connection | None:
        """Return the connection of one of Zenoh's links; None if it is something else."""
        ends = _ENDPOINT.fullmatch(link.src), _ENDPOINT.fullmatch(link.dst)
        if ends[0] is None or ends[1] is None:
            return None
        return cls(int(ends[0][2]), _plain(ends[1][1]), int(ends[1][2]))


def find(connections: Collection[Connection]) -> dict[Connection, int | None]:
    """Return the descriptors of connections that others have opened to this process; None for all other ones."""
    descriptors, listening = _descriptors()
    return {each: descriptors.get(each) if each.port in listening else None for each in connections}


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


def close_at_once(connections: Collection[Connection]) -> None:
    """Have the system not wait when these connections are closed; what was sent still arrives.

    Zenoh has Linux wait until the other end has taken everything, up to ten seconds, in a thread that serves other
    links too (SO_LINGER). The next task of this thread waits with it, which may be the one that reads any other link.
    """
    descriptors = _descriptors()[0] if sys.platform == "linux" and connections else {}
    for each in descriptors.keys() & connections:
        with contextlib.suppress(OSError), _copy(descriptors[each]) as found:
            if _ends(found) == each:
                found.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_WAIT)


def _descriptors() -> tuple[dict[Connection, int], set[int]]:
    """Return the descriptors of all TCP connections of this process, and the ports at which it listens."""
    connections: dict[Connection, int] = {}
    listening: set[int] = set()
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError), _copy(int(name)) as found:
            if found.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
                listening.add(found.getsockname()[1])
            else:
                connections[_ends(found)] = int(name)
    return connections, listening


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
    if ":" not in address:
        return address
    import ipaddress  # it takes a millisecond, and every client imports this module

    plain = ipaddress.IPv6Address(address.partition("%")[0])
    return str(plain.ipv4_mapped or plain)
