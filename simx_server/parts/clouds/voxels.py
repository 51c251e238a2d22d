"""The cells of an octree, in its frame: cubes of one size, with a colour and a tag each.

As in V-REP, the frame's origin is a corner of eight cells.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

from .near import Array
from .points import Colors

Cells = NDArray[np.int64]
"""(n, 3) numbers of cells along x, y, z; cell 0 lies between 0 and the size."""

FARTHEST = 1 << 20
"""Most cells between the origin and a cell along an axis."""

_BITS = 21
_DEEPEST = 19
"""Levels of an octree that V-REP's number of a cell's location has room for."""

_FIT = 2.001
"""How much wider than the farthest coordinate V-REP makes a new octree."""


class _Box(NamedTuple):
    """The cube that an octree divides: its lowest cell along x, y, z, and its edge in cells."""

    low: tuple[int, int, int]
    edge: int


class Voxels:
    """Filled cells in the order in which they came."""

    def __init__(self, size: float) -> None:
        """Make an empty octree with cells of this edge in metres."""
        self.size = size
        self._cells: dict[int, tuple[int, int]] = {}
        """Cell to colour (red, green, blue as one number) and tag."""
        self._box: _Box | None = None

    def __len__(self) -> int:
        return len(self._cells)

    @property
    def reach(self) -> float:
        """Return how far from the origin a cell may be, in metres."""
        return self.size * FARTHEST

    def copy(self) -> Voxels:
        """Return the same cells, which then change independently."""
        twin = Voxels(self.size)
        twin._cells, twin._box = dict(self._cells), self._box
        return twin

    def coarser(self, size: float) -> Voxels:
        """Return an octree with cells of another size that contain the middles of these."""
        made = Voxels(size)
        made.fill(made.cells_of(self.places), self.colors, self.tags)
        return made

    def cells_of(self, places: Array) -> Cells:
        """Return the cells (n, 3) that contain some points (n, 3). Raises CommandError: too far away."""
        found = np.floor(places / self.size)
        if len(found) and not np.abs(found).max() < FARTHEST:
            raise CommandError(
                f"a point is more than {FARTHEST} voxels away from its octree; choose voxels above {self.size:g} m"
            )
        return found.astype(np.int64)

    def count_of_new(self, cells: Cells) -> int:
        """Return how many of some cells (n, 3) are empty."""
        return len(set(_packed(cells)) - self._cells.keys())

    def fill(self, cells: Cells, colors: Colors, tags: NDArray[np.uint32]) -> None:
        """Fill cells (n, 3), or change what they have, with colours (n, 3) and tags (n,)."""
        if not len(cells):
            return
        codes = (colors.astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])).tolist()
        self._cells.update(zip(_packed(cells), zip(codes, tags.tolist(), strict=True), strict=True))
        self._grow(cells)

    def empty(self, cells: Cells) -> None:
        """Empty cells (n, 3)."""
        for key in _packed(cells):
            self._cells.pop(key, None)
        if not self._cells:
            self._box = None

    def clear(self) -> None:
        """Empty all cells."""
        self._cells.clear()
        self._box = None

    def holds(self, cells: Cells) -> NDArray[np.bool_]:
        """Return (n,) which cells (n, 3) are filled."""
        known = self._cells
        return np.array([key in known for key in _packed(cells)], bool)

    @property
    def cells(self) -> Cells:
        """Return all filled cells (n, 3)."""
        return _unpacked(np.array(list(self._cells), np.int64))

    @property
    def places(self) -> Array:
        """Return the middles of all filled cells (n, 3)."""
        return (self.cells.astype(np.float64) + 0.5) * self.size

    @property
    def colors(self) -> Colors:
        """Return the colours of all filled cells (n, 3)."""
        codes = np.array([color for color, _ in self._cells.values()], np.int64)
        return (codes[:, np.newaxis] >> np.array([16, 8, 0]) & 0xFF).astype(np.uint8).reshape(-1, 3)

    @property
    def tags(self) -> NDArray[np.uint32]:
        """Return the tags of all filled cells (n,)."""
        return np.array([tag for _, tag in self._cells.values()], np.uint32)

    def tag(self, cell: Cells) -> int:
        """Return the tag of a filled cell (3,)."""
        return self._cells[_packed(cell[np.newaxis])[0]][1]

    def location(self, cell: Cells) -> int:
        """Return V-REP's number of a cell's place (3,): in 6 bits its level, then 3 bits for each level."""
        assert self._box is not None
        place = cell - self._box.low
        level = min(self._box.edge.bit_length() - 1, _DEEPEST)
        number = level
        for step in range(level):
            half = self._box.edge >> (step + 1)
            upper = (place // half) % 2
            number |= int(upper @ np.array([1, 2, 4])) << (6 + 3 * (level - 1 - step))
        return number

    def _grow(self, cells: Cells) -> None:
        """Enlarge the cube for new cells: it doubles towards those that are outside."""
        low, high = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
        if self._box is None:
            farthest = max(abs(each + 0.5) for each in (*low, *high))
            edge = 2 << max(0, math.ceil(math.log2(max(1.0, farthest * _FIT / 2))))
            low_end = -edge // 2
            self._box = _Box((low_end, low_end, low_end), edge)
        while True:
            box = self._box
            below = [least < start for least, start in zip(low, box.low, strict=True)]
            above = [most >= start + box.edge for most, start in zip(high, box.low, strict=True)]
            if not any((*below, *above)):
                return
            x, y, z = np.where(below, np.array(box.low) - box.edge, box.low).tolist()
            self._box = _Box((x, y, z), 2 * box.edge)


def _packed(cells: Cells) -> list[int]:
    shifted = cells + FARTHEST
    return ((shifted[:, 0] << 2 * _BITS) | (shifted[:, 1] << _BITS) | shifted[:, 2]).tolist()


def _unpacked(keys: NDArray[np.int64]) -> Cells:
    mask = (1 << _BITS) - 1
    columns = [keys >> 2 * _BITS, keys >> _BITS & mask, keys & mask]
    return np.stack(columns, axis=1).reshape(-1, 3) - FARTHEST
