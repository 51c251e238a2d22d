"""CoppeliaSim's ZeroMQ remote API: a gateway for its official clients, which run unchanged.

`gateway.py` has the port; `peer.py` is a connection, and `wire/` has its frames and messages; `clients.py` keeps the
clients; `connection.py` answers the messages of one connection, with the namespaces that the
scene's scripts see (`calls.py`). All of it runs on the physics thread. cbor2 is the extra ``zmq``.
"""

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
    from .gateway import ZmqGateway  # slow, and often not needed

    return ZmqGateway(opening.service, address, may_only_read=may_only_read)
