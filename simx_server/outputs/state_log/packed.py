"""Send a protobuf message repeatedly with other numbers: serialise it once, then overwrite the numbers in place.

Serialising the poses of a hundred objects takes protobuf's Python half a millisecond. Physics would wait for that long,
because both need the interpreter. In the serialised message every double has its eight bytes and every time can have
ten, so numpy writes new ones there in some microseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MARK = 0xFFF8_0000_0000_0000
"""One of the many values that are not a number: the lower bits count. No text in UTF-8 has a byte 0xff."""

_SECONDS, _NANOSECONDS = 1 << 28, 1 << 28
"""The smallest numbers with five bytes, as many as every written time has."""


class Packed:
    """One message, its doubles in the order in which they were marked."""

    def __init__(self, message: Any, places: Sequence[tuple[Any, str]], times: Sequence[Any]) -> None:
        """Mark and serialise.

        Args:
            places: (message within it, field of type double).
            times: all `google.protobuf.Timestamp` within it.
        """
        marks = np.arange(_MARK, _MARK + len(places), dtype=np.uint64).view(np.float64)
        for (owner, field), mark in zip(places, marks, strict=True):
            setattr(owner, field, mark)
        for time in times:
            time.seconds, time.nanos = _SECONDS, _NANOSECONDS
        serialised = message.SerializeToString()
        self._bytes = np.frombuffer(serialised, np.uint8).copy()
        starts = _find_all(serialised, [mark.tobytes() for mark in marks])
        self._doubles = np.array(starts, np.intp)[:, np.newaxis] + np.arange(8)
        stamp = b"\x08" + bytes(_varint(_SECONDS)) + b"\x10" + bytes(_varint(_NANOSECONDS))
        starts = _find_all(serialised, [stamp] * len(times))
        self._times = np.array(starts, np.intp)[:, np.newaxis] + np.arange(1, len(stamp))

    def filled(self, values: NDArray[np.float64], time_ns: int) -> bytes:
        """Return the message with these doubles and, everywhere, this time (nanoseconds since 1970)."""
        self._bytes[self._doubles] = np.ascontiguousarray(values).view(np.uint8).reshape(-1, 8)
        seconds, nanoseconds = divmod(time_ns, 1_000_000_000)
        self._bytes[self._times] = [*_varint(seconds), 0x10, *_varint(nanoseconds)]
        return self._bytes.tobytes()


def _varint(number: int) -> list[int]:
    """Return a number in five bytes, even one that needs fewer: readers accept the leading zeros."""
    return [(number >> shift) & 0x7F | (0x80 if shift < 28 else 0) for shift in range(0, 35, 7)]


def _find_all(data: bytes, patterns: Sequence[bytes]) -> list[int]:
    """Return the start of each pattern, one after the other."""
    found: list[int] = []
    start = 0
    for pattern in patterns:
        start = data.index(pattern, start)
        found.append(start)
        start += len(pattern)
    return found
