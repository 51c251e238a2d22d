"""Write values of the server's own classes as bytes, and make equal values of the bytes in another process.

Types are kept exactly: tuples, sets, enums, dataclasses, named tuples, arrays. Reading executes nothing: an instance of
a dataclass gets its fields, no method of it is called, and only classes of the server are known by name.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import msgpack
import numpy as np

_PLAIN = frozenset((int, float, bool, str, bytes, type(None)))
_SHORT = _PLAIN - {int}
"""Types of values that are written as they are; the second for values with integers of more than 64 bits."""

_TUPLE, _LIST, _DICT, _SET, _FROZENSET, _ARRAY, _RECORD, _NAMED, _ENUM, _LONG, _PATH = range(11)

_WIDEST = 1 << 63
"""msgpack has integers of 64 bits; states of random generators are longer."""

_NUMBERS = "biufc"
"""Kinds of arrays that hold numbers alone."""

_OWN = ("simx_server.", "simx_client.protocol.")


class NotPackable(Exception):
    """A value, or bytes, that this module does not know."""


def pack(value: object) -> bytes:
    """Return a value as bytes. Raises NotPackable."""
    try:
        try:
            packed = msgpack.packb(_tagged(value, _PLAIN), unicode_errors="surrogatepass")
        except OverflowError:
            packed = msgpack.packb(_tagged(value, _SHORT), unicode_errors="surrogatepass")
    except (ValueError, RecursionError) as error:  # too large, or nested too deeply
        raise NotPackable(str(error)) from error
    assert packed is not None
    return packed


def unpack(data: bytes) -> Any:
    """Return the value that `pack` was given. Raises NotPackable: the bytes are none of its."""
    try:
        tree: Any = msgpack.unpackb(data, unicode_errors="surrogatepass", strict_map_key=False)
        return _untagged(tree)
    except NotPackable:
        raise
    except Exception as error:
        raise NotPackable(f"bytes that are no packed value: {error!r:.200}") from error


def _tagged(value: Any, plain: frozenset[type[Any]]) -> Any:
    kind = cast("type[Any]", type(value))
    if kind in plain:
        return value
    if kind is tuple or kind is list:
        tag = _TUPLE if kind is tuple else _LIST
        return [
            tag,
            *(value if plain.issuperset(map(type, value)) else (_tagged(each, plain) for each in value)),
        ]
    if isinstance(value, np.ndarray | np.generic):
        return _tagged_numbers(value, plain)
    if isinstance(value, Mapping):
        flat = [_DICT]
        for key, item in cast("Mapping[Any, Any]", value).items():
            flat += _tagged(key, plain), _tagged(item, plain)
        return flat
    if kind is set or kind is frozenset:
        return [_SET if kind is set else _FROZENSET, *(_tagged(each, plain) for each in value)]
    return _tagged_object(value, kind, plain)


def _tagged_numbers(value: Any, plain: frozenset[type[Any]]) -> Any:
    if isinstance(value, np.generic):
        return _tagged(value.item(), plain)
    if value.dtype.kind not in _NUMBERS:
        raise NotPackable(f"an array of {value.dtype}")
    return [_ARRAY, value.dtype.str, list(value.shape), value.tobytes()]


def _tagged_object(value: Any, kind: type[Any], plain: frozenset[type[Any]]) -> Any:
    if kind is int:  # not among the plain ones: there is one that is too long
        return value if -_WIDEST <= value < _WIDEST else [_LONG, hex(value)]
    if isinstance(value, Enum):
        return [_ENUM, _name_of(kind), _tagged(value.value, plain)]
    if isinstance(value, tuple):
        return [_NAMED, _name_of(kind), *(_tagged(each, plain) for each in cast("tuple[Any, ...]", value))]
    if isinstance(value, Path):
        return [_PATH, str(value)]
    if dataclasses.is_dataclass(kind):
        fields = (_tagged(getattr(value, name), plain) for name in _fields_of(kind))
        return [_RECORD, _name_of(kind), *fields]
    raise NotPackable(f"a value of {kind.__module__}.{kind.__qualname__}")


def _untagged(tree: Any) -> Any:
    if type(tree) is not list:
        return tree
    items = cast("list[Any]", tree)
    kind, rest = items[0], items[1:]
    if kind in _GATHERED:
        return _GATHERED[kind](map(_untagged, rest))
    if kind == _DICT:
        values = [_untagged(each) for each in rest]
        return dict(zip(values[::2], values[1::2], strict=True))
    match rest:
        case [str(dtype), shape, bytes(data)] if kind == _ARRAY:
            wanted = np.dtype(dtype)
            if wanted.kind not in _NUMBERS:
                raise NotPackable(f"an array of {wanted}")
            return np.frombuffer(data, wanted).reshape(tuple(shape)).copy()
        case [str(text)] if kind == _LONG:
            return int(text, 16)
        case [str(text)] if kind == _PATH:
            return Path(text)
        case [str(name), value] if kind == _ENUM:
            return _class(name, Enum)(_untagged(value))
        case [str(name), *values] if kind == _NAMED:
            made: Any = _class(name, tuple)
            return made._make(map(_untagged, values))
        case [str(name), *values] if kind == _RECORD:
            return _record(_class(name, object), [_untagged(each) for each in values])
        case _:
            raise NotPackable(f"bytes that begin with {kind!r:.40}")


_GATHERED: dict[int, Callable[[Any], Any]] = {_TUPLE: tuple, _LIST: list, _SET: set, _FROZENSET: frozenset}


def _record(kind: type[Any], values: list[Any]) -> Any:
    if not dataclasses.is_dataclass(kind):
        raise NotPackable(f"{kind.__qualname__} is no record")
    made = object.__new__(kind)
    for name, value in zip(_fields_of(kind), values, strict=True):
        object.__setattr__(made, name, value)
    return made


@cache
def _fields_of(kind: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(kind))


@cache
def _name_of(kind: type[Any]) -> str:
    name = f"{kind.__module__}:{kind.__qualname__}"
    if not name.startswith(_OWN):
        raise NotPackable(f"a value of {kind.__module__}.{kind.__qualname__}")
    return name


@cache
def _class(name: str, base: type[Any]) -> type[Any]:
    """Return a class of the server by name. Raises NotPackable: it is none, or is not derived from `base`."""
    module, _, path = name.partition(":")
    if not name.startswith(_OWN) or module.endswith("__main__"):
        raise NotPackable(f"a class {name!r:.80}")
    found: Any = sys.modules.get(module) or import_module(module)
    for part in path.split("."):
        found = getattr(found, part, None)
    if not isinstance(found, type) or not issubclass(found, base) or found.__module__ != module:
        raise NotPackable(f"a class {name!r:.80}")
    return found
