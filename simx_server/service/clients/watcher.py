"""The events of the clients, for a recording, the metrics and others that look on. Physics thread only."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .sessions import ClientSession


class Watcher:
    """Base class: every method may be overridden, and does nothing here."""

    def joined(self, session: ClientSession) -> None:
        """React to a client that has joined."""

    def welcomes(self, session: ClientSession) -> bool:
        """Return whether a client that has joined goes on with what it did before, so that it starts no simulation."""
        return False

    def left(self, client: str) -> None:
        """React to a client that has left."""

    def stepping_lost(self, client: str) -> None:
        """React before a client loses its stepped mode."""

    def started(self) -> None:
        """React before the server starts the simulation."""
