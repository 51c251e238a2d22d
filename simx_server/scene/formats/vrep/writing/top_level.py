"""The records of a whole file, and the header before them."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from simx_server.scene.formats.vrep.chunks import Body, heads
from simx_server.scene.formats.vrep.container import HEADER, MODEL, SCENE, UNCOMPRESSED

from .record_lists import record

_END = b"EOF"

TopRecord = tuple[str, bytes]
"""Tag and payload."""


def top_records(body: bytes) -> list[TopRecord]:
    """Return all records of an uncompressed body. Raises SceneError."""
    found: list[TopRecord] = []
    for tag, start, end in heads(Body(memoryview(body), ""), 0, len(body)):
        if tag == _END:
            break
        found.append((tag.decode("latin-1"), body[start:end]))
    return found


def file_bytes(records: Iterable[TopRecord], header: bytes, *, is_model: bool) -> bytes:
    """Return a file, uncompressed.

    Args:
        records: all records.
        header: start of the file from which they come: the versions are taken over.
        is_model: whether the new file is a model.
    """
    body = b"".join(record(tag, payload) for tag, payload in records) + _END
    start = bytearray(header[:HEADER])
    struct.pack_into("<BI", start, 12, UNCOMPRESSED, len(body))
    start[28] = MODEL if is_model else SCENE
    return bytes(start) + body
