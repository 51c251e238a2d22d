"""Measure the load of a server: recent simulated time and processor time per second of the wall clock."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

INTERVAL = 1.0
"""Seconds between two samples while simulation steps are made."""

LEAST = 0.5
"""Seconds that a figure should cover at least."""


class Load(NamedTuple):
    real_time_factor: float
    """Simulated seconds per second."""

    core_share: float
    """Processor seconds of all threads of the process per second."""


class _Sample(NamedTuple):
    wall: float
    processor: float
    simulated: float


class LoadMeter:
    """Counts simulation steps. Used by the physics thread alone."""

    def __init__(
        self,
        now: Callable[[], float] = time.monotonic,
        processor: Callable[[], float] = time.process_time,
    ) -> None:
        self._now, self._processor = now, processor
        self._simulated = 0.0
        self._samples: deque[_Sample] = deque([self._sample()], maxlen=3)

    def passed(self, time_step: float) -> None:
        """Record that a simulation step was made.

        Args:
            time_step: its simulated seconds.
        """
        self._simulated += time_step
        since = self._now() - self._samples[-1].wall
        if since >= INTERVAL:
            if since > 2 * INTERVAL:  # samples before a pause do not describe the present
                self._samples.clear()
            self._samples.append(self._sample())

    def load(self) -> Load:
        """Return the load over the last one or two seconds; for a stopped simulation, since the last call."""
        present = self._sample()
        old_enough = [sample for sample in self._samples if present.wall - sample.wall >= LEAST]
        since = old_enough[-1] if old_enough else self._samples[0]
        if present.wall - self._samples[-1].wall >= INTERVAL:
            self._samples.append(present)
        span = present.wall - since.wall
        if span <= 0:
            return Load(0.0, 0.0)
        return Load(
            (present.simulated - since.simulated) / span, (present.processor - since.processor) / span
        )

    def _sample(self) -> _Sample:
        return _Sample(self._now(), self._processor(), self._simulated)
