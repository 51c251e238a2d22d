"""Which connections of the socket are open, from the descriptors that its monitor and its messages name.

ZeroMQ reports that a descriptor was accepted or closed, and tells by which descriptor a message came. Descriptors are
used again by later connections: each acceptance starts a new epoch of its descriptor. A connection belongs to the
newest epoch at the time of its first message. So a connection that is open is never taken for one that was closed.
"""

from __future__ import annotations

from collections import defaultdict


class Peers:
    """Connections by their routing identity."""

    def __init__(self) -> None:
        self._epochs: defaultdict[int, int] = defaultdict(int)
        """How often a descriptor was accepted."""

        self._by_descriptor: defaultdict[int, dict[bytes, int]] = defaultdict(dict)
        """Identities that came by a descriptor, with their epochs."""

        self._closed: list[tuple[int, int]] = []
        """Descriptors that were closed, with the epoch that ended."""

        self.open: set[int] = set()
        """Descriptors of open connections, also of those that have sent nothing."""

    def accepted(self, descriptor: int) -> None:
        """Record a new connection."""
        self._epochs[descriptor] += 1
        self.open.add(descriptor)

    def disconnected(self, descriptor: int) -> None:
        """Record the end of a connection; `gone` returns its identity once all of its messages are read."""
        self.open.discard(descriptor)
        self._closed.append((descriptor, self._epochs[descriptor]))

    def seen(self, descriptor: int, identity: bytes) -> None:
        """Record the first message of a connection, after everything that the monitor has reported so far."""
        self._by_descriptor[descriptor][identity] = self._epochs[descriptor]

    def gone(self) -> list[bytes]:
        """Return the identities of connections that have ended, each once."""
        closed, self._closed = self._closed, []
        found: list[bytes] = []
        for descriptor, epoch in closed:
            known = self._by_descriptor.get(descriptor, {})
            for identity in [each for each, its in known.items() if its <= epoch]:
                found.append(identity)
                del known[identity]
            if not known:
                self._by_descriptor.pop(descriptor, None)
        return found
