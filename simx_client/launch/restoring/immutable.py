"""Set attributes of types that are written in C, such as NumPy's arrays, which Python refuses.

Conversions such as ``float(a)`` use the type and not the object, so only this restores an old conversion. The
type's flag "immutable" is cleared for that moment. It applies to this process only.
"""

from __future__ import annotations

import ctypes
import logging
import sys
from collections.abc import Mapping
from typing import Any

logger = logging.getLogger(__name__)

_IMMUTABLE = 1 << 8
"""Py_TPFLAGS_IMMUTABLETYPE: since Python 3.10."""

_POINTERS_BEFORE_FLAGS = 18
"""Number of fields from tp_name to tp_as_buffer in PyTypeObject, after the header of an object of variable
size."""


def set_attributes(kind: type, members: Mapping[str, Any]) -> bool:
    """Set attributes of a type; return whether that was possible: only CPython allows it."""
    if not members:
        return True
    if not kind.__flags__ & _IMMUTABLE:
        for name, value in members.items():
            setattr(kind, name, value)
        return True
    flags = _flags(kind)
    if flags is None:
        logger.info("%s stays as it is: this Python does not let the type be changed", kind.__name__)
        return False
    flags.value &= ~_IMMUTABLE
    try:
        for name, value in members.items():
            setattr(kind, name, value)
    finally:
        flags.value |= _IMMUTABLE  # not the saved value: setting an attribute changes other flags
    return True


def _flags(kind: type) -> ctypes.c_ulong | None:
    """Return the type's flags in memory; None if they are not at the expected offset."""
    if sys.implementation.name != "cpython":
        return None
    header = object.__basicsize__ + ctypes.sizeof(ctypes.c_ssize_t)
    place = header + _POINTERS_BEFORE_FLAGS * ctypes.sizeof(ctypes.c_void_p)
    flags = ctypes.c_ulong.from_address(id(kind) + place)
    return flags if flags.value == kind.__flags__ and flags.value & _IMMUTABLE else None
