"""Paths of joints through the points of a trajectory, as ros2_control's controller makes them.

Between points with positions only a path is straight; with velocities it is a cubic, with accelerations too a quintic.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

MOST_POINTS = 10_000
"""Points of a trajectory."""

LARGEST = 1e6
"""The greatest magnitude of a position, velocity or acceleration: rad or m, and seconds."""

Array = NDArray[np.float64]


class Sample(NamedTuple):
    """A path at one time: (n,) position, velocity and acceleration, and the number of the message's point before."""

    position: Array
    velocity: Array
    acceleration: Array
    point: int


class Path:
    """A path of n joints in time."""

    def __init__(
        self,
        times: Sequence[float],
        points: Sequence[tuple[Array, Array | None, Array | None]],
        added: int,
    ) -> None:
        """Make a path.

        Args:
            times: seconds, increasing.
            points: (n,) positions, and velocities and accelerations where they are known.
            added: points in front of those of the message.
        """
        self._times, self._points, self._added = times, points, added

    @property
    def duration(self) -> float:
        """Return the time of the last point, seconds."""
        return self._times[-1]

    @property
    def goal(self) -> Array:
        """Return the last positions."""
        return self._points[-1][0]

    def at(self, time: float) -> Sample:
        """Return the path at a time; before its first and after its last point it rests."""
        after = bisect_right(self._times, time)
        if after in (0, len(self._times)):
            position = self._points[0 if after == 0 else -1][0]
            still = np.zeros_like(position)
            return Sample(position, still, still, self._number(after))
        began = self._times[after - 1]
        span, passed = self._times[after] - began, time - began
        return Sample(
            *_between(self._points[after - 1], self._points[after], span, passed), self._number(after)
        )

    def _number(self, after: int) -> int:
        return max(after - 1 - self._added, 0)


def _between(
    one: tuple[Array, Array | None, Array | None],
    other: tuple[Array, Array | None, Array | None],
    span: float,
    passed: float,
) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration between two points, `span` seconds apart."""
    p, v, a = one
    q, w, b = other
    still = np.zeros_like(p)
    if v is None or w is None:
        rate = (q - p) / span
        return p + rate * passed, rate, still
    gap = q - p
    if a is None or b is None:
        factors = [p, v, (3 * gap / span - 2 * v - w) / span, ((v + w) - 2 * gap / span) / span**2]
    else:
        factors = [
            p,
            v,
            a / 2,
            (20 * gap - (8 * w + 12 * v) * span - (3 * a - b) * span**2) / (2 * span**3),
            (-30 * gap + (14 * w + 16 * v) * span + (3 * a - 2 * b) * span**2) / (2 * span**4),
            (12 * gap - 6 * (w + v) * span + (b - a) * span**2) / (2 * span**5),
        ]
    position, velocity, acceleration = still, still, still
    for power, factor in enumerate(factors):
        position = position + factor * passed**power
        velocity = velocity + (power * factor * passed ** (power - 1) if power else 0)
        acceleration = acceleration + (
            power * (power - 1) * factor * passed ** (power - 2) if power > 1 else 0
        )
    return position, velocity, acceleration


def read_path(message: Mapping[str, Any], start: Array) -> Path:
    """Return the path of a ``JointTrajectory`` for its own joints.

    Args:
        message: the trajectory.
        start: (n,) positions at its start, from which the first point is approached.

    Raises:
        CommandError: the points are not valid.
    """
    points: Sequence[Mapping[str, Any]] = message["points"]
    count = len(message["joint_names"])
    if not points:
        raise CommandError("the trajectory has no points")
    if len(points) > MOST_POINTS:
        raise CommandError(f"the trajectory has {len(points)} points; valid: up to {MOST_POINTS}")
    times: list[float] = []
    read: list[tuple[Array, Array | None, Array | None]] = []
    for number, point in enumerate(points):
        time = point["time_from_start"]["sec"] + point["time_from_start"]["nanosec"] * 1e-9
        if time < 0 or (times and time <= times[-1]):
            raise CommandError(f"point {number} is at {time:g} s; times are not negative and increase")
        position, velocity, acceleration = (
            _numbers(point[field], count, number, field, is_needed=field == "positions")
            for field in ("positions", "velocities", "accelerations")
        )
        assert position is not None
        times.append(time)
        read.append((position, velocity, acceleration if velocity is not None else None))
    added = int(times[0] > 0)
    if added:
        still = np.zeros_like(start)
        times.insert(0, 0.0)
        read.insert(0, (start, still, still))
    return Path(times, read, added)


def _numbers(values: Any, count: int, number: int, field: str, *, is_needed: bool) -> Array | None:
    if not len(values) and not is_needed:
        return None
    if len(values) != count:
        raise CommandError(f"point {number} has {len(values)} {field} for {count} joints")
    found = np.array(values, np.float64)
    if not (np.abs(found) <= LARGEST).all():  # false for NaN too
        raise CommandError(f"point {number} has {field} that are not finite, or beyond {LARGEST:g}")
    return found
