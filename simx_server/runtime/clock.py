"""When the next pass is due: real time, a multiple of it, or at once."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable

logger = logging.getLogger(__name__)

MAX_LAG = 0.25
"""Seconds of wall time the simulation may fall behind before the lost time is given up."""


class Pacer:
    """Says how long to wait for the next pass. Used by the physics thread only."""

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
        """Seconds of wall time that were given up so far."""

    def restart(self) -> None:
        """The next pass is due now: the simulation was started or resumed."""
        self._due = self._now()

    def seconds_left(self) -> float:
        """Wall time until the next pass is due; 0 when it is."""
        return max(0.0, self._due - self._now())

    def passed(self, time_step: float) -> None:
        """A pass of so many simulated seconds was made."""
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
