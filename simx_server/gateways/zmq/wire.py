"""Messages of the ZeroMQ remote API: CBOR maps (RFC 8949), bounded because a peer may send anything.

The reader is a separate one because general readers build objects for tags, and accept keys whose hashes collide.
"""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Callable
from sys import byteorder
from typing import Any, NamedTuple, cast

MAX_MESSAGE = 64 << 20
"""Bytes of one message; ZeroMQ closes the connection of a sender of more."""

MAX_DEPTH = 18
"""Nesting of lists and maps: that of scripts' values, within the list of arguments, within the message."""

MAX_ITEMS = 1 << 20
"""Values in one message; a list of float64 counts as one for each 64 numbers."""

LONGEST_NAME = 200
"""Characters of a function's name; a search for similar names would take long with a longer one."""

LONGEST_UUID = 64
"""Bytes of a client's identity; official clients send 36."""

_UUID = b"\x64uuid"
"""The key of the identity."""

_PLACES = 4
"""Places that are looked at: an argument may look like the key."""

EXECUTED = "_*executed*_"
END = "_*end*_"

EVAL = "zmqRemoteApi.eval"
"""Stands for the function of a message that has a piece of Lua, ``eval``, in place of a function."""

_LARGEST_KEY = (1 << 63) - 1
"""Thousands of larger numbers may have the same hash, and such a dict takes seconds to build."""

_FLOATS = re.compile(rb"(?:\xfb.{8}){16,}", re.DOTALL)
"""Many numbers of 64 bits, one after another."""

_NUMBERS_PER_ITEM = 64

_MANY = 16
"""Numbers from which they are read together."""

_SIZES = {24: 1, 25: 2, 26: 4, 27: 8}
_REALS = {25: struct.Struct(">e"), 26: struct.Struct(">f"), 27: struct.Struct(">d")}
_SIMPLE = {20: False, 21: True, 22: None, 23: None}
_INDEFINITE, _BREAK = 31, 0xFF
_BIG, _BIG_NEGATIVE = 2, 3


class WireError(ValueError):
    """A message that no correct client sends."""


class Request(NamedTuple):
    """One message of a client."""

    function: str
    arguments: list[Any]
    """None, bool, int, float, bytes (every string), list, dict with keys str or int."""

    language: str = ""
    """That of the client's program; empty in later messages."""


def read_request(payload: bytes) -> Request:
    """Return the content of a message.

    Raises:
        WireError: it cannot be read; the text is for the client.
    """
    try:
        message = Reader(payload).whole()
    except (struct.error, IndexError):
        raise WireError("the message ends within a value") from None
    if not isinstance(message, dict):
        raise WireError("the message must be a map with func and args")
    fields = cast(dict[Any, Any], message)
    function, arguments = fields.get("func"), fields.get("args", [])
    if not function and fields.get("eval"):
        function, arguments = EVAL.encode(), [fields["eval"]]
    if not isinstance(function, bytes) or len(function) > LONGEST_NAME:
        raise WireError(f"func must be a text of at most {LONGEST_NAME} bytes")
    if isinstance(arguments, dict) and not arguments:
        arguments = []  # an empty table of Lua
    if not isinstance(arguments, list):
        raise WireError("args must be a list")
    language = fields.get("lang")
    return Request(
        function.decode("utf-8", "replace"),
        cast(list[Any], arguments),
        language[:32].decode("utf-8", "replace") if isinstance(language, bytes) else "",
    )


def uuid_of(payload: bytes) -> str:
    """Return the identity in a message without reading the rest; empty if there is none that is valid.

    It stands behind the arguments, so the last place that looks like one counts.
    """
    place = len(payload)
    for _ in range(_PLACES):
        place = payload.rfind(_UUID, 0, place)
        if place < 0:
            break
        try:
            found = Reader(payload, place + len(_UUID)).item(0)
        except (WireError, struct.error, IndexError):
            continue
        if isinstance(found, bytes) and 0 < len(found) <= LONGEST_UUID:
            text = found.decode("ascii", "replace")
            return text if text.isprintable() and text.isascii() else ""
    return ""


class Reader:
    """Reads the values of one message."""

    __slots__ = ("_data", "_left", "_place")

    def __init__(self, data: bytes, place: int = 0) -> None:
        self._data = data
        self._place: int = place
        self._left = MAX_ITEMS

    def whole(self) -> Any:
        """Return the value that is the whole message. Raises WireError, struct.error or IndexError."""
        value = self.item(0)
        if self._place != len(self._data):
            raise WireError("the message goes on behind its map")
        return value

    def item(self, depth: int) -> Any:
        """Return the next value. Raises WireError, struct.error or IndexError."""
        data, place = self._data, self._place
        first = data[place]
        self._place = place = place + 1
        if first < 0x18:  # the most frequent ones first: a small number, a short text, a number of 64 bits
            return first
        if 0x60 <= first < 0x78:
            end = place + first - 0x60
            if end <= len(data):
                self._place = end
                return data[place:end]
        elif first == 0x78:
            self._place = place + 1
            return self._take(data[place])
        elif first == 0xFB:
            return self._simple(27)
        major, code = first >> 5, first & 31
        if major == 7:
            return self._simple(code)
        number = code if code < 24 else self._number(code)
        if number is None:
            return self._endless(major, depth)
        if major == 3 or major == 2:
            return self._take(number)
        if major < 2:
            return number if major == 0 else -1 - number
        if major == 4:
            return self._list(number, self._inner(depth))
        return self._map(number, self._inner(depth)) if major == 5 else self._tagged(number)

    def _endless(self, major: int, depth: int) -> Any:
        """Return a value whose length is not given."""
        if major in (2, 3):
            return self._pieces(major)
        if major in (4, 5):
            inner = self._inner(depth)
            return self._list(None, inner) if major == 4 else self._map(None, inner)
        raise WireError(f"no value at byte {self._place - 1}")

    def _count(self, items: int) -> None:
        self._left -= items
        if self._left < 0:
            raise _too_many()

    def _inner(self, depth: int) -> int:
        if depth >= MAX_DEPTH:
            raise WireError(f"lists and maps may be nested {MAX_DEPTH} levels deep")
        return depth + 1

    def _number(self, code: int) -> int | None:
        """Return a length or a number; None for a length that is not given."""
        if code == _INDEFINITE:
            return None
        size = _SIZES.get(code)
        if size is None:
            raise WireError(f"no value at byte {self._place - 1}")
        return int.from_bytes(self._take(size), "big")

    def _take(self, count: int) -> bytes:
        end = self._place + count
        if end > len(self._data):
            raise WireError(f"{count} bytes are announced at byte {self._place}, which are not there")
        taken = self._data[self._place : end]
        self._place = end
        return taken

    def _simple(self, code: int) -> Any:
        form = _REALS.get(code)
        if form is not None:
            (value,) = form.unpack_from(self._data, self._place)
            self._place += form.size
            return value
        if code not in _SIMPLE:
            raise WireError(f"a simple value {code} has no meaning here")
        return _SIMPLE[code]

    def _pieces(self, major: int) -> bytes:
        """Return a string that comes in pieces."""
        pieces: list[bytes] = []
        while not self._ends():
            first = self._data[self._place]
            self._place += 1
            self._count(1)
            size = first & 31 if first & 31 < 24 else self._number(first & 31)
            if first >> 5 != major or size is None:
                raise WireError("a piece of another kind in a string")
            pieces.append(self._take(size))
        return b"".join(pieces)

    def _list(self, count: int | None, depth: int) -> list[Any]:
        if count is not None and count < _MANY:
            self._count(count)
            return [self.item(depth) for _ in range(count)]
        values: list[Any] = []
        while not self._ends() if count is None else len(values) < count:
            left = _MANY if count is None else count - len(values)
            run = self._floats(left) if left >= _MANY else None
            if run is None:
                self._count(1)
                values.append(self.item(depth))
            else:
                values += run
        return values

    def _floats(self, left: int) -> list[float] | None:
        """Return the numbers of 64 bits that follow, if they are many; not more than are left in the list."""
        if self._data[self._place] != 0xFB:
            return None
        found = _FLOATS.match(self._data, self._place)
        if found is None:
            return None
        count = min(left, (found.end() - found.start()) // 9)
        self._count(1 + count // _NUMBERS_PER_ITEM)
        run = memoryview(self._data)[self._place : self._place + 9 * count]
        raw = bytearray(8 * count)
        for byte in range(8):  # without the head of each number
            raw[byte::8] = run[byte + 1 :: 9]
        numbers = array("d", bytes(raw))
        if byteorder == "little":
            numbers.byteswap()
        self._place += 9 * count
        return numbers.tolist()

    def _map(self, count: int | None, depth: int) -> dict[Any, Any]:
        values: dict[Any, Any] = {}
        if count is not None:
            self._count(2 * count)
            for _ in range(count):
                key = self._key(depth)
                values[key] = self.item(depth)
            return values
        while not self._ends():
            self._count(2)
            key = self._key(depth)
            values[key] = self.item(depth)
        return values

    def _key(self, depth: int) -> int | str:
        key = self.item(depth)
        if type(key) is bytes:
            return key.decode("utf-8", "surrogateescape")
        if isinstance(key, float) and key.is_integer():
            key = int(key)  # as in Lua
        if isinstance(key, int) and not isinstance(key, bool) and abs(key) <= _LARGEST_KEY:
            return key
        raise WireError("a key must be a text or a whole number of 64 bits")

    def _tagged(self, tag: int) -> int:
        """Return a number of more than 64 bits, the only value with a tag that is read."""
        if tag not in (_BIG, _BIG_NEGATIVE):
            raise WireError(f"tag {tag} has no meaning here")
        digits = self.item(MAX_DEPTH)
        if not isinstance(digits, bytes) or len(digits) > 128:
            raise WireError("a big number has at most 128 bytes")
        number = int.from_bytes(digits, "big")
        return number if tag == _BIG else -1 - number

    def _ends(self) -> bool:
        if self._data[self._place] == _BREAK:
            self._place += 1
            return True
        return False


def _too_many() -> WireError:
    return WireError(f"at most {MAX_ITEMS} values fit into one message")


def packer() -> Callable[[Any], bytes]:
    """Return the function that writes an answer. Raises ImportError: the extra ``zmq`` is missing."""
    from cbor2 import dumps

    def pack(value: Any) -> bytes:
        return dumps(value, default=_default)

    return pack


def _default(encoder: Any, value: Any) -> None:
    """Write what CBOR has no form for: numbers and arrays of numpy, and functions of scripts, which cannot travel."""
    encoder.encode(value.tolist() if hasattr(value, "tolist") else "<FUNCTION>")
