"""Loopback ports that open and close while the server runs, for scripts that start the remote API.

A port speaks one protocol: that of this project, or the original's on a server that was started for clients of the
original (``--legacy-port``). The script cannot know which program will connect.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from simx_client.protocol.messages import Pace
from simx_server.errors import CommandError
from simx_server.service.server_loop import ServerLoop

from .errors import GatewayError
from .original.listener import LegacyGateway
from .zenoh.gateway import ZenohGateway

logger = logging.getLogger(__name__)

GRACE = 1.0
"""Seconds from the request to close a port until its clients are dropped: their last answers arrive before."""


@dataclass
class _Door:
    gateway: ZenohGateway | LegacyGateway
    closes_at: float | None = None


class ScriptDoors:
    """One gateway per port: its clients reach the same server loop as all others. Physics thread."""

    def __init__(
        self,
        loop: ServerLoop,
        own: Collection[int],
        config: Path | None,
        clock: Callable[[], float] = time.monotonic,
        *,
        legacy_pace: Pace | None = None,
    ) -> None:
        """Open nothing yet.

        Args:
            own: ports that the server itself offers.
            config: Zenoh configuration of the server, whose logins and certificates apply to these ports too.
            clock: seconds.
            legacy_pace: the ports are for clients of the original, with this pace of blocking calls.
        """
        self.own = own
        self._loop, self._config, self._clock = loop, config, clock
        self._legacy_pace = legacy_pace
        self._doors: dict[int, _Door] = {}
        self._closing: list[threading.Thread] = []

    def open(self, port: int) -> None:
        """Offer a port to clients. Raises CommandError: it is taken or not allowed."""
        door = self._doors.get(port)
        if door is not None:  # it was about to close
            door.closes_at = None
            return
        try:
            self._doors[port] = _Door(self._gateway(port))
        except GatewayError as error:
            raise CommandError(str(error)) from None

    def _gateway(self, port: int) -> ZenohGateway | LegacyGateway:
        if self._legacy_pace is not None:
            return LegacyGateway(self._loop, [f"127.0.0.1:{port}"], self._legacy_pace)
        return ZenohGateway(self._loop, ports=[port], config=self._config)

    def close(self, port: int) -> None:
        """Close a port after `GRACE`, with its clients."""
        door = self._doors.get(port)
        if door is not None:
            door.closes_at = self._clock() + GRACE

    def look(self) -> None:
        """Close the ports whose time has come; called often."""
        for port, door in list(self._doors.items()):
            if door.closes_at is not None and self._clock() >= door.closes_at:
                del self._doors[port]
                # Zenoh waits for clients that read nothing.
                thread = threading.Thread(target=door.gateway.leave, name="simx-port", daemon=True)
                thread.start()
                self._closing = [*filter(threading.Thread.is_alive, self._closing), thread]

    def close_all(self) -> None:
        """Close every port at once, when the server ends."""
        for door in self._doors.values():
            door.gateway.close()
        self._doors.clear()
        for thread in self._closing:
            thread.join()
