"""The course of a run: quantities of objects and answers of calls over simulated time, and the calls in their order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .quantities import ANSWER

Floats = NDArray[np.float64]

SAME_TIME = 5e-4
"""Seconds between two times that are the same; the original's protocol counts milliseconds."""

MOST_CALLS = 200_000
"""Calls that are kept; a run that makes more is compared by its states and answers."""


class Quantity(NamedTuple):
    """One quantity of one object, or an answer."""

    owner: str
    """The object's name; of an answer the call, such as ``simxReadProximitySensor(nose)``."""

    name: str
    """One of `UNITS`."""

    def __str__(self) -> str:
        return self.owner if self.name == ANSWER else f"{self.owner} {self.name}"


class Series(NamedTuple):
    """The values of a quantity over time."""

    times: Floats
    """Seconds, rising, shape (n,)."""

    values: Floats
    """Shape (n, width)."""


class Call(NamedTuple):
    """One call of the program."""

    time: float
    """Simulated seconds when it was sent, as far as it is known."""

    function: str
    arguments: list[Any]
    """As JSON has them; handles are names of objects where these are known."""

    changes: bool
    """Whether it may change something, so that its place among the others counts."""

    def __str__(self) -> str:
        return f"{self.function}({', '.join(map(repr, self.arguments))})"


@dataclass
class Run:
    """One run of a program."""

    series: dict[Quantity, Series]
    calls: list[Call] = field(default_factory=list[Call])
    steps: bool = False
    """Whether the program made simulation steps itself."""

    @property
    def end(self) -> float:
        """Return the last time of any quantity in seconds."""
        return max((float(each.times[-1]) for each in self.series.values() if len(each.times)), default=0.0)


class Collector:
    """Collects samples of a run as they come.

    The time goes on where a program stops the simulation and starts it again. The state of a stopped simulation counts
    only before the first step.
    """

    def __init__(self) -> None:
        self._rows: dict[Quantity, list[tuple[float, tuple[float, ...]]]] = {}
        self._before = self._last = 0.0
        self.calls: list[Call] = []
        self.steps = False

    @property
    def time(self) -> float:
        """Return the newest time in seconds, over all runs of the simulation."""
        return self._before + self._last

    def at(self, time: float) -> float | None:
        """Return the time over all runs for a simulation time; None for one of a stopped simulation after a run."""
        if time <= 0 and self.time > 0:
            return None
        if time < self._last - SAME_TIME:
            self._before, self._last = self._before + self._last, time
        self._last = max(self._last, time)
        return self._before + time

    def add(self, time: float, values: Iterable[tuple[Quantity, Sequence[float]]]) -> None:
        """Add a sample; a newer one of the same time replaces the older one.

        Args:
            time: as `at` returned it.
        """
        for quantity, numbers in values:
            rows = self._rows.setdefault(quantity, [])
            row = time, tuple(map(float, numbers))
            if rows and time - rows[-1][0] < SAME_TIME:
                rows[-1] = row
            elif not rows or len(row[1]) == len(rows[0][1]):
                rows.append(row)

    def note(self, call: Call) -> None:
        """Add a call."""
        if len(self.calls) < MOST_CALLS:
            self.calls.append(call)

    def run(self) -> Run:
        """Return what was collected."""
        return Run(
            {
                quantity: Series(
                    np.array([time for time, _ in rows]),
                    np.array([numbers for _, numbers in rows], dtype=float),
                )
                for quantity, rows in self._rows.items()
                if len({len(numbers) for _, numbers in rows}) == 1
            },
            self.calls,
            self.steps,
        )
