"""CBOR (RFC 8949) for tables of scripts: ``sim.packTable`` with scheme 1 or 2.

A string becomes text if it is UTF-8 without control characters, else bytes, as in CoppeliaSim; the endings ``@:txt:``
and ``@:dat:`` force one of them.
"""

from __future__ import annotations

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import MAX_DEPTH, Plain

from .byte_reader import Damaged

_UNSIGNED, _NEGATIVE, _BYTES, _TEXT, _LIST, _MAP, _TAG, _SIMPLE = range(8)
_FALSE, _TRUE, _NULL, _UNDEFINED, _HALF, _SINGLE, _DOUBLE, _INDEFINITE = 20, 21, 22, 23, 25, 26, 27, 31
_BREAK = 0xFF
_AS_TEXT, _AS_BYTES = b"@:txt:", b"@:dat:"
_CONTROL = bytes(range(32))

MOST_PIECES = 600_000
"""Pieces of packed bytes: one or two for a value."""

_FEW = 64
"""Items of a list up to which each is packed alone."""

_LONGER_HEADS = [
    (24 + i, 1 << (8 << i), struct.Struct(f">B{letter}").pack) for i, letter in enumerate("BHIQ")
]
"""Of heads for numbers from 24: the code, the first number that is too large, the function that packs them."""

FUNCTION = b"<FUNCTION>"
"""Stands for a function, which cannot be packed."""


def in_order(table: dict[Any, Any]) -> list[Any]:
    """Return key, value, key, value ...: whole numbers first, then names, each in order."""
    names = sorted(key for key in table if isinstance(key, str))
    numbers = sorted(key for key in table if not isinstance(key, str))
    return [part for key in (*numbers, *names) for part in (key, table[key])]


def is_table(data: bytes) -> bool:
    """Return whether the first item is a list or a map, possibly behind tags."""
    place = 0
    while place < len(data) and data[place] >> 5 == _TAG:
        place += 1 + {24: 1, 25: 2, 26: 4, 27: 8}.get(data[place] & 31, 0)
    return place < len(data) and data[place] >> 5 in (_LIST, _MAP)


def encode(value: Plain, *, single: bool = False) -> bytes:
    """Return a value as CBOR; keys are in order, so equal values give equal bytes. `single`: floats as float32."""
    pieces: list[bytes] = []
    _add(pieces, value, single)
    return b"".join(pieces)


def decode(data: bytes) -> Any:
    """Return the first item of the bytes.

    Raises:
        Damaged: the bytes are not CBOR, or nested too deeply.
    """
    return _Decoder(data).item(0)


def _head(major: int, number: int) -> bytes:
    if number < 24:
        return bytes((major << 5 | number,))
    for code, most, pack in _LONGER_HEADS:
        if number < most:
            return pack(major << 5 | code, number)
    raise OverflowError(number)


def _add(pieces: list[bytes], value: Plain, single: bool) -> None:
    if isinstance(value, str):  # most values: each name is one
        value = value.encode("utf-8", "surrogateescape")
    match value:
        case bytes():
            pieces += _string(value)
        case None:
            pieces.append(_head(_SIMPLE, _NULL))
        case bool():
            pieces.append(_head(_SIMPLE, _TRUE if value else _FALSE))
        case int() if 0 <= value < 1 << 64:
            pieces.append(_head(_UNSIGNED, value))
        case int() if -(1 << 64) <= value < 0:
            pieces.append(_head(_NEGATIVE, -1 - value))
        case int() | float():
            pieces.append(_float(as_float(value), single))
        case list() | dict():
            _add_table(pieces, value, single)
        case _:
            pieces += _string(FUNCTION)


def _add_table(pieces: list[bytes], table: list[Any] | dict[Any, Any], single: bool) -> None:
    pieces.append(_head(_LIST if isinstance(table, list) else _MAP, len(table)))
    if isinstance(table, list) and not single and (numbers := as_floats(table)) is not None:
        pieces.append(headed(_SIMPLE << 5 | _DOUBLE, numbers, ">f8"))
        return
    for item in table if isinstance(table, list) else in_order(table):
        _add(pieces, item, single)
    check_room(pieces)


def as_float(number: float) -> float:
    """Return a number as a float. Raises CommandError: an integer, which Python does not limit, is too large."""
    try:
        return float(number)
    except OverflowError:
        raise CommandError("a whole number of a table is too large even for a float") from None


def as_floats(items: list[Any]) -> NDArray[np.float64] | None:
    """Return the items of a long list of floats; None for any other list."""
    is_long = len(items) > _FEW and set(map(type, items)) == {float}
    return np.array(items, np.float64) if is_long else None


def headed(head: int, numbers: NDArray[np.float64], form: str) -> bytes:
    """Return numbers as bytes, in a form of NumPy, each behind the same first byte."""
    found = np.empty(len(numbers), np.dtype([("head", "u1"), ("number", form)]))
    found["head"], found["number"] = head, numbers
    return found.tobytes()


def check_room(pieces: list[bytes]) -> None:
    """Raise CommandError: the packed values are too many."""
    if len(pieces) > MOST_PIECES:
        raise CommandError("the table has too many values to be packed; a table of floats may be longer")


def _float(value: float, single: bool) -> bytes:
    if not single:
        return struct.pack(">Bd", _SIMPLE << 5 | _DOUBLE, value)
    try:
        return struct.pack(">Bf", _SIMPLE << 5 | _SINGLE, value)
    except OverflowError:
        return struct.pack(">Bf", _SIMPLE << 5 | _SINGLE, math.copysign(math.inf, value))


def _string(value: bytes) -> list[bytes]:
    if value.endswith(_AS_BYTES):
        value, kind = value.removesuffix(_AS_BYTES), _BYTES
    elif value.endswith(_AS_TEXT):
        value, kind = value.removesuffix(_AS_TEXT), _TEXT
    else:
        kind = _TEXT if _is_text(value) else _BYTES
    return [_head(kind, len(value)), value]


def _is_text(value: bytes) -> bool:
    if value.translate(None, _CONTROL) != value:
        return False
    try:
        value.decode()
    except UnicodeDecodeError:
        return False
    return True


class _Decoder:
    def __init__(self, data: bytes) -> None:
        self._data = data
        self._place = 0

    def item(self, depth: int) -> Any:
        if depth > MAX_DEPTH:
            raise Damaged(f"its tables are nested more than {MAX_DEPTH} levels deep")
        first = self._take(">B")
        major, code = first >> 5, first & 31
        if major == _SIMPLE:
            return self._simple(code)
        number = self._number(code) if code != _INDEFINITE else None
        match major:
            case 0 if number is not None:
                return number
            case 1 if number is not None:
                return -1 - number
            case 2 | 3:
                return self._bytes(major, number)
            case 4:
                return [self.item(depth + 1) for _ in self._counted(number)]
            case 5:
                return {self._key(depth): self.item(depth + 1) for _ in self._counted(number)}
            case 6 if number is not None:
                return self.item(depth + 1)  # what a tag says about its item has no meaning for scripts
            case _:
                raise Damaged(f"no item of CBOR at byte {self._place - 1}")

    def _take(self, form: str) -> Any:
        try:
            (value,) = struct.unpack_from(form, self._data, self._place)
        except struct.error:
            raise Damaged(f"it ends at byte {len(self._data)} within a value") from None
        self._place += struct.calcsize(form)
        return value

    def _number(self, code: int) -> int:
        if code < 24:
            return code
        form = {24: ">B", 25: ">H", 26: ">I", 27: ">Q"}.get(code)
        if form is None:
            raise Damaged(f"no item of CBOR at byte {self._place - 1}")
        return int(self._take(form))

    def _simple(self, code: int) -> Any:
        match code:
            case 20 | 21:
                return code == _TRUE
            case 22 | 23:
                return None
            case 25:
                return self._take(">e")
            case 26:
                return self._take(">f")
            case 27:
                return self._take(">d")
            case _:
                raise Damaged(f"a simple value {code}, which has no meaning here")

    def _bytes(self, major: int, count: int | None) -> bytes:
        if count is None:
            pieces: list[bytes] = []
            while not self._ends():
                first = self._take(">B")
                if first >> 5 != major or first & 31 == _INDEFINITE:
                    raise Damaged(f"a piece of another kind in a string, at byte {self._place - 1}")
                pieces.append(self._bytes(major, self._number(first & 31)))
            return b"".join(pieces)
        if count > len(self._data) - self._place:
            raise Damaged(f"{count} bytes of text at byte {self._place}, which are not there")
        self._place += count
        return self._data[self._place - count : self._place]

    def _counted(self, count: int | None) -> Any:
        """Yield once for each item; an item has at least one byte, so a false number ends soon."""
        if count is None:
            while not self._ends():
                yield
        else:
            for _ in range(count):
                yield

    def _ends(self) -> bool:
        if self._place < len(self._data) and self._data[self._place] == _BREAK:
            self._place += 1
            return True
        return False

    def _key(self, depth: int) -> int | str:
        key = self.item(depth + 1)
        if isinstance(key, bytes):
            return key.decode("utf-8", "surrogateescape")
        if isinstance(key, float) and key.is_integer():
            return int(key)
        if isinstance(key, int) and not isinstance(key, bool):
            return key
        raise Damaged("a key that is neither text nor a whole number")
