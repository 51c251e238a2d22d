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

_M_ARENA_MAX = -8
"""Constant from glibc's malloc.h."""


@cache
def _trim() -> Any:
    return _of_glibc("malloc_trim")


def _of_glibc(name: str) -> Any:
    """Return a function of glibc; None with other libraries, which return unused memory automatically."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


def keep_together() -> None:
    """Let threads that start from now on share a few arenas, unless the user chose their number."""
    if "MALLOC_ARENA_MAX" not in os.environ and (mallopt := _of_glibc("mallopt")) is not None:
        mallopt(_M_ARENA_MAX, ARENAS)


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
