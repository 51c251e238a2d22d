"""One connection: its socket, as the gateway and its client share it."""

from __future__ import annotations

import contextlib
import math
import socket
import time
from collections import deque

from simx_server.service.clients.admission.unfinished import Unfinished

from ..listening import READ, part
from .wire.zmtp import GREETING, PING, BadPeer, Incoming, framed, framed_alone

NUMBER_BYTES = 8
"""Length of a connection's number in front of a message that waits in the client's queue."""


def with_number(number: int, payload: bytes) -> bytes:
    """Return a message with the number of its connection in front, as it waits in the client's queue."""
    return number.to_bytes(NUMBER_BYTES, "big") + payload


def number_of(numbered: bytes) -> int:
    """Return the number of the connection that a message of `with_number` came by."""
    return int.from_bytes(numbered[:NUMBER_BYTES], "big")


class Peer:
    """A connection as its client's calls see it. Physics thread."""

    address = ""
    """Of the other machine, where it is known."""

    def __init__(self, number: int) -> None:
        """Make a connection.

        Args:
            number: never used again.
        """
        self.number = number
        self.is_gone = False
        self.nested: deque[bytes | None] | None = None
        """Takes its messages while it runs a function for the server; None is put in when it is gone."""

    def count_answered(self) -> None:
        """Count one of its messages as answered, or as one that has no answer."""

    def nest(self, queue: deque[bytes | None] | None) -> deque[bytes | None] | None:
        """Give it the queue for the messages from within a function; return the one before."""
        outer, self.nested = self.nested, queue
        return outer


class SocketPeer(Peer):
    """An open connection. Physics thread."""

    def __init__(self, connected: socket.socket, number: int, longest: int, unfinished: Unfinished) -> None:
        """Greet the peer.

        Args:
            connected: a socket that does not block; it belongs to the connection from now on.
            number: never used again.
            longest: bytes that a message may have.
            unfinished: counts what it has sent of a message that is not complete.
        """
        super().__init__(number)
        self.socket = connected
        self.address: str = connected.getpeername()[0]
        self.since = time.monotonic()
        self.key = ""
        """Its client, as the server loop names it; empty before the first valid message."""

        self.was_told = False
        """It was told that the server before this one has crashed."""

        self.unanswered = 0
        """Messages that were not answered yet."""

        self.answered = -math.inf
        """When it last got an answer, by the performance counter."""

        self.is_quick = False
        """Its last message came soon after the answer before."""

        self.silent_looks = 0
        """How often the gateway has looked without anything new of it."""

        self.problem = ""
        """Why it is closed, as soon as it is noticed; see `break_off`."""

        self._incoming = Incoming(longest)
        self._unfinished = unfinished.holder(self.break_off)
        self.unsent = bytearray(GREETING)
        """Bytes that the system has not taken yet."""

        self.flush()

    def count_answered(self) -> None:
        self.unanswered = max(0, self.unanswered - 1)

    @property
    def is_stranger(self) -> bool:
        """Return whether it has no client yet."""
        return not self.key

    @property
    def sends_alone(self) -> bool:
        """Return whether its messages are single frames, as those of API 2 are."""
        return self._incoming.is_alone

    @property
    def is_ready(self) -> bool:
        """Return whether the peer has said everything that comes before its messages."""
        return self._incoming.is_ready

    @property
    def answers_pings(self) -> bool:
        """Return whether silence means that its process is frozen, or cannot be reached."""
        return self._incoming.answers_pings

    def ping(self) -> None:
        """Ask for a sign of life. Raises OSError: the peer has left."""
        self.unsent += PING
        self.flush()

    def receive(self) -> list[bytes]:
        """Return the messages that have arrived.

        Raises:
            BadPeer: it breaks the rules.
            OSError: it has left.
        """
        incoming = self._incoming
        try:
            data = self.socket.recv(part(incoming.missing) if incoming.missing else READ)
        except BlockingIOError:
            return []
        if not data:
            raise ConnectionResetError
        self.silent_looks = 0
        messages = incoming.take(data)
        if (held := incoming.held) or self._unfinished.size:
            self._unfinished.hold(held, is_new=bool(messages))
        if self.problem:
            raise BadPeer(self.problem)
        if incoming.due:
            self.unsent += incoming.due
            incoming.due = b""
            self.flush()
        return messages

    def send(self, payload: bytes) -> None:
        """Send a message; what the system does not take now stays in `unsent`."""
        data = framed_alone(payload) if self._incoming.is_alone else framed(payload)
        if self.unsent:
            self.unsent += data
            return
        try:
            sent = self.socket.send(data)
        except BlockingIOError:
            sent = 0
        except OSError:  # it has just gone; reading tells
            return
        if sent < len(data):
            with memoryview(data) as view:
                self.unsent += view[sent:]

    def flush(self) -> None:
        """Send what is left. Raises OSError: the peer has left."""
        with contextlib.suppress(BlockingIOError):
            del self.unsent[: self.socket.send(self.unsent)]

    def break_off(self, problem: str) -> None:
        """Have the physics thread close the connection, for a reason. Any thread."""
        self.problem = problem
        with contextlib.suppress(OSError):  # it is closed already
            self.socket.shutdown(socket.SHUT_RDWR)

    def end(self) -> None:
        """Close the socket, and keep nothing."""
        self._unfinished.end()
        self.socket.close()

    def finish(self, until: float) -> None:
        """Send what is left, and wait for it until a time on the monotonic clock."""
        with contextlib.suppress(OSError):
            self.socket.settimeout(max(0.001, until - time.monotonic()))
            self.socket.sendall(self.unsent)
