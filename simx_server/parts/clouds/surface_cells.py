"""The cells of a grid that the triangles of a surface meet, as V-REP makes octrees of shapes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

from .near import Array
from .voxels import FARTHEST, Cells

_MOST_PAIRS = 1_000_000
"""Pairs of a triangle and a cell of one size: a fifth of a second."""

_AT_ONCE = 50_000
"""Pairs between two moments at which others are served."""

_SLACK = 1e-6
"""A face on the border of two cells meets both: in parts of a cell, half its size grows by this."""

_OCTANTS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], np.int64)


def surface_cells(corners: Array, size: float, serve_others: Callable[[], object]) -> Cells:
    """Return the numbers (n, 3) of the cells that some triangles (m, 3, 3) meet; cell 0 starts at the origin.

    Args:
        corners: of the triangles, metres.
        size: edge of a cell in metres.
        serve_others: called between parts of the work.

    Raises:
        CommandError: too many cells, or one too far away.
    """
    corners = corners / size
    low, high = corners.min(axis=1), corners.max(axis=1)
    if len(corners) and not max(np.abs(low).max(), np.abs(high).max()) < FARTHEST:
        raise CommandError(
            f"the surface is more than {FARTHEST} voxels of {size:g} m away; choose larger ones"
        )
    # Each triangle starts with the eight cells around its lowest corner, of a size that it does not exceed.
    levels = np.ceil(np.log2(np.maximum((high - low).max(axis=1, initial=0.0), 1.0))).astype(np.int64)
    found: list[Cells] = []
    triangles, cells = np.zeros(0, np.intp), np.zeros((0, 3), np.int64)
    for level in range(int(levels.max(initial=0)), -1, -1):
        edge = float(1 << level)
        fresh = np.flatnonzero(levels == level)
        starts = np.floor(low[fresh] / edge - _SLACK).astype(np.int64)
        _check_room(len(cells) + len(_OCTANTS) * len(starts), size)
        cells = np.concatenate([cells, (starts[:, np.newaxis] + _OCTANTS).reshape(-1, 3)])
        triangles = np.concatenate([triangles, np.repeat(fresh, len(_OCTANTS))])
        met = _meet(corners, triangles, cells, edge, serve_others)
        triangles, cells = triangles[met], cells[met]
        if level:
            _check_room(len(_OCTANTS) * len(cells), size)
            cells = (2 * cells[:, np.newaxis] + _OCTANTS).reshape(-1, 3)
            triangles = np.repeat(triangles, len(_OCTANTS))
    found.append(cells)
    return np.unique(np.concatenate(found), axis=0)


def _check_room(pairs: int, size: float) -> None:
    """Raise CommandError for too many pairs, before they take memory."""
    if pairs > _MOST_PAIRS:
        raise CommandError(f"the surface meets too many voxels of {size:g} m; choose larger ones")


def _meet(
    corners: Array,
    triangles: NDArray[np.intp],
    cells: Cells,
    edge: float,
    serve_others: Callable[[], object],
) -> NDArray[np.bool_]:
    """Return (n,) whether triangles meet cells with this edge, in parts of the smallest cell."""
    found = np.zeros(len(cells), bool)
    columns = np.ascontiguousarray(corners.transpose(1, 2, 0))  # each number of all triangles together
    for first in range(0, len(cells), _AT_ONCE):
        serve_others()
        part = slice(first, first + _AT_ONCE)
        middles = np.ascontiguousarray(((cells[part] + 0.5) * edge).T)
        found[part] = _overlap(columns[:, :, triangles[part]] - middles, edge / 2 + _SLACK)
    return found


def _overlap(corners: Array, half: float) -> NDArray[np.bool_]:
    """Return (n,) whether triangles meet the cube around the origin: no axis separates them.

    Args:
        corners: of the triangles (3, 3, n): corner, axis, triangle.
        half: half the edge of the cube.
    """
    together = np.ones(corners.shape[2], bool)
    for axis in range(3):
        together &= _meets(corners[:, axis], half)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.cross(edges[0], edges[1], axis=0)
    away = np.abs((normals * corners[0]).sum(axis=0))
    together &= away <= half * np.abs(normals).sum(axis=0) * (1 + _SLACK)
    for edge in edges:
        for axis in range(3):
            one, other = (axis + 1) % 3, (axis + 2) % 3
            # The axis is the product of the edge and a side of the cube.
            heights = edge[other] * corners[:, one] - edge[one] * corners[:, other]
            reach = half * (np.abs(edge[one]) + np.abs(edge[other])) * (1 + _SLACK)
            together &= _meets(heights, reach)
    return together


def _meets(heights: Array, reach: Array | float) -> NDArray[np.bool_]:
    """Return (n,) whether the range of three numbers (3, n) meets the one from -`reach` to `reach`."""
    first, second, third = heights
    low, high = np.minimum(np.minimum(first, second), third), np.maximum(np.maximum(first, second), third)
    return (low <= reach) & (high >= -reach)
