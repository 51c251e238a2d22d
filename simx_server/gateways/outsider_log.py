"""Log what outsiders do wrong, but not more lines than people read: anyone can connect again and again."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

MOST = 20
"""Lines in each period."""

PERIOD = 60.0
"""Seconds."""


class OutsiderLog:
    """One log for all connections of a port. Any thread."""

    def __init__(self, logger: logging.Logger, clock: Callable[[], float] = time.monotonic) -> None:
        """Make a log.

        Args:
            logger: takes the lines.
            clock: seconds.
        """
        self._logger, self._clock = logger, clock
        self._lock = threading.Lock()
        self._until = 0.0
        self._count = 0
        """Lines of this period, also those that were left out."""

    def say(self, level: int, text: str, *values: object) -> None:
        """Log a line as ``logger.log`` does, unless there were too many; the next period starts with their number."""
        now = self._clock()
        with self._lock:
            left_out = 0
            if now >= self._until:
                left_out = max(0, self._count - MOST)
                self._until, self._count = now + PERIOD, 0
            self._count += 1
            is_said, is_last = self._count <= MOST, self._count == MOST
        if left_out:
            self._logger.warning("%d more lines about connections were left out", left_out)
        if is_said:
            self._logger.log(level, text, *values)
        if is_last:
            self._logger.warning("further lines about connections are left out for a while")
