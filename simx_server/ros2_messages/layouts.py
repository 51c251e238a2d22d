"""Layouts of messages: the fields in their order on the wire."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from .primitives import Primitive

Value: TypeAlias = bool | int | float | str


class WideString(str):
    """The kind of a string of 16-bit units (`wstring`), each of which is sent as a number of 32 bits."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message.

    Attributes:
        kind: a plain type, `str`, `WideString`, or the layout of another message.
        count: None for one value, 0 for a sequence of any length, else the length of an array.
        default: value of a field that is not set; a tuple of values for a sequence or an array, empty if the definition
            has none.
        most: the values that a sequence has at most; 0: any number.
        longest: the characters that a string has at most; 0: any number.
    """

    name: str
    kind: Kind
    count: int | None
    default: Value | tuple[Value, ...]
    most: int = 0
    longest: int = 0


@dataclass(frozen=True)
class Layout:
    """The fields of a message in their order on the wire.

    Attributes:
        name: such as `geometry_msgs/msg/Twist`.
        constants: values that the definition names.
    """

    name: str
    fields: tuple[Field, ...]
    constants: Mapping[str, Value]


Kind: TypeAlias = Primitive | type[str] | Layout
