"""The bounded server of sockets that all gateways with their own sockets share.

It accepts connections, keeps places for those that matter, closes the ones that say nothing, and recovers when no file
descriptor is free. The gateway reads its connections itself.
"""

from __future__ import annotations

import errno
import logging
import math
import socket
import time
from abc import abstractmethod
from collections.abc import Sequence
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from .gateway import Gateway
from .outsider_log import OutsiderLog

if TYPE_CHECKING:
    from simx_server.service.server_loop import ServerLoop

RETRY = 1.0
"""Seconds between two looks at the connections, and until more are accepted when no file descriptor was free."""

READ, MOST_READ = 1 << 16, 1 << 20
"""Least and most bytes to read at a time: the physics thread does other things in between."""


def part(missing: int) -> int:
    """Return how many bytes to read from a socket, of whose message this many are missing."""
    return min(missing, MOST_READ) if missing > READ else READ


class Peer(Protocol):
    """A connection."""

    since: float
    """When it came, on the monotonic clock."""

    @property
    def is_stranger(self) -> bool:
        """Return whether it has no client yet: it goes first when others need its place."""
        ...


P = TypeVar("P", bound=Peer)


class Listening(Gateway, Generic[P]):
    """A gateway with one or more listening sockets."""

    silence: float = math.inf
    """Seconds that a connection has to start."""

    unsaid: str = ""
    """The thing that a connection which does not start has left out, for the log."""

    crowded: str
    """Why a connection has to make room for another one, for the log."""

    def __init__(
        self, loop: ServerLoop, listeners: Sequence[socket.socket], log: logging.Logger, gateway: str = ""
    ) -> None:
        """Accept connections from now on.

        Args:
            listeners: sockets that listen; they belong to the gateway from now on.
            log: takes what outsiders do wrong, in bounds.
            gateway: name by which it keeps places for its clients, see `Places`; empty for none.
        """
        super().__init__(loop)
        self._listeners, self._gateway = listeners, gateway
        self._log = OutsiderLog(log)
        self._peers: dict[P, None] = {}
        """The open connections in the order in which they came."""

        self._is_accepting = False
        self._next_look = 0.0
        if gateway:
            loop.clients.places.open(gateway)
        for listener in listeners:
            listener.setblocking(False)
        self._go_on_accepting()

    # --- what a gateway fills in -------------------------------------------------------------------

    @abstractmethod
    def _admit(self, connected: socket.socket, listener: socket.socket, address: Any) -> P:
        """Return a new connection, and have it read. Raises OSError: it has left already."""

    @abstractmethod
    def _cut(self, peer: P, why: str) -> None:
        """Close a connection whose peer breaks the rules; call `_forget`."""

    def _refuse(self, listener: socket.socket, address: Any) -> None:
        """Log that a connection gets no place."""

    def _objection(self, connected: socket.socket) -> bool:
        """Return whether a connection is not accepted at all, after a line in the log. Raises OSError."""
        return False

    @abstractmethod
    def _crowd(self, host: str) -> Sequence[P]:
        """Return the connections of which one has to go before one more from a host can come; none if there is room."""

    def _dispensable(self, crowd: Sequence[P]) -> P | None:
        """Return the one of a crowd without strangers that goes; None: the new one is refused."""
        return None

    def _is_silent(self, peer: P) -> bool:
        """Return whether a connection has not started, which it may not for longer than `silence`."""
        return peer.is_stranger

    # --- connections -------------------------------------------------------------------------------

    def _accept(self, listener: socket.socket) -> None:
        try:
            connected, address = listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._stop_accepting()
            return
        try:
            if self._objection(connected):
                connected.close()
            elif not self._has_room(address[0] if address else ""):
                self._refuse(listener, address)
                connected.close()
            else:
                self._peers[self._admit(connected, listener, address)] = None
        except OSError:  # it has left already
            connected.close()

    def _has_room(self, host: str) -> bool:
        """Return whether there is a place for one more connection, which another one may have to free."""
        crowd = self._crowd(host)
        if not crowd:
            return True
        strangers = [peer for peer in crowd if peer.is_stranger]
        gone = min(strangers, key=attrgetter("since")) if strangers else self._dispensable(crowd)
        if gone is not None:
            self._cut(gone, self.crowded)
        return gone is not None

    def look(self) -> None:
        """Have everything checked that time changes, if the last check was long enough ago."""
        if (now := time.monotonic()) >= self._next_look:
            self._next_look = now + RETRY
            self._check(now)

    def _check(self, now: float) -> None:
        """Close connections that do not start, and accept again if descriptors may be free."""
        for peer in list(self._peers):
            if self._is_silent(peer) and peer.since < now - self.silence:
                self._cut(peer, f"{self.unsaid} within {self.silence:g} s")
        self._go_on_accepting()

    def _go_on_accepting(self) -> None:
        if not self._is_accepting:
            self._is_accepting = True
            for listener in self._listeners:
                self._loop.sockets.add(listener, partial(self._accept, listener))

    def _stop_accepting(self) -> None:
        if self._is_accepting:
            self._is_accepting = False
            for listener in self._listeners:
                self._loop.sockets.remove(listener)

    def close(self) -> None:
        """Close the connections that are left, and listen no more."""
        if not self._is_open:
            return
        super().close()
        self._stop_accepting()
        for peer in list(self._peers):
            self._end(peer)
        for listener in self._listeners:
            listener.close()
        if self._gateway:
            self._loop.clients.places.close(self._gateway)

    @abstractmethod
    def _end(self, peer: P) -> None:
        """Close a connection as the gateway closes."""
