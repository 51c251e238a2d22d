"""Give values the form that a message gives them, without making bytes: single precision, plain types.

A client in the server's process gets and sends values directly. Its results are bit for bit those of a client of
another process.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, cast

from .codec import as_sent
from .kinds import Kind, apply

Values = list[Any]

_SINGLE = struct.Struct("f")
_VECTORS = {length: struct.Struct(f"{length}f") for length in (2, 3, 4, 6, 12)}
_FLOATS = {float}
_PLAIN = frozenset((bool, bytes, float, int, str, type(None)))
"""Types that a message keeps; of these only a float changes its value."""


def through_message(kinds: Sequence[Kind]) -> Callable[[Values], Values]:
    """Return a function that converts a list of values of these kinds as sending and receiving them would.

    The function may return the list that it got.
    """
    converters = tuple(_converter(kind) for kind in kinds)
    if not converters:
        return _unchanged
    if len(converters) == 1:
        convert = converters[0]
        return lambda values: [convert(values[0])]
    return lambda values: list(map(apply, converters, values))


def _unchanged(values: Values) -> Values:
    return values


def _converter(kind: Kind) -> Callable[[Any], Any]:
    if kind.annotation == "float":
        return as_single
    if kind.annotation == "list[float]" and not kind.is_image:
        return _floats
    return _plain


def as_single(value: Any) -> Any:
    """Return a number in single precision, infinity for one beyond it."""
    if value.__class__ is float:
        try:
            return _SINGLE.unpack(_SINGLE.pack(value))[0]
        except OverflowError:  # infinity, as in a message
            pass
    return as_sent(value)


def _floats(value: Any) -> Any:
    if value.__class__ is list:
        items = cast(list[Any], value)
        if set(map(type, items)) == _FLOATS:
            count = len(items)
            vector = _VECTORS.get(count) or struct.Struct(f"{count}f")
            try:
                return list(vector.unpack(vector.pack(*items)))
            except OverflowError:
                pass
    return as_sent(value)


def _plain(value: Any) -> Any:
    return value if value.__class__ in _PLAIN and value.__class__ is not float else as_sent(value)
