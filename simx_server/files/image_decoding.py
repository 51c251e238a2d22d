"""The process that decodes one image file: OpenCV's decoders are large, and the file may come from anybody.

Run with `-m`. Standard input is the file; standard output is a `.npy` file of its pixels as RGBA.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

_MEMORY = 2 << 30
"""Bytes of address space that the process may take."""


def main() -> None:
    """Decode; the exit code is 1 if the file is damaged."""
    if resource is not None:
        if sys.platform == "linux":  # macOS refuses a limit below what all processes map
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pixels = decode(sys.stdin.buffer.read())
    if pixels is None:
        sys.exit(1)
    np.save(sys.stdout.buffer, pixels)


def decode(data: bytes) -> NDArray[np.uint8] | None:
    """Return the pixels (rows, columns, 4) as RGBA, in this process; None for a damaged file."""
    import cv2  # large, and most servers read no images

    try:
        read: Any = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
    if read is None:
        return None
    return _rgba((read >> 8).astype(np.uint8) if read.dtype == np.uint16 else read)


def _rgba(found: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return (rows, columns, 4) of grey, BGR or BGRA pixels."""
    rows, columns = found.shape[:2]
    pixels = np.full((rows, columns, 4), 255, np.uint8)
    if found.ndim == 2:
        pixels[..., :3] = found[..., np.newaxis]
    else:
        pixels[..., :3] = found[..., 2::-1]
        if found.shape[2] == 4:
            pixels[..., 3] = found[..., 3]
    return pixels


if __name__ == "__main__":
    main()
