"""Messages to bytes and back. Everything that arrives is hostile: the only error out of here is CodecError."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import msgpack

from .messages import Batch, Call, Delivery, Greeting, Reply, Welcome

MAX_MESSAGE = 256 << 20
"""Largest message in bytes that is decoded."""


class CodecError(ValueError):
    """These bytes are not the message they should be."""


def _plain(value: Any) -> Any:
    """Numpy scalars and arrays as what they hold."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"cannot send a {type(value).__name__}")


def encode(message: Batch | Delivery | Greeting | Welcome) -> bytes:
    """Pack a message: lists in field order, float32 numbers."""
    return msgpack.packb(message, use_single_float=True, unicode_errors="surrogateescape", default=_plain)


def _unpack(payload: bytes) -> list[Any]:
    if len(payload) > MAX_MESSAGE:
        raise CodecError(f"message of {len(payload)} bytes; at most {MAX_MESSAGE} are read")
    try:
        value = msgpack.unpackb(payload, unicode_errors="surrogateescape", strict_map_key=True)
    except Exception as error:  # msgpack raises many kinds, all of them mean the same here
        raise CodecError(f"not a message: {error}") from None
    if not isinstance(value, list):
        raise CodecError(f"not a message: a {type(value).__name__} instead of a list")
    return cast(list[Any], value)


def _fields(kind: type[Any], value: Any) -> list[Any]:
    names = kind._fields
    if not isinstance(value, list) or len(cast(list[Any], value)) != len(names):
        raise CodecError(f"a {kind.__name__} has {len(names)} fields ({', '.join(names)})")
    return cast(list[Any], value)


def _require(kind: type[Any], values: Iterable[Any], *types: type) -> None:
    for name, value, expected in zip(kind._fields, values, types, strict=True):
        if type(value) is not expected:
            raise CodecError(
                f"{kind.__name__}.{name} must be {expected.__name__}, got {type(value).__name__}"
            )


def decode_batch(payload: bytes) -> Batch:
    """Unpack and check what a client sent; arguments are checked later, against the table."""
    value = _fields(Batch, _unpack(payload))
    _require(Batch, value, int, int, list)
    calls: list[Call] = []
    for item in value[2]:
        _require(Call, _fields(Call, item), int, int, int, str, list)
        calls.append(Call._make(item))
    return Batch(value[0], value[1], calls)


def decode_delivery(payload: bytes) -> Delivery:
    """Unpack what a server sent."""
    value = _fields(Delivery, _unpack(payload))
    _require(Delivery, value, int, int, int, int, int, list)
    value[5] = [Reply._make(_fields(Reply, item)) for item in value[5]]
    return Delivery._make(value)


def decode_greeting(payload: bytes) -> Greeting:
    """Unpack and check the first message of a client; a newer version may have more fields."""
    value = _unpack(payload)[: len(Greeting._fields)]
    _require(Greeting, _fields(Greeting, value), int, str, str, int)
    return Greeting._make(value)


def decode_welcome(payload: bytes) -> Welcome:
    """Unpack and check the server's answer to a greeting; a newer version may have more fields."""
    value = _unpack(payload)[: len(Welcome._fields)]
    _require(Welcome, _fields(Welcome, value), int, str, str, str, str)
    return Welcome._make(value)
