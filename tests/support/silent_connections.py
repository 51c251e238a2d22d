"""Connections that say nothing after their opening."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager


@contextmanager
def silent(port: int, count: int, opening: bytes = b"", patience: float = 20.0) -> Iterator[None]:
    """Hold so many of them at a loopback port within the block."""
    with ExitStack() as stack:
        for _ in range(count):
            made = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=patience))
            made.sendall(opening)
        yield
