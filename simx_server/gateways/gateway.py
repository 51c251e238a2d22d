"""The contract of all gateways: where clients reach the server, and what the server asks of each.

A new gateway is a folder here and a line in the list of `app/extensions.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.service.watcher import Watcher

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.settings.settings import Settings


class Gateway(Watcher):
    """Serves the clients of one server by one protocol. Physics thread, or before and after it runs."""

    ports: Sequence[int] = ()
    """Ports of this host at which clients of the remote API find the server."""

    endpoints: Sequence[str] = ()
    """Where clients reach it, ``PROTOCOL/ADDRESS`` each, for the line that says that the server is ready."""

    def __init__(self, service: Service) -> None:
        """Watch until the gateway is closed: `look` and `read_while_busy` are the events that a gateway may need."""
        self._service = service
        self._is_open = True
        service.watchers.add(self)

    def close(self) -> None:
        """Close for good, as the server ends; wait for what is on its way. Idempotent."""
        if self._is_open:
            self._is_open = False
            self._service.watchers.remove(self)

    @property
    def is_closing(self) -> bool:
        """Return whether something is on its way after `leave`, for which `close` would wait."""
        return False

    def leave(self) -> None:
        """Close while the server goes on, without waiting: the clients leave. `close` waits later."""
        self.close()


@dataclass(frozen=True, slots=True)
class Opening:
    """The server that a gateway is opened for."""

    service: Service
    settings: Settings
    opened: list[Gateway] = field(default_factory=list[Gateway])
    """The gateways before it in the list."""

    @property
    def ports(self) -> list[int]:
        """Return the ports of the gateways before it."""
        return [port for gateway in self.opened for port in gateway.ports]


@dataclass(frozen=True, slots=True)
class Entry:
    """A gateway in the list of `app/extensions.py`."""

    settings: Sequence[str]
    """Names of the settings each of which lets other processes connect by it, when it is not empty."""

    open: Callable[[Opening], Gateway | None]
    """Opens it, or returns None: the settings want none. Raises GatewayError: it cannot be opened as they want."""
