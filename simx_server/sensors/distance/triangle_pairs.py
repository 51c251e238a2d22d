"""The minimum distance between two surfaces of triangles: exact for surfaces of any shape, hollow or not.

Pairs of boxes are examined from the nearest on, so time and memory grow with the number of near pairs, not with all
pairs. `native/_triangle_pairs.c` does the same operations in the same order where it is compiled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array
from simx_server.sensors.proximity.seen import cross

from .box_tree import Bounds, Indices, Placed, dot
from .native.loading import compiled_module

_BOXES_AT_ONCE, _PAIRS_AT_ONCE = 32, 512

_ROUNDING = 1e-9
"""Share of a distance by which a bound or a known distance may be wrong."""

_SMALLEST = 1e-12
"""The same in metres."""

_APART = 1e-6
"""Metres between the boxes of two triangles from which on none passes through the other, whatever rounding does."""

_MUCH = 1.0 - 1e-6
"""A distance that is less shorter than by this factor lies along the same line, on which the bounds look already."""

_NEXT = [1, 2, 0]

Pair = tuple[int, int]
"""Numbers of two triangles in the trees of their geoms."""


class Gap(NamedTuple):
    """The distance of two surfaces and its points."""

    distance: float
    """Distance in metres, 0 where they meet."""
    first: Array
    second: Array
    """(3,) each: the nearest points; nan when only a limit of the distance is known."""
    row: int = -1
    """Number of the pair of triangles among those that were examined together."""


_NOWHERE = np.full(3, np.nan)


class Found(NamedTuple):
    """The minimum distance, and the triangles that are this far apart."""

    gap: Gap
    pair: Pair | None = None


def least_gap(first: Placed, second: Placed, limit: float, guess: Pair | None = None) -> Found:
    """Return metres between two surfaces, 0 where they meet; the limit and no pair if they are not nearer.

    Args:
        first: triangles.
        second: triangles.
        limit: metres from which on a distance does not matter.
        guess: triangles that were nearest in a similar pose. The result does not depend on it, only the time does.
    """
    module = compiled_module()
    if module is not None:
        mine, theirs = (-1, -1) if guess is None else guess
        distance, *numbers, mine, theirs = module.least_gap(
            *(first.tree.corners, first.tree.boxes, first.turn, first.place),
            *(second.tree.corners, second.tree.boxes, second.turn, second.place),
            *(limit, mine, theirs),
        )
        gap = Gap(distance, np.array(numbers[:3]), np.array(numbers[3:]))
        return Found(gap, (mine, theirs) if mine >= 0 else None)
    search = _Search(first, second, limit, guess)
    search.run()
    if search.best.gap.distance <= 0.0 and search.is_guided:
        # Surfaces that meet have many such points, and a search ends at its first one.
        search = _Search(first, second, limit, None)
        search.run()
    return search.best


def come_within(first: Placed, second: Placed, margin: float) -> bool:
    """Return whether two surfaces meet, or are not farther apart than a margin (m)."""
    module = compiled_module()
    if module is None:
        return bool(least_gap(first, second, _beyond(margin)).gap.distance <= margin)
    return module.come_within(
        *(first.tree.corners, first.tree.boxes, first.turn, first.place),
        *(second.tree.corners, second.tree.boxes, second.turn, second.place),
        margin,
    )


class _Search:
    """One search for the minimum distance."""

    def __init__(self, first: Placed, second: Placed, limit: float, guess: Pair | None) -> None:
        """Leave out all that is farther than the limit, and than guessed triangles that are apart."""
        self._first, self._second = first, second
        self._bounds = Bounds(first, second)
        direction = second.middle - first.middle
        gap = None
        if guess is not None:
            mine, theirs = np.array(guess[:1]), np.array(guess[1:])
            gap = _pairs(first.corners(mine), second.corners(theirs), np.zeros(1, np.intp))
        self.is_guided = gap is not None and 0.0 < gap.distance < math.inf
        if gap is not None and self.is_guided:
            limit = min(limit, _beyond(gap.distance))
            direction = gap.second - gap.first
        self._bounds.look_along(direction)
        self.best = Found(Gap(limit, _NOWHERE, _NOWHERE))

    def run(self) -> None:
        """Examine all boxes of the highest level."""
        trees = self._first.tree, self._second.tree
        height = max(len(each.levels) for each in trees) - 1
        top = (np.arange(len(each.level(height).centres)) for each in trees)
        mine, theirs = (each.ravel() for each in np.meshgrid(*top, indexing="ij"))
        self.examine(height, mine, theirs)

    def examine(self, level: int, mine: Indices, theirs: Indices) -> None:
        """Examine boxes of a level pair by pair, the nearest first, and what is below them."""
        bounds = self._bounds.between(level, mine, theirs)
        near = np.flatnonzero(bounds <= _beyond(self.best.gap.distance))
        near = near[np.argsort(bounds[near], kind="stable")]
        mine, theirs, bounds = mine[near], theirs[near], bounds[near]
        at_once = _BOXES_AT_ONCE if level else _PAIRS_AT_ONCE
        for start in range(0, len(near), at_once):
            least = self.best.gap.distance
            if least <= 0.0 or bounds[start] > _beyond(least):
                return
            some = slice(start, start + at_once)
            if level == 0:
                self._compare(mine[some], theirs[some], bounds[some])
            else:
                self.examine(level - 1, *self._below(level - 1, mine[some], theirs[some]))

    def _below(self, level: int, mine: Indices, theirs: Indices) -> tuple[Indices, Indices]:
        ours, are_ours = self._first.tree.below(level, mine)
        yours, are_yours = self._second.tree.below(level, theirs)
        are_real = are_ours[:, :, np.newaxis] & are_yours[:, np.newaxis]
        rows, columns = np.broadcast_arrays(ours[:, :, np.newaxis], yours[:, np.newaxis])
        return rows[are_real], columns[are_real]

    def _compare(self, mine: Indices, theirs: Indices, bounds: Array) -> None:
        """Compare triangles pair by pair; of equally near ones those with the lowest numbers count, in any order."""
        ordered = np.lexsort((theirs, mine))
        mine, theirs = mine[ordered], theirs[ordered]
        close = np.flatnonzero(bounds[ordered] <= _APART)
        found = _pairs(self._first.corners(mine), self._second.corners(theirs), close)
        pair = int(mine[found.row]), int(theirs[found.row])
        best = self.best
        if found.distance < best.gap.distance or (
            found.distance == best.gap.distance and best.pair is not None and pair < best.pair
        ):
            self.best = Found(found, pair)
            if 0.0 < found.distance < _MUCH * best.gap.distance:
                self._bounds.look_along(found.second - found.first)


def _beyond(distance: float) -> float:
    """Return a distance with what rounding may add to it."""
    return distance * (1.0 + _ROUNDING) + _SMALLEST


def _by_distance(gap: Gap) -> tuple[float, int]:
    return gap.distance, gap.row


def _pairs(first: Array, second: Array, close: Indices) -> Gap:
    """Return the minimum gap of triangles pair by pair, (n, 3, 3) each; of equal ones that of the first pair.

    `close`: the pairs that may pass through each other.
    """
    edges, others = first[:, _NEXT] - first, second[:, _NEXT] - second
    for corners, sides, faces in ((first, edges, second), (second, others, first)):
        through = _pierced(corners[close], sides[close], faces[close])
        if through is not None:
            return through._replace(row=int(close[through.row]))
    back = _face_gap(second, first)
    found = (
        _face_gap(first, second),
        Gap(back.distance, back.second, back.first, back.row),
        _edge_gap(first, edges, second, others),
    )
    return min(found, key=_by_distance)


def _edge_gap(first: Array, edges: Array, second: Array, others: Array) -> Gap:
    """Return the gap between any edge of one and any of the other. Segments: p + s u and q + t v, s and t in 0..1."""
    p, u = first[:, :, np.newaxis], edges[:, :, np.newaxis]
    q, v = second[:, np.newaxis], others[:, np.newaxis]
    r = p - q
    a, e = dot(u, u), dot(v, v)
    b, c, f = dot(u, v), dot(u, r), dot(v, r)
    denominator = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(denominator > 1e-14 * a * e, np.clip((b * f - c * e) / denominator, 0.0, 1.0), 0.0)
        t = np.clip((b * s + f) / e, 0.0, 1.0)
        s = np.clip((b * t - c) / a, 0.0, 1.0)
    away = r + s[..., np.newaxis] * u - t[..., np.newaxis] * v
    # Not the squares, of which different ones have the same root: other searches compare the roots.
    distances = np.sqrt(np.nan_to_num(dot(away, away), nan=math.inf))
    pair, edge, side = np.unravel_index(int(distances.argmin()), distances.shape)
    least = float(distances[pair, edge, side])
    if not math.isfinite(least):
        return Gap(math.inf, _NOWHERE, _NOWHERE)
    return Gap(
        least,
        first[pair, edge] + s[pair, edge, side] * edges[pair, edge],
        second[pair, side] + t[pair, edge, side] * others[pair, side],
        int(pair),
    )


def _face_gap(corners: Array, faces: Array) -> Gap:
    """Return the gap from corners of one to the inside of the other."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.sqrt(dot(normal, normal))
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = normal / length[:, np.newaxis]
    heights = dot(corners - faces[:, :1], normal[:, np.newaxis])
    feet = corners - heights[..., np.newaxis] * normal[:, np.newaxis]
    away = np.where(_held(feet, faces, normal), np.abs(heights), math.inf)
    pair, corner = np.unravel_index(int(away.argmin()), away.shape)
    return Gap(float(away[pair, corner]), corners[pair, corner], feet[pair, corner], int(pair))


def _pierced(corners: Array, edges: Array, faces: Array) -> Gap | None:
    """Return a point where an edge passes through the other triangle of its pair as a gap of 0, or None."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    heights = dot(corners - faces[:, :1], normal[:, np.newaxis])
    ends = heights[:, _NEXT]
    crosses = heights * ends < 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        where = np.where(crosses, heights / (heights - ends), 0.0)
    points = corners + where[..., np.newaxis] * edges
    through = crosses & _held(points, faces, normal)
    if not through.any():
        return None
    pair, edge = np.unravel_index(int(through.argmax()), through.shape)
    return Gap(0.0, points[pair, edge], points[pair, edge], int(pair))


def _held(points: Array, faces: Array, normal: Array) -> NDArray[np.bool_]:
    """Return (n, k): whether points (n, k, 3) of each triangle's plane lie within it."""
    inward = cross(normal[:, np.newaxis], faces[:, _NEXT] - faces)
    offset = points[:, :, np.newaxis] - faces[:, np.newaxis]
    return np.all(dot(offset, inward[:, np.newaxis]) >= 0.0, axis=2)
