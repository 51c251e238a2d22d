"""Input that arrives as bytes: every decoder of the codec, every kind of argument, keys, names of files.

`one` takes any bytes: the first says what is made of the rest, a raw message or one built of them value by value, as
random bytes are seldom a message.
"""

# ruff: noqa: E501 - long lines are lists of values and commands

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgpack

from simx_client.protocol import codec
from simx_client.protocol.kinds import KINDS
from simx_client.protocol.messages import Batch, Call, Delivery, Greeting, Reply, Status, Welcome
from simx_client.protocol.zenoh import keys
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.limits import LimitError, Limits, limit_text

DECODERS: tuple[tuple[Callable[[bytes], Any], type[Any]], ...] = (
    (codec.decode_batch, Batch),
    (codec.decode_delivery, Delivery),
    (codec.decode_greeting, Greeting),
    (codec.decode_welcome, Welcome),
    (codec.decode_status, Status),
)
MOST_CALLS = 1000

SEEDS: tuple[bytes, ...] = (
    b"\x00"
    + codec.encode(Batch(1, 2, [Call(3, 1, 0, "simxGetObjectHandle", ["arm"]), Call(4, 2, 0, "", [3])])),
    b"\x00" + codec.encode(Delivery(1, 2, 3, 4, 5, [Reply(6, 0, 50, [1, 0.5, b"abc", [1.0], None])])),
    b"\x00" + codec.encode(Greeting(1, "client", "name", 19997, 1)),
    b"\x00" + codec.encode(Welcome(1, "", "realm", "scene", "1.0")),
    b"\x00" + codec.encode(Status(1, "r", "s", "running", 1, [1], "h", 9, 0.5, 1.0, 0.1, "1.0")),
    b"\x01" + bytes(range(64)),
    b"\x02..//a\\b\0c",
    b"\x03simx-19997",
    b"\x04objects=500",
)


class Bytes:
    """Numbers and texts out of bytes, zeros when they are used up."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at = data, 0

    def take(self, count: int) -> bytes:
        taken = self._data[self._at : self._at + count]
        self._at += count
        return taken.ljust(count, b"\0")

    def number(self, below: int) -> int:
        return self.take(1)[0] % below

    @property
    def is_used_up(self) -> bool:
        return self._at >= len(self._data)


_NUMBERS = (0, 1, -1, 2**31 - 1, -(2**31), 2**31, 2**32, 2**63 - 1, 2**64 - 1, -(2**63))


def value(data: Bytes, depth: int = 0) -> Any:
    """Any value that a message can hold."""
    kind = data.number(14)
    if kind == 0:
        return None
    if kind == 1:
        return bool(data.number(2))
    if kind == 2:
        return _NUMBERS[data.number(len(_NUMBERS))]
    if kind == 3:
        return data.number(256)
    if kind in (4, 5):
        return struct.unpack("<d", data.take(8))[0]
    if kind == 6:
        return data.take(data.number(20))
    if kind in (7, 8):
        return data.take(data.number(20)).decode("utf-8", "surrogateescape")
    if kind == 9:
        return msgpack.ExtType(data.number(128), data.take(data.number(5)))
    if kind == 10 and depth < 4:
        return {str(data.number(9)): value(data, depth + 1) for _ in range(data.number(3))}
    if depth < 6 and not data.is_used_up:
        return [value(data, depth + 1) for _ in range(data.number(14))]
    return []


def _message(data: Bytes) -> Any:
    """Like a message of one of the kinds, with something else here and there."""
    kind = data.number(6)

    def field(right: Any) -> Any:
        return value(data) if data.number(12) == 0 else right

    def number() -> Any:
        return field(_NUMBERS[data.number(len(_NUMBERS))])

    if kind == 0:
        calls = [
            field([number(), number(), number(), field("simxGetObjects"), field([value(data)])])
            for _ in range(data.number(4))
        ]
        return [number(), number(), field(calls)]
    if kind == 1:
        replies = [field([number(), number(), number(), field([value(data)])]) for _ in range(data.number(4))]
        return [number(), number(), number(), number(), number(), field(replies)]
    if kind == 2:
        return [number(), field("client"), field("name"), number(), *([value(data)] * data.number(3))]
    if kind == 3:
        return [number(), *(field("text") for _ in range(4)), *([value(data)] * data.number(3))]
    if kind == 4:
        return [number(), *(field("t") for _ in range(3)), number(), field([1]), field("h"), number(), field(0.5), field(1.0), field(0.1), field("v")]  # fmt: skip
    return value(data)


def _packed(message: Any) -> bytes:
    return msgpack.packb(message, unicode_errors="surrogateescape")


def decode_all(payload: bytes) -> None:
    """Each decoder makes its message of it, which survives the way back, or raises CodecError."""
    for decode, kind in DECODERS:
        try:
            message = decode(payload)
        except codec.CodecError:
            continue
        assert type(message) is kind
        again = codec.encode(message)
        assert codec.encode(decode(again)) == again, message
        if kind is Batch:
            ids = [call.call_id for call in message.calls]
            assert codec.decode_callers(payload, MOST_CALLS) == (message.message_id, message.client_time, ids[:MOST_CALLS])  # fmt: skip
    with contextlib.suppress(codec.CodecError):
        codec.decode_callers(payload, MOST_CALLS)


def check_all(given: Any) -> None:
    """Each kind gives the value that a handler gets, or raises ValueError with a short text."""
    for kind in KINDS.values():
        try:
            kind.check(given)
        except ValueError as error:
            assert len(str(error)) < 500, len(str(error))  # noqa: PT017 - no test, but what tests call


def one(data: bytes, folder: Path = Path("/tmp")) -> None:
    """One case. Raises AssertionError, or what should not be raised."""
    how, rest = data[:1], data[1:]
    if how in (b"", b"\x00"):
        decode_all(rest)
    elif how == b"\x02":
        text = rest.decode("utf-8", "surrogateescape")
        try:
            path = workspace.path_within(folder, text)
        except CommandError:
            return
        assert path.is_relative_to(folder.resolve()), path
    elif how == b"\x03":
        try:
            chunk = keys.check_chunk(rest.decode("utf-8", "surrogateescape"))
        except ValueError:
            return
        for key in (keys.hello(chunk), keys.call(chunk, chunk), keys.image(chunk, chunk, 1)):
            assert keys.realm_of(key) == chunk
            assert not set(key) & set("*?#$ \n")
    elif how == b"\x04":
        try:
            text = limit_text(rest.decode("utf-8", "surrogateescape"))
        except LimitError:
            return
        assert Limits.of([text])
    elif how[0] % 2:
        decode_all(_packed(_message(Bytes(rest))))
    else:
        check_all(
            msgpack.unpackb(
                _packed(value(Bytes(rest))), unicode_errors="surrogateescape", strict_map_key=True
            )
        )
