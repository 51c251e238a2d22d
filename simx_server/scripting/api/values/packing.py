"""Numbers and tables as strings of bytes, and back; all numbers are little-endian.

Counts and offsets are numbers of items from 0; a count of 0 means all remaining items.
"""

from __future__ import annotations

import struct
from typing import Any

import msgpack

from simx_server.errors import CommandError
from simx_server.scripting.api.base import ApiPart
from simx_server.scripting.interpreter import Plain

_TABLE_MARK = b"simx:table:1\n"
"""Prefix of the bytes that `packTable` returns; the digit is the version of the format."""

MAX_NUMBERS = 1 << 21
"""Maximum length of an unpacked table: the server serves no other client while it builds one."""

MAX_TABLE = 1 << 20
"""Maximum bytes of a packed table to unpack, for the same reason."""

MAX_TABLES = 100_000
"""Maximum number of tables within it."""

_INTEGERS = {"B": (8, False), "H": (16, False), "I": (32, False), "i": (32, True)}


def pack(letter: str, values: list[float], start: int, count: int) -> bytes:
    """Return numbers as bytes; integers wrap as in C and lose their fraction, floats that are too large become
    infinite.
    """
    chosen = _span(values, start, count, "the table")
    if letter in _INTEGERS:
        bits, signed = _INTEGERS[letter]
        low = (1 << bits - 1) if signed else 0
        whole = [((int(value) + low) & ((1 << bits) - 1)) - low for value in chosen]
        return struct.pack(f"<{len(whole)}{letter}", *whole)
    if letter == "f":
        return b"".join(map(_float32, chosen))
    return struct.pack(f"<{len(chosen)}{letter}", *chosen)


def unpack(letter: str, data: bytes, start: int, count: int, skip: int) -> list[Any]:
    """Return bytes as numbers, from `skip` bytes after the start; bytes of an incomplete last number are ignored."""
    size = struct.calcsize(letter)
    if not 0 <= skip <= len(data):
        raise CommandError(f"the byte offset must be 0 to {len(data)}, the length of the data, not {skip}")
    present = range((len(data) - skip) // size)
    chosen = _span(present, start, count, "the data")
    if len(chosen) > MAX_NUMBERS:
        raise CommandError(
            f"{len(chosen)} numbers are too many for one table, which holds {MAX_NUMBERS}: unpack in parts "
            "(start, count)"
        )
    return list(struct.unpack_from(f"<{len(chosen)}{letter}", data, skip + size * start))


def _span(values: Any, start: int, count: int, what: str) -> Any:
    if start < 0 or count < 0 or start + count > len(values):
        raise CommandError(
            f"{what} has {len(values)} items, which {count or 'all'} of them from index {start} do not fit"
        )
    return values[start : start + count] if count else values[start:]


def _float32(value: float) -> bytes:
    try:
        return struct.pack("<f", value)
    except OverflowError:
        return struct.pack("<f", float("inf") if value > 0 else float("-inf"))


def pack_table(table: Plain) -> bytes:
    """Return a table as bytes.

    Raises:
        CommandError: the value is not a table, or contains a function.
    """
    if not isinstance(table, (list, dict)):
        raise CommandError("only a table can be packed")
    try:
        return _TABLE_MARK + msgpack.packb(_sorted(table), unicode_errors="surrogateescape")
    except (TypeError, ValueError, OverflowError) as problem:
        raise CommandError(f"the table cannot be packed: {problem}") from None


def unpack_table(data: bytes) -> Any:
    """Return the table that the bytes hold.

    Raises:
        CommandError: the bytes do not come from `pack_table`.
    """
    if not data.startswith(_TABLE_MARK):
        raise CommandError(
            "this was not made by packTable of this server, whose data is the only one it reads"
        )
    if len(data) > MAX_TABLE:
        raise CommandError(
            f"the packed table has {len(data)} bytes, of which at most {MAX_TABLE} are unpacked"
        )
    count = 0

    def counted(table: Any) -> Any:
        nonlocal count
        count += 1
        if count > MAX_TABLES:
            raise ValueError(f"it has more than {MAX_TABLES} tables within it")
        return table

    try:
        return msgpack.unpackb(
            data[len(_TABLE_MARK) :],
            strict_map_key=False,
            unicode_errors="surrogateescape",
            list_hook=counted,
            object_hook=counted,
        )
    except ValueError as problem:
        raise CommandError(f"the packed table is damaged or too large: {problem}") from None


class PackingFunctions(ApiPart):
    """Functions for packed tables of numbers, and of any values."""

    def packInt32Table(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("i", numbers, start, count)

    def packUInt32Table(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("I", numbers, start, count)

    def packUInt16Table(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("H", numbers, start, count)

    def packUInt8Table(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("B", numbers, start, count)

    def packFloatTable(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("f", numbers, start, count)

    def packDoubleTable(self, numbers: list[float], start: int = 0, count: int = 0) -> bytes:
        return pack("d", numbers, start, count)

    def unpackInt32Table(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[int]:
        return unpack("i", data, start, count, skip)

    def unpackUInt32Table(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[int]:
        return unpack("I", data, start, count, skip)

    def unpackUInt16Table(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[int]:
        return unpack("H", data, start, count, skip)

    def unpackUInt8Table(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[int]:
        return unpack("B", data, start, count, skip)

    def unpackFloatTable(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[float]:
        return unpack("f", data, start, count, skip)

    def unpackDoubleTable(self, data: bytes, start: int = 0, count: int = 0, skip: int = 0) -> list[float]:
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

    def unpackBytes(self, data: bytes, start: int = 0, count: int = 0) -> list[int]:
        return self.unpackUInt8Table(data, start, count)

    unpackWords = unpackUInt16Table
    unpackFloats = unpackFloatTable
    unpackDoubles = unpackDoubleTable

    def packTable(self, table: Any, scheme: int = 0) -> bytes:
        """Return a table of booleans, numbers, strings and tables as bytes that `unpackTable` reads; equal tables
        give equal bytes.

        Partly: the format is specific to this server, also for the CBOR schemes 1 and 2; other programs cannot read
        it.
        """
        if scheme not in (0, 1, 2):
            raise CommandError(f"the scheme is 0, 1 or 2, not {scheme}")
        return pack_table(table)

    def unpackTable(self, data: bytes) -> Any:
        """Return the table that `packTable` packed."""
        return unpack_table(data)


def _sorted(value: Plain) -> Any:
    """Return tables with their names in order, so that equal ones are packed alike. Functions cannot be packed."""
    if isinstance(value, dict):
        pairs = sorted(value.items(), key=lambda pair: (isinstance(pair[0], str), pair[0]))
        return {key: _sorted(item) for key, item in pairs}
    if isinstance(value, list):
        return [_sorted(item) for item in value]
    if value is None or isinstance(value, (bool, int, float, bytes, str)):
        return value
    raise CommandError(f"a {type(value).__name__.lower()} cannot be packed")
