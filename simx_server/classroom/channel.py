"""Messages between the page's process and the seats, and between it and the supervisor.

They travel through pairs of UNIX sockets that keep the bounds of messages and that only forks of one process have, so
no student can reach them. Each message is one line of JSON; an image may follow.
"""

from __future__ import annotations

import json
import socket
from typing import Any, NamedTuple, cast

MOST_BYTES = 200_000
"""Maximum size of a message; Linux takes messages of 212,992 bytes, of which it needs a part itself."""


class Message(NamedTuple):
    """A received message."""

    fields: dict[str, Any]
    picture: bytes = b""


def pair() -> tuple[socket.socket, socket.socket]:
    """Return two connected sockets whose calls never wait."""
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    here.setblocking(False)
    there.setblocking(False)
    return here, there


def packed(fields: dict[str, Any], picture: bytes = b"") -> bytes:
    """Return a message as bytes."""
    return json.dumps(fields).encode() + b"\n" + picture


def unpacked(data: bytes) -> Message:
    """Return the message in these bytes.

    Raises:
        ValueError: they have another form.
    """
    head, _, picture = data.partition(b"\n")
    try:
        fields = json.loads(head)
    except RecursionError:
        raise ValueError("a message whose values lie too deep in each other") from None
    if not isinstance(fields, dict):
        raise ValueError("a message is an object of JSON")
    return Message(cast(dict[str, Any], fields), picture)
