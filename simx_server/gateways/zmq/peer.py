"""One connection, as the socket and its client share it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

NUMBER_BYTES = 8
"""Length of a connection's number in front of a message that waits in the client's queue."""


@dataclass(slots=True, eq=False)
class Peer:
    """An open connection."""

    identity: bytes
    """The routing identity that the socket gives it."""

    number: int
    """Never used again."""

    descriptor: int | None = None
    """By which its messages come; None until the first is read."""

    key: str = ""
    """Its client, as the server loop names it; empty before the first valid message."""

    unanswered: int = 0
    """Messages that were not answered yet."""

    is_cut: bool = False
    """It broke the rules: nothing more of it is read."""

    is_gone: bool = False

    nested: deque[bytes | None] | None = None
    """Takes its messages while it runs a function for the server; None is put in when it is gone."""
