"""The helpers that make trials: as many as there are trials at a time, within a bound."""

from __future__ import annotations

import threading
import time

from simx_server.scene.trial import helper
from simx_server.scene.trial.helper import Helper

MOST = 3
"""Trials at a time. Others wait for one of them to end; a trial has an end."""


class Pool:
    """Hands out helpers. Any thread; nobody's helper is another's at the same time."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._idle: list[Helper] = []
        self._used: set[Helper] = set()
        self._starting = 0
        self._is_closed = False

    def add(self, started: Helper) -> None:
        """Have this one used first."""
        with self._changed:
            self._idle.append(started)

    def take(self, seconds: float) -> Helper:
        """A helper that nobody else uses; give it back. Raises TimeoutError: all are in use for so long."""
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
        """It is not in use any more. One is kept for the next trial."""
        with self._changed:
            self._used.discard(used)
            is_kept = used.is_usable and not self._idle and not self._is_closed
            if is_kept:
                self._idle.append(used)
            self._changed.notify()
        if not is_kept:
            used.close()

    def close(self) -> None:
        """End all of them; whoever waits for a trial gets EOFError."""
        with self._changed:
            self._is_closed = True
            idle, used = self._idle.copy(), list(self._used)
            self._idle.clear()
            self._changed.notify_all()
        for each in used:
            each.kill()
        for each in idle:
            each.close()
