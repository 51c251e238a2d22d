"""Write an image as a PNG file (W3C PNG specification, third edition), with the standard library only."""

from __future__ import annotations

import array
import struct
import sys
import zlib
from collections.abc import Iterable

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GREY, _RGB = 0, 2  # colour types
_NO_FILTER = b"\0"


def png(rows: Iterable[bytes], width: int, height: int, *, is_colour: bool, bits: int = 8) -> bytes:
    """Return the bytes of the file.

    Args:
        rows: from the top, each of width * (3 or 1) samples; samples of 16 bits have their high byte first.
        bits: bits of a sample, 8 or 16.

    Raises:
        ValueError: the number or length of the rows is wrong.
    """
    given = list(rows)
    length = width * (3 if is_colour else 1) * bits // 8
    if len(given) != height or any(len(row) != length for row in given):
        raise ValueError(f"{height} rows of {length} bytes are needed for {width}x{height} pixels")
    head = struct.pack(">IIBBBBB", width, height, bits, _RGB if is_colour else _GREY, 0, 0, 0)
    data = zlib.compress(b"".join(_NO_FILTER + row for row in given))
    return SIGNATURE + _chunk(b"IHDR", head) + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def samples_16(depths: Iterable[float]) -> bytes:
    """Convert numbers from 0 to 1 to samples of 16 bits; values outside are clipped."""
    samples = array.array("H", (round(65535 * min(1.0, max(0.0, depth))) for depth in depths))
    if sys.byteorder == "little":
        samples.byteswap()
    return samples.tobytes()


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
