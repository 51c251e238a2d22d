"""Image files in memory: pixels to PNG, JPEG or BMP, and back."""

from __future__ import annotations

import io
import math
import struct
import subprocess
import sys

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

from .image_decoding import decode

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp")

MOST_PIXELS = 4096 * 4096
"""Most pixels of an image: a small file may hold very many."""

_SECONDS = 10
"""Longest time to decode a file."""

_USUAL_QUALITY = 90
"""Quality of a JPEG file that is written without one."""

_FRAME_MARKERS = frozenset({*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC})
"""Markers of JPEG before the size of the image."""

Pixels = NDArray[np.uint8]


def encoded(pixels: Pixels, suffix: str, quality: int = -1) -> bytes:
    """Return the bytes of an image file.

    Args:
        pixels: (rows, columns, 3 or 4) RGB or RGBA, the upper row first.
        suffix: one of `SUFFIXES`.
        quality: 0 to 100 of JPEG; below 0 the usual one.

    Raises:
        CommandError: the file cannot be made.
    """
    import cv2  # large, and most servers neither read nor write images

    order = [2, 1, 0, 3][: pixels.shape[2]]
    level = _USUAL_QUALITY if quality < 0 else min(quality, 100)
    settings = [cv2.IMWRITE_JPEG_QUALITY, level] if suffix in (".jpg", ".jpeg") else []
    if suffix != ".png":
        order = order[:3]
    made, data = cv2.imencode(suffix, np.ascontiguousarray(pixels[..., order]), settings)
    if not made:
        raise CommandError(f"no image file of {pixels.shape[1]} x {pixels.shape[0]} pixels can be made")
    return data.tobytes()


def decoded(data: bytes, *, is_trusted: bool = False) -> Pixels:
    """Return the pixels (rows, columns, 4), RGBA with the upper row first, of an image file.

    Args:
        data: the file.
        is_trusted: whether the operator has named the file: it is decoded in this process then. Another process
            takes 0.3 s or more.

    Raises:
        CommandError: the content is not an image of these formats, it is damaged, or too large.
    """
    size = _size(data)
    if size is None:
        raise CommandError(f"the content is not an image file; those are {', '.join(SUFFIXES)}")
    if not 0 < size[0] * size[1] <= MOST_PIXELS:
        raise CommandError(f"the image has {size[0]} x {size[1]} pixels; at most {MOST_PIXELS} are read")
    if is_trusted:
        found = decode(data)
        if found is None:
            raise CommandError("the image file is damaged")
        return found
    try:
        done = subprocess.run(
            [sys.executable, "-m", "simx_server.files.image_decoding"],
            input=data,
            capture_output=True,
            timeout=_SECONDS,
            check=True,
        )
        pixels: Pixels = np.load(io.BytesIO(done.stdout))
    except (subprocess.SubprocessError, OSError, ValueError, EOFError):
        raise CommandError("the image file is damaged") from None
    return pixels


def fitted(pixels: Pixels, largest: int) -> Pixels:
    """Return an image with sides of powers of two up to a largest one; 0: as it is."""
    if largest <= 0:
        return pixels
    import cv2

    height, width = (
        1 << max(0, min(math.floor(math.log2(largest)), round(math.log2(side)))) for side in pixels.shape[:2]
    )
    return cv2.resize(pixels, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8)


def _size(data: bytes) -> tuple[int, int] | None:
    """Return the width and height that the head of an image file says."""
    try:
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            width, height = struct.unpack_from(">II", data, 16)
            return width, height
        if data.startswith(b"BM"):
            width, height = struct.unpack_from("<ii", data, 18)
            return abs(width), abs(height)
        if data.startswith(b"\xff\xd8"):
            return _size_of_jpeg(data)
    except struct.error:
        return None
    return None


def _size_of_jpeg(data: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
            continue
        if marker in _FRAME_MARKERS:
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        at += 2 + max(2, struct.unpack_from(">H", data, at + 2)[0])
    return None
