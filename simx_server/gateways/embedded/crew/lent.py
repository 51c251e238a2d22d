"""The link to a world, as a crew uses it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol.commands import Command
from simx_client.protocol.messages import Reply
from simx_server.service.calls.direct import DirectCall
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.service import Service

if TYPE_CHECKING:
    from simx_server.gateways.embedded.alone import Alone
    from simx_server.gateways.embedded.turns import Turns


class Link(Protocol):
    """The part of an `EmbeddedTransport` that a crew uses."""

    is_direct: bool

    def lend(self, take_back: Callable[[], object]) -> None: ...
    def returned(self) -> None: ...
    def execute_together(
        self, calls: Sequence[tuple[Command, list[Any]]], timeout: float
    ) -> list[Reply] | None: ...


@dataclass(frozen=True, slots=True)
class Lent:
    """The link, and what belongs to the world at its end."""

    link: Link
    service: Service
    turns: Turns
    session: ClientSession
    alone: Alone
    direct: Callable[[ClientSession, Command], DirectCall]
    """Prepares a command of the client."""
