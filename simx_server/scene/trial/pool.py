"""The helpers that make trials: one for each simultaneous trial, up to a limit."""

from __future__ import annotations

import threading
import time

from simx_server.scene.trial import helper
from simx_server.scene.trial.helper import Helper

MOST = 3
"""Most simultaneous trials. Others wait until one of them ends; every trial ends."""


class Pool:
    """Distribute helpers, on any thread; a helper has one user at a time."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._idle: list[Helper] = []
        self._used: set[Helper] = set()
        self._starting = 0
        self._is_closed = False

    def add(self, started: Helper) -> None:
        """Add a helper that is used first."""
        with self._changed:
            self._idle.append(started)

    def take(self, seconds: float) -> Helper:
        """Return an unused helper; give it back later. Raises TimeoutError: all are in use for this time."""
        limit = time.monotonic() + seconds
        with self._changed:
            while not self._is_closed and not self._idle and len(self._used) + self._starting >= MOST:
                if not self._changed.wait(limit - time.monotonic()):
                    raise TimeoutError
            if self._is_closed:
                raise EOFError
            if self._idle:
                found = self._idle.pop()
                self._used.add(found)
                return found
            self._starting += 1
        try:
            started = helper.start()
            with self._changed:
                self._used.add(started)
        finally:
            with self._changed:
                self._starting -= 1
                self._changed.notify()
        return started

    def give_back(self, used: Helper) -> None:
        """Return a helper to the pool, which keeps one for the next trial."""
        with self._changed:
            self._used.discard(used)
            is_kept = used.is_usable and not self._idle and not self._is_closed
            if is_kept:
                self._idle.append(used)
            self._changed.notify()
        if not is_kept:
            used.close()

    def close(self) -> None:
        """End all helpers; callers that wait for a trial get EOFError."""
        with self._changed:
            self._is_closed = True
            idle, used = self._idle.copy(), list(self._used)
            self._idle.clear()
            self._changed.notify_all()
        for each in used:
            each.kill()
        for each in idle:
            each.close()
