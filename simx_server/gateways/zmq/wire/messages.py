"""Messages of the ZeroMQ remote API: CBOR maps (RFC 8949), bounded because a peer may send anything.

The reader is a separate one because general readers build objects for tags, and accept keys whose hashes collide.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from sys import byteorder
from typing import Any, NamedTuple, cast

MAX_MESSAGE = 64 << 20
"""Bytes of one message; ZeroMQ closes the connection of a sender of more."""

MAX_DEPTH = 18
"""Nesting of lists and maps: that of scripts' values, within the list of arguments, within the message."""

MAX_ITEMS = 1 << 19
"""Values in one message, which take up to 0.4 us each to read. Collections count as more; of float64 in a row,
two count as one.
"""

LONGEST_NAME = 200
"""Characters of a function's name; a search for similar names would take long with a longer one."""

LONGEST_UUID = 64
"""Bytes of a client's identity; official clients send 36."""

LONGEST_LANGUAGE = 32
"""Bytes of the name of a client's language."""

_UUID, _LANGUAGE = b"\x64uuid", b"\x64lang"
"""The keys of the identity, and of the language of the client's program."""

_EDGE = 1024
"""Bytes at each end of a message in which these keys are looked for: only ``args`` may be long, and it stands on one
side of them.
"""

_PLACES = 4
"""Places of a key that are looked at in each end: an argument may look like the key."""

EXECUTED = "_*executed*_"
END = "_*end*_"

EVAL = "zmqRemoteApi.eval"
"""Stands for the function of a message that has a piece of Lua, ``eval``, in place of a function."""

_LARGEST_KEY = (1 << 63) - 1
"""Thousands of larger numbers may have the same hash, and such a dict takes seconds to build."""

_COLLECTION, _PIECE = 2, 1
"""Values that a list, a map or a text without a length, and a piece of such a text, count in addition to their
content.
"""

_FLOAT = b"\xfb"
"""The first byte of a number of 64 bits; eight follow."""

_MANY = 16
"""Numbers from which they are read together."""

_TO_LAST = 9 * (_MANY - 1)
"""Bytes from the first to the last of these."""

_TEXTS = frozenset(bytes((major << 5 | code,)) for major in (2, 3) for code in range(26))
"""First bytes of texts and bytes whose length, of less than 64 KB, is given."""

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


def read_request(payload: bytes) -> Request:
    """Return the content of a message.

    Raises:
        WireError: it cannot be read; the text is for the client.
    """
    message = Reader(payload).whole()
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
    return Request(function.decode("utf-8", "replace"), cast(list[Any], arguments))


def uuid_of(payload: bytes) -> str:
    """Return the identity in a message without reading the rest; empty if there is none that is valid."""
    return _short_text(payload, _UUID, LONGEST_UUID)


def language_of(payload: bytes) -> str:
    """Return the language of the client's program without reading the rest; empty if none is named."""
    return _short_text(payload, _LANGUAGE, LONGEST_LANGUAGE)


def _short_text(payload: bytes, key: bytes, longest: int) -> str:
    """Return the text of a key near the end or the start of a message; empty if there is none that is valid.

    Most clients put it behind the arguments, so the last place that looks like one counts.
    """
    for edge in (payload[-_EDGE:], payload[:_EDGE]):
        place = len(edge)
        for _ in range(_PLACES):
            place = edge.rfind(key, 0, place)
            if place < 0:
                break
            start = place + len(key)
            if edge[start : start + 1] not in _TEXTS:
                continue
            try:
                text = Reader(edge, start).item(0)[: longest + 1].decode("ascii", "replace")
            except (WireError, IndexError):
                continue
            if 0 < len(text) <= longest:
                return text if text.isprintable() and text.isascii() else ""
    return ""


class Reader:
    """Reads the values of one message."""

    __slots__ = ("_data", "_left", "place")

    def __init__(self, data: bytes, place: int = 0) -> None:
        self._data = data
        self.place: int = place
        """Where the next value starts."""

        self._left = MAX_ITEMS

    def whole(self) -> Any:
        """Return the value that is the whole message. Raises WireError."""
        try:
            value = self.item(0)
        except (struct.error, IndexError):
            raise WireError("the message ends within a value") from None
        if self.place != len(self._data):
            raise WireError("the message goes on behind its map")
        return value

    def item(self, depth: int) -> Any:
        """Return the next value. Raises WireError, struct.error or IndexError."""
        data, place = self._data, self.place
        first = data[place]
        self.place = place = place + 1
        if first < 0x18:  # the most frequent ones first: a small number, a short text, a number of 64 bits
            return first
        if 0x60 <= first < 0x78:
            end = place + first - 0x60
            if end <= len(data):
                self.place = end
                return data[place:end]
        elif first == 0x78:
            self.place = place + 1
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
        return self._map(number, self._inner(depth)) if major == 5 else self._tagged(number, depth)

    def _endless(self, major: int, depth: int) -> Any:
        """Return a value whose length is not given."""
        if major in (2, 3):
            return self._pieces(major)
        if major in (4, 5):
            inner = self._inner(depth)
            return self._list(None, inner) if major == 4 else self._map(None, inner)
        raise WireError(f"no value at byte {self.place - 1}")

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
            raise WireError(f"no value at byte {self.place - 1}")
        return int.from_bytes(self._take(size), "big")

    def _take(self, count: int) -> bytes:
        end = self.place + count
        if end > len(self._data):
            raise WireError(f"{count} bytes are announced at byte {self.place}, which are not there")
        taken = self._data[self.place : end]
        self.place = end
        return taken

    def _simple(self, code: int) -> Any:
        form = _REALS.get(code)
        if form is not None:
            (value,) = form.unpack_from(self._data, self.place)
            self.place += form.size
            return value
        if code not in _SIMPLE:
            raise WireError(f"a simple value {code} has no meaning here")
        return _SIMPLE[code]

    def _pieces(self, major: int) -> bytes:
        """Return a string that comes in pieces."""
        pieces: list[bytes] = []
        self._count(_COLLECTION)
        while not self._ends():
            first = self._data[self.place]
            self.place += 1
            self._count(1 + _PIECE)
            size = first & 31 if first & 31 < 24 else self._number(first & 31)
            if first >> 5 != major or size is None:
                raise WireError("a piece of another kind in a string")
            pieces.append(self._take(size))
        return b"".join(pieces)

    def _list(self, count: int | None, depth: int) -> list[Any]:
        if count is not None and count < _MANY:
            self._count(count + _COLLECTION)
            return [self.item(depth) for _ in range(count)]
        self._count(_COLLECTION)
        values: list[Any] = []
        data = self._data
        while not self._ends() if count is None else len(values) < count:
            place, left = self.place, _MANY if count is None else count - len(values)
            last = place + _TO_LAST  # of many numbers; looked at first, since to count them takes longer
            if left < _MANY or data[place] != 0xFB or last >= len(data) or data[last] != 0xFB:
                self._count(1)
                values.append(self.item(depth))
                continue
            allowed = 2 * self._left + 2  # one more than may come
            run = self._run(allowed if count is None else min(left, allowed))
            if run < _MANY:
                self._count(run + 1)
                values += [self.item(depth) for _ in range(max(run, 1))]
            else:
                self._count(run // 2)
                values += self._floats(run)
        return values

    def _run(self, most: int) -> int:
        """Return how many numbers of 64 bits follow, at most `most`.

        Looks twice as far each time, so that it costs what it finds.
        """
        data, start, found, window = self._data, self.place, 0, _MANY
        most = min(most, (len(data) - start) // 9)
        while found < most:
            heads = data[start + 9 * found : start + 9 * min(found + window, most) : 9]
            same = len(heads) - len(heads.lstrip(_FLOAT))
            found += same
            if same < len(heads):
                break
            window *= 2
        return found

    def _floats(self, count: int) -> list[float]:
        """Return this number of numbers of 64 bits, which follow."""
        run = memoryview(self._data)[self.place : self.place + 9 * count]
        raw = bytearray(8 * count)
        for byte in range(8):  # without the head of each number
            raw[byte::8] = run[byte + 1 :: 9]
        numbers = array("d", bytes(raw))
        if byteorder == "little":
            numbers.byteswap()
        self.place += 9 * count
        return numbers.tolist()

    def _map(self, count: int | None, depth: int) -> dict[Any, Any]:
        values: dict[Any, Any] = {}
        self._count(_COLLECTION)
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
        if type(key) is str:
            return key
        if isinstance(key, float) and key.is_integer():
            key = int(key)  # as in Lua
        if isinstance(key, int) and not isinstance(key, bool) and abs(key) <= _LARGEST_KEY:
            return key
        raise WireError("a key must be a text or a whole number of 64 bits")

    def _tagged(self, tag: int, depth: int) -> Any:
        """Return a number of more than 64 bits, the only value with a tag that is read."""
        if tag not in (_BIG, _BIG_NEGATIVE):
            raise WireError(f"tag {tag} has no meaning here")
        is_text = (
            self._data[self.place : self.place + 1] in _TEXTS
        )  # another tag would have another one in it
        digits = Reader.item(self, MAX_DEPTH) if is_text else None
        if not isinstance(digits, bytes) or len(digits) > 128:
            raise WireError("a big number has at most 128 bytes")
        number = int.from_bytes(digits, "big")
        return number if tag == _BIG else -1 - number

    def _ends(self) -> bool:
        if self._data[self.place] == _BREAK:
            self.place += 1
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
