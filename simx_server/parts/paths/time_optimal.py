"""The fastest motion along a path within limits of velocity and acceleration.

The method is TOPP-RA: H. Pham, Q.-C. Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis, IEEE Transactions on Robotics 34 (2018). The squared speed along the path is x, the acceleration along it u.
A pass from the end finds at each grid point the greatest x from which rest at the end can be reached; a pass from the
start accelerates as much as these x and the limits allow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simx_server.errors import CommandError

from .splines import Array, CubicSpline

_GRID = 1000
"""Least number of intervals of the grid; all knots of the spline are grid points."""

_PER_SEGMENT = 10

_TINY = 1e-12


@dataclass(frozen=True)
class Limits:
    """Limits of one quantity: (dimensions,) each, the lower ones below 0 and the upper ones above."""

    lower: Array
    upper: Array


def time_optimal(
    spline: CubicSpline, velocity: Limits, acceleration: Limits, samples: int
) -> tuple[Array, Array]:
    """Return points (samples, dimensions) at equal intervals of time, from rest to rest, and their times in s.

    Raises CommandError: the path has no motion within the limits.
    """
    grid = _grid(spline.knots)
    step = np.diff(grid)
    _, first, second = spline.at(grid)
    slowest = _greatest_speed(first, velocity)
    lines = [_acceleration_lines(first, second, step, acceleration, ahead) for ahead in (False, True)]
    inertia, centrifugal, bound = (np.concatenate(parts, axis=1) for parts in zip(*lines, strict=True))
    reachable = _backwards(slowest, step, inertia, centrifugal, bound)
    squared = _forwards(reachable, step, inertia, centrifugal, bound)
    speed = np.sqrt(squared)
    with np.errstate(divide="ignore"):
        times = np.concatenate([[0.0], np.cumsum(2 * step / (speed[:-1] + speed[1:]))])
    if not np.isfinite(times[-1]):
        raise CommandError("the path cannot be followed within these limits of velocity and acceleration")
    wanted: Array = times[-1] * np.arange(samples) / (samples - 1)
    index = np.clip(np.searchsorted(times, wanted, side="right") - 1, 0, len(step) - 1)
    since = wanted - times[index]
    change = (squared[index + 1] - squared[index]) / (2 * step[index])
    along = grid[index] + since * (speed[index] + since * change / 2)
    return spline.at(np.clip(along, grid[0], grid[-1]))[0], wanted


def _grid(knots: Array) -> Array:
    count = max(_PER_SEGMENT, math.ceil(_GRID / (len(knots) - 1)))
    shares = np.arange(count) / count
    inner = knots[:-1, None] + np.diff(knots)[:, None] * shares
    return np.append(inner.ravel(), knots[-1])


def _greatest_speed(first: Array, velocity: Limits) -> Array:
    """Return the greatest squared speed along the path at each grid point; infinite where nothing moves."""
    with np.errstate(divide="ignore", invalid="ignore"):
        fastest = np.where(first > 0, velocity.upper / first, velocity.lower / first)
    return np.min(np.where(np.abs(first) > _TINY, fastest, np.inf), axis=1) ** 2


def _acceleration_lines(
    first: Array, second: Array, step: Array, limits: Limits, ahead: bool
) -> tuple[Array, Array, Array]:
    """Return the conditions ``inertia * u + centrifugal * x <= bound`` at each interval, (intervals, conditions).

    Args:
        ahead: those at the end of the interval, where the squared speed is ``x + 2 * step * u``.
    """
    inertia, centrifugal = (first[1:], second[1:]) if ahead else (first[:-1], second[:-1])
    if ahead:
        inertia = inertia + 2 * step[:, None] * centrifugal
    bound = np.broadcast_to(np.concatenate([limits.upper, -limits.lower]), (len(step), 2 * first.shape[1]))
    return np.hstack([inertia, -inertia]), np.hstack([centrifugal, -centrifugal]), bound


def _backwards(slowest: Array, step: Array, inertia: Array, centrifugal: Array, bound: Array) -> Array:
    """Return the greatest squared speed at each grid point from which rest at the end can be reached."""
    reachable = np.empty(len(step) + 1)
    reachable[-1] = 0.0
    for i in range(len(step) - 1, -1, -1):
        # Each condition with a positive factor bounds u from above, with a negative one from below; two more keep the
        # next squared speed between 0 and what is reachable from there.
        a = np.append(inertia[i], (2 * step[i], -2 * step[i]))
        b = np.append(centrifugal[i], (1.0, -1.0))
        c = np.append(bound[i], (reachable[i + 1], 0.0))
        upper, lower, free = a > _TINY, a < -_TINY, np.abs(a) <= _TINY
        best = slowest[i]
        if free.any():
            falls = free & (b > _TINY)
            best = min(best, np.min(c[falls] / b[falls], initial=np.inf))
        # Lines of u over x: u <= top - top_slope * x and u >= bottom - bottom_slope * x.
        top, top_slope = c[upper] / a[upper], b[upper] / a[upper]
        bottom, bottom_slope = c[lower] / a[lower], b[lower] / a[lower]
        closing = top_slope[:, None] - bottom_slope
        gap = top[:, None] - bottom
        meets = closing > _TINY
        best = min(best, np.min(gap[meets] / closing[meets], initial=np.inf))
        reachable[i] = max(best, 0.0)
    return reachable


def _forwards(reachable: Array, step: Array, inertia: Array, centrifugal: Array, bound: Array) -> Array:
    """Return the squared speed at each grid point of the fastest motion from rest."""
    squared = np.zeros(len(reachable))
    for i in range(len(step)):
        limiting = inertia[i] > _TINY
        room = (bound[i] - centrifugal[i] * squared[i])[limiting] / inertia[i][limiting]
        greatest = squared[i] + 2 * step[i] * np.min(room, initial=np.inf)
        squared[i + 1] = min(max(greatest, 0.0), reachable[i + 1])
    return squared
