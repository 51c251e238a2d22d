"""Arguments of clients as scripts give them, and results in the types that a client's language has."""

from __future__ import annotations

import typing
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any, cast

from simx_server.scripting import api
from simx_server.scripting.interpreter import Function
from simx_server.scripting.namespaces import signatures
from simx_server.scripting.strings import GIVES_BYTES, with_texts

FUNCTION = b"@func"
"""The end of a text that stands for a function of the client."""

_SHORT = 16
"""Most items of a list or map in which clients look for functions."""

NIL = b"_*NIL*_"
"""Stands for nil in the arguments of clients in Lua."""


def split_name(full_name: str) -> tuple[str, str]:
    """Return the namespace and the name of a function; ``sim-2.step`` means that of ``sim``."""
    space, _, name = full_name.partition(".")
    return space.partition("-")[0], name


def is_function(full_name: str) -> bool:
    """Return whether a namespace has this function."""
    space, name = split_name(full_name)
    return space in api.NAMESPACES and name in signatures(space)


def with_functions(values: list[Any], function: Callable[[str], Function]) -> list[Any]:
    """Return arguments with functions in place of the texts that stand for them, there and in lists and maps."""
    return [_with_functions(value, function, depth=2) for value in values]


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


def to_client(function: str, results: Iterable[Any]) -> list[Any]:
    """Return the results of a function as they travel: text as text, where the function does not declare bytes."""
    values = list(results)
    if _are_typed(function):
        return [_valid(value) for value in values]
    as_bytes = bool(GIVES_BYTES.search(function))
    return [with_texts(value, as_bytes=as_bytes) for value in values]


def _valid(value: Any) -> Any:
    """Return a value whose texts can be encoded: names of objects may have bytes other than UTF-8."""
    if isinstance(value, str) and not value.isascii():
        return with_texts(value.encode("utf-8", "surrogateescape"))
    if isinstance(value, (list, tuple)):
        items = cast(Sequence[Any], value)
        if items and isinstance(items[0], (str, list, tuple)):
            return [_valid(item) for item in items]
    return cast(Any, value)


@cache
def _are_typed(full_name: str) -> bool:
    """Return whether a function declares the types of all its results."""
    space, name = split_name(full_name)
    if space not in api.NAMESPACES:
        return False
    found: Any = getattr(api.NAMESPACES[space], name, None)
    return found is not None and not _is_open(typing.get_type_hints(found).get("return"))


def _is_open(annotation: Any) -> bool:
    """Return whether a type contains Any, a map or a result that comes later."""
    if annotation is Any or (typing.get_origin(annotation) or annotation) in (dict, typing.NoReturn):
        return True
    return any(_is_open(each) for each in typing.get_args(annotation))
