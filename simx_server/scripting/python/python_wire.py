"""Messages between the server and the process of one Python script: standard library only, both sides use it.

A message is a list of plain values whose first item is its type. On the wire: the lengths of text and bytes as two
little-endian uint32, a JSON text, then all byte strings in sequence. In the text a byte string is ``{"b": [offset,
length]}``, a long text ``{"s": [offset, length]}``, many numbers ``{"n": [offset, length, kind, shape]}``, a dict
``{"d": [[key, value], ...]}``, so that keys (str, int) keep their types, and a function of the script ``{"f":
number}``. The format is JSON because Python implements both directions in C, and because reading it runs no code: the
script's side is not trusted.

The server reads a text in one piece and answers no client meanwhile. So messages of a script contain little text: its
long lists of numbers, also rectangular lists of lists, are arrays of double or int64 among the bytes.
"""

from __future__ import annotations

import json
import math
import struct
from array import array
from collections.abc import Callable
from itertools import chain
from typing import Any

HEADER = struct.Struct("<II")

MAX_LENGTH = 64 << 20
"""Bytes of one message: four images of the maximum size; a script must not make the server allocate more."""

MAX_TEXT = 256 << 10
"""Bytes of JSON in a message of a script; the server reads the worst of them in 0.2 s."""

MAX_NUMBERS = 1 << 20
"""Numbers in arrays of one message of a script; each list within a list counts for 16 of them."""

_LONG, _LONG_TEXT = 64, 1024
"""Length from which a list is sent as an array, and a text as bytes."""

_MANY = 8
"""Number of inner lists from which they are processed together."""

_SHORT = {float, int, bool, type(None)}

_LARGEST_KEY = (1 << 63) - 1
"""Limit of the keys of a dict: thousands of larger numbers may have the same hash, and such a dict takes seconds to
build.
"""

Value = None | bool | int | float | str | bytes | list[Any] | tuple[Any, ...] | dict[Any, Any]
"""A value that travels as it is, or a list or dict of such values."""

_KINDS = {float: "d", int: "q"}

MAX_DEPTH = 16
"""Nesting of lists and dicts; the script's side refuses deeper values with a text for the author."""


class WireError(ValueError):
    """The other side sent data that a correct side never sends."""


class Packer:
    """Converts messages to bytes."""

    def __init__(
        self, number_of: Callable[[Any], int], max_text: int = MAX_LENGTH, max_numbers: int = MAX_LENGTH
    ) -> None:
        """Create a converter of messages to bytes.

        Args:
            number_of: returns the number of a function of the script; TypeError for anything else.
            max_text: bytes of JSON in one message.
            max_numbers: numbers in its arrays.
        """
        self._number_of = number_of
        self._max_text, self._max_numbers = max_text, max_numbers
        self._blobs: list[bytes] = []
        self._used = self._numbers_left = 0
        self._encode = json.JSONEncoder(
            separators=(",", ":"), check_circular=False, default=self._default
        ).encode

    def pack(self, message: list[Any]) -> bytes:
        """Return a message as bytes.

        Raises:
            TypeError: a value cannot be sent.
            ValueError: a value is too deep or too big.
        """
        self._blobs, self._used, self._numbers_left = [], 0, self._max_numbers
        text = self._encode(self._marked(message, MAX_DEPTH + 2)).encode()
        if len(text) + self._used > MAX_LENGTH:
            raise ValueError(f"more than {MAX_LENGTH >> 20} MiB cannot travel")
        if len(text) > self._max_text:
            raise ValueError(
                f"more than {self._max_text >> 10} KiB of texts and short lists cannot travel; a long list of numbers "
                "of one type, one array and one byte string are not counted"
            )
        return b"".join((HEADER.pack(len(text), self._used), text, *self._blobs))

    def _add(self, blob: bytes) -> list[Any]:
        self._blobs.append(blob)
        self._used += len(blob)
        return [self._used - len(blob), len(blob)]

    def _default(self, value: Any) -> Any:
        if isinstance(value, (bytes, bytearray, memoryview)):
            return {"b": self._add(bytes(value))}  # pyright: ignore[reportUnknownArgumentType]  # any items
        if hasattr(value, "tolist"):  # numbers and arrays of numpy, array.array
            plain: list[Any] | complex | str | bytes | None = value.tolist()
            return (isinstance(plain, list) and plain and self._numbers(plain)) or plain
        return {"f": self._number_of(value)}

    def _marked(self, value: Value, depth: int) -> Any:
        """Return the value with dicts as lists of their items, and numbers and long texts as bytes."""
        if isinstance(value, (list, tuple)):
            if depth == 0:
                raise ValueError("a list that is nested too deeply cannot travel")
            return (len(value) >= _MANY and self._numbers(value)) or [
                item
                if (
                    (kind := type(item)) in _SHORT  # pyright: ignore[reportUnknownVariableType]  # any item
                    or (kind is str and len(item) < _LONG_TEXT)
                )
                else self._marked(item, depth - 1)
                for item in value
            ]
        if isinstance(value, dict):
            return {"d": [[_key(key), self._marked(item, depth - 1)] for key, item in value.items()]}
        if isinstance(value, str) and len(value) >= _LONG_TEXT:
            return {"s": self._add(value.encode("utf-8", "surrogatepass"))}
        return value

    def _numbers(self, value: list[Any] | tuple[Any, ...]) -> Any:
        """Return a long list of numbers of one type, or of equally long such lists, as an array; else None."""
        if len(value) < _LONG and type(value[0]) not in (list, tuple):
            return None
        shape = [len(value)]
        while value and type(value[0]) in (list, tuple) and len(shape) < MAX_DEPTH:
            shape.append(len(value[0]))
            if (
                not shape[-1]
                or not set(map(type, value)) <= {list, tuple}
                or set(map(len, value)) != {shape[-1]}
            ):
                return None
            value = list(chain.from_iterable(value))
        if len(value) < _LONG or _cost(shape) > self._numbers_left:
            return None
        kinds = set(map(type, value))
        kind = _KINDS.get(kinds.pop()) if len(kinds) == 1 else None
        if kind is None:
            return None
        try:
            numbers = array(kind, value)
        except OverflowError:
            return None
        self._numbers_left -= _cost(shape)
        return {"n": [*self._add(numbers.tobytes()), kind, shape]}


def _cost(shape: list[int]) -> int:
    """Return the cost of an array: its numbers, and 16 for each list within a list."""
    return math.prod(shape) + 16 * sum(math.prod(shape[:end]) for end in range(1, len(shape)))


def _key(key: Any) -> str | int:
    number = key.tolist() if hasattr(key, "tolist") else key
    if isinstance(number, float) and number.is_integer():
        number = int(number)  # as in Lua, and to Python it is the same key
    if isinstance(number, int) and abs(number) > _LARGEST_KEY:
        raise TypeError("a dict with a number of more than 63 bits as a key cannot travel")
    if isinstance(number, str) or (isinstance(number, int) and not isinstance(number, bool)):
        return number
    raise TypeError(f"a dict with a {type(key).__name__} as a key cannot travel; keys are str or int")


class Unpacker:
    """Converts the body of a message back; every error of the other side is a `WireError`."""

    def __init__(
        self, function_of: Callable[[int], Any], max_text: int = MAX_LENGTH, max_numbers: int = MAX_LENGTH
    ) -> None:
        """Create a converter of bytes to messages.

        Args:
            function_of: returns the local object for the number of a function; KeyError or TypeError for a wrong
                one.
            max_text: bytes of JSON in one message.
            max_numbers: numbers in its arrays.
        """
        self._function_of = function_of
        self._max_text, self._max_numbers = max_text, max_numbers
        self._body = b""
        self._text_length = self._numbers_left = self._bytes_left = 0
        self._decode = json.JSONDecoder(object_hook=self._unmark).decode

    def lengths(self, header: bytes) -> tuple[int, int]:
        """Return the lengths of text and bytes."""
        text, blobs = HEADER.unpack(header)
        if text + blobs > MAX_LENGTH or text > self._max_text:
            raise WireError(f"a message of {text + blobs} bytes")
        return text, blobs

    def unpack(self, body: bytes, text_length: int) -> list[Any]:
        self._body, self._text_length = body, text_length
        self._numbers_left = self._max_numbers
        self._bytes_left = len(body) - text_length
        try:
            message: Value = self._decode(body[:text_length].decode())
        except (ValueError, TypeError, LookupError, ArithmeticError, RecursionError) as problem:
            raise WireError(f"an unreadable message: {type(problem).__name__}") from problem
        finally:
            self._body = b""
        if not isinstance(message, list) or not message or not isinstance(message[0], str):
            raise WireError("a message without a kind")
        return message

    def _unmark(self, marked: dict[str, Any]) -> Any:
        if "b" in marked:
            return self._blob(*marked["b"])
        if "s" in marked:
            return self._blob(*marked["s"]).decode("utf-8", "surrogatepass")
        if "n" in marked:
            return self._array(*marked["n"])
        if "f" in marked:
            return self._function_of(marked["f"])
        items = marked["d"]
        for key, _ in items:
            if type(key) is not str and (type(key) is not int or abs(key) > _LARGEST_KEY):
                raise TypeError("a key that no dict has here")
        return dict(items)

    def _blob(self, offset: int, length: int) -> bytes:
        start = self._text_length + offset
        self._bytes_left -= length  # bytes may not be used twice, or few bytes would become many
        if offset < 0 or length < 0 or start + length > len(self._body) or self._bytes_left < 0:
            raise ValueError("bytes outside the message")
        return self._body[start : start + length]

    def _array(self, offset: int, length: int, kind: str, shape: list[int]) -> list[Any]:
        if (
            kind not in _KINDS.values()
            or len(shape) > MAX_DEPTH
            or min(shape) < 1
            or math.prod(shape) * 8 != length
        ):
            raise ValueError("an array that no correct side sends")
        self._numbers_left -= _cost(shape)
        if self._numbers_left < 0:
            raise ValueError("too many numbers")
        numbers = array(kind, self._blob(offset, length)).tolist()
        for count in reversed(shape[1:]):
            numbers = [numbers[start : start + count] for start in range(0, len(numbers), count)]
        return numbers
