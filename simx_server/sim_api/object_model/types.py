"""The types of API 2's properties that API 1 lacks: matrices, colours with alpha, enumerations; and their numbers."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import cache, partial
from types import MappingProxyType
from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import to_int
from simx_server.scripting.conversion.strings import with_texts
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.property_types import PropertyType

from .enumerations import number_of
from .values import Color, Matrix, Pose, Quaternion, Ref, to_color, to_matrix


class _ColorType(PropertyType):
    """API 1's type of the name is 10: three numbers."""

    @property
    def number(self) -> int:
        return 26


MATRIX = PropertyType(
    "Matrix",
    t.MATRIX.family,
    "a matrix",
    to_matrix,
    lambda value: t.MATRIX.encode(value.in_rows()),
    lambda data: to_matrix(t.MATRIX.decode(data)),
)
COLOR = _ColorType(
    "Color",
    "color",
    "red, green, blue, alpha, 0 to 255",
    to_color,
    lambda value: struct.pack("<3f", *value.parts),
    lambda data: Color.of(struct.unpack("<3f", data)),
    t.COLOR.tag,
)


class _ReferenceType(PropertyType):
    """API 1 has no objects but handles."""

    @property
    def number(self) -> int:
        return _REFERENCES[self.name]


_REFERENCES = {"Object": 224, "ObjectArray": 225, "ObjectMap": 226}


def _no_bytes(_value: Any) -> bytes:
    raise CommandError("objects have no bytes")


OBJECT, OBJECT_ARRAY, OBJECT_MAP = (
    _ReferenceType(name, name.lower(), what, lambda value: value, _no_bytes, lambda data: data)
    for name, what in (
        ("Object", "an object"),
        ("ObjectArray", "objects"),
        ("ObjectMap", "objects by handle"),
    )
)
"""The types of properties whose values are references (`Ref`), lists of them, and maps to them."""


def _to_item(enumeration: str, value: Any) -> int:
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    try:
        return number_of(enumeration, value if isinstance(value, str) else to_int(value))
    except CommandError as problem:
        raise TypeError(str(problem)) from None


class EnumType(PropertyType):
    """An integer of an enumeration."""

    enumeration = ""


@cache
def enum_of(enumeration: str) -> EnumType:
    """Return the type of the integers of an enumeration, which are set by name or number."""

    class Of(EnumType):
        pass

    Of.enumeration = enumeration
    return Of(
        "Enum",
        "integer",
        f"an item of {enumeration}",
        partial(_to_item, enumeration),
        t.INT.encode,
        t.INT.unpack,
    )


ENUM = EnumType("Enum", "integer", "an item of an enumeration", to_int, t.INT.encode, t.INT.unpack)
"""The type of the items of any enumeration."""

TYPES: Mapping[str, PropertyType] = MappingProxyType(
    {**t.TYPES, "Matrix": MATRIX, "Color": COLOR, "Enum": ENUM}
)
"""The types of API 2 by their names in ``getNAMEProperty``."""

BY_NUMBER: Mapping[int, PropertyType] = MappingProxyType(
    {**{each.number: each for each in TYPES.values()}, t.COLOR.number: COLOR}
)

MORE_NAMES: Mapping[int, str] = MappingProxyType(
    {17: "null", 19: "array", 20: "map", 24: "group", 26: "color", 224: "object", 225: "objectarray", 226: "objectmap",
     240: "method"}
)  # fmt: skip
"""Types that no property of a table has, by number."""


def presented(kind: PropertyType, value: Any) -> Any:
    """Return the value of a property of a type as API 2 has it."""
    if value is None:
        return None
    if kind is t.HANDLE:
        return Ref(value)
    if kind is t.HANDLE_ARRAY:
        return [Ref(each) for each in value]
    if kind in (t.VECTOR2, t.VECTOR3):
        return Matrix.vector(value)
    if kind is t.QUATERNION:
        return Quaternion(list(value))
    if kind is t.POSE:
        return Pose(list(value))
    if kind is t.COLOR:
        return Color.of(value)
    if kind is t.MATRIX:
        return to_matrix(value)
    if kind is t.TABLE:
        return with_texts(value)
    return value


def type_of(value: Any) -> PropertyType:
    """Return the type that a property made by a program gets from its value. Raises TypeError: none holds it."""
    match value:
        case Ref():
            return t.HANDLE
        case Matrix():
            return t.VECTOR3 if (value.rows, value.columns) == (3, 1) else t.MATRIX
        case Pose():
            return t.POSE
        case Quaternion():
            return t.QUATERNION
        case Color():
            return COLOR
        case bytes():
            return t.BUFFER
        case str():
            return t.STRING
        case [Ref(), *rest] if all(isinstance(each, Ref) for each in rest):
            return t.HANDLE_ARRAY
        case _:
            return t.type_of(value)
