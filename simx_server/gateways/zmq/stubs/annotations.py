"""Types of arguments and results as a program writes them, from the annotations of our methods."""

from __future__ import annotations

import types
import typing
from collections.abc import Generator, Mapping
from typing import Annotated, Any

from simx_server.scripting.interpreter import Function

HELPERS = '''
class _Array(Protocol):
    """An array of NumPy: the client sends it as a list."""

    def tolist(self) -> Any: ...

class _Scalar(Protocol):
    """A number of NumPy with a fraction: the client sends it as a float."""

    def __float__(self) -> float: ...
    def item(self) -> Any: ...

_Float: TypeAlias = float | _Scalar
_Floats: TypeAlias = Sequence[_Float] | _Array
_Ints: TypeAlias = Sequence[int] | _Array
'''
"""Definitions that the types of arguments use."""

ANY = "Any"

_ARGUMENTS: Mapping[Any, tuple[str, ...]] = {
    int: ("int",),
    float: ("_Float",),
    bool: ("bool", "int"),
    str: ("str",),
    bytes: ("bytes", "bytearray", "str"),
    dict: ("Mapping[Any, Any]",),
    Function: ("Callable[..., Any]",),
    Any: (ANY,),
    type(None): ("None",),
}

_LISTS: Mapping[str, tuple[str, ...]] = {"_Float": ("_Floats",), "int": ("_Ints",)}

_RESULTS: Mapping[Any, str] = {
    int: "int",
    float: "float",
    bool: "bool",
    str: "str",
    bytes: "bytes",
    dict: "dict[str, Any]",
    Any: ANY,
    type(None): "None",
}


def argument(annotation: Any, *, is_optional: bool = False) -> str:
    """Return the type of an argument.

    Args:
        annotation: The annotation of our method, see `scripting/conversion/signature.py`.
        is_optional: None stands for the default.
    """
    found = dict.fromkeys(text for each in _alternatives(annotation) for text in _argument(each))
    if ANY in found:
        return ANY
    if is_optional or "None" in found:
        found.pop("None", None)
        found["None"] = None
    return " | ".join(found)


def _argument(annotation: Any) -> tuple[str, ...]:
    origin = typing.get_origin(annotation)
    if origin is list:
        (item,) = typing.get_args(annotation)
        inner = argument(item)
        return _LISTS.get(inner, (f"Sequence[{inner}]", "_Array"))
    return _ARGUMENTS[origin or annotation]


def result(annotation: Any) -> str:
    """Return the type of what a call returns: no result is None, several are a tuple.

    A result that is another one on rare occasions, as None is where an object does not exist, has ``| Any``: a type
    checker then accepts programs that do not test for it, and knows what the usual result has.
    """
    kinds = [_arrived(each) for each in _alternatives(annotation)]
    several = [each for each in kinds if typing.get_origin(each) is tuple]
    usual = several or [each for each in kinds if each is not type(None)] or [type(None)]
    texts = list(dict.fromkeys(map(_result, usual)))
    if set(texts) == {"int", "float"}:
        texts = ["float"]
    if len(texts) > 1 or ANY in texts:
        return ANY
    return f"{texts[0]} | {ANY}" if len(usual) < len(kinds) else texts[0]


def _arrived(annotation: Any) -> Any:
    """Return what a call gives in the end, for a function that waits: the one result, or a tuple of them."""
    if typing.get_origin(annotation) is not Generator:
        return annotation
    results: tuple[Any, ...] = typing.get_args(typing.get_args(annotation)[2])
    if Ellipsis in results:
        return Any
    return tuple[results] if len(results) > 1 else results[0] if results else type(None)


def _result(annotation: Any) -> str:
    origin, parts = typing.get_origin(annotation), typing.get_args(annotation)
    if annotation is typing.NoReturn or Ellipsis in parts:
        return ANY
    if origin in (list, tuple):
        return f"{origin.__name__}[{', '.join(map(result, parts))}]"
    return _RESULTS[origin or annotation]


def _alternatives(annotation: Any) -> list[Any]:
    origin = typing.get_origin(annotation)
    if origin is Annotated:
        return _alternatives(typing.get_args(annotation)[0])
    if isinstance(annotation, types.UnionType) or origin is typing.Union:
        return [inner for each in typing.get_args(annotation) for inner in _alternatives(each)]
    return [annotation]
