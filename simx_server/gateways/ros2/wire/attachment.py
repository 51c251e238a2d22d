"""The 33 bytes with every message, request and answer: its number, the time of sending, and who sends it."""

from __future__ import annotations

import secrets
import struct
import time
from typing import NamedTuple

_HEAD = struct.Struct("<qqB")
GID_BYTES = 16
"""Bytes of a global id, which every publisher and every client of a service has."""

SIZE = _HEAD.size + GID_BYTES


class Attachment(NamedTuple):
    """The data that a message carries beside its payload."""

    number: int
    """Counted from 1 for each sender; a gap is a lost message for the receiver."""

    time_ns: int
    """Nanoseconds of the system's clock since 1970, never simulation time."""

    gid: bytes

    def packed(self) -> bytes:
        """Return the 33 bytes."""
        return _HEAD.pack(self.number, self.time_ns, GID_BYTES) + self.gid


def new_gid() -> bytes:
    """Return the global id of a new publisher."""
    return secrets.token_bytes(GID_BYTES)


def read(data: bytes) -> Attachment:
    """Return the attachment of a message.

    Raises:
        ValueError: it is none of rmw_zenoh's; the text says why.
    """
    if len(data) != SIZE:
        raise ValueError(f"an attachment of rmw_zenoh has {SIZE} bytes, not {len(data)}")
    number, time_ns, length = _HEAD.unpack_from(data)
    if length != GID_BYTES:
        raise ValueError(f"the global id of an attachment has {GID_BYTES} bytes, not {length}")
    if number < 0 or time_ns < 0:
        raise ValueError("number and time of an attachment are not negative")
    return Attachment(number, time_ns, data[_HEAD.size :])


def answering(request: Attachment) -> bytes:
    """Return the attachment of the answer to a request: its number and sender, and the present time."""
    return request._replace(time_ns=time.time_ns()).packed()
