"""Types of arguments and results: how values are coerced, checked and handed out.

Meanings (``table/meanings.py``) refine them: an object's handle, a signal's name.

``coerce`` runs in the client and accepts everything that scripts are known to pass (numpy scalars,
arrays of shape (1,), bools for ints, ctypes arrays, tuples, rows). ``check`` runs in the server, where
every byte is hostile. ``fresh`` runs in the client on each fetch: results are changed in place by
scripts, so a stored value is never handed out twice. ``default`` makes the value of a slot when the
return code is not 0.

Numbers cross the boundary as int32 (wrapping) and float32 (the codec packs single precision), as the
original's did.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterable
from typing import Any, cast

from .python.light_dataclass import dataclass

MAX_ITEMS = 1_000_000
"""Longest list of numbers or texts that either side accepts."""

MAX_TEXT = 1 << 20
MAX_BYTES = 64 << 20
_FEW = 64
"""Items of a list up to which each is checked alone."""

_FLOAT32_MAX = 3.4028234663852886e38

apply = cast(Callable[[Callable[[Any], Any], Any], Any], operator.call)
"""Calls its first argument with its second. Mapped over checks and a call's arguments it takes half the time of a loop,
and each call passes here at both ends."""


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of value. ``annotation`` is its Python type in signatures and stubs."""

    name: str
    annotation: str
    default: Callable[[], Any]
    coerce: Callable[[Any], Any]
    check: Callable[[Any], Any]
    fresh: Callable[[Any], Any] | None = None
    """How a stored value is copied for the caller; None when the value cannot be changed in place."""

    meaning: str = ""
    length: int = 0
    """How many numbers a list must have; 0: any number of them."""

    is_image: bool = False
    """The pixels or depths of an image."""

    optional: Kind | None = None
    """The kind of its values that are not None, where None is valid too."""


def _scalar(value: Any) -> Any:
    """Return the element of an array of size 1, and any other value unchanged."""
    if getattr(value, "size", None) == 1 and hasattr(value, "item"):
        return value.item()
    return value


def to_int32(value: Any) -> int:
    """Coerce like a C int parameter: wraps modulo 2**32, accepts bool and numpy integers, refuses floats."""
    if type(value) is int:
        if -0x8000_0000 <= value <= 0x7FFF_FFFF:
            return value
    else:
        value = _scalar(value)
        try:
            value = value.__index__()
        except (AttributeError, TypeError):
            raise TypeError(f"needs an integer, got {_describe(value)}") from None
    return ((value + 0x8000_0000) & 0xFFFF_FFFF) - 0x8000_0000


def to_float(value: Any) -> float:
    """Coerce like a C float parameter: any real number or array of one element."""
    if type(value) is float:
        return value
    try:
        return float(_scalar(value))
    except (TypeError, ValueError):
        raise TypeError(f"needs a number, got {_describe(value)}") from None


def to_text(value: Any) -> str:
    """Coerce to a C string: str or bytes, cut at the first NUL."""
    if isinstance(value, (bytes, bytearray)):
        value = bytes(value).decode("utf-8", "surrogateescape")
    if not isinstance(value, str):
        raise TypeError(f"needs a string, got {_describe(value)}")
    return value if "\0" not in value else value[: value.index("\0")]


def to_bytes(value: Any) -> bytes:
    """Coerce to binary data: bytes, bytearray, str (UTF-8), or anything with a buffer (ctypes arrays)."""
    if isinstance(value, str):
        return value.encode("utf-8", "surrogateescape")
    try:
        return bytes(memoryview(value))
    except TypeError:
        raise TypeError(f"needs bytes, bytearray or str, got {_describe(value)}") from None


def to_pixels(value: Any) -> bytes:
    """Coerce an image: any sequence of ints taken modulo 256, or anything with a byte buffer."""
    if getattr(value, "holds_pixels", False):
        return value.tobytes()  # an image that this package handed out
    try:
        view = memoryview(value)
        if view.itemsize == 1:
            return view.tobytes()
    except TypeError:
        pass
    if hasattr(value, "astype") and hasattr(value, "tobytes"):
        return value.astype("int64").astype("uint8").tobytes()
    try:
        return bytes([int(v) & 0xFF for v in value])
    except (TypeError, ValueError):
        raise TypeError(f"needs a sequence of pixel values, got {_describe(value)}") from None


def to_ints(value: Any) -> list[int]:
    return [to_int32(v) for v in _items(value)]


def to_floats(value: Any) -> list[float]:
    return [to_float(v) for v in _items(value)]


def to_texts(value: Any) -> list[str]:
    if isinstance(value, (str, bytes)):
        raise TypeError("needs a list of strings, got one string")
    return [to_text(v) for v in _items(value)]


def _items(value: Any) -> Iterable[Any]:
    if hasattr(value, "ravel"):
        return value.ravel().tolist()
    try:
        return iter(value)
    except TypeError:
        raise TypeError(f"needs a sequence, got {_describe(value)}") from None


def _to_vector(length: int, items: Callable[[Any], list[Any]], zero: float) -> Callable[[Any], list[Any]]:
    """Too few elements are filled with zeros, too many are an error, as C array construction did."""

    def coerce(value: Any) -> list[Any]:
        values = items(value)
        if len(values) > length:
            raise IndexError(f"needs at most {length} numbers, got {len(values)}")
        return values + [zero] * (length - len(values))

    return coerce


def _optional(coerce: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda value: None if value is None else coerce(value)


def _describe(value: Any) -> str:
    """Return its type, and the value if it is short: a message may hold deeply nested lists and megabytes of bytes."""
    kind = type(value).__name__
    if isinstance(value, (list, tuple, dict)):
        items = cast("list[Any] | tuple[Any, ...] | dict[Any, Any]", value)
        if len(items) > 20 or any(isinstance(each, (list, tuple, dict, str, bytes)) for each in items):
            return f"{kind} of {len(items)} items"
    elif isinstance(value, (str, bytes, bytearray)):
        value = value[:60]
    text = repr(cast(object, value))
    return f"{kind} {text if len(text) <= 60 else text[:57] + '...'}"


# --- the server's side: values as decoded from the wire -----------------------------------------


def _check_int(value: Any) -> int:
    if type(value) is int and -0x8000_0000 <= value <= 0x7FFF_FFFF:
        return value
    raise ValueError(f"must be a 32-bit integer, got {_describe(value)}")


def _check_float(value: Any) -> float:
    if type(value) in (float, int) and -_FLOAT32_MAX <= value <= _FLOAT32_MAX:
        return float(value)
    raise ValueError(f"must be a finite number, got {_describe(value)}")


def _check_bool(value: Any) -> bool:
    if type(value) not in (bool, int):
        raise ValueError(f"must be true or false, got {_describe(value)}")
    return bool(value)


def _check_text(value: Any) -> str:
    if type(value) is not str or len(value) > MAX_TEXT:
        raise ValueError(f"must be a text of at most {MAX_TEXT} characters, got {_describe(value)}")
    return value


def _check_bytes(value: Any) -> bytes:
    if type(value) is not bytes or len(value) > MAX_BYTES:
        raise ValueError(f"must be at most {MAX_BYTES} bytes of binary data, got {_describe(value)}")
    return value


def _are_ints(items: list[Any]) -> bool:
    """Return whether all items are 32-bit integers."""
    return set(map(type, items)) == {int} and min(items) >= -0x8000_0000 and max(items) <= 0x7FFF_FFFF


def _are_floats(items: list[Any]) -> bool:
    """Return whether all items are floats that `_check_float` accepts."""
    if set(map(type, items)) != {float} or not math.isfinite(sum(items)):  # min and max overlook NaN
        return False
    return min(items) >= -_FLOAT32_MAX and max(items) <= _FLOAT32_MAX


_ALL: dict[Callable[[Any], Any], Callable[[list[Any]], bool]] = {
    _check_int: _are_ints,
    _check_float: _are_floats,
}
"""The same checks of whole lists, in a third of the time."""


def _check_list(item: Callable[[Any], Any], length: int | None = None) -> Callable[[Any], list[Any]]:
    all_numbers = _ALL.get(item)

    def check(value: Any) -> list[Any]:
        if not isinstance(value, list) or len(items := cast(list[Any], value)) > MAX_ITEMS:
            raise ValueError(f"must be a list of at most {MAX_ITEMS} items, got {_describe(value)}")
        if length is not None and len(items) != length:
            raise ValueError(f"must have {length} items, got {len(items)}")
        if len(items) > _FEW and all_numbers is not None and all_numbers(items):
            return items
        return [item(v) for v in items]

    return check


def _same(value: Any) -> Any:
    return value


INT = Kind("int", "int", int, to_int32, _check_int, None, "a 32-bit integer")
FLOAT = Kind("float", "float", float, to_float, _check_float, None, "a number, single precision")
BOOL = Kind("bool", "bool", bool, lambda value: bool(_scalar(value)), _check_bool, bool, "true or false")
TEXT = Kind("text", "str", str, to_text, _check_text, None, "a text")
BYTES = Kind("bytes", "bytearray", bytearray, to_bytes, _check_bytes, bytearray, "binary data")
INTS = Kind("ints", "list[int]", list, to_ints, _check_list(_check_int), list, "a list of integers")
FLOATS = Kind("floats", "list[float]", list, to_floats, _check_list(_check_float), list, "a list of numbers")
TEXTS = Kind("texts", "list[str]", list, to_texts, _check_list(_check_text), list, "a list of texts")
PACKETS = Kind(
    "packets",
    "list[list[float]]",
    list,
    lambda value: [to_floats(packet) for packet in value],
    _check_list(_check_list(_check_float)),
    lambda value: [list(packet) for packet in value],
    "a list of lists of numbers",
)
RESOLUTION = Kind(
    "resolution", "list[int]", list, to_ints, _check_list(_check_int, 2), list, "[width, height]"
)
PIXELS = Kind(
    "pixels",
    "list[int]",
    list,
    to_pixels,
    _check_bytes,
    _same,
    "pixel bytes, bottom row first",
    is_image=True,
)
DEPTHS = Kind(
    "depths",
    "list[float]",
    list,
    to_bytes,
    _check_bytes,
    _same,
    "float32 depths, bottom row first",
    is_image=True,
)


def _vector(name: str, length: int, items: Kind = FLOATS) -> Kind:
    zero, check = (0.0, _check_float) if items is FLOATS else (0, _check_int)
    return Kind(
        name,
        items.annotation,
        lambda: [zero] * length,
        _to_vector(length, items.coerce, zero),
        _check_list(check, length),
        list,
        f"{length} numbers",
        length=length,
    )


VECTOR3 = _vector("vector3", 3)
VECTOR4 = _vector("vector4", 4)
MATRIX12 = _vector("matrix12", 12)
INT_PAIR = Kind(
    "int_pair", "list[int]", lambda: [0, 0], to_ints, _check_list(_check_int, 2), list, "two integers"
)


def _optional_kind(kind: Kind) -> Kind:
    return Kind(
        f"optional_{kind.name}",
        f"{kind.annotation} | None",
        lambda: None,
        _optional(kind.coerce),
        _optional(kind.check),
        kind.fresh,
        f"{kind.meaning} or None",
        length=kind.length,
        optional=kind,
    )


OPTIONAL_TEXT = _optional_kind(TEXT)
OPTIONAL_INTS2 = _optional_kind(_vector("ints2", 2, INTS))
OPTIONAL_INTS12 = _optional_kind(_vector("ints12", 12, INTS))
OPTIONAL_FLOATS3 = _optional_kind(_vector("floats3", 3))
OPTIONAL_FLOATS6 = _optional_kind(_vector("floats6", 6))

KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        INT,
        FLOAT,
        BOOL,
        TEXT,
        BYTES,
        INTS,
        FLOATS,
        TEXTS,
        PACKETS,
        RESOLUTION,
        PIXELS,
        DEPTHS,
        VECTOR3,
        VECTOR4,
        MATRIX12,
        INT_PAIR,
        OPTIONAL_TEXT,
        OPTIONAL_INTS2,
        OPTIONAL_INTS12,
        OPTIONAL_FLOATS3,
        OPTIONAL_FLOATS6,
    )
}
