"""Tables as bytes, in the format of V-REP and CoppeliaSim, and back; scenes hold such bytes as custom data.

The first byte is the version: 0 of V-REP 3 to CoppeliaSim 4.2, whose only numbers are float64, 5 of later programs.
The table follows, and in files of CoppeliaSim 4.7 and later some more bytes, which are ignored. Each value is a byte
with its kind, then

| kind | value |
|---|---|
| 0 nil | nothing |
| 1 float | float64 |
| 2 boolean | one byte |
| 3 string | int32 length, bytes |
| 4 table | the table: one byte (1: a list, 0: keys and values), int32 number of items, the items |
| 9 integer | int64 |

Bytes that start otherwise are CBOR (`cbor.py`), which CoppeliaSim writes on request.
"""

from __future__ import annotations

import struct
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import MAX_DEPTH, Plain

from . import cbor
from .byte_reader import ByteReader, Damaged

MAX_TABLE = 1 << 20
"""Maximum bytes of a packed table to unpack: the server serves no other client meanwhile."""

_OLD, _PRESENT = 0, 5
_NIL, _FLOAT, _BOOLEAN, _STRING, _TABLE, _INTEGER = 0, 1, 2, 3, 4, 9
_NAMED, _LIST = 0, 1

_STRING_HEAD, _INTEGER_VALUE = struct.Struct("<Bi").pack, struct.Struct("<Bq").pack

_LONG = 1 << 63
"""Integers below this one, and not below its negative, fit in int64."""

_EXACT = 1 << 53
"""Whole numbers below this one are exact in float64."""


def pack_table(table: Plain, scheme: int = 0) -> bytes:
    """Return a table as bytes; names are in alphabetical order, so equal tables give equal bytes.

    Args:
        table: a list or dict of nil, booleans, numbers, strings and tables; a function becomes a string.
        scheme: 0 V-REP's format, 1 CBOR, 2 CBOR with float32.

    Raises:
        CommandError: the value is not a table, or the scheme is unknown.
    """
    if scheme not in (0, 1, 2):
        raise CommandError(f"the scheme is 0 (V-REP's format), 1 or 2 (CBOR), not {scheme}")
    if not isinstance(table, (list, dict)):
        raise CommandError("only a table can be packed")
    if scheme:
        return cbor.encode(table, single=scheme == 2)
    pieces = [bytes([_PRESENT])]
    _add_table(pieces, table)
    return b"".join(pieces)


def unpack_table(data: bytes) -> Any:
    """Return the table that the bytes hold.

    Raises:
        CommandError: the bytes hold no table, are damaged or too many.
    """
    if len(data) > MAX_TABLE:
        raise CommandError(
            f"the packed table has {len(data)} bytes, of which at most {MAX_TABLE} are unpacked"
        )
    try:
        if data[:1] in (bytes([_OLD]), bytes([_PRESENT])):
            reader = ByteReader(data)
            version = reader.take("B")
            return _table(reader, version, 1)
        if cbor.is_table(data):
            return cbor.decode(data)
    except Damaged as problem:
        raise CommandError(f"the packed table is damaged: {problem}") from None
    raise CommandError("this is no packed table: neither V-REP's format nor CBOR")


def _add_table(pieces: list[bytes], table: list[Any] | dict[Any, Any]) -> None:
    items: list[Any] = table if isinstance(table, list) else cbor.in_order(table)
    pieces.append(struct.pack("<Bi", _LIST if isinstance(table, list) else _NAMED, len(items)))
    if (numbers := cbor.as_floats(items)) is not None:
        pieces.append(cbor.headed(_FLOAT, numbers, "<f8"))
        return
    add = pieces.append
    for item in items:
        kind = cast("Any", type(item))
        if kind is str:
            item = item.encode("utf-8", "surrogateescape")
        if kind is str or kind is bytes:  # most values: each name is one
            add(_STRING_HEAD(_STRING, len(item)))
            add(item)
        elif kind is int and -_LONG <= item < _LONG:
            add(_INTEGER_VALUE(_INTEGER, item))
        else:
            _add(pieces, item)
    cbor.check_room(pieces)


def _add(pieces: list[bytes], value: Plain) -> None:
    match value:
        case None:
            pieces.append(bytes([_NIL]))
        case bool():
            pieces.append(bytes([_BOOLEAN, value]))
        case float() | int():  # an integer that int64 does not hold
            pieces.append(struct.pack("<Bd", _FLOAT, cbor.as_float(value)))
        case list() | dict():
            pieces.append(bytes([_TABLE]))
            _add_table(pieces, value)
        case _:
            pieces += (_STRING_HEAD(_STRING, len(cbor.FUNCTION)), cbor.FUNCTION)


def _table(reader: ByteReader, version: int, depth: int) -> Any:
    if depth > MAX_DEPTH:
        raise Damaged(f"its tables are nested more than {MAX_DEPTH} levels deep")
    kind, count = reader.take("B"), reader.take("i")
    if kind not in (_NAMED, _LIST) or not 0 <= count <= reader.left:
        raise Damaged(f"no table at byte {reader.place}")
    items = [_value(reader, version, depth) for _ in range(count)]
    if kind == _LIST:
        return items
    if count % 2:
        raise Damaged("a name without a value")
    return {_key(items[i]): items[i + 1] for i in range(0, count, 2)}


def _value(reader: ByteReader, version: int, depth: int) -> Any:
    kind = reader.take("B")
    match kind:
        case 0:
            return None
        case 1:
            number: float = reader.take("d")
            # Lua 5.1, which wrote the old version, has one type of number, and shows 5.0 as "5".
            is_whole = version == _OLD and number.is_integer() and abs(number) < _EXACT
            return int(number) if is_whole else number
        case 2:
            return bool(reader.take("B"))
        case 3:
            return reader.bytes(reader.take("i"))
        case 4:
            return _table(reader, version, depth + 1)
        case 9:
            return reader.take("q")
        case _:
            raise Damaged(f"a value of the unknown kind {kind} at byte {reader.place - 1}")


def _key(value: Any) -> int | str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "surrogateescape")
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    raise Damaged("a key that is neither text nor a whole number")
