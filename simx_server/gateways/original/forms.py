"""Read arguments from payloads, and write results into payloads, in the forms of `original_wire.py`.

Payloads come from outside: whatever does not fit is an `Unreadable`, before much memory is used.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from typing import Any, cast

_INT = struct.Struct("<i")
_FLOAT = struct.Struct("<f")
_COUNTS = struct.Struct("<4i")

DEFAULT_NUMBER, DEFAULT_PLACE = -5.0, 98765
"""A colour that starts below the first number, or a place that starts with the second, means the default."""

_COLOURS = 12
_TEXT_ENCODING = "utf-8", "surrogateescape"


class Unreadable(ValueError):
    """The payload of a request does not have the form of its command."""


class Reader:
    """The bytes of a payload, read from the front."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._position = 0

    @property
    def left(self) -> int:
        """Return how many bytes are unread."""
        return len(self._data) - self._position

    def take(self, size: int) -> bytes:
        """Return the next bytes. Raises Unreadable if there are fewer."""
        if not 0 <= size <= self.left:
            raise Unreadable(f"its payload ends {size - self.left} bytes too early")
        begin = self._position
        self._position = begin + size
        return self._data[begin : self._position]

    def text(self) -> str:
        """Return the text up to the next zero byte. Raises Unreadable without one."""
        end = self._data.find(b"\0", self._position)
        if end < 0:
            raise Unreadable("a text of its payload has no end")
        text = self.take(end - self._position).decode(*_TEXT_ENCODING)
        self._position += 1
        return text

    def int(self) -> int:
        """Return an int32."""
        return _INT.unpack(self.take(4))[0]

    def numbers(self, count: int, letter: str) -> list[Any]:
        """Return a number of int32 (``i``) or float32 (``f``)."""
        return list(struct.unpack(f"<{count}{letter}", self.take(4 * count)))


def read(reader: Reader, form: str) -> list[Any]:
    """Return the arguments of one form: one value, or four of ``lists``. Raises Unreadable."""
    if form == "lists":
        ints, floats, texts, size = _COUNTS.unpack(reader.take(_COUNTS.size))
        found = [reader.numbers(ints, "i"), reader.numbers(floats, "f"), _texts(reader, texts)]
        return [*found, reader.take(size)]
    reading = _READ.get(form)
    return [_vector(reader, form) if reading is None else reading(reader)]


def _texts(reader: Reader, count: int) -> list[str]:
    if not 0 <= count <= reader.left:
        raise Unreadable(f"its payload cannot hold {count} texts")
    return [reader.text() for _ in range(count)]


def _ints_to_the_end(reader: Reader) -> list[int]:
    return reader.numbers(reader.left // 4, "i")


def _colour(reader: Reader) -> list[int] | None:
    is_given = reader.take(1)[0]
    colours = list(reader.take(min(reader.left, _COLOURS)))
    return colours if is_given and len(colours) == _COLOURS else None


_READ: dict[str, Callable[[Reader], Any]] = {
    "i": Reader.int,
    "b": lambda reader: reader.take(1)[0],
    "f": lambda reader: _FLOAT.unpack(reader.take(4))[0],
    "z": Reader.text,
    "z?": lambda reader: reader.text() if reader.left else None,
    "*": lambda reader: reader.take(reader.left),
    "*i": _ints_to_the_end,
    "colour": _colour,
}

_VECTOR = re.compile(r"(\d+)([if])(\??)")


def _vector(reader: Reader, form: str) -> list[Any] | None:
    count, letter, is_optional = _parts(form)
    values = reader.numbers(count, letter)
    if is_optional and (values[0] < DEFAULT_NUMBER if letter == "f" else values[0] == DEFAULT_PLACE):
        return None
    return values


def _parts(form: str) -> tuple[int, str, bool]:
    match = _VECTOR.fullmatch(form)
    assert match is not None, form
    return int(match[1]), match[2], bool(match[3])


def write(forms: Sequence[str], values: Sequence[Any]) -> bytes:
    """Return the payload of a reply.

    Args:
        forms: of each result, or one form for several (``lists``, ``group``).
        values: the results, as the server gives them.

    Raises:
        ValueError, TypeError, OverflowError, struct.error: a result does not fit its form.
    """
    if forms in (("lists",), ("group",)):
        return _lists(*values) if forms[0] == "lists" else _group(*values)
    return b"".join(
        _WRITE.get(form, _numbers)(form, value) for form, value in zip(forms, values, strict=True)
    )


def _numbers(form: str, value: Any) -> bytes:
    count, letter, _ = _parts(form)
    return _array(letter, value, count)


def _array(letter: str, values: Sequence[Any], count: int | None = None) -> bytes:
    return struct.pack(f"<{len(values) if count is None else count}{letter}", *values)


def _text(value: str) -> bytes:
    return value.partition("\0")[0].encode(*_TEXT_ENCODING) + b"\0"


def _sizes(_: str, packets: Sequence[Sequence[float]]) -> bytes:
    parts = [_INT.pack(len(packets)), _array("i", [len(packet) for packet in packets])]
    return b"".join([*parts, *(_array("f", packet) for packet in packets)])


def _counted_texts(texts: Sequence[str]) -> bytes:
    return b"".join(map(_text, texts))


def _lists(ints: Sequence[int], floats: Sequence[float], texts: Sequence[str], data: bytes) -> bytes:
    counts = _COUNTS.pack(len(ints), len(floats), len(texts), len(data))
    return b"".join((counts, _array("i", ints), _array("f", floats), _counted_texts(texts), data))


def _group(
    handles: Sequence[int], ints: Sequence[int], floats: Sequence[float], texts: Sequence[str]
) -> bytes:
    counts = _COUNTS.pack(len(handles), len(ints), len(floats), len(texts))
    return b"".join(
        (counts, _array("i", handles), _array("i", ints), _array("f", floats), _counted_texts(texts))
    )


def _counted_ints(_: str, values: Sequence[int]) -> bytes:
    return _INT.pack(len(values)) + _array("i", values)


_WRITE: dict[str, Callable[[str, Any], bytes]] = {
    "i": lambda _, value: _INT.pack(value),
    "b": lambda _, value: bytes((int(value) & 0xFF,)),
    "f": lambda _, value: _FLOAT.pack(value),
    "z": lambda _, value: _text(value),
    "*": lambda _, value: bytes(cast(bytes, value)),
    "n*i": _counted_ints,
    "n*z": lambda _, value: _INT.pack(len(value)) + _counted_texts(value),
    "sizes": _sizes,
}
