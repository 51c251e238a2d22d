"""Messages of the original's protocol: a header of 18 bytes, then commands with headers of 26 bytes each."""

from __future__ import annotations

import struct
from typing import NamedTuple

from simx_client.protocol.constants import (
    simx_opmode_continuous,
    simx_opmode_discontinue,
    simx_opmode_oneshot_split,
    simx_opmode_oneshot_wait,
    simx_opmode_streaming_split,
)
from simx_client.protocol.table.original_wire import KILL_CONNECTION

VERSION = 11
HEADER = struct.Struct("<HBiiiHB")
"""Checksum (0: not used), version, message id, client time, server time, scene id, server state."""

COMMAND = struct.Struct("<iiHiiHiBB")
"""Size here, size of the complete command, size of the identification data, offset of this piece, id and mode, delay or
size of pieces, simulation time, status, reserved."""

ID_MASK, MODE_MASK = 0xFFFF, 0x7FFF0000
BLOCKING, STREAMING, DISCONTINUE = simx_opmode_oneshot_wait, simx_opmode_continuous, simx_opmode_discontinue
ONESHOT_SPLIT, STREAMING_SPLIT = simx_opmode_oneshot_split, simx_opmode_streaming_split
SPLIT_MODES = (ONESHOT_SPLIT, STREAMING_SPLIT)

DO_NOT_OVERWRITE = 1
"""Bit of the status of a request: an equal command that waits stays."""

FAILED = 1
"""Bit of the status of a reply."""

NOTHING_EXECUTED = -1
"""The message id of a reply without new results."""

_UI_EVENT_BUTTON = 0x2003
"""The one command whose identification data is sent with four bytes too few."""

Key = tuple[int, bytes]
"""Id and identification data: commands with the same key are *equal*."""


class Malformed(ValueError):
    """The bytes of a message do not fit together; the text says where."""


class Request(NamedTuple):
    """One command of a client, or a piece of one."""

    id: int
    mode: int
    low: int
    """Delay of a stream in ms, or size of pieces in bytes."""

    ident: bytes
    payload: bytes
    keeps_equal: bool
    """An equal command that waits is not replaced."""

    full_size: int
    """Bytes of the complete command, with its header and identification data."""

    offset: int
    """Offset of this piece in the complete payload."""

    @property
    def key(self) -> Key:
        return self.id, self.ident

    @property
    def is_piece(self) -> bool:
        """Return whether it is not the complete command."""
        return self.offset > 0 or self.full_size > COMMAND.size + len(self.ident) + len(self.payload)


class Message(NamedTuple):
    """One message of a client."""

    message_id: int
    client_time: int
    requests: list[Request]
    is_last: bool
    """The client ends the connection."""


class Head(NamedTuple):
    """The header of a message to a client."""

    message_id: int = NOTHING_EXECUTED
    client_time: int = 0
    server_time: int = 0
    scene_id: int = 0
    server_state: int = 0


def read(message: bytes, most: int) -> Message:
    """Return the commands of a message.

    Args:
        most: most commands.

    Raises:
        Malformed: a length does not fit, or there are more commands.
    """
    if len(message) < HEADER.size:
        raise Malformed(f"a message of {len(message)} bytes, which is less than its header")
    _, _, message_id, client_time, _, _, _ = HEADER.unpack_from(message)
    requests: list[Request] = []
    position, is_last = HEADER.size, False
    while position < len(message):
        if len(message) - position < COMMAND.size:
            raise Malformed("a command that ends within its header")
        size, full_size, _, offset, command, low, _, status, _ = COMMAND.unpack_from(message, position)
        if not COMMAND.size <= size <= len(message) - position:
            raise Malformed(f"a command of {size} bytes where {len(message) - position} are left")
        if full_size < size or offset < 0:
            raise Malformed(f"a piece of {size} bytes at {offset} of a command of {full_size} bytes")
        if len(requests) >= most:
            raise Malformed(f"more than {most} commands in one message")
        id, body = command & ID_MASK, message[position + COMMAND.size : position + size]
        position += size
        if command == KILL_CONNECTION:
            is_last = position == len(message)
            continue
        ident, payload = _divide(id, body)
        requests.append(
            Request(
                id,
                command & MODE_MASK,
                low,
                ident,
                payload,
                bool(status & DO_NOT_OVERWRITE),
                full_size,
                offset,
            )
        )
    return Message(message_id, client_time, requests, is_last)


def _divide(id: int, body: bytes) -> tuple[bytes, bytes]:
    """Return identification data and payload of a command; the range of the id decides about the former."""
    if id < 0x1000:
        return b"", body
    if id == _UI_EVENT_BUTTON and len(body) == 4:
        return body + bytes(4), b""
    if id < 0x3000:
        size = 4 if id < 0x2000 else 8
    else:
        size = 4 if 0x3400 <= id < 0x3800 else 0
        for _ in range(2 if size else 1):
            size = body.find(b"\0", size) + 1
            if not size:
                raise Malformed(f"a command {id:#06x} without the end of its text")
    if len(body) < size:
        raise Malformed(f"a command {id:#06x} with {len(body)} bytes where {size} identify it")
    return body[:size], body[size:]


def command(request: Request, payload: bytes, *, time_ms: int = 0, has_failed: bool = False) -> bytes:
    """Return the bytes of a complete reply to a request."""
    size = COMMAND.size + len(request.ident) + len(payload)
    return _header(request, size, size, 0, time_ms, has_failed) + request.ident + payload


def piece(request: Request, payload: bytes, offset: int, size: int, time_ms: int) -> bytes:
    """Return the bytes of a piece of a successful reply: `size` bytes of its payload from `offset`."""
    part, whole = payload[offset : offset + size], COMMAND.size + len(request.ident)
    return (
        _header(request, whole + len(part), whole + len(payload), offset, time_ms, False)
        + request.ident
        + part
    )


def _header(
    request: Request, size: int, full_size: int, offset: int, time_ms: int, has_failed: bool
) -> bytes:
    return COMMAND.pack(
        size,
        full_size,
        len(request.ident),
        offset,
        request.id | request.mode,
        request.low,
        time_ms,
        FAILED if has_failed else 0,
        0,
    )


def message(head: Head, commands: bytes) -> bytes:
    """Return a message to a client."""
    return (
        HEADER.pack(
            0,
            VERSION,
            head.message_id,
            head.client_time,
            head.server_time,
            head.scene_id & 0xFFFF,
            head.server_state & 0xFF,
        )
        + commands
    )
