"""Memory that is free in this process, given back to the system."""

from __future__ import annotations

import ctypes
import sys
import threading
from functools import cache
from typing import Any


@cache
def _trim() -> Any:
    """What glibc has for it; None with other libraries, which give back what is free by themselves."""
    if sys.platform != "linux":
        return None
    try:
        return ctypes.CDLL(None).malloc_trim
    except AttributeError:
        return None


def give_back() -> None:
    """Begin to give free memory back, on a thread of its own, as it may take many milliseconds."""
    if (trim := _trim()) is not None:
        threading.Thread(target=trim, args=(0,), name="simx-trim", daemon=True).start()
