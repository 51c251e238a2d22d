"""Compute when the next simulation step is due: in real time, a multiple of it, or at once."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable

logger = logging.getLogger(__name__)

MAX_LAG = 0.25
"""Seconds of wall time that the simulation may fall behind before the lost time is dropped."""


class Pacer:
    """Computes how long to wait for the next simulation step. Used by the physics thread only."""

    def __init__(self, speed: float, now: Callable[[], float] = time.monotonic) -> None:
        """Make a pacer.

        Args:
            speed: simulated seconds per wall second; infinity for as fast as possible.
            now: the wall clock, seconds.
        """
        self.speed = speed
        self._now = now
        self._due = now()
        self._has_warned = False
        self.lost = 0.0
        """Seconds of wall time that were dropped so far."""

    def restart(self) -> None:
        """Make the next simulation step due now, because the simulation was started or resumed."""
        self._due = self._now()

    def seconds_left(self) -> float:
        """Return the wall time in seconds until the next simulation step is due; 0 when it is."""
        return max(0.0, self._due - self._now())

    def passed(self, time_step: float) -> None:
        """Record that a simulation step was made.

        Args:
            time_step: its simulated seconds.
        """
        now = self._now()
        if math.isinf(self.speed):
            self._due = now
            return
        self._due += time_step / self.speed
        lag = now - self._due
        if lag > MAX_LAG:
            self._due = now
            self.lost += lag
            if not self._has_warned:
                self._has_warned = True
                logger.warning(
                    "the simulation cannot keep up with speed %g on this machine; it runs as fast as it can",
                    self.speed,
                )
