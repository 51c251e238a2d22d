"""Loopback ports that open and close while the server runs, for scripts that start the remote API.

A port speaks one protocol: that of this project, or the original's on a server that was started for clients of the
original (``--legacy-port``). The script cannot know which program will connect.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.messages import Pace
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .errors import GatewayError
from .gateway import Gateway, Opening
from .zenoh.gateway import ZenohGateway

if TYPE_CHECKING:
    from simx_server.service.service import Service

GRACE = 1.0
"""Seconds from the request to close a port until its clients are dropped: their last answers arrive before."""


def open_script_ports(opening: Opening) -> ScriptPortsGateway | None:
    """Serve the requests of the scene's scripts, if they may open ports. Comes behind all gateways with ports."""
    settings, ports = opening.settings, opening.service.world.script_ports
    if not settings.script_ports:
        return None
    pace = Pace[settings.legacy_pace.upper()] if settings.legacy_ports else None
    gateway = ScriptPortsGateway(opening.service, opening.ports, settings.config, legacy_pace=pace)
    ports.serve(gateway)
    return gateway


@dataclass
class _Port:
    gateway: Gateway
    closes_at: float | None = None


class ScriptPortsGateway(Gateway):
    """One gateway per port: its clients reach the same server loop as all others."""

    def __init__(
        self,
        service: Service,
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
        super().__init__(service)
        self.own = own
        self._config, self._clock = config, clock
        self._legacy_pace = legacy_pace
        self._open: dict[int, _Port] = {}
        self._left: list[Gateway] = []
        """Gateways that may still be closing."""

    def open(self, port: int) -> None:
        """Offer a port to clients. Raises CommandError: it is taken or not allowed."""
        present = self._open.get(port)
        if present is not None:  # it was about to close
            present.closes_at = None
            return
        try:
            self._open[port] = _Port(self._gateway(port))
        except GatewayError as error:
            raise CommandError(str(error)) from None

    def _gateway(self, port: int) -> Gateway:
        if self._legacy_pace is not None:
            from .original.gateway import OriginalGateway

            return OriginalGateway(self._service, [f"127.0.0.1:{port}"], self._legacy_pace)
        return ZenohGateway(self._service, ports=[port], config=self._config)

    def stop(self, port: int) -> None:
        """Close a port after `GRACE`, with its clients."""
        present = self._open.get(port)
        if present is not None:
            present.closes_at = self._clock() + GRACE

    def look(self) -> None:
        """Close the ports whose time has come."""
        for port, present in list(self._open.items()):
            if present.closes_at is not None and self._clock() >= present.closes_at:
                del self._open[port]
                present.gateway.leave()
                self._left = [each for each in (*self._left, present.gateway) if each.is_closing]

    def close(self) -> None:
        """Close every port at once, when the server ends."""
        super().close()
        for gateway in (*(each.gateway for each in self._open.values()), *self._left):
            gateway.close()
        self._open.clear()
        self._left.clear()
