"""Values of C as Python's, and back: arguments arrive as a C function would get them, or as plain Python values.

An array that a function returns owns its memory, which lives as long as the program holds it; so
`simReleaseBuffer` has nothing to do.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Sequence
from typing import Any

from simx_client.protocol.precision import as_single

try:
    from ._ffi import ffi as _made
except (
    ModuleNotFoundError
) as missing:  # the functions can be listed then, not called: `finder` refuses before
    if missing.name != "_cffi_backend":
        raise
    _made = None

ffi: Any = _made
C = Any
"""A value of cffi: an array, or a pointer."""

NULL: C = None if ffi is None else ffi.NULL


def text(value: Any) -> bytes | None:
    """Return a ``const char *`` argument; None for NULL."""
    if value is None or isinstance(value, bytes):
        return value
    if isinstance(value, str):
        return value.encode()
    return None if value == NULL else ffi.string(value)


def path(value: Any) -> str | None:
    """Return the name of a file as a path from the root: the server does not know the program's working folder."""
    name = text(value)
    if not name:
        return None if name is None else ""
    return os.path.abspath(os.fsdecode(name))


def content(value: Any) -> bytes | None:
    """Return the bytes of an array, zero bytes included; None for NULL."""
    if value is None or isinstance(value, bytes):
        return value
    if isinstance(value, ffi.CData):
        return None if value == NULL else bytes(ffi.buffer(value))
    return bytes(value)


def floats(value: Any) -> list[float] | None:
    """Return an array of numbers: a list, a tuple, one of NumPy or of C; None for NULL."""
    return None if value is None or value is NULL else [float(each) for each in value]


def integers(value: Any) -> list[int] | None:
    """Return an array of integers as `floats` does."""
    return None if value is None or value is NULL else [int(each) for each in value]


def flags(value: Any) -> list[bool] | None:
    """Return an array of truth values as `floats` does."""
    return None if value is None or value is NULL else [bool(each) for each in value]


def fill(target: C, values: Any) -> None:
    """Write a number, or as many as the array takes, to where a pointer points; nothing for NULL."""
    if target is None or target is NULL or values is None:
        return
    if isinstance(values, (int, float)):
        target[0] = values
        return
    count = min(len(target), len(values))
    target[0:count] = values[:count]


def array(kind: str, values: Sequence[Any]) -> C:
    """Return an array of ``float`` or ``int`` that owns its memory; for no values one that is not NULL."""
    return ffi.new(f"{kind}[]", values or [0])


def string(value: str | bytes | None) -> C:
    """Return a text that ends with a zero; NULL for None."""
    if value is None:
        return NULL
    return ffi.new("char[]", value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value)


def block(value: bytes) -> C:
    """Return bytes without a zero at their end, so that `content` gives them back."""
    return ffi.new("char[]", len(value)) if not value else _copied(value)


def _copied(value: bytes) -> C:
    made = ffi.new("char[]", len(value))
    ffi.memmove(made, value, len(value))
    return made


def single(value: float) -> float:
    """Return a number with the precision of a C ``float``."""
    return as_single(value)


def strings(values: Iterable[str | bytes]) -> tuple[C, list[C]]:
    """Return an array of texts, and the texts, which must be kept as long as the array."""
    kept = [string(each) for each in values]
    return ffi.new("char *[]", kept or [NULL]), kept


def pointers(kind: str, arrays: Sequence[C]) -> C:
    """Return an array of pointers to arrays, which must be kept as long as it."""
    return ffi.new(f"{kind} *[]", list(arrays) or [NULL])


def fill_pointer(target: C, value: C) -> None:
    """Write a pointer to where a pointer points; nothing for NULL. The value must be kept as long as it is read."""
    if target is not None and target is not NULL:
        target[0] = value


_kept = threading.local()


def keep(function: str, *values: object) -> None:
    """Keep arrays behind the pointers that a function returns, until this thread calls it again."""
    vars(_kept)[function] = values
