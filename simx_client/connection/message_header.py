"""Fields of the original's message header, as far as scripts can read them."""

from __future__ import annotations

import time

from simx_client.protocol import constants as c
from simx_client.protocol.messages import CLIENT_TIME_MASK, Delivery

PROTOCOL_HEADER_VERSION = 11
"""Message version of the original library (SIMX_VERSION of the C headers)."""


def client_time() -> int:
    """Return the client's time in milliseconds, as in the message header."""
    return int(time.monotonic() * 1000) & CLIENT_TIME_MASK


def header_field(header: Delivery, info_type: int) -> int | None:
    """Return a field of a received header, None for an unknown field."""
    return {
        c.simx_headeroffset_version: PROTOCOL_HEADER_VERSION,
        c.simx_headeroffset_message_id: header.message_id,
        c.simx_headeroffset_client_time: header.client_time,
        c.simx_headeroffset_server_time: header.server_time,
        c.simx_headeroffset_scene_id: header.scene_id,
        c.simx_headeroffset_server_state: header.server_state,
    }.get(info_type)
