"""Messages to bytes and back. Bytes from outside may be hostile: this module raises only CodecError for them."""

from __future__ import annotations

import math
import struct
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, cast

import msgpack

from .messages import Batch, Call, Delivery, Greeting, Reply, Status, Welcome, of_fields
from .python.garbage import no_collections

MAX_MESSAGE = 256 << 20
"""Maximum size of a decoded message in bytes."""

MAX_BATCH = 128 << 20
"""Maximum size of a client's batch of calls in bytes; servers read nothing larger."""

MOST_VALUES = 2_000_000
"""Maximum number of values in one message, with those of nested lists: a byte can become an object of sixty
bytes, and they take up to 0.1 us each to read."""

_MOST_REPLIED = 2 * MOST_VALUES
"""The same of a message of a server, which may answer several large calls at once."""

_COLLECTION = 8
"""Values that a list or a map counts in addition to its content, since it takes as long to read."""

_MOST_MEMBERS = 1000
"""Maximum number of members of a map; no message contains one."""

_SMALL = 1 << 16
"""Size in bytes of a message whose values need not be counted."""

_BEYOND_FLOAT32 = (2.0 - 2.0**-24) * 2.0**127
"""Smallest number that rounds to more than the largest float32."""

_REPLY_HEAD = bytes((0x90 | len(Reply._fields),))
"""msgpack's header of a list of this number of items."""

_ONE_NUMBER = b"\x91\xca"
"""msgpack's header of a list of one float32."""

_BUFFER = 64 << 10
"""Size of each thread's buffer for packing in bytes."""


class CodecError(ValueError):
    """The bytes are not a valid message of the expected kind."""


def _plain(value: Any) -> Any:
    """Convert NumPy scalars and arrays to plain values."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"cannot send a {type(value).__name__}")


def encode(message: Batch | Delivery | Greeting | Welcome | Status | tuple[int, int, list[Any]]) -> bytes:
    """Pack a message: lists in field order, float32 numbers; infinity for numbers beyond their range, as in
    C."""
    try:
        return _pack(message)
    except OverflowError:
        return _pack(_in_range(message))


class _Packer(threading.local):
    """Packer of one thread: making one, with its buffer, takes longer than packing a call."""

    pack: Callable[[Any], bytes]

    def __init__(self) -> None:
        self.renew()

    def renew(self) -> None:
        """Free the buffer, which has the size of the largest message so far."""
        self.pack = msgpack.Packer(
            use_single_float=True, unicode_errors="surrogateescape", default=_plain, buf_size=_BUFFER
        ).pack


_PACKER = _Packer()


def _pack(message: Any) -> bytes:
    packed = _PACKER.pack(message)
    if len(packed) > _BUFFER:
        _PACKER.renew()
    return packed


def pack_answer(status: int, time_ms: int, values: list[Any]) -> bytes:
    """Pack a reply without its id, once for all its receivers."""
    return encode((status, time_ms, values))[1:]


def answer_packer(status: int, time_ms: int) -> Callable[[list[Any]], bytes]:
    """Return `pack_answer` for many answers that differ only in their values; for immediate use on this
    thread."""
    head = pack_answer(status, time_ms, [])[:-1]
    pack = _PACKER.pack

    def packed(values: list[Any]) -> bytes:
        try:
            made = pack(values)
        except OverflowError:
            return pack_answer(status, time_ms, values)
        if len(made) > _BUFFER:
            _PACKER.renew()
        return head + made

    return packed


def pack_reply_head(call_id: int) -> bytes:
    """Pack the head that completes a packed answer to a reply."""
    return _REPLY_HEAD + _pack(call_id)


class NumberPacker:
    """Packs replies of one number each, whose ids stay the same, by one call."""

    __slots__ = ("_form", "_heads", "_items", "_length")

    def __init__(self, call_ids: Iterable[int]) -> None:
        self._heads = [pack_reply_head(call_id) for call_id in call_ids]
        self._length = -1
        """Length of what is between the head and the number of a reply, in `_form`."""

        self._form = struct.Struct("")
        self._items: list[Any] = [item for head in self._heads for item in (head, b"", 0.0)]

    def pack(self, status: int, time_ms: int, numbers: Sequence[float]) -> bytes:
        """Return the replies with these numbers, as they travel."""
        answer = _PACKER.pack((status, time_ms))[1:] + _ONE_NUMBER
        if len(answer) != self._length:
            self._length = len(answer)
            self._form = struct.Struct(">" + "".join(f"{len(head)}s{len(answer)}sf" for head in self._heads))
        items = self._items
        items[1::3] = [answer] * len(numbers)
        items[2::3] = numbers
        try:
            return self._form.pack(*items)
        except OverflowError:
            items[2::3] = _in_range(numbers)
            return self._form.pack(*items)


def as_sent(value: Any) -> Any:
    """Return a value as the receiver of a message would get it."""
    try:
        packed = _pack(value)
    except OverflowError:
        packed = _pack(_in_range(value))
    return msgpack.unpackb(packed, unicode_errors="surrogateescape", strict_map_key=True)


def encode_delivery(empty: Delivery, replies: bytes, count: int) -> bytes:
    """Pack a delivery.

    Args:
        empty: the delivery without replies.
        replies: packed replies, one after the other.
        count: number of replies.
    """
    begin = _pack(empty)[:-1]
    if count < 16:
        return begin + bytes((0x90 | count,)) + replies
    return begin + b"\xdd" + count.to_bytes(4, "big") + replies


def _in_range(value: Any) -> Any:
    """Return a message with infinity for every number beyond float32."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_in_range(each) for each in cast(list[Any], value)]
    if isinstance(value, dict):
        return {name: _in_range(each) for name, each in cast(dict[Any, Any], value).items()}
    if isinstance(value, float) and math.isfinite(value) and abs(value) >= _BEYOND_FLOAT32:
        return math.copysign(math.inf, value)
    return value


def _unpack(payload: bytes, most: int = MOST_VALUES) -> list[Any]:
    if len(payload) > MAX_MESSAGE:
        raise CodecError(f"message of {len(payload)} bytes; at most {MAX_MESSAGE} are read")
    try:
        if len(payload) <= _SMALL:
            value = _read(payload)
        else:
            with no_collections():
                value = _read(payload, **_bounded(most))
    except Exception as error:  # msgpack raises many types, all with the same meaning here
        raise CodecError(f"not a message: {error}") from None
    if value.__class__ is not list:
        raise CodecError(f"not a message: a {type(value).__name__} instead of a list")
    return value


def _refuse_extension(_code: int, _data: bytes) -> Any:
    raise CodecError("extension types of msgpack have no meaning here")


_read: Callable[..., Any] = partial(
    cast(Any, msgpack.unpackb),
    unicode_errors="surrogateescape",
    strict_map_key=True,
    ext_hook=_refuse_extension,
    timestamp=1,  # times are numbers: an object for each takes long
)
"""Unpacks bytes."""


def _bounded(most: int) -> dict[str, Any]:
    """Return options for unpacking that stop it at too many values, before they fill the memory."""
    left = most

    def count(values: Any) -> Any:
        nonlocal left
        left -= len(values) + _COLLECTION
        if left < 0:
            raise CodecError(f"more than {most} values; send less at a time")
        return values

    return {
        "list_hook": count,
        "object_hook": count,
        "max_array_len": most,
        "max_map_len": _MOST_MEMBERS,
    }


_FIELD_TYPES: dict[type[Any], tuple[type, ...]] = {
    Batch: (int, int, list),
    Call: (int, int, int, str, list),
    Delivery: (int, int, int, int, int, list),
    Reply: (int, int, int, list),
    Greeting: (int, str, str, int, int),
    Welcome: (int, str, str, str, str, str),
    Status: (int, str, str, str, int, list, str, int, float, float, float, str),
}
"""Types of each message's fields, in order; one comparison checks them all, since every call is decoded here.
"""

_BATCH, _CALL, _DELIVERY, _REPLY = (_FIELD_TYPES[kind] for kind in (Batch, Call, Delivery, Reply))


def _wrong(kind: type[Any], value: Any) -> CodecError:
    """Return the error for a value that does not have the fields of this message."""
    names = kind._fields
    if not isinstance(value, list) or len(cast(list[Any], value)) != len(names):
        return CodecError(f"a {kind.__name__} has {len(names)} fields ({', '.join(names)})")
    for name, item, expected in zip(names, cast(list[Any], value), _FIELD_TYPES[kind], strict=True):
        if type(item) is not expected:
            return CodecError(
                f"{kind.__name__}.{name} must be {expected.__name__}, got {type(item).__name__}"
            )
    raise AssertionError(f"this {kind.__name__} is right")


def _each(kind: type[Any], types: tuple[type, ...], items: list[Any]) -> list[Any]:
    """Return the messages inside a message."""
    found: list[Any] = []
    for item in items:
        if item.__class__ is not list or tuple(map(type, item)) != types:
            raise _wrong(kind, item)
        found.append(of_fields(kind, item))
    return found


def decode_batch(payload: bytes) -> Batch:
    """Unpack and check a client's batch; arguments are checked later, against the table."""
    value = _unpack(payload)
    if tuple(map(type, value)) != _BATCH:
        raise _wrong(Batch, value)
    value[2] = _each(Call, _CALL, value[2])
    return of_fields(Batch, value)


def decode_callers(payload: bytes, most: int) -> tuple[int, int, list[int]]:
    """Return message id, client time and the ids of the first `most` calls of a batch that is too large to be
    unpacked.

    Nothing else is kept, so this takes no memory. Raises CodecError.
    """
    unpacker: Any = msgpack.Unpacker(max_buffer_size=max(1, len(payload)))
    try:
        unpacker.feed(payload)
        if unpacker.read_array_header() != len(_BATCH):
            raise CodecError("not a batch of calls")
        head: tuple[Any, Any] = (unpacker.unpack(), unpacker.unpack())
        found: list[Any] = []
        for _ in range(min(most, unpacker.read_array_header())):
            if unpacker.read_array_header() != len(_CALL):
                raise CodecError("not a batch of calls")
            found.append(unpacker.unpack())
            for _ in _CALL[1:]:
                unpacker.skip()
    except msgpack.OutOfData:
        raise CodecError("the message is cut off") from None
    except Exception as error:
        raise CodecError(f"not a message: {error}") from None
    if any(type(number) is not int for number in (*head, *found)):
        raise CodecError("not a batch of calls")
    return *head, found


def decode_delivery(payload: bytes) -> Delivery:
    """Unpack and check a server's delivery."""
    value = _unpack(payload, _MOST_REPLIED)
    if tuple(map(type, value)) != _DELIVERY:
        raise _wrong(Delivery, value)
    value[5] = _each(Reply, _REPLY, value[5])
    return of_fields(Delivery, value)


def decode_greeting(payload: bytes) -> Greeting:
    """Unpack and check the first message of a client; a newer version may have more fields."""
    value = _unpack(payload)[: len(Greeting._fields)]
    if len(value) == len(Greeting._fields) - 1:  # of versions with one protocol version
        value.append(value[0])
    if tuple(map(type, value)) != _FIELD_TYPES[Greeting]:
        raise _wrong(Greeting, value)
    return Greeting._make(value)


def decode_welcome(payload: bytes) -> Welcome:
    """Unpack and check the server's answer to a greeting; a newer version may have more fields."""
    value = _unpack(payload)[: len(Welcome._fields)]
    if len(value) == len(Welcome._fields) - 1:  # of servers without a socket
        value.append("")
    if tuple(map(type, value)) != _FIELD_TYPES[Welcome]:
        raise _wrong(Welcome, value)
    return Welcome._make(value)


def decode_status(payload: bytes) -> Status:
    """Unpack and check a server's status; a newer version may have more fields."""
    value = _unpack(payload)[: len(Status._fields)]
    if tuple(map(type, value)) != _FIELD_TYPES[Status]:
        raise _wrong(Status, value)
    return Status._make(value)
