"""The offer that another gateway may add to the welcome of a client."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.service.answers.link import Link, PackingLink


class Offers:
    """Offers a client another connection, by which its messages travel from then on; this one offers none.

    Physics thread.
    """

    def invite(self, client: str, link: PackingLink) -> Link:
        """Make an offer to a client that joins; return the link to use in place of that over Zenoh."""
        return link

    def offer_to(self, client: str) -> str:
        """Return the offer in a client's welcome; empty without one."""
        return ""

    def serves(self, client: str) -> bool:
        """Return whether a client uses its offer."""
        return False
