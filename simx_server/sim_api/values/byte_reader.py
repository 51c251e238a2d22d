"""Reading of packed values from bytes that may be damaged."""

from __future__ import annotations

import struct
from typing import Any

_FORMATS = {letter: struct.Struct(f"<{letter}") for letter in "Biqd"}


class Damaged(ValueError):
    """The bytes do not hold what their first bytes announce; the text says what is wrong."""


class ByteReader:
    """Reads little-endian values one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.place = 0
        """Index of the next byte."""

    @property
    def left(self) -> int:
        """Return how many bytes are left."""
        return len(self._data) - self.place

    def take(self, letter: str) -> Any:
        """Return one number; `letter` is that of `struct`: B, i, q or d.

        Raises:
            Damaged: too few bytes are left.
        """
        form = _FORMATS[letter]
        try:
            (value,) = form.unpack_from(self._data, self.place)
        except struct.error:
            raise Damaged(f"it ends at byte {len(self._data)} within a value") from None
        self.place += form.size
        return value

    def bytes(self, count: int) -> bytes:
        """Return the next `count` bytes.

        Raises:
            Damaged: too few bytes are left.
        """
        if not 0 <= count <= self.left:
            raise Damaged(f"{count} bytes of text at byte {self.place}, where {self.left} are left")
        self.place += count
        return self._data[self.place - count : self.place]
