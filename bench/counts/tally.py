"""Count what Python code does: its calls, and the system calls that it makes."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from types import BuiltinFunctionType, FrameType
from typing import Any

_WAITING_MODULES = frozenset({"_socket", "select"})
"""Every method of the objects of these modules is a system call."""

_FILE_CALLS = frozenset(
    {"read", "write", "readv", "writev", "pread", "pwrite", "sendfile", "open", "close", "stat"}
)
"""The functions of the module of POSIX that are system calls and may come in a call of a client."""


class _Thread:
    """The counts of one thread."""

    def __init__(self) -> None:
        self.calls = self.system_calls = 0

    def note(self, frame: FrameType, event: str, argument: Any) -> None:
        """React to an event of Python's profiler."""
        if event == "call":
            self.calls += 1
        elif event == "c_call" and _is_system_call(argument):
            self.system_calls += 1


def _is_system_call(function: BuiltinFunctionType) -> bool:
    owner = function.__self__
    for kind in type(owner).__mro__:
        if kind.__module__ in _WAITING_MODULES:
            return True
    module = function.__module__
    if module == "time":
        return function.__name__ == "sleep"
    return module in {"posix", "nt"} and function.__name__ in _FILE_CALLS


class Tally:
    """Counts for the thread that makes it, and for those of Python that start afterwards.

    The threads of libraries, as Zenoh's, are not counted.
    """

    def __init__(self) -> None:
        self._threads: list[_Thread] = []

    def start(self) -> None:
        """Count from now on."""
        threading.setprofile(self._begin)
        sys.setprofile(self._begin)

    def stop(self) -> None:
        """Count no more in this thread, nor in those that start from now on."""
        threading.setprofile(_nothing)
        sys.setprofile(None)

    def _begin(self, frame: FrameType, event: str, argument: Any) -> None:
        """Give a thread counts of its own at its first event: a common number would need a lock."""
        thread = _Thread()
        self._threads.append(thread)
        sys.setprofile(thread.note)
        thread.note(frame, event, argument)

    def totals(self) -> tuple[int, int]:
        """Return the calls of Python functions and the system calls of all counted threads."""
        threads = tuple(self._threads)
        return sum(each.calls for each in threads), sum(each.system_calls for each in threads)


def _nothing(frame: FrameType, event: str, argument: Any) -> None:
    sys.setprofile(None)


def count(operation: Callable[[], object], times: int) -> tuple[float, float]:
    """Return the calls of Python functions and the system calls that an operation makes in this thread.

    Args:
        operation: it is called once before the count, too.
        times: its number of calls. Twice as many are counted, in two halves of which the lower one is returned.
    """
    operation()
    return min(_count(operation, times), _count(operation, times))


def _count(operation: Callable[[], object], times: int) -> tuple[float, float]:
    tally = Tally()
    tally.start()
    try:
        for _ in range(times):
            operation()
    finally:
        tally.stop()
    calls, system_calls = tally.totals()
    return calls / times, system_calls / times
