"""The lines in which surfaces cut each other: a segment for each pair of triangles that meet."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.geometry.triangles import TOGETHER, Array
from simx_server.sensors.instant import Instant
from simx_server.sensors.proximity.seen import cross

from .measuring import triangles_in_world

MOST_PAIRS = 2_000_000
"""Most pairs of triangles that are examined, which takes a few seconds."""

_PAIRS_AT_ONCE = 20_000
_ROWS_AT_ONCE = 256

_NEXT = [1, 2, 0]
_SHORTEST = 1e-12
"""Length in metres up to which two triangles touch in a point only."""

_Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


def intersections(instant: Instant, first: Collection[int], second: Collection[int]) -> Array:
    """Return the segments (n, 2, 3) in which the surfaces of two sets of shapes cut each other, in the world, metres.

    An object does not cut itself. Triangles that lie in one plane give no segment.

    Raises:
        CommandError: there are too many near triangles.
    """
    owners, model = instant.surroundings.owners, instant.model
    found = [np.zeros((0, 2, 3))]
    mine, theirs = instant.geoms_of(first).tolist(), instant.geoms_of(second).tolist()
    for geom in mine:
        for other in theirs:
            reach = float(model.geom_rbound[geom] + model.geom_rbound[other])
            away = float(np.linalg.norm(instant.geom_xpos[geom] - instant.geom_xpos[other]))
            endless = min(model.geom_rbound[geom], model.geom_rbound[other]) <= 0.0
            if owners[geom] != owners[other] and (endless or away <= reach):
                one, two = triangles_in_world(instant, geom, other), triangles_in_world(instant, other, geom)
                found.append(cuts(one, two))
    return np.concatenate(found)


def cuts(first: Array, second: Array) -> Array:
    """Return the segments (k, 2, 3) in which triangles (n, 3, 3) and (m, 3, 3) cut each other.

    Raises:
        CommandError: there are too many near triangles.
    """
    found = [np.zeros((0, 2, 3))]
    pairs = 0
    for mine, theirs in _near(first, second):
        pairs += len(mine)
        if pairs > MOST_PAIRS:
            raise CommandError(f"more than {MOST_PAIRS} pairs of triangles are near each other")
        for start in range(0, len(mine), _PAIRS_AT_ONCE):
            some = slice(start, start + _PAIRS_AT_ONCE)
            found.append(_cut(first[mine[some]], second[theirs[some]]))
    return np.concatenate(found)


def _near(first: Array, second: Array) -> Iterator[_Pairs]:
    """Yield the indices of pairs of triangles whose boxes overlap; neighbours are examined as bundles first."""
    if len(first) == 0 or len(second) == 0:
        return
    (low, high), (other_low, other_high) = _boxes(first), _boxes(second)
    starts, other_starts = np.arange(0, len(first), TOGETHER), np.arange(0, len(second), TOGETHER)
    bundles = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
    others = np.minimum.reduceat(other_low, other_starts), np.maximum.reduceat(other_high, other_starts)
    for start in range(0, len(starts), _ROWS_AT_ONCE):
        rows = slice(start, start + _ROWS_AT_ONCE)
        overlap = _overlap(bundles[0][rows], bundles[1][rows], *others)
        mine, theirs = np.nonzero(overlap)
        for at in range(0, len(mine), _ROWS_AT_ONCE):
            ours = _members(mine[at : at + _ROWS_AT_ONCE] + start, len(first))
            yours = _members(theirs[at : at + _ROWS_AT_ONCE], len(second))
            one, two = np.repeat(ours, TOGETHER, axis=1).ravel(), np.tile(yours, TOGETHER).ravel()
            exist = (one >= 0) & (two >= 0)
            one, two = one[exist], two[exist]
            near = np.all((low[one] <= other_high[two]) & (other_low[two] <= high[one]), axis=1)
            yield one[near], two[near]


def _members(bundles: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Return the triangles (n, TOGETHER) of bundles, -1 for those that do not exist."""
    found = bundles[:, np.newaxis] * TOGETHER + np.arange(TOGETHER)
    return np.where(found < count, found, -1)


def _boxes(corners: Array) -> tuple[Array, Array]:
    return corners.min(axis=1), corners.max(axis=1)


def _overlap(low: Array, high: Array, other_low: Array, other_high: Array) -> NDArray[np.bool_]:
    """Return (n, m): whether boxes (n, 3) overlap boxes (m, 3)."""
    found = np.ones((len(low), len(other_low)), bool)
    for axis in range(3):
        found &= low[:, np.newaxis, axis] <= other_high[:, axis]
        found &= other_low[:, axis] <= high[:, np.newaxis, axis]
    return found


def _cut(first: Array, second: Array) -> Array:
    """Return the segments of triangles pair by pair, (n, 3, 3) each, for the pairs that cut each other."""
    points = np.concatenate([_pierced(first, second), _pierced(second, first)], axis=1)
    along = cross(_normals(first), _normals(second))
    places = np.einsum("nki,ni->nk", points, along)
    cut = np.isfinite(places).sum(axis=1) >= 2
    points, places = points[cut], places[cut]
    rows = np.arange(len(points))
    starts = points[rows, np.nan_to_num(places, nan=np.inf).argmin(axis=1)]
    ends = points[rows, np.nan_to_num(places, nan=-np.inf).argmax(axis=1)]
    segments = np.stack([starts, ends], axis=1)
    return segments[np.linalg.norm(ends - starts, axis=1) > _SHORTEST]


def _pierced(corners: Array, faces: Array) -> Array:
    """Return (n, 3, 3): for each edge the point where it passes through the other triangle, nan for none."""
    normal = _normals(faces)
    heights = np.einsum("nki,ni->nk", corners - faces[:, :1], normal)
    ends = heights[:, _NEXT]
    crosses = (heights > 0.0) != (ends > 0.0)
    where = np.divide(heights, heights - ends, out=np.zeros_like(heights), where=crosses)
    points = corners + where[..., np.newaxis] * (corners[:, _NEXT] - corners)
    inward = cross(normal[:, np.newaxis], faces[:, _NEXT] - faces)
    offset = points[:, :, np.newaxis] - faces[:, np.newaxis]
    held = np.all(np.einsum("nkei,nei->nke", offset, inward) >= 0.0, axis=2)
    return np.where((crosses & held)[..., np.newaxis], points, np.nan)


def _normals(corners: Array) -> Array:
    return cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
