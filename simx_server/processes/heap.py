"""Return unused memory of this process to the system."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from functools import cache
from typing import Any

ARENAS = 4
"""Number of heap arenas.

glibc creates eight for each core, and keeps the memory that is freed in them: 115 MB after floods.
"""

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


def give_back() -> None:
    """Start to return unused memory, on a separate thread, as it may take many milliseconds."""
    if (trim := _trim()) is not None:
        threading.Thread(target=trim, args=(0,), name="simx-trim", daemon=True).start()
