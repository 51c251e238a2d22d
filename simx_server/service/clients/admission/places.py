"""Places for clients: each gateway keeps some of them, and programs of one other machine get at most half."""

from __future__ import annotations

import ipaddress
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from simx_server.limits import Limits

from .entrance import Entrance

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession

SHARE = 16
"""Each open gateway keeps one place of this number for its own clients."""


class Places:
    """Decides whether one more client may join. Any thread."""

    def __init__(self, limits: Callable[[], Limits], sessions: Mapping[str, ClientSession]) -> None:
        """Start without gateways.

        Args:
            limits: returns the present limits.
            sessions: the present clients.
        """
        self._limits, self._sessions = limits, sessions
        self._gateways: set[str] = set()

    def open(self, gateway: str) -> None:
        """Keep places for the clients of a gateway from now on."""
        self._gateways.add(gateway)

    def close(self, gateway: str) -> None:
        """Keep no more places for a gateway."""
        self._gateways.discard(gateway)

    def check(self, entrance: Entrance) -> None:
        """Refuse one more client, if all places for it are taken. Raises LimitReached."""
        limits = self._limits()
        entrances = [session.entrance for session in list(self._sessions.values())]
        limits.check("clients", len(entrances) + 1, "let others leave first")
        kept = limits.clients // SHARE
        others = self._gateways - {entrance.gateway}
        free = sum(max(0, kept - sum(each.gateway == gateway for each in entrances)) for gateway in others)
        limits.check(
            "clients",
            len(entrances) + 1 + free,
            f"let others of this port leave first, as each other port keeps {kept} places",
        )
        if is_elsewhere(entrance.address):
            of_one = sum(each.address == entrance.address for each in entrances) + 1
            limits.check(
                "clients",
                2 * of_one - 1,
                "let others of your machine leave first, which may have half of the places",
            )


def is_elsewhere(address: str) -> bool:
    """Return whether an address is that of another machine."""
    try:
        return not ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False
