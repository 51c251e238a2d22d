"""Find the points that lie near other points."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

Array = NDArray[np.float64]

LEAST_TOLERANCE = 1e-7
"""Metres: V-REP keeps points in single precision."""

_FEW = 100_000
"""Pairs of points up to which all are compared at once; more, and a grid is quicker."""

_AT_ONCE = 1_000_000
_MOST_PAIRS = 50_000_000
"""Pairs that are compared in one call, which takes about two seconds."""

_MOST_CELLS = 1 << 62

_MIXERS = np.array([73856093, 19349663, 83492791], np.int64)
"""Primes that make one number of the three of a cell; different cells rarely get the same, which costs time only."""


def near(points: Array, others: Array, tolerance: float) -> NDArray[np.bool_]:
    """Return (n,) whether each point (n, 3) has one of the others (m, 3) within the tolerance in metres.

    Raises:
        CommandError: the tolerance reaches too many of the others.
    """
    tolerance = max(tolerance, LEAST_TOLERANCE)
    found = np.zeros(len(points), bool)
    if not len(points) or not len(others):
        return found
    if len(points) * len(others) <= _FEW:
        away = points[:, np.newaxis] - others
        return (np.einsum("nmi,nmi->nm", away, away) <= tolerance * tolerance).any(axis=1)
    found = _share_a_cell(points, others, tolerance / math.sqrt(3.0) * 0.999)
    rest = np.flatnonzero(~found)
    found[rest] = _by_grid(points[rest], others, tolerance)
    return found


def _share_a_cell(points: Array, others: Array, edge: float) -> NDArray[np.bool_]:
    """Return (n,) whether each point lies in one cell of a grid with one of the others; without an answer, False."""
    low, high = (
        np.minimum(points.min(axis=0), others.min(axis=0)),
        np.maximum(points.max(axis=0), others.max(axis=0)),
    )
    x, y, z = (int(each) + 1 for each in np.floor((high - low) / edge))
    if x * y * z >= _MOST_CELLS:
        return np.zeros(len(points), bool)
    factors = np.array([y * z, z, 1], np.int64)
    keys, taken = (np.floor((each - low) / edge).astype(np.int64) @ factors for each in (points, others))
    return np.isin(keys, taken)


def _by_grid(points: Array, others: Array, tolerance: float) -> NDArray[np.bool_]:
    cells = np.floor(others / tolerance).astype(np.int64)
    keys = cells @ _MIXERS
    order = np.argsort(keys)
    keys, others = keys[order], others[order]
    own = np.floor(points / tolerance).astype(np.int64)
    found = np.zeros(len(points), bool)
    compared = 0
    for offset in product((0, -1, 1), repeat=3):
        left = np.flatnonzero(~found)
        wanted = (own[left] + offset) @ _MIXERS
        first, last = np.searchsorted(keys, wanted, "left"), np.searchsorted(keys, wanted, "right")
        counts = last - first
        while counts.any():
            # The candidates of all points are compared in rounds, so that a point that is found needs no more.
            now = np.flatnonzero(counts)
            share = np.minimum(counts[now], max(1, _AT_ONCE // len(now)))
            compared += int(share.sum())
            if compared > _MOST_PAIRS:
                raise CommandError(
                    f"a tolerance of {tolerance:g} m reaches too many of the {len(others)} points; choose a smaller "
                    "one, or fewer points"
                )
            rows = np.repeat(now, share)
            steps = np.arange(len(rows)) - np.repeat(np.cumsum(share) - share, share)
            away = points[left[rows]] - others[first[rows] + steps]
            hit = np.einsum("ni,ni->n", away, away) <= tolerance * tolerance
            found[left[rows[hit]]] = True
            first[now] += share
            counts[now] -= share
            counts[found[left]] = 0
    return found


class Spacing:
    """Points that are all at least a distance apart; it grows point by point."""

    def __init__(self, distance: float) -> None:
        self._distance = max(distance, LEAST_TOLERANCE)
        self._cells: dict[tuple[int, int, int], list[tuple[float, float, float]]] = {}

    def add(self, point: Array) -> bool:
        """Add a point (3,) and return True, unless it is too near to another one."""
        x, y, z = (float(number) for number in point)
        i, j, k = (math.floor(number / self._distance) for number in (x, y, z))
        for cell in product((i - 1, i, i + 1), (j - 1, j, j + 1), (k - 1, k, k + 1)):
            for other in self._cells.get(cell, ()):
                if math.dist(other, (x, y, z)) <= self._distance:
                    return False
        self._cells.setdefault((i, j, k), []).append((x, y, z))
        return True
