"""Memory that is free in this process, given back to the system."""

from __future__ import annotations

import ctypes
import sys
import threading
import time
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


PAUSE = 10.0
"""Seconds between two times that memory is given back."""


class Tide:
    """Notices that much has waited and nothing does any more."""

    def __init__(self, much: int) -> None:
        """Begin low.

        Args:
            much: from so many on, memory is worth giving back.
        """
        self._much = much
        self._was_high = False
        self._given_back = -PAUSE

    def look(self, amount: int) -> None:
        """So much waits now; give memory back when it was much and is next to nothing."""
        if amount > self._much:
            self._was_high = True
        elif self._was_high and amount < self._much // 100 and time.monotonic() > self._given_back + PAUSE:
            self._was_high, self._given_back = False, time.monotonic()
            give_back()
