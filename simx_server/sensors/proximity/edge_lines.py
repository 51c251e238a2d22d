"""Which triangles of a geom a line may cross: the edges as lines, on whose sides the line passes.

A line crosses a triangle if it passes all its edges on the same side. With Pluecker's coordinates the side is one
product: of a direction and moment of the line with moment and direction of the edge.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.forms import GeomTriangles
from simx_server.scene.geometry.triangles import TOGETHER, Array, bundled

_FEW = 1000
"""Triangles up to which all are examined; of more, the bundles of neighbours are examined first."""

_SLACK = 1e-7
"""Share of the longest edge, and of its product with metres: more than rounding, so no crossed triangle is missed."""

_IN_BUNDLE = np.arange(TOGETHER)


class _Table(NamedTuple):
    """The triangles of one geom."""

    edges: Array
    """(3, t, 6): per edge its moment about the frame's origin and its direction, metres^2 and metres."""
    longest: float
    """Length of the longest edge in metres."""
    middles: Array
    squares: Array
    """(b, 3) and (b,): centres and squared radii of the bundles' balls; a little more than those."""


class EdgeLines:
    """The edges of one model's geoms; those of a geom are made on first use."""

    def __init__(self, triangles: GeomTriangles) -> None:
        self._triangles = triangles
        self._tables: dict[int, _Table] = {}

    def crossed(self, geom: int, start: Sequence[float], direction: Sequence[float]) -> NDArray[np.intp]:
        """Return the triangles of a geom that a line may cross, all that it does cross among them.

        Args:
            geom: the geom; not a plane.
            start: a point of the line in the geom's frame.
            direction: its direction, a unit vector.
        """
        table = self._tables.get(geom)
        if table is None:
            table = self._tables[geom] = self._table(geom)
        (x, y, z), (u, v, w) = start, direction
        line = np.array((u, v, w, y * w - z * v, z * u - x * w, x * v - y * u))
        slack = _SLACK * table.longest * (1.0 + math.hypot(x, y, z))
        if table.edges.shape[1] <= _FEW:
            return _one_sided(table.edges @ line, slack)
        # The distance of a point from the line: of its moment about the point.
        moments = np.cross(table.middles, line[:3]) - line[3:]
        bundles = np.flatnonzero(np.einsum("ni,ni->n", moments, moments) <= table.squares)
        rows = (bundles[:, np.newaxis] * TOGETHER + _IN_BUNDLE).ravel()
        rows = rows[: np.searchsorted(rows, table.edges.shape[1])]
        return rows[_one_sided(table.edges[:, rows] @ line, slack)]

    def _table(self, geom: int) -> _Table:
        corners, centres, radii = self._triangles.of(geom)
        edges = np.roll(corners, -1, axis=1) - corners
        lines = np.concatenate([np.cross(corners, edges), edges], axis=2)
        longest = float(np.sqrt(np.einsum("nei,nei->ne", edges, edges).max(initial=0.0)))
        _, _, middles, reaches = bundled(centres, radii)
        return _Table(
            np.ascontiguousarray(lines.transpose(1, 0, 2)), longest, middles, (1.001 * reaches + 1e-6) ** 2
        )


def _one_sided(sides: Array, slack: float) -> NDArray[np.intp]:
    """Return which columns of (3, n) have no two signs."""
    return np.flatnonzero((sides.min(axis=0) >= -slack) | (sides.max(axis=0) <= slack))
