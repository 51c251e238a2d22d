"""The helpers that make trials: one for each simultaneous trial, up to a limit."""

from __future__ import annotations

import threading
import time

from . import helper
from .helper import Helper

MOST = 3
"""Most simultaneous trials. Others wait until one of them ends; every trial ends."""


class Loan:
    """A helper in the hands of one user, until it is given back."""

    def __init__(self, pool: Pool, helper: Helper) -> None:
        self._pool = pool
        self.helper = helper

    def kill(self) -> None:
        """End the helper, unless it was given back: then it may be another user's. Any thread."""
        self._pool.kill(self)


class Pool:
    """Lend helpers, on any thread; a helper has one user at a time."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._idle: list[Helper] = []
        self._used: set[Loan] = set()
        self._starting = 0
        self._is_closed = False

    def add(self, started: Helper) -> None:
        """Add a helper that is used first."""
        with self._changed:
            self._idle.append(started)

    def take(self, seconds: float) -> Loan:
        """Lend an unused helper; give it back later. Raises TimeoutError: all are in use for this time."""
        limit = time.monotonic() + seconds
        with self._changed:
            while not self._is_closed and not self._idle and len(self._used) + self._starting >= MOST:
                if not self._changed.wait(limit - time.monotonic()):
                    raise TimeoutError
            if self._is_closed:
                raise EOFError
            if self._idle:
                return self._lent(self._idle.pop())
            self._starting += 1
        try:
            started = helper.start()
            with self._changed:
                return self._lent(started)
        finally:
            with self._changed:
                self._starting -= 1
                self._changed.notify()

    def _lent(self, helper: Helper) -> Loan:
        loan = Loan(self, helper)
        self._used.add(loan)
        return loan

    def kill(self, loan: Loan) -> None:
        """End the helper of a loan, unless it was given back."""
        with self._changed:
            if loan in self._used:
                loan.helper.kill()

    def give_back(self, loan: Loan) -> None:
        """End a loan, and keep one helper for the next trial."""
        used = loan.helper
        with self._changed:
            self._used.discard(loan)
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
            each.helper.kill()
        for each in idle:
            each.close()
