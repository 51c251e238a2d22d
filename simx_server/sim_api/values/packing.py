"""Numbers and tables as strings of bytes, and back; all numbers are little-endian.

Counts and offsets are numbers of items from 0; a count of 0 means all remaining items.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from simx_server.errors import CommandError
from simx_server.sim_api.base import ApiPart

from .tables import pack_table, unpack_table

MAX_NUMBERS = 1 << 20
"""Maximum length of an unpacked table: the server serves no other client while it builds one."""

_INTEGERS = {"B": 8, "H": 16, "I": 32, "i": 32}
"""Letters of `struct`, and bits."""


def pack(letter: str, values: Sequence[float | None], start: int, count: int) -> bytes:
    """Return numbers as bytes; integers wrap as in C and lose their fraction, floats that are too large become
    infinite, and nil is 0.
    """
    chosen = _span(values, start, count)
    numbers = np.array([value or 0 for value in chosen] if None in chosen else chosen, np.float64)
    if letter in _INTEGERS:
        bits = _INTEGERS[letter]
        np.trunc(numbers, out=numbers)
        np.fmod(numbers, 2.0**bits, out=numbers)  # exact, also of numbers beyond 64 bits
        return numbers.astype(np.int64).astype(f"<i{bits // 8}").tobytes()
    with np.errstate(over="ignore"):
        return numbers.astype(f"<{letter}").tobytes()


def unpack(letter: str, data: bytes, start: int, count: int, skip: int) -> list[Any] | None:
    """Return bytes as numbers, from `skip` bytes after the start; bytes of an incomplete last number are ignored.

    None if no number has the index `start`.
    """
    size = struct.calcsize(letter)
    present = range(max(len(data) - skip, 0) // size)
    if start < 0 or skip < 0 or start > len(present):
        return None
    chosen = _span(present, start, count)
    if not chosen:
        return []
    if len(chosen) > MAX_NUMBERS:
        raise CommandError(
            f"{len(chosen)} numbers are too many for one table, which holds {MAX_NUMBERS}: unpack in parts "
            "(start, count)"
        )
    return list(struct.unpack_from(f"<{len(chosen)}{letter}", data, skip + size * start))


def _span(values: Any, start: int, count: int) -> Any:
    """Return `count` items from an index on, or as many as there are; 0: all."""
    start = max(start, 0)
    return values[start : start + count] if count > 0 else values[start:]


class PackingFunctions(ApiPart, effect="reads"):
    """Functions for packed tables of numbers, and of any values."""

    def packInt32Table(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("i", numbers, start, count)

    def packUInt32Table(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("I", numbers, start, count)

    def packUInt16Table(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("H", numbers, start, count)

    def packUInt8Table(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("B", numbers, start, count)

    def packFloatTable(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("f", numbers, start, count)

    def packDoubleTable(self, numbers: list[float | None], start: int = 0, count: int = 0) -> bytes:
        return pack("d", numbers, start, count)

    def unpackInt32Table(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[int] | None:
        return unpack("i", data, start, count, skip)

    def unpackUInt32Table(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[int] | None:
        return unpack("I", data, start, count, skip)

    def unpackUInt16Table(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[int] | None:
        return unpack("H", data, start, count, skip)

    def unpackUInt8Table(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[int] | None:
        return unpack("B", data, start, count, skip)

    def unpackFloatTable(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[float] | None:
        return unpack("f", data, start, count, skip)

    def unpackDoubleTable(
        self, data: bytes, start: int = 0, count: int = 0, skip: int = 0
    ) -> list[float] | None:
        return unpack("d", data, start, count, skip)

    # The names before V-REP 3.3.

    packInts = packInt32Table
    packUInts = packUInt32Table
    packBytes = packUInt8Table
    packWords = packUInt16Table
    packFloats = packFloatTable
    packDoubles = packDoubleTable
    unpackInts = unpackInt32Table
    unpackUInts = unpackUInt32Table

    def unpackBytes(self, data: bytes, start: int = 0, count: int = 0) -> list[int] | None:
        return self.unpackUInt8Table(data, start, count)

    unpackWords = unpackUInt16Table
    unpackFloats = unpackFloatTable
    unpackDoubles = unpackDoubleTable

    def packTable(self, table: Any, scheme: int = 0) -> bytes:
        """Return a table of booleans, numbers, strings and tables as bytes that `unpackTable` reads; equal tables
        give equal bytes. `scheme`: 0 V-REP's format, 1 CBOR, 2 CBOR with float32. A function becomes a string.
        """
        return pack_table(table, scheme)

    def unpackTable(self, data: bytes) -> Any:
        """Return the table that `packTable` packed, here or in any version of V-REP and CoppeliaSim, in any scheme."""
        return unpack_table(data)
