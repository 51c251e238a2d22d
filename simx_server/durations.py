"""Count durations by size, at a cost of about 0.3 us each."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import accumulate

MAX_TEXT = 300
"""Characters of an error that are kept."""

MAX_CAMERAS = 256
"""Cameras counted by name; all further ones are counted together."""

OTHERS = "(others)"

BOUNDS = tuple(1e-6 * 2 ** (step / 4) for step in range(108))
"""Seconds, from a microsecond to two minutes; each is 19 % more than the one before."""

_MIDDLES = (BOUNDS[0], *(bound * 2**0.125 for bound in BOUNDS))
"""The value that stands for a count between two bounds: the geometric middle."""


class Histogram:
    """Counts durations by size. One thread adds; another may read, and misses the newest at worst."""

    __slots__ = ("counts", "longest", "seconds")

    def __init__(self) -> None:
        self.counts = [0] * (len(BOUNDS) + 1)
        self.seconds = 0.0
        """Sum of all durations."""

        self.longest = 0.0

    def add(self, seconds: float, times: int = 1) -> None:
        self.counts[bisect_right(BOUNDS, seconds)] += times
        self.seconds += seconds * times
        if seconds > self.longest:
            self.longest = seconds


def percentiles(counts: Sequence[int], shares: Sequence[float] = (0.5, 0.9, 0.99)) -> list[float]:
    """Return the seconds below which these shares of the counted durations stay, within 10 %; 0 when there are none."""
    reached = list(accumulate(counts))
    if not reached[-1]:
        return [0.0] * len(shares)
    return [_MIDDLES[bisect_left(reached, share * reached[-1])] for share in shares]


class ImageTimes:
    """How long images took, by camera. The render thread adds."""

    def __init__(self) -> None:
        self.by_camera: dict[str, Histogram] = {}
        self.failed = 0
        self.last_error = ""

    def made(self, camera: str, seconds: float) -> None:
        times = self.by_camera.get(camera)
        if times is None:
            name = camera if len(self.by_camera) < MAX_CAMERAS else OTHERS
            times = self.by_camera.setdefault(name, Histogram())
        times.add(seconds)

    def not_made(self, error: str) -> None:
        self.failed += 1
        self.last_error = error[:MAX_TEXT]
