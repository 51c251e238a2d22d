"""Triangles of one geom under boxes, boxes of boxes and so on: bounds of distances without a look at each triangle.

The boxes stand along the axes of the geom's frame, so a tree is made once and holds in every pose; and all boxes of a
geom have the same directions, so bounds of thousands of pairs are a few operations on arrays.

Sums of products are written out, term by term, so that they round as those of the compiled form do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array

FAN = 8
"""Boxes below a box."""

Indices = NDArray[np.intp]


class _Level(NamedTuple):
    """Centres and half sides (n, 3) of the boxes of a level, in metres in the geom's frame."""

    centres: Array
    halves: Array


class BoxTree:
    """A tree over triangles; the children of box i start at box i * `FAN` of the level below."""

    def __init__(self, corners: Array) -> None:
        """Make the boxes of triangles (n, 3, 3)."""
        self.corners = corners[_neighbours_together(corners.mean(axis=1))]
        low, high = self.corners.min(axis=1), self.corners.max(axis=1)
        made = [_boxes(low, high)]
        while len(low) > FAN:
            starts = np.arange(0, len(low), FAN)
            low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
            made.append(_boxes(low, high))
        self.boxes = np.concatenate(made)
        """(boxes, 2, 3): centre and half sides of the boxes of all levels, those of single triangles first."""
        ends = np.cumsum([len(each) for each in made]).tolist()
        self.levels = [
            _Level(*self.boxes[end - len(each) : end].swapaxes(0, 1))
            for each, end in zip(made, ends, strict=True)
        ]

    def level(self, number: int) -> _Level:
        """Return a level; above the top, each box stands over one that is the same."""
        return self.levels[min(number, len(self.levels) - 1)]

    def ends(self, direction: Array, extreme: np.ufunc) -> list[Array]:
        """Return the greatest or smallest coordinate along a direction of the triangles of each box, by level."""
        along = dot(self.corners, direction)
        found = [extreme(extreme(along[:, 0], along[:, 1]), along[:, 2])]
        for _ in self.levels[1:]:
            found.append(extreme.reduceat(found[-1], np.arange(0, len(found[-1]), FAN)))
        return found

    def below(self, level: int, boxes: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        """Return the boxes (n, FAN) of a level below boxes (n,), and which of them exist."""
        if level >= len(self.levels) - 1:
            found = np.repeat(boxes[:, np.newaxis], FAN, axis=1)
            return found, np.broadcast_to(np.arange(FAN) == 0, found.shape)
        found = boxes[:, np.newaxis] * FAN + np.arange(FAN)
        real = found < len(self.levels[level].centres)
        return np.where(real, found, 0), real


class Placed(NamedTuple):
    """A geom's triangles in the world."""

    tree: BoxTree
    turn: Array
    """(3, 3) rotation from the geom's frame to the world."""
    place: Array
    """(3,) its origin in the world."""

    @property
    def middle(self) -> Array:
        """Return the middle (3,) of its boxes in the world."""
        centres = self.tree.levels[-1].centres
        return turned(centres.mean(axis=0), self.turn.T) + self.place if len(centres) else self.place

    def corners(self, triangles: Indices) -> Array:
        """Return triangles (n, 3, 3) in the world."""
        return turned(self.tree.corners[triangles], self.turn.T) + self.place


class Bounds:
    """Lower bounds of the distances between boxes of two geoms in their poses; call `look_along` first."""

    def __init__(self, first: Placed, second: Placed) -> None:
        self._first, self._second = first, second
        self._turn = turned(first.turn.T, second.turn)
        self._place = turned(second.place - first.place, first.turn)
        self._spread = np.abs(self._turn)

    def look_along(self, direction: Array) -> None:
        """Use also planes across a direction (3,) of the world, from the first geom to the second.

        Along the shortest line between two surfaces they show at once that most pairs of long triangles are farther
        apart, whose boxes overlap.
        """
        direction = direction / max(math.sqrt(dot(direction, direction)), 1e-300)
        self._ends = self._first.tree.ends(turned(direction, self._first.turn), np.maximum)
        self._begins = self._second.tree.ends(turned(direction, self._second.turn), np.minimum)
        self._shift = float(dot(direction, self._second.place - self._first.place))

    def between(self, level: int, mine: Indices, theirs: Indices) -> Array:
        """Return metres (n,) between boxes pair by pair, as far as planes show."""
        ours, yours = self._first.tree.level(level), self._second.tree.level(level)
        half, other_half = ours.halves[mine], yours.halves[theirs]
        away = turned(yours.centres[theirs], self._turn.T) + self._place - ours.centres[mine]
        along = np.abs(away) - half - turned(other_half, self._spread.T)
        other = np.abs(turned(away, self._turn)) - other_half - turned(half, self._spread)
        by_sides = np.sqrt(np.maximum(_square(along), _square(other)))
        ends, begins = (
            self._ends[min(level, len(self._ends) - 1)],
            self._begins[min(level, len(self._begins) - 1)],
        )
        return np.maximum(by_sides, begins[theirs] - ends[mine] + self._shift)


def dot(a: Array, b: Array) -> Array:
    """Return the products (...) of vectors (..., 3)."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def turned(vectors: Array, turn: Array) -> Array:
    """Return the products (..., 3) of vectors (..., 3), as rows, and a matrix (3, 3)."""
    return vectors[..., :1] * turn[0] + vectors[..., 1:2] * turn[1] + vectors[..., 2:] * turn[2]


def _square(gaps: Array) -> Array:
    gaps = np.maximum(gaps, 0.0)
    return dot(gaps, gaps)


def _boxes(low: Array, high: Array) -> Array:
    return np.stack([(low + high) / 2, (high - low) / 2], axis=1)


def _neighbours_together(centres: Array) -> Indices:
    """Return an order of places (n, 3) in which neighbours follow each other, also across the levels of a tree.

    A set is halved along its longest side, where whole boxes of the highest possible level end.
    """
    pending = [np.arange(len(centres))]
    ordered = [np.zeros(0, np.intp)]
    while pending:
        some = pending.pop()
        if len(some) <= FAN:
            ordered.append(some)
            continue
        whole = FAN
        while whole * FAN < len(some):
            whole *= FAN
        half = max(whole, len(some) // 2 // whole * whole)
        axis = int(np.ptp(centres[some], axis=0).argmax())
        parts = np.argpartition(centres[some, axis], half)
        pending += [some[parts[half:]], some[parts[:half]]]
    return np.concatenate(ordered)
