"""CoppeliaSim 4.11's API 2 over ZeroMQ: a gateway for its clients, which call methods of objects.

The connections are those of the older protocol (`gateways/zmq/`); `messages.py` has the numbered messages of this one,
`tags.py` its values; `clients.py` and `connection.py` call the methods of `sim_api/object_model/`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening

    from .gateway import Zmq2Gateway


def open_zmq2(opening: Opening) -> Zmq2Gateway | None:
    """Open the port, if there is one. Raises GatewayError."""
    return _opened(opening, opening.settings.zmq2, may_only_read=False)


def open_zmq2_viewers(opening: Opening) -> Zmq2Gateway | None:
    """Open the port of clients that only read, if there is one. Raises GatewayError."""
    return _opened(opening, opening.settings.zmq2_viewers, may_only_read=True)


def _opened(opening: Opening, address: str | None, *, may_only_read: bool) -> Zmq2Gateway | None:
    if address is None:
        return None
    from .gateway import Zmq2Gateway  # slow, and often not needed

    return Zmq2Gateway(opening.service, address, may_only_read=may_only_read)
