"""The types of properties: their numbers, the values that they accept, and their values as bytes.

The bytes are those that CoppeliaSim stores for custom data of the type, under a name with the type's tag: little-endian
numbers, text as UTF-8, a table as ``sim.packTable`` packs it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, cast

from simx_server.constant_tables import TABLES
from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import (
    to_any,
    to_bool,
    to_bytes,
    to_float,
    to_int,
    to_list,
    to_text,
)
from simx_server.sim_api.values.tables import pack_table, unpack_table

_LONG = 1 << 63


@dataclass(frozen=True, slots=True)
class PropertyType:
    """One type. Types of the same family hold the same kind of values: each reads and sets the properties of all."""

    name: str
    """As in the names of the functions: ``sim.getNAMEProperty``."""
    family: str
    what: str
    """A property of the type in the words of the manual, such as "a number"."""
    convert: Callable[[Any], Any]
    """Return a script's value as one of this type. Raises TypeError that says what the value must be."""
    encode: Callable[[Any], bytes]
    unpack: Callable[[bytes], Any]
    tag: str = ""
    """Text before the name of custom data of this type in CoppeliaSim's files."""

    def decode(self, data: bytes) -> Any:
        """Return the value that bytes hold. Raises CommandError: they hold none of this type."""
        try:
            return self.unpack(data)
        except (struct.error, IndexError):
            raise CommandError(
                f"the {len(data)} bytes are damaged: they hold no value of the type {self.name.lower()}"
            ) from None

    @property
    def number(self) -> int:
        """Return ``sim.propertytype_*``."""
        return TABLES[f"propertytype_{self.name.lower()}"]


def _to_long(value: Any) -> int:
    if isinstance(value, int) and -_LONG <= value < _LONG:
        return int(value)
    return to_int(value)


def _exactly(count: int, convert: Callable[[Any], Any], what: str) -> Callable[[Any], list[Any]]:
    items = to_list(convert)

    def of_length(value: Any) -> list[Any]:
        found = items(value)
        if len(found) != count:
            raise TypeError(what)
        return found

    return of_length


def _to_table(value: Any) -> Any:
    if isinstance(value, (list, dict)):
        return cast(Any, value)
    raise TypeError("a table")


def _numbers(letter: str) -> tuple[Callable[[list[Any]], bytes], Callable[[bytes], list[Any]]]:
    def encode(values: list[Any]) -> bytes:
        return struct.pack(f"<{len(values)}{letter}", *values)

    def unpack(data: bytes) -> list[Any]:
        return list(struct.unpack(f"<{len(data) // struct.calcsize(letter)}{letter}", data))

    return encode, unpack


def _number(letter: str) -> tuple[Callable[[Any], bytes], Callable[[bytes], Any]]:
    encode, unpack = _numbers(letter)
    return lambda value: encode([value]), lambda data: unpack(data)[0]


def _floats(name: str, what: str, tag: str, count: int, form: str) -> PropertyType:
    return PropertyType(name, "floats", what, _exactly(count, to_float, form), *_numbers("d"), tag)


def _colour(value: Any) -> list[float]:
    found: list[float] = _exactly(3, to_float, _COLOUR)(value)
    if max(map(abs, found)) > _BIGGEST_SINGLE:
        raise TypeError(_COLOUR)
    return found


def _to_utf8(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _from_utf8(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def _pack_texts(texts: list[str]) -> bytes:
    return b"".join(_to_utf8(text) + b"\0" for text in texts)


def _unpack_texts(data: bytes) -> list[str]:
    return [_from_utf8(text) for text in data.split(b"\0")[:-1]]


def _unpack_bool(data: bytes) -> bool:
    return struct.unpack("<i", data) != (0,)


def _to_rows(value: Any) -> list[list[float]]:
    rows: list[list[float]] = [_row(each) for each in to_list(to_any)(value)]
    if len({len(row) for row in rows}) > 1:
        raise TypeError("a table of rows that are equally long")
    return rows


_row = to_list(to_float)
_SHAPE = struct.Struct("<ii")


def _pack_rows(rows: list[list[float]]) -> bytes:
    width = len(rows[0]) if rows else 0
    numbers = [number for row in rows for number in row]
    return _SHAPE.pack(len(rows), width) + struct.pack(f"<{len(numbers)}d", *numbers)


def _unpack_rows(data: bytes) -> list[list[float]]:
    count, width = _SHAPE.unpack_from(data)
    numbers = list(struct.unpack(f"<{(len(data) - _SHAPE.size) // 8}d", data[_SHAPE.size :]))
    if count < 0 or width < 0 or count * width != len(numbers):
        raise struct.error("no matrix has this size")
    return [numbers[width * place : width * (place + 1)] for place in range(count)]


_COLOUR = "a table of 3 numbers from 0 to 1: red, green, blue"
_BIGGEST_SINGLE = 3.4e38
"""Greatest number of single precision, in which colours are stored."""

BOOL = PropertyType(
    "Bool", "bool", "true or false", to_bool, lambda value: struct.pack("<i", value), _unpack_bool, "&bool&."
)
INT = PropertyType("Int", "integer", "an integer", to_int, *_number("i"), "&int&.")
LONG = PropertyType("Long", "integer", "an integer of 64 bits", _to_long, *_number("q"), "&lng&.")
HANDLE = PropertyType("Handle", "integer", "a handle", to_int, *_number("q"), "&han&.")
FLOAT = PropertyType("Float", "float", "a number", to_float, *_number("d"), "&dbl&.")
STRING = PropertyType("String", "text", "text", to_text, _to_utf8, _from_utf8, "&str&.")
BUFFER = PropertyType("Buffer", "text", "a string of bytes", to_bytes, bytes, bytes)
TABLE = PropertyType("Table", "table", "a table", _to_table, pack_table, unpack_table, "&tbl&.")
VECTOR2 = _floats("Vector2", "2 numbers", "&vect2&.", 2, "a table of 2 numbers")
VECTOR3 = _floats("Vector3", "x, y, z", "&vect3&.", 3, "a table of 3 numbers: x, y, z")
QUATERNION = _floats("Quaternion", "x, y, z, w", "&quat&.", 4, "a table of 4 numbers: x, y, z, w")
POSE = _floats(
    "Pose",
    "x, y, z, then the quaternion x, y, z, w",
    "&pose&.",
    7,
    "a table of 7 numbers: x, y, z, then a quaternion x, y, z, w",
)
COLOR = PropertyType("Color", "floats", "red, green, blue, 0 to 1", _colour, *_numbers("f"), "&col&.")
MATRIX = PropertyType(
    "Matrix", "matrix", "a matrix, a table of its rows", _to_rows, _pack_rows, _unpack_rows, "&mtrx&."
)
FLOAT_ARRAY = PropertyType("FloatArray", "floats", "numbers", to_list(to_float), *_numbers("d"), "&vect&.")
INT_ARRAY = PropertyType("IntArray", "integers", "integers", to_list(to_int), *_numbers("i"), "&ivect&.")
INT_ARRAY2 = PropertyType(
    "IntArray2",
    "integers",
    "2 integers",
    _exactly(2, to_int, "a table of 2 integers"),
    *_numbers("i"),
    "&ivect2&.",
)
HANDLE_ARRAY = PropertyType(
    "HandleArray", "integers", "handles", to_list(to_int), *_numbers("q"), "&hanvect&."
)
STRING_ARRAY = PropertyType(
    "StringArray", "texts", "texts", to_list(to_text), _pack_texts, _unpack_texts, "&strvect&."
)

TYPES: Mapping[str, PropertyType] = MappingProxyType(
    {
        each.name: each
        for each in (
            BOOL, INT, LONG, FLOAT, STRING, BUFFER, TABLE, VECTOR2, VECTOR3, QUATERNION, POSE, COLOR, MATRIX,
            FLOAT_ARRAY, INT_ARRAY, INT_ARRAY2, HANDLE, HANDLE_ARRAY, STRING_ARRAY,
        )
    }
)  # fmt: skip
"""All types by name."""

BY_TAG: Mapping[str, PropertyType] = MappingProxyType({each.tag: each for each in TYPES.values()})
"""All types by their tags."""

_BIGGEST_INT = 1 << 31


def type_of(value: Any) -> PropertyType:
    """Return the type that a script's value has where nothing else defines one.

    Raises TypeError: no property holds such a value.
    """
    match value:
        case bool():
            return BOOL
        case int():
            return INT if -_BIGGEST_INT <= value < _BIGGEST_INT else LONG
        case float():
            return FLOAT
        case bytes() | str():
            return STRING if _is_text(to_bytes(value)) else BUFFER
        case list() | dict():
            return TABLE
        case _:
            raise TypeError("a boolean, a number, a string or a table")


def _is_text(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return b"\0" not in data
