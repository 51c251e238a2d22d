"""Commands and replies that travel in pieces, one piece of each per message."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

from .messages import COMMAND, Key, Request, piece

LEAST_PIECE = 50
"""Bytes of a reply's piece, where the client asks for fewer."""


PIECE_COST = 200
"""Bytes that a piece counts in addition to its own."""


@dataclass
class _Partial:
    """The pieces of one command that have come."""

    full_size: int
    parts: list[bytes]
    size: int = 0


class Incoming:
    """Pieces of commands, until each is complete."""

    def __init__(self, largest: int) -> None:
        """Start without pieces.

        Args:
            largest: most bytes of all pieces that are kept together; older commands are dropped first.
        """
        self._largest = largest
        self._partial: OrderedDict[Key, _Partial] = OrderedDict()
        """Oldest first; to find the first one of a dict takes long after many of its first ones have gone."""

        self.size = 0
        """The bytes of all pieces, with `PIECE_COST` for each."""

    def add(self, request: Request) -> Request | None:
        """Add a piece; return the complete command with its last piece.

        A piece that is not the next one, or of a command of another size, starts the command again, or is dropped.
        """
        partial = self._partial.get(request.key)
        if partial is None or partial.full_size != request.full_size or partial.size != request.offset:
            self._drop(request.key)
            if request.offset:
                return None
            partial = self._partial[request.key] = _Partial(request.full_size, [])
        partial.parts.append(request.payload)
        partial.size += len(request.payload)
        self.size += len(request.payload) + PIECE_COST
        if COMMAND.size + len(request.ident) + partial.size >= request.full_size:
            self._drop(request.key)
            return request._replace(payload=b"".join(partial.parts), offset=0)
        while self.size > self._largest and self._partial:
            self._drop(next(iter(self._partial)))
        return None

    def _drop(self, key: Key) -> None:
        partial = self._partial.pop(key, None)
        if partial is not None:
            self.size -= partial.size + PIECE_COST * len(partial.parts)


@dataclass
class _Reply:
    request: Request
    payload: bytes
    time_ms: int
    sent: int = 0


class Outgoing:
    """Replies that leave in pieces."""

    def __init__(self) -> None:
        self._replies: dict[Key, _Reply] = {}

    def put(self, request: Request, payload: bytes, time_ms: int) -> None:
        """Start a reply, unless an earlier one to an equal command is still under way. Empty ones never leave."""
        if payload and request.key not in self._replies:
            self._replies[request.key] = _Reply(request, payload, time_ms)

    def drop(self, key: Key) -> None:
        """Forget the reply to a command."""
        self._replies.pop(key, None)

    def take(self) -> list[bytes]:
        """Return the next piece of each reply."""
        pieces: list[bytes] = []
        for key, reply in list(self._replies.items()):
            size = max(LEAST_PIECE, reply.request.low)
            pieces.append(piece(reply.request, reply.payload, reply.sent, size, reply.time_ms))
            reply.sent += size
            if reply.sent >= len(reply.payload):
                del self._replies[key]
        return pieces
