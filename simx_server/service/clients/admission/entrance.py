"""The gateway and the machine by which a client has come."""

from __future__ import annotations

from typing import NamedTuple


class Entrance(NamedTuple):
    """Where a client has come in."""

    gateway: str = ""
    """A name of the gateway; empty for clients within this process."""

    address: str = ""
    """Of the other machine; empty if it is not known."""
