"""The least distance between two sets of triangles: exact for surfaces of any shape, hollow or not."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .seen import cross
from .triangles import TOGETHER, Array, bundled, with_balls

_BLOCK = TOGETHER
"""Triangles that follow each other are looked at together; `GeomTriangles` puts neighbours side by side."""
_BLOCK_PAIRS_AT_ONCE = 32
_PAIRS_AT_ONCE = 4096

_NEXT = [1, 2, 0]


class Gap(NamedTuple):
    """How near two surfaces come, and where."""

    distance: float
    """Metres, 0 where they meet."""
    first: Array
    second: Array
    """(3,) each: the nearest points; not numbers when only a limit of the distance is known."""


_NOWHERE = np.full(3, np.nan)


def least_distance(first: Array, second: Array, limit: float) -> float:
    """Metres between triangles (n, 3, 3) and (m, 3, 3), 0 where they meet; `limit` if none are closer than that."""
    return least_gap(first, second, limit).distance


def least_gap(first: Array, second: Array, limit: float) -> Gap:
    """The same with the points."""
    one, other = _Blocks(first), _Blocks(second)
    best = Gap(limit, _NOWHERE, _NOWHERE)
    # The centre of any triangle is a point of the surface.
    away = _distances(one.centres[::_BLOCK], other.centres[::_BLOCK])
    row, column = np.unravel_index(int(away.argmin()), away.shape)
    if away[row, column] < limit:
        best = Gap(float(away[row, column]), one.centres[::_BLOCK][row], other.centres[::_BLOCK][column])
    lower = _distances(one.middles, other.middles) - one.reaches[:, np.newaxis] - other.reaches
    near, far = np.nonzero(lower <= best.distance)
    bounds = lower[near, far]
    order = np.argsort(bounds)
    near, far, bounds = near[order], far[order], bounds[order]
    for start in range(0, len(near), _BLOCK_PAIRS_AT_ONCE):
        if bounds[start] > best.distance or best.distance <= 0.0:
            break
        some = slice(start, start + _BLOCK_PAIRS_AT_ONCE)
        best = _between(one, other, near[some], far[some], best)
    return best


class _Blocks:
    """Triangles, their balls, and the balls of each block of them."""

    def __init__(self, corners: Array) -> None:
        self.corners, self.centres, self.radii = with_balls(corners)
        _, _, self.middles, self.reaches = bundled(self.centres, self.radii)

    def members(self, blocks: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """(b, _BLOCK) indices of triangles, and which of them are real: the last block may have fewer."""
        found = blocks[:, np.newaxis] * _BLOCK + np.arange(_BLOCK)
        real = found < len(self.corners)
        return np.where(real, found, 0), real


def _between(one: _Blocks, other: _Blocks, near: NDArray[np.intp], far: NDArray[np.intp], best: Gap) -> Gap:
    """The least gap between blocks pair by pair, or `best` if that is less."""
    mine, is_mine = (array[:, :, np.newaxis] for array in one.members(near))
    theirs, is_theirs = (array[:, np.newaxis] for array in other.members(far))
    away = one.centres[mine] - other.centres[theirs]
    lower = np.sqrt(_dot(away, away)) - one.radii[mine] - other.radii[theirs]
    chosen = (lower <= best.distance) & is_mine & is_theirs
    bounds = lower[chosen]
    order = np.argsort(bounds)
    mine, theirs = (np.broadcast_to(index, lower.shape)[chosen][order] for index in (mine, theirs))
    bounds = bounds[order]
    for start in range(0, len(bounds), _PAIRS_AT_ONCE):
        if bounds[start] > best.distance or best.distance <= 0.0:
            break
        some = slice(start, start + _PAIRS_AT_ONCE)
        best = min(best, _pairs(one.corners[mine[some]], other.corners[theirs[some]]), key=_by_distance)
    return best


def _by_distance(gap: Gap) -> float:
    return gap.distance


def _pairs(first: Array, second: Array) -> Gap:
    """Least gap of triangles pair by pair, (n, 3, 3) each."""
    edges, others = first[:, _NEXT] - first, second[:, _NEXT] - second
    for corners, sides, faces in ((first, edges, second), (second, others, first)):
        point = _pierced(corners, sides, faces)
        if point is not None:
            return Gap(0.0, point, point)
    back = _face_gap(second, first)
    found = (
        _face_gap(first, second),
        Gap(back.distance, back.second, back.first),
        _edge_gap(first, edges, second, others),
    )
    return min(found, key=_by_distance)


def _edge_gap(first: Array, edges: Array, second: Array, others: Array) -> Gap:
    """Between any edge of one and any of the other. Segments as p + s u and q + t v, s and t within 0..1."""
    p, u = first[:, :, np.newaxis], edges[:, :, np.newaxis]
    q, v = second[:, np.newaxis], others[:, np.newaxis]
    r = p - q
    a, e = _dot(u, u), _dot(v, v)
    b, c, f = _dot(u, v), _dot(u, r), _dot(v, r)
    denominator = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(denominator > 1e-14 * a * e, np.clip((b * f - c * e) / denominator, 0.0, 1.0), 0.0)
        t = np.clip((b * s + f) / e, 0.0, 1.0)
        s = np.clip((b * t - c) / a, 0.0, 1.0)
    away = r + s[..., np.newaxis] * u - t[..., np.newaxis] * v
    squares = np.nan_to_num(_dot(away, away), nan=math.inf)
    pair, edge, side = np.unravel_index(int(squares.argmin()), squares.shape)
    least = squares[pair, edge, side]
    if not math.isfinite(least):
        return Gap(math.inf, _NOWHERE, _NOWHERE)
    return Gap(
        math.sqrt(least),
        first[pair, edge] + s[pair, edge, side] * edges[pair, edge],
        second[pair, side] + t[pair, edge, side] * others[pair, side],
    )


def _face_gap(corners: Array, faces: Array) -> Gap:
    """From corners of one to the inside of the other."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.sqrt(_dot(normal, normal))
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = normal / length[:, np.newaxis]
    heights = np.einsum("nki,ni->nk", corners - faces[:, :1], normal)
    feet = corners - heights[..., np.newaxis] * normal[:, np.newaxis]
    away = np.where(_held(feet, faces, normal), np.abs(heights), math.inf)
    pair, corner = np.unravel_index(int(away.argmin()), away.shape)
    return Gap(float(away[pair, corner]), corners[pair, corner], feet[pair, corner])


def _pierced(corners: Array, edges: Array, faces: Array) -> Array | None:
    """(3,) where an edge goes through the other triangle of its pair, or None."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    heights = np.einsum("nki,ni->nk", corners - faces[:, :1], normal)
    ends = heights[:, _NEXT]
    crosses = heights * ends < 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        where = np.where(crosses, heights / (heights - ends), 0.0)
    points = corners + where[..., np.newaxis] * edges
    through = crosses & _held(points, faces, normal)
    return points[through][0] if through.any() else None


def _held(points: Array, faces: Array, normal: Array) -> NDArray[np.bool_]:
    """(n, k): whether points (n, k, 3) of each triangle's plane lie within it."""
    inward = cross(normal[:, np.newaxis], faces[:, _NEXT] - faces)
    offset = points[:, :, np.newaxis] - faces[:, np.newaxis]
    return np.all(np.einsum("nkei,nei->nke", offset, inward) >= 0.0, axis=2)


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)


def _distances(points: Array, others: Array) -> Array:
    """(n, m) between points (n, 3) and (m, 3)."""
    away = points[:, np.newaxis] - others
    return np.sqrt(_dot(away, away))
