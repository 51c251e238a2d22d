"""Results of functions of the API as flat values, whose short lists Lua makes itself.

Positions and matrices are lists of a few numbers. lupa needs 1 us to make a table, and 0.02 us for a further value of
a call. So the numbers of short lists are passed one by one, after the shape of the results, from which `values.lua`
makes a function that puts them into tables.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import repeat
from typing import Any

_MOST_ITEMS = 16
"""Numbers of a list that is passed flat."""

_MOST_VALUES = 60
"""Values that are passed flat: a function of Lua has at most 200 local variables."""

_SIMPLE = frozenset((bool, float, bytes, type(None)))
"""Types of values that enter Lua as they are."""

_LEAST, _GREATEST = -(1 << 63), (1 << 63) - 1
"""Limits of Lua's integers."""

_EACH_A_FLOAT = repeat(float)

_ALONE = -1
"""Stands for the length of a value that is not a list."""

_OF_ONE_LIST = tuple(b"%d" % length for length in range(_MOST_ITEMS + 1))
"""Shapes of results that are one list, by its length."""


def flat(results: tuple[Any, ...], to_lua: Callable[[Any], Any]) -> tuple[Any, ...]:
    """Return what a function of Python returns to Lua: True or the shape of the results, then their values.

    A shape has a part for each result, with commas between them: the length of a list, or ``-`` for a value.

    Args:
        results: of a function of the API.
        to_lua: converts any value.
    """
    if len(results) == 1:
        (value,) = results
        kind = value.__class__
        if kind is list and len(value) <= _MOST_ITEMS and all(map(isinstance, value, _EACH_A_FLOAT)):
            return _OF_ONE_LIST[len(value)], *value
        is_plain = kind in _SIMPLE or (kind is int and _LEAST <= value <= _GREATEST)
        return True, value if is_plain else to_lua(value)
    lengths: list[int] = []
    values: list[Any] = []
    for value in results:
        kind = value.__class__
        if kind is list and len(value) <= _MOST_ITEMS and all(map(isinstance, value, _EACH_A_FLOAT)):
            lengths.append(len(value))
            values += value
        else:
            lengths.append(_ALONE)
            is_plain = kind in _SIMPLE or (kind is int and _LEAST <= value <= _GREATEST)
            values.append(value if is_plain else to_lua(value))
    if len(values) > _MOST_VALUES:
        return True, *map(to_lua, results)
    return _shape(tuple(lengths)), *values


@lru_cache(maxsize=500)
def _shape(lengths: tuple[int, ...]) -> bytes | bool:
    """Return the shape of results, or True if none of them is a list."""
    parts = ["-" if length == _ALONE else str(length) for length in lengths]
    return set(parts) <= {"-"} or ",".join(parts).encode()
