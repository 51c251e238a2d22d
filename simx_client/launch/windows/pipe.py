"""Messages over a pipe between the script's process and that of the windows: length, then MessagePack."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import Any

import msgpack

_HEAD = struct.Struct("<I")
_CHUNK = 1 << 20


def write(file: int, message: Any) -> None:
    """Write one message to a file descriptor. Raises OSError if the reader has closed it."""
    body = msgpack.packb(message)
    rest = memoryview(_HEAD.pack(len(body)) + body)
    while rest:
        rest = rest[os.write(file, rest[:_CHUNK]) :]


def read_all(file: int) -> Iterator[list[Any]]:
    """Yield messages until the other side closes its end, or exits."""
    while (head := _exactly(file, _HEAD.size)) is not None:
        body = _exactly(file, _HEAD.unpack(head)[0])
        if body is None:
            return
        yield msgpack.unpackb(body)


def _exactly(file: int, size: int) -> bytes | None:
    parts: list[bytes] = []
    while size:
        try:
            part = os.read(file, min(size, _CHUNK))
        except OSError:  # closed here
            return None
        if not part:
            return None
        parts.append(part)
        size -= len(part)
    return b"".join(parts)
