"""The minimum distance between two sets of triangles: exact for surfaces of any shape, hollow or not.

Consecutive triangles are bundled, and the bundles too; `GeomTriangles` puts neighbours side by side. Pairs of
bundles are examined from the nearest on, so time and memory grow with the number of near pairs, not with all pairs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.sensors.proximity.seen import cross
from simx_server.sensors.triangles import TOGETHER, Array, bundled, with_balls

_BUNDLES_AT_ONCE = 32
_PAIRS_AT_ONCE = 4096
_ROUNDING = 1e-12
_SAMPLE = 256

_NEXT = [1, 2, 0]


class Gap(NamedTuple):
    """The distance of two surfaces and its points."""

    distance: float
    """Distance in metres, 0 where they meet."""
    first: Array
    second: Array
    """(3,) each: the nearest points; nan when only a limit of the distance is known."""


_NOWHERE = np.full(3, np.nan)


def least_distance(first: Array, second: Array, limit: float) -> float:
    """Return metres between triangles (n, 3, 3) and (m, 3, 3), 0 where they meet.

    The result is `limit` if none are closer than that.
    """
    return least_gap(first, second, limit).distance


def least_gap(first: Array, second: Array, limit: float) -> Gap:
    """Return the same with the points."""
    height = max(_height(len(first)), _height(len(second)))
    along = second.mean(axis=(0, 1)) - first.mean(axis=(0, 1)) if len(first) and len(second) else np.zeros(3)
    along /= max(math.sqrt(_dot(along, along)), 1e-300)
    one, other = _Tree(first, height, -along), _Tree(second, height, along)
    best = _first_guess(one, other, Gap(limit, _NOWHERE, _NOWHERE))
    top = (np.arange(len(tree.levels[-1].radii)) for tree in (one, other))
    mine, theirs = (each.ravel() for each in np.meshgrid(*top, indexing="ij"))
    return _search(one, other, height, _sorted(one, other, height, mine, theirs, best.distance), best)


def _first_guess(one: _Tree, other: _Tree, best: Gap) -> Gap:
    """Return the gap between the centres of a few triangles, which lie on the surfaces; or `best` if smaller."""
    mine, theirs = one.sample(), other.sample()
    away = mine[:, np.newaxis] - theirs
    squares = _dot(away, away)
    if squares.size == 0:
        return best
    row, column = np.unravel_index(int(squares.argmin()), squares.shape)
    found = Gap(math.sqrt(squares[row, column]), mine[row], theirs[column])
    return min(best, found, key=_by_distance)


class _Nodes(NamedTuple):
    """Nodes of a level: balls that hold all below a node, (n, 3) and (n,), and its minimum along a direction, (n,)."""

    centres: Array
    radii: Array
    begins: Array


def _height(triangles: int) -> int:
    """Return the number of levels of bundles above this many triangles, until few bundles are left."""
    return 0 if triangles <= TOGETHER else 1 + _height(-(-triangles // TOGETHER))


class _Tree:
    """Triangles, bundles of them, bundles of these and so on; the children of node i start at node i * `TOGETHER`."""

    def __init__(self, corners: Array, height: int, direction: Array) -> None:
        """Bundle triangles. `direction`: from the other set; along it these start behind the gap."""
        self.corners, centres, radii = with_balls(corners)
        begins = (corners @ direction).min(axis=1, initial=math.inf)
        self.levels = [_Nodes(centres, radii, begins)]
        for _ in range(height):
            starts, _, centres, radii = bundled(centres, radii)
            begins = np.minimum.reduceat(begins, starts)
            self.levels.append(_Nodes(centres, radii, begins))

    def sample(self) -> Array:
        """Return (n, 3) centres of triangles from all over the surface, at most `_SAMPLE`."""
        centres = self.levels[0].centres
        step = TOGETHER * max(1, math.ceil(len(centres) / (TOGETHER * _SAMPLE)))
        return centres[::step]

    def below(self, level: int, nodes: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Return the child nodes (n, TOGETHER) at a level, and which of them exist: the last node may have fewer."""
        found = nodes[:, np.newaxis] * TOGETHER + np.arange(TOGETHER)
        real = found < len(self.levels[level].radii)
        return np.where(real, found, 0), real


class _Pairs(NamedTuple):
    """Pairs of nodes of a level, the nearest first."""

    mine: NDArray[np.intp]
    theirs: NDArray[np.intp]
    bounds: Array
    """Lower bounds in metres: no triangles of a pair are nearer."""


def _sorted(
    one: _Tree, other: _Tree, level: int, mine: NDArray[np.intp], theirs: NDArray[np.intp], limit: float
) -> _Pairs:
    """Return the pairs that may come as near as the limit."""
    ours, yours = one.levels[level], other.levels[level]
    away = ours.centres[mine] - yours.centres[theirs]
    bounds = np.sqrt(_dot(away, away)) - ours.radii[mine] - yours.radii[theirs]
    # A plane between bodies that are far apart separates them better than balls, which are all about as
    # near.
    begins = ours.begins[mine], yours.begins[theirs]
    bounds = np.maximum(bounds, sum(begins) - _ROUNDING * sum(map(np.abs, begins)))
    near = np.flatnonzero(bounds <= limit)
    near = near[np.argsort(bounds[near])]
    return _Pairs(mine[near], theirs[near], bounds[near])


def _search(one: _Tree, other: _Tree, level: int, pairs: _Pairs, best: Gap) -> Gap:
    """Return the minimum gap between nodes pair by pair, or `best` if that is smaller."""
    at_once = _PAIRS_AT_ONCE if level == 0 else _BUNDLES_AT_ONCE
    for start in range(0, len(pairs.bounds), at_once):
        if pairs.bounds[start] > best.distance or best.distance <= 0.0:
            break
        mine, theirs = pairs.mine[start : start + at_once], pairs.theirs[start : start + at_once]
        if level == 0:
            best = min(best, _pairs(one.corners[mine], other.corners[theirs]), key=_by_distance)
            continue
        (ours, are_ours), (yours, are_yours) = one.below(level - 1, mine), other.below(level - 1, theirs)
        are_real = are_ours[:, :, np.newaxis] & are_yours[:, np.newaxis]
        rows, columns = (
            np.broadcast_to(nodes, are_real.shape)[are_real]
            for nodes in (ours[:, :, np.newaxis], yours[:, np.newaxis])
        )
        below = _sorted(one, other, level - 1, rows, columns, best.distance)
        best = _search(one, other, level - 1, below, best)
    return best


def _by_distance(gap: Gap) -> float:
    return gap.distance


def _pairs(first: Array, second: Array) -> Gap:
    """Return the minimum gap of triangles pair by pair, (n, 3, 3) each."""
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
    """Return the gap between any edge of one and any of the other. Segments: p + s u and q + t v, s and t in 0..1."""
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
    """Return the gap from corners of one to the inside of the other."""
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
    """Return a point (3,) where an edge passes through the other triangle of its pair, or None."""
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
    """Return (n, k): whether points (n, k, 3) of each triangle's plane lie within it."""
    inward = cross(normal[:, np.newaxis], faces[:, _NEXT] - faces)
    offset = points[:, :, np.newaxis] - faces[:, np.newaxis]
    return np.all(np.einsum("nkei,nei->nke", offset, inward) >= 0.0, axis=2)


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)
