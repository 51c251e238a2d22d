"""The masked text of a script, as `decoding/scripts.py` unmasks it."""

from __future__ import annotations

import numpy as np


def masked(text: str) -> bytes:
    """Return the bytes of a script's text as files have them."""
    data = text.encode("utf-8", "surrogateescape") + b"\0"
    if len(data) < 3:
        return data
    octets = np.frombuffer(data, np.uint8).astype(np.int64)
    first = int(octets[0]) - 256 * (octets[0] > 127)
    start, end = int(int(first) / 2), 0  # the last byte is the 0 that ends the text
    place = np.arange(octets.size)
    shift = np.where(place & 1, place + start + end, 0)
    shift -= np.where(place & 2, 3 * place + start, 0)
    shift += np.where(place & 4, (place >> 1) + end, 0)
    shift[[0, -1]] = 0
    return (octets - shift & 255).astype(np.uint8).tobytes()
