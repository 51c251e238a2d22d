"""Messages between the server and the process of one Python script: standard library only, both sides use it.

A message is a list of plain values whose first item says what it is. On the wire: the lengths of text and bytes as two
little-endian uint32, a JSON text, then all byte strings one after the other. In the text a byte string is
``{"b": [offset, length]}``, a dict ``{"d": [[key, value], ...]}``, so that keys (str, int) keep their types, and a
function of the script ``{"f": number}``. JSON because both directions of it are C code in every Python, and because
reading it runs nothing: the script's side is not trusted.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any

HEADER = struct.Struct("<II")

MAX_LENGTH = 64 << 20
"""Bytes of one message: four pictures of the largest kind; a script must not make the server allocate more."""

MAX_DEPTH = 16
"""Nesting of lists and dicts; what a script sends deeper is refused there, with a text for its author."""


class WireError(ValueError):
    """The other side sent what no correct side sends."""


class Packer:
    """Turns messages into bytes. `number_of`: the number of a function of the script, TypeError for anything else."""

    def __init__(self, number_of: Callable[[Any], int]) -> None:
        self._number_of = number_of
        self._blobs: list[bytes] = []
        self._used = 0
        self._encode = json.JSONEncoder(
            separators=(",", ":"), check_circular=False, default=self._default
        ).encode

    def pack(self, message: list[Any]) -> bytes:
        """Raises TypeError for a value that cannot travel, ValueError for one that is too deep or too big."""
        self._blobs, self._used = [], 0
        text = self._encode(_marked(message, MAX_DEPTH + 2)).encode()
        if len(text) + self._used > MAX_LENGTH:
            raise ValueError(f"more than {MAX_LENGTH >> 20} MiB cannot travel")
        return b"".join((HEADER.pack(len(text), self._used), text, *self._blobs))

    def _default(self, value: Any) -> Any:
        if isinstance(value, (bytes, bytearray, memoryview)):
            blob = bytes(value)
            self._blobs.append(blob)
            self._used += len(blob)
            return {"b": [self._used - len(blob), len(blob)]}
        if hasattr(value, "tolist"):  # numbers and arrays of numpy, array.array
            return value.tolist()
        return {"f": self._number_of(value)}


def _marked(value: Any, depth: int) -> Any:
    """The same with dicts written as their items."""
    if isinstance(value, (list, tuple)):
        if depth == 0:
            raise ValueError("a list that is nested too deeply cannot travel")
        return [_marked(item, depth - 1) if isinstance(item, (list, tuple, dict)) else item for item in value]
    if isinstance(value, dict):
        return {"d": [[_key(key), _marked(item, depth - 1)] for key, item in value.items()]}
    return value


def _key(key: Any) -> str | int:
    number = key.tolist() if hasattr(key, "tolist") else key
    if isinstance(number, float) and number.is_integer():
        return int(number)  # as Lua has it, and to Python it is the same key
    if isinstance(number, str) or (isinstance(number, int) and not isinstance(number, bool)):
        return number
    raise TypeError(f"a dict with a {type(key).__name__} as a key cannot travel; keys are str or int")


class Unpacker:
    """Turns the body of a message back; every fault of the other side is a `WireError`."""

    def __init__(self, function_of: Callable[[int], Any]) -> None:
        """`function_of`: what stands here for the function of a number; KeyError or TypeError for a wrong one."""
        self._function_of = function_of
        self._body = b""
        self._text_length = 0
        self._decode = json.JSONDecoder(object_hook=self._unmark).decode

    @staticmethod
    def lengths(header: bytes) -> tuple[int, int]:
        """Lengths of text and bytes."""
        text, blobs = HEADER.unpack(header)
        if text + blobs > MAX_LENGTH:
            raise WireError(f"a message of {text + blobs} bytes")
        return text, blobs

    def unpack(self, body: bytes, text_length: int) -> list[Any]:
        self._body, self._text_length = body, text_length
        try:
            message = self._decode(body[:text_length].decode())
        except (ValueError, TypeError, KeyError, IndexError, RecursionError) as problem:
            raise WireError(f"an unreadable message: {type(problem).__name__}") from problem
        finally:
            self._body = b""
        if not isinstance(message, list) or not message or not isinstance(message[0], str):
            raise WireError("a message without a kind")
        return message

    def _unmark(self, marked: dict[str, Any]) -> Any:
        if "b" in marked:
            offset, length = marked["b"]
            start = self._text_length + offset
            if offset < 0 or length < 0 or start + length > len(self._body):
                raise ValueError("bytes outside the message")
            return self._body[start : start + length]
        if "f" in marked:
            return self._function_of(marked["f"])
        found = dict(marked["d"])
        if not all(type(key) in (str, int) for key in found):
            raise TypeError("a key that no dict has here")
        return found
