"""When the ports of the ZeroMQ remote API are opened. The rest is slow to import, and often not needed."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening

    from .gateway import ZmqGateway


def open_zmq(opening: Opening) -> ZmqGateway | None:
    """Open the port, if there is one. Raises GatewayError."""
    return _opened(opening, opening.settings.zmq, may_only_read=False)


def open_zmq_viewers(opening: Opening) -> ZmqGateway | None:
    """Open the port of clients that only read, if there is one. Raises GatewayError."""
    return _opened(opening, opening.settings.zmq_viewers, may_only_read=True)


def _opened(opening: Opening, address: str | None, *, may_only_read: bool) -> ZmqGateway | None:
    if address is None:
        return None
    from .gateway import ZmqGateway

    return ZmqGateway(opening.loop, address, may_only_read=may_only_read)
