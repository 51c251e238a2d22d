"""Arguments of clients as scripts give them, and results in the types that a client's language has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from simx_server.scripting.conversion.strings import NUMBERS, with_texts
from simx_server.scripting.interpreter import Function

from .functions import described

FUNCTION = b"@func"
"""The end of a text that stands for a function of the client."""

_SHORT = 16
"""Most items of a list or map in which clients look for functions."""

NIL = b"_*NIL*_"
"""Stands for nil in the arguments of clients in Lua."""


def with_functions(values: list[Any], function: Callable[[str], Function]) -> list[Any]:
    """Return arguments with functions in place of the texts that stand for them, there and in lists and maps."""
    if NUMBERS.issuperset(map(type, values)):
        return values
    return [
        value if type(value) in NUMBERS else _with_functions(value, function, depth=2) for value in values
    ]


def _with_functions(value: Any, function: Callable[[str], Function], depth: int) -> Any:
    if isinstance(value, bytes):
        if value.endswith(FUNCTION):
            return function(value.removesuffix(FUNCTION).decode("utf-8", "replace"))
        return None if value == NIL else value
    if depth > 1 and isinstance(value, list):
        items = cast(list[Any], value)
        if len(items) <= _SHORT:  # as clients do
            return [_with_functions(item, function, depth - 1) for item in items]
    if depth > 1 and isinstance(value, dict):
        fields = cast(dict[Any, Any], value)
        return {key: _with_functions(item, function, depth - 1) for key, item in fields.items()}
    return cast(Any, value)


def to_client(function: str, results: Sequence[Any]) -> list[Any]:
    """Return the results of a function as they travel: text as text, where the function does not declare bytes."""
    declared = described(function)
    if declared.is_typed:
        if NUMBERS.issuperset(map(type, results)):
            return list(results)
        return [value if type(value) in NUMBERS else _valid(value) for value in results]
    return [with_texts(value, as_bytes=declared.gives_bytes) for value in results]


def _valid(value: Any) -> Any:
    """Return a value whose texts can be encoded: names of objects may have bytes other than UTF-8."""
    if isinstance(value, str) and not value.isascii():
        return with_texts(value.encode("utf-8", "surrogateescape"))
    if isinstance(value, (list, tuple)):
        items = cast(Sequence[Any], value)
        if items and isinstance(items[0], (str, list, tuple)):
            return [_valid(item) for item in items]
    return cast(Any, value)
