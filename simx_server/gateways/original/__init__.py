"""The gateway of the original's TCP protocol: unmodified programs with V-REP's own library connect here.

======================  ===========================================================================
`packets.py`            bytes of a socket to messages, and back
`messages.py`           messages to commands, and replies to messages
`forms.py`              payloads to arguments, and results to payloads
`translation.py`        a command to the call of the table, and a result to its reply
`containers.py`         commands that wait and replies to send: equal commands, streams, message ids
`splitting.py`          commands and replies in pieces
`connection.py`         one client: lock-step, time-outs, the server loop
`gateway.py`            the ports
======================  ===========================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.messages import Pace

if TYPE_CHECKING:
    from simx_server.gateways.gateway import Opening

    from .gateway import OriginalGateway


def open_original(opening: Opening) -> OriginalGateway | None:
    """Open the ports for clients of the original, if there are any. Raises GatewayError."""
    settings = opening.settings
    if not settings.legacy_ports:
        return None
    from .gateway import OriginalGateway  # slow, and often not needed

    return OriginalGateway(opening.service, settings.legacy_ports, Pace[settings.legacy_pace.upper()])
