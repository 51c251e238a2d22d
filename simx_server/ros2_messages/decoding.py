"""Read the CDR bytes of messages. All bytes are hostile: each count is checked against the bytes that are there.

`encoding.py` has the rules of CDR.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from .encoding import structs
from .errors import MessageError
from .layouts import Field, Layout, WideString
from .primitives import Primitive

MOST_BYTES = 64 << 20
"""Size of the largest message that is read: a colour image of 4,700 x 4,700 pixels."""

MOST_ITEMS = 100_000
"""Strings, arrays and messages within one message, with those within them. Each becomes an object of Python, much
larger than its bytes, in a microsecond.
"""

_BIG_ENDIAN = b"\x00\x00"
_LITTLE_ENDIAN = b"\x00\x01"
_LARGEST_UNIT = 0xFFFF
_MOST_PADDING = 7
"""Bytes after the last field, and for each empty sequence: ROS 2 counts their padding when it writes a message with
`serialize_message`, and leaves it at the end.
"""


class _Reader:
    """The bytes after the header, and how far they are read.

    Attributes:
        at: bytes read.
        spare: bytes that may be left after the last field.
        items: strings, arrays and messages that may still come.
    """

    __slots__ = ("at", "data", "items", "message", "spare")

    def __init__(self, message: str, data: memoryview) -> None:
        self.message = message
        self.data = data
        self.at = 0
        self.spare = _MOST_PADDING
        self.items = MOST_ITEMS

    def fail(self, field: str, why: str) -> MessageError:
        return MessageError(f"{self.message}: field {field}: {why}")

    def short(self, field: str) -> MessageError:
        return self.fail(field, f"the {len(self.data) + 4} bytes of the message end within it")

    def count(self, field: str) -> int:
        start = self.at + -self.at % 4
        if start + 4 > len(self.data):
            raise self.short(field)
        self.at = start + 4
        return int.from_bytes(self.data[start : start + 4], "little")

    def take(self, field: str, items: int) -> None:
        self.items -= items
        if self.items < 0:
            raise self.fail(
                field, f"the message has more than {MOST_ITEMS:,} strings, arrays and messages within it"
            )

    def text(self, field: str, longest: int = 0) -> str:
        size = self.count(field)
        end = self.at + size
        if end > len(self.data):
            raise self.fail(
                field, f"a string of {size} bytes does not fit into {len(self.data) - self.at} bytes"
            )
        if not size:
            return ""
        raw = bytes(self.data[self.at : end])
        self.at = end
        if raw[-1]:
            raise self.fail(field, "a string has no final NUL")
        try:
            text = raw[:-1].decode()
        except UnicodeDecodeError as error:
            raise self.fail(field, f"a string is not UTF-8: {error}") from None
        if longest and len(text) > longest:
            raise self.fail(field, f"a string has {len(text)} characters, and at most {longest} are valid")
        return text

    def wide_text(self, field: str, longest: int = 0) -> str:
        count = self.count(field)
        end = self.at + 4 * count
        if end > len(self.data):
            room = len(self.data) - self.at
            raise self.fail(field, f"a wide string of {count} units does not fit into {room} bytes")
        units = np.frombuffer(self.data, "<u4", count, self.at)
        self.at = end
        self.spare += 4  # ROS 2 counts a final NUL there
        if count and int(units.max()) > _LARGEST_UNIT:
            raise self.fail(field, "a wide string has a unit of more than 16 bits")
        try:
            text = units.astype("<u2").tobytes().decode("utf-16-le")
        except UnicodeDecodeError as error:
            raise self.fail(field, f"a wide string is not UTF-16: {error}") from None
        if longest and len(text) > longest:
            raise self.fail(field, f"a string has {len(text)} characters, and at most {longest} are valid")
        return text


_Step: TypeAlias = Callable[[_Reader, dict[str, Any]], None]
_Read: TypeAlias = Callable[[_Reader], dict[str, Any]]


class Decoders:
    """The reading functions of all layouts, each made when it is first needed."""

    def __init__(self) -> None:
        self._made: dict[str, _Read] = {}

    def decode(self, layout: Layout, data: bytes | bytearray | memoryview) -> dict[str, Any]:
        """Return the fields of a message; arrays of numbers are NumPy arrays.

        Raises:
            MessageError: the bytes are not a message of this layout.
        """
        view = memoryview(data)
        if len(view) > MOST_BYTES:
            raise MessageError(f"{layout.name}: {len(view):,} bytes are more than {MOST_BYTES:,}, the limit")
        if bytes(view[:2]) != _LITTLE_ENDIAN or len(view) < 4:
            raise MessageError(f"{layout.name}: {_wrong_header(bytes(view[:4]))}")
        reader = _Reader(layout.name, view[4:])
        found = self._of(layout)(reader)
        rest = len(reader.data) - reader.at
        if rest > reader.spare:
            raise MessageError(
                f"{layout.name}: {rest} bytes are left after the last field; the sender's definition is another one"
            )
        return found

    def _of(self, layout: Layout) -> _Read:
        if layout.name not in self._made:
            self._made[layout.name] = self._make(layout)
        return self._made[layout.name]

    def _make(self, layout: Layout) -> _Read:
        steps: list[_Step] = []
        plain: list[Field] = []
        for field in layout.fields:
            if isinstance(field.kind, Primitive) and field.count is None:
                plain.append(field)
                continue
            if plain:
                steps.append(_plain(plain))
                plain = []
            steps.append(self._step(field))
        if plain:
            steps.append(_plain(plain))
        if not layout.fields:
            steps.append(_skip_byte)

        def read(reader: _Reader) -> dict[str, Any]:
            found: dict[str, Any] = {}
            for step in steps:
                step(reader, found)
            return found

        return read

    def _step(self, field: Field) -> _Step:
        if isinstance(field.kind, Primitive):
            return _numbers(field.name, field.kind, field.count or 0, field.most)
        if isinstance(field.kind, Layout):
            read = self._of(field.kind)
            return (
                _single(field.name, read)
                if field.count is None
                else _several(field, read, 1, _objects(field.kind))
            )
        read_text = _Reader.wide_text if field.kind is WideString else _Reader.text

        def read_one(reader: _Reader) -> str:
            return read_text(reader, field.name, field.longest)

        return _single(field.name, read_one) if field.count is None else _several(field, read_one, 4, 1)


def _objects(layout: Layout) -> int:
    """Return how many objects one message becomes: itself and what is in it, without the items of its sequences."""
    return 1 + sum(
        _objects(field.kind) * (field.count or 1)
        if isinstance(field.kind, Layout) and field.count != 0
        else 1
        for field in layout.fields
        if not isinstance(field.kind, Primitive) or field.count is not None
    )


def _plain(fields: list[Field]) -> _Step:
    """Return the step for numbers that follow each other."""
    names = tuple(field.name for field in fields)
    forms = structs("".join(field.kind.letter for field in fields if isinstance(field.kind, Primitive)))

    def step(reader: _Reader, found: dict[str, Any]) -> None:
        form = forms[reader.at & 7]
        try:
            values = form.unpack_from(reader.data, reader.at)
        except struct.error:
            raise reader.short(names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}") from None
        reader.at += form.size
        found.update(zip(names, values, strict=True))

    return step


def _skip_byte(reader: _Reader, _found: dict[str, Any]) -> None:
    if reader.at >= len(reader.data):
        raise MessageError(f"{reader.message}: a message without fields has one byte, which is missing")
    reader.at += 1


def _single(name: str, read: Callable[[_Reader], Any]) -> _Step:
    def step(reader: _Reader, found: dict[str, Any]) -> None:
        found[name] = read(reader)

    return step


def _several(field: Field, read: Callable[[_Reader], Any], least: int, objects: int) -> _Step:
    """Return the step for strings or messages.

    Args:
        least: bytes that each of them has at least.
        objects: that each of them becomes at least.
    """
    name, fixed, most = field.name, field.count or 0, field.most

    def step(reader: _Reader, found: dict[str, Any]) -> None:
        count = fixed or reader.count(name)
        if most and count > most:
            raise reader.fail(name, f"it has {count} values, and at most {most} are valid")
        if count * least > len(reader.data) - reader.at:
            raise reader.fail(name, f"{count} values do not fit into {len(reader.data) - reader.at} bytes")
        reader.take(name, count * objects)
        found[name] = [read(reader) for _ in range(count)]

    return step


def _numbers(name: str, kind: Primitive, fixed: int, most: int) -> _Step:
    def step(reader: _Reader, found: dict[str, Any]) -> None:
        count = fixed or reader.count(name)
        if most and count > most:
            raise reader.fail(name, f"it has {count} values, and at most {most} are valid")
        if not count:
            found[name] = np.empty(0, kind.dtype)
            reader.spare += _MOST_PADDING
            return
        start = reader.at + -reader.at % kind.size
        size = count * kind.size
        if start + size > len(reader.data):
            room = max(len(reader.data) - start, 0)
            raise reader.fail(name, f"{count} values of {kind.name} do not fit into {room} bytes")
        found[name] = np.frombuffer(reader.data, kind.dtype, count, start)
        reader.at = start + size

    return step


def _wrong_header(header: bytes) -> str:
    if len(header) < 4:
        return f"{len(header)} bytes are less than the header of CDR, which has 4"
    if header[:2] == _BIG_ENDIAN:
        return "the bytes are big endian; this server reads little endian, 00 01 00 00"
    return f"the header {header.hex(' ')} is not that of CDR version 1, 00 01 00 00"
