"""Sample the main thread of this process: how much of its processor time each function takes."""

from __future__ import annotations

import signal
import time
from collections import defaultdict
from pathlib import Path
from types import FrameType
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
INTERVAL_S = 0.001


class Taken(NamedTuple):
    """Processor time of a process, seconds."""

    by_function: dict[str, float]
    """Of the main thread, by the function of Python that runs or that has called into C."""

    main: float
    others: float
    """Of all other threads: those of Zenoh and of the physics."""


class Sampler:
    """Looks at the main thread each millisecond of the process's processor time.

    Python is interrupted between two of its instructions, so a call into C is counted at its end, for the function that
    made it. Each sample has the weight of the thread's processor time since the one before.
    """

    def __init__(self) -> None:
        self._found: defaultdict[str, float] = defaultdict(float)
        self._main = self._all = self._last = 0.0
        self.seconds = 0.0
        """Of the wall clock, in which it looked."""

    def start(self) -> None:
        """Look from now on. To be called in the main thread, as `stop`; both may be called several times."""
        self.seconds -= time.perf_counter()
        self._all -= time.process_time()
        self._last = time.thread_time()
        self._main -= self._last
        signal.signal(signal.SIGPROF, self._sample)
        signal.setitimer(signal.ITIMER_PROF, INTERVAL_S, INTERVAL_S)

    def stop(self) -> None:
        """Look no more."""
        signal.setitimer(signal.ITIMER_PROF, 0)
        self._main += time.thread_time()
        self._all += time.process_time()
        self.seconds += time.perf_counter()
        signal.signal(signal.SIGPROF, signal.SIG_IGN)

    def taken(self, times: int = 1) -> Taken:
        """Return what was found, for one of so many operations."""
        found = {name: seconds / times for name, seconds in self._found.items()}
        return Taken(found, self._main / times, max(0.0, self._all - self._main) / times)

    def _sample(self, _number: int, frame: FrameType | None) -> None:
        now = time.thread_time()
        if frame is not None:
            self._found[_name_of(frame)] += now - self._last
        self._last = now


def _name_of(frame: FrameType) -> str:
    """Return a function as ``room/module.function``; for one outside of the project its file's name stands alone."""
    code = frame.f_code
    path = Path(code.co_filename)
    module = (
        path.relative_to(ROOT) if path.is_relative_to(ROOT) and ".venv" not in path.parts else Path(path.name)
    )
    return f"{module.with_suffix('')}.{code.co_qualname}"
