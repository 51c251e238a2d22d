"""Expect the clients of a crashed server, whose successor this server is: they reconnect automatically.

Each reads once, in `simxGetLastErrors`, what happened. One that stepped the simulation does so again from its return
on; until then, and for a while at most, the simulation waits for it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.service.watcher import Watcher

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession

WAIT = 4.0
"""Seconds that the simulation waits for clients that stepped it: the time after which a silent peer counts as lost."""


class Returning(Watcher):
    """Those that have not come back yet. Physics thread only."""

    def __init__(self) -> None:
        """Expect no client."""
        self._clients: dict[str, tuple[str, bool]] = {}
        self._back: set[str] = set()
        self.text = ""
        self._until = -math.inf

    def expect(self, clients: Mapping[str, tuple[str, bool]], text: str) -> None:
        """Expect the clients of a server that has crashed just now, instead of others.

        Args:
            clients: id to name, and whether the client stepped the simulation.
            text: what happened, for them.
        """
        self._clients, self._back, self.text = dict(clients), set(), text
        self._until = time.monotonic() + WAIT

    @property
    def is_awaiting(self) -> bool:
        """Return whether the simulation may have to wait for clients."""
        return bool(self._clients)

    def welcomes(self, session: ClientSession) -> bool:
        """Tell a client that joins what happened, if it is one of those; let it step again if it did.

        A client may connect twice, when it finds the new server before it has noticed the end of the old one.

        Returns whether it is one of those.
        """
        former = self._former(session)
        if former not in self._clients or (former in self._back and not self.is_early):
            return False
        self._back.add(former)
        session.errors.append(self.text)
        if self._clients[former][1]:
            session.set_stepping(True)
        return True

    def seconds_left(self) -> float:
        """Return how long the simulation still waits for clients that stepped it."""
        if all(client in self._back for client, (_, is_stepping) in self._clients.items() if is_stepping):
            return 0.0
        return max(0.0, self._until - time.monotonic())

    def awaited(self) -> dict[str, tuple[str, bool]]:
        """Return the clients that may still come back, as given: a further server may have to expect them."""
        if not self.is_early:
            return {}
        return {client: each for client, each in self._clients.items() if client not in self._back}

    @property
    def is_early(self) -> bool:
        """Return whether peers that come now may be those of the crashed server."""
        return time.monotonic() < self._until

    def _former(self, session: ClientSession) -> str:
        """Return the id that a client had. One of the original library has another id, and port, at each connection."""
        if session.client in self._clients or not session.name.startswith("legacy "):
            return session.client
        host = session.name.rpartition(":")[0]
        same = (
            client
            for client, (name, _) in self._clients.items()
            if client not in self._back and name.rpartition(":")[0] == host
        )
        return next(same, session.client)
