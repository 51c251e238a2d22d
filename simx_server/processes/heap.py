"""Return unused memory of this process to the system."""

from __future__ import annotations

import ctypes
import math
import os
import sys
import threading
from functools import cache
from typing import Any

ARENAS = 4
"""Number of heap arenas.

glibc creates eight for each core, and keeps the memory that is freed in them: 115 MB after floods.
"""

MUCH = 64 << 20
"""Unused bytes that are worth returning."""

LARGE = 4 << 20
"""Bytes of an allocation that has separate pages, which return to the system as soon as it is freed.

Otherwise glibc raises this size to that of the largest one freed, up to 32 MB: then large messages lie in the arenas,
and small objects that outlive them keep their pages: 140 MB after messages that were never ended. Smaller ones, such
as images, use the same pages again, which is faster.
"""

KEPT = 2 * LARGE
"""Unused bytes at an arena's end that are not returned at once: the ratio that glibc has by default."""

_M_ARENA_MAX, _M_MMAP_THRESHOLD, _M_TRIM_THRESHOLD = -8, -3, -1
"""Constants from glibc's malloc.h."""

_PARAMETERS = {
    _M_ARENA_MAX: ("MALLOC_ARENA_MAX", ARENAS),
    _M_MMAP_THRESHOLD: ("MALLOC_MMAP_THRESHOLD_", LARGE),
    _M_TRIM_THRESHOLD: ("MALLOC_TRIM_THRESHOLD_", KEPT),
}
"""The variable by which a user chooses each parameter, and its value otherwise."""


@cache
def _trim() -> Any:
    return _of_glibc("malloc_trim")


def _of_glibc(name: str) -> Any:
    """Return a function of glibc; None with other libraries, which return unused memory automatically."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


def keep_together() -> None:
    """Let threads that start from now on share a few arenas without large allocations.

    A parameter that the user chose by a variable of glibc stays.
    """
    if (mallopt := _of_glibc("mallopt")) is not None:
        for parameter, (variable, value) in _PARAMETERS.items():
            if variable not in os.environ:
                mallopt(parameter, value)


class _Mallinfo2(ctypes.Structure):
    """The result of glibc's mallinfo2."""

    _fields_ = [(f"field{number}", ctypes.c_size_t) for number in range(8)] + [
        ("unused", ctypes.c_size_t),
        ("top", ctypes.c_size_t),
    ]


@cache
def _mallinfo2() -> Any:
    found = _of_glibc("mallinfo2")
    if found is not None:
        found.restype = _Mallinfo2
    return found


class Unused:
    """Notices that much memory has become unused, also that of libraries whose peers this process never knew."""

    def __init__(self) -> None:
        self._before = math.inf
        """Unused bytes, as far as they were returned or may be needed soon."""

    def has_grown(self) -> bool:
        """Return whether there is much more unused memory than after the last time that this was so."""
        ask = _mallinfo2()
        if ask is None:
            return False
        unused = int(ask().unused)
        has_grown = unused > self._before + MUCH
        self._before = unused if has_grown else min(self._before, unused)
        return has_grown


def give_back() -> None:
    """Start to return unused memory, on a separate thread, as it may take many milliseconds."""
    if (trim := _trim()) is not None:
        threading.Thread(target=trim, args=(0,), name="simx-trim", daemon=True).start()
