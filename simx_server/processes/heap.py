"""Memory that is free in this process, given back to the system."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from functools import cache
from typing import Any

ARENAS = 4
"""Parts of the heap. glibc makes eight for each core, and keeps what threads freed in them: 115 MB after floods."""

_M_ARENA_MAX = -8
"""From glibc's malloc.h."""


@cache
def _trim() -> Any:
    return _of_glibc("malloc_trim")


def _of_glibc(name: str) -> Any:
    """None with other libraries, which give back what is free by themselves."""
    return getattr(ctypes.CDLL(None), name, None) if sys.platform == "linux" else None


def keep_together() -> None:
    """Let threads that are started from now on share a few parts of the heap, unless the user chose how many."""
    if "MALLOC_ARENA_MAX" not in os.environ and (mallopt := _of_glibc("mallopt")) is not None:
        mallopt(_M_ARENA_MAX, ARENAS)


def give_back() -> None:
    """Begin to give free memory back, on a thread of its own, as it may take many milliseconds."""
    if (trim := _trim()) is not None:
        threading.Thread(target=trim, args=(0,), name="simx-trim", daemon=True).start()
