"""Random starts of a search: where they may be, how near to the goal, and how many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import monotonic

import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.poses.poses import Pose

from ..errors import CommandError
from .chain import Joints
from .least_squares.rows import weighted_length
from .scratch import Array

LONGEST = 60.0
"""Maximum duration in seconds of a search or a plan, even if a script requests more."""

_LOOKS_PER_SAMPLE, _SECONDS_PER_CHECK = 0.2, 1e-3
"""Work of a random start that is too far away, and of a check whether a configuration is accepted."""

_PATIENCE = 10.0
"""Work that takes this many times as long as foreseen ends a search by the clock."""

_USUAL_METRIC = (1.0, 1.0, 1.0, 0.1)


@dataclass(frozen=True)
class Nearness:
    """How near the tips must be to their goals, before a random start is worth solving."""

    threshold: float
    """Greatest length of the weighted differences of a pose."""
    metric: tuple[float, ...] = _USUAL_METRIC
    """Weights of x, y, z (m, along the world's axes) and of the angle (rad)."""

    @classmethod
    def checked(cls, threshold: float, metric: Sequence[float] | None) -> Nearness:
        """Return what a script asks for; without a metric V-REP's own. Raises CommandError."""
        weights = tuple(metric or _USUAL_METRIC)
        if len(weights) != len(_USUAL_METRIC) or not all(map(math.isfinite, weights)):
            raise CommandError(f"a metric is four numbers, weights of x, y, z and the angle, not {weights}")
        return cls(threshold, weights)

    def includes(self, tips: Sequence[Pose], goals: Sequence[Pose]) -> bool:
        """Return whether all tips are near their goals."""
        return all(
            weighted_length(tip, goal, self.metric) <= self.threshold
            for tip, goal in zip(tips, goals, strict=True)
        )


class Effort:
    """The work that a search may still do: counted, not timed, so that equal searches find the same.

    A second of it is about one of wall time on a slow machine.
    """

    def __init__(self, seconds: float, seconds_per_look: float) -> None:
        self._left = min(seconds, LONGEST)
        self._per_look = seconds_per_look
        self._end = monotonic() + min(_PATIENCE * seconds + 1.0, LONGEST)

    @property
    def is_left(self) -> bool:
        """Return whether the search may go on."""
        return self._left > 0 and monotonic() < self._end

    @property
    def looks(self) -> int:
        """Return the number of states that a solver may still look at."""
        return max(1, int(self._left / self._per_look))

    @property
    def samples(self) -> int:
        """Return the number of random starts that may still be tried."""
        return max(1, math.ceil(self._left / (_LOOKS_PER_SAMPLE * self._per_look)))

    def spend(self, *, looks: int = 0, samples: int = 0, checks: int = 0) -> None:
        """Count work that is done."""
        self._left -= (looks + samples * _LOOKS_PER_SAMPLE) * self._per_look + checks * _SECONDS_PER_CHECK


def sampling_range(joints: Joints) -> tuple[Array, Array]:
    """Return (minimum, range) of each joint; a joint without limits turns once, or moves by 1 m to both sides."""
    no_limit = np.where(joints.is_hinge, math.pi, 1.0)
    low = np.where(np.isfinite(joints.low), joints.low, -no_limit)
    high = np.where(np.isfinite(joints.high), joints.high, no_limit)
    return low, high - low


def asked_range(
    low: Sequence[float] | None, ranges: Sequence[float] | None, order: Sequence[int]
) -> tuple[Array, Array] | None:
    """Return (minimum, range) of each joint as a script passes them, in our order; None when it passes none.

    Args:
        low: minimum values in the script's order.
        ranges: ranges in the script's order.
        order: our index of each of the script's joints.

    Raises:
        CommandError: the number of values is wrong.
    """
    if not low or not ranges:
        return None
    if not len(low) == len(ranges) == len(order):
        raise CommandError(
            f"lowest values and ranges of random starts are one for each of the {len(order)} joints"
        )
    found = np.zeros(len(order)), np.zeros(len(order))
    found[0][list(order)], found[1][list(order)] = low, ranges
    return found


def wrapped(joints: Joints, values: Array) -> Array:
    """Return joint values with those of cyclic joints in -pi..pi."""
    endless = ~np.isfinite(joints.low) & joints.is_hinge
    return np.where(endless, np.remainder(values + math.pi, 2 * math.pi) - math.pi, values)


def turned_back(joints: Joints, values: Array) -> Array:
    """Return the same; values that are within -pi..pi stay as they are to the last bit."""
    return np.where(np.abs(values) > math.pi, wrapped(joints, values), values)
