"""Find the triangles near sensors: many sensors and geoms in a few operations.

Neighbouring triangles form bundles with a ball around each; bundles out of reach are dropped before their triangles
are examined.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.forms import GeomTriangles
from simx_server.scene.geometry.triangles import Array, bundled

from .reach import Pairs
from .volume import Volume

Indices = NDArray[np.intp]


class _Table(NamedTuple):
    """Triangles of some geoms one after the other, in the geoms' own frames, and their bundles."""

    corners: Array
    """(t, 3, 3) corners."""
    centres: Array
    radii: Array
    """(t, 3) and (t,): the triangles' balls."""
    starts: Indices
    sizes: Indices
    """(b,) numbers of triangles in the bundles."""
    middles: Array
    reaches: Array
    """(b, 3) and (b,): the bundles' balls."""


_EMPTY = _Table(
    np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0),
    np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros((0, 3)), np.zeros(0),
)  # fmt: skip


class Bundles:
    """The triangles of one model's geoms; those of a geom are added on first use."""

    def __init__(self, triangles: GeomTriangles, geoms: int) -> None:
        self._triangles = triangles
        self._first = np.full(geoms, -1)
        """Index of a geom's first bundle; -1 while it has none here."""
        self._count = np.zeros(geoms, np.intp)
        self._table = _EMPTY

    def near(self, pairs: Pairs, volume: Volume) -> tuple[Indices, Array]:
        """Return the triangles that may meet the volumes of their sensors.

        Returns:
            (n,) which pair, and (n, 3, 3) a triangle of its geom, in the sensor's frame.
        """
        if len(pairs.geoms) == 0:
            return pairs.geoms, _EMPTY.corners
        self._add(pairs.geoms)
        table = self._table
        which, bundles = _numbers(self._first[pairs.geoms], self._count[pairs.geoms])
        if len(bundles) > len(pairs.geoms):  # else a bundle is a whole geom, which is known to be near
            near = volume.may_touch(pairs.to_sensor(which, table.middles[bundles]), table.reaches[bundles])
            which, bundles = which[near], bundles[near]
        some, rows = _numbers(table.starts[bundles], table.sizes[bundles])
        which = which[some]
        near = volume.may_touch(pairs.to_sensor(which, table.centres[rows]), table.radii[rows])
        which, rows = which[near], rows[near]
        return which, pairs.to_sensor(which, table.corners[rows])

    def _add(self, geoms: Indices) -> None:
        new = np.unique(geoms[self._first[geoms] < 0]).tolist()
        if not new:
            return
        tables = [self._table]
        triangles, bundles = len(self._table.corners), len(self._table.starts)
        for geom in new:
            corners, centres, radii = self._triangles.of(geom)
            starts, sizes, middles, reaches = bundled(centres, radii)
            self._first[geom], self._count[geom] = bundles, len(starts)
            more = _Table(corners, centres, radii, starts + triangles, sizes, middles, reaches)
            tables.append(more)
            triangles, bundles = triangles + len(corners), bundles + len(starts)
        self._table = _Table(*(np.concatenate(arrays) for arrays in zip(*tables, strict=True)))


def _numbers(starts: Indices, counts: Indices) -> tuple[Indices, Indices]:
    """Return ranges one after the other: which range, and the numbers from its start on."""
    which = np.repeat(np.arange(len(starts)), counts)
    before = np.cumsum(counts) - counts
    return which, np.arange(len(which)) + (starts - before)[which]
