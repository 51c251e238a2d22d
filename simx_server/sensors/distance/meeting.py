"""Whether geoms meet, or come nearer than a margin: faster than their distance, with the same answers.

Balls and boxes around the geoms leave out most pairs: in C where it is compiled, else many in a few operations on
arrays. The others are measured only as far as the margin.
"""

from __future__ import annotations

from collections.abc import Collection

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.triangles import Array
from simx_server.sensors.instant import Instant

from .measuring import lower_bounds, placed
from .native.loading import compiled_module
from .triangle_pairs import come_within

Pair = tuple[int, int] | tuple[()]
"""Handles of two objects that meet; empty where none do."""

Indices = NDArray[np.intp]

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)

_ROUNDING = 1e-9
"""Metres by which a bound may be wrong."""

_BEYOND = 1e-3
"""Metres beyond the margin as far as MuJoCo measures convex geoms."""


def colliding_pair(instant: Instant, first: Collection[int], second: Collection[int]) -> Pair:
    """Return one shape of the first objects and one of the second that meet; an object does not meet itself."""
    mine, theirs = instant.geoms_of(first), instant.geoms_of(second)
    if len(mine) == 0 or len(theirs) == 0:
        return ()
    lower = lower_bounds(instant, mine, theirs)
    rows, columns = np.nonzero(lower <= 0.0)
    near = ~are_apart(instant, mine[rows], theirs[columns])
    if not near.any():
        return ()
    possible = np.zeros(lower.shape, bool)
    possible[rows[near], columns[near]] = True
    ordered = np.argsort(
        lower, axis=None
    )  # of several pairs that meet, the one whose balls are nearest counts
    for index in ordered[possible.ravel()[ordered]].tolist():
        row, column = divmod(index, len(theirs))
        geoms = int(mine[row]), int(theirs[column])
        if geoms_meet(instant, *geoms):
            owners = instant.surroundings.owners
            return int(owners[geoms[0]]), int(owners[geoms[1]])
    return ()


class GeomPairs:
    """Pairs of geoms of one model that are looked at again and again."""

    def __init__(self, instant: Instant, first: Indices, second: Indices) -> None:
        """Note geoms (n,) and (n,), MuJoCo's ids."""
        around, is_plane = instant.surroundings, instant.model.geom_type == _PLANE
        possible = ~(is_plane[first] & is_plane[second])
        self._first, self._second, self._is_plane = first[possible], second[possible], is_plane
        self._reach = around.radii[self._first] + around.radii[self._second]

    def __len__(self) -> int:
        return len(self._first)

    def meet(self, instant: Instant, margin: float = 0.0) -> bool:
        """Return whether geoms of any pair come nearer than the margin (m), whatever their objects."""
        return any(geoms_meet(instant, *self.geoms(pair), margin) for pair in self.possible(instant, margin))

    def geoms(self, pair: int) -> tuple[int, int]:
        """Return MuJoCo's ids of the geoms of a pair."""
        return int(self._first[pair]), int(self._second[pair])

    def possible(self, instant: Instant, margin: float = 0.0) -> list[int]:
        """Return which pairs are not surely farther apart than the margin, by balls and boxes around the geoms."""
        places = instant.geom_xpos
        module = compiled_module()
        if module is not None:
            boxes = instant.model.geom_aabb
            return module.possible_pairs(
                *(self._first, self._second, self._reach),
                *(places, instant.geom_xmat, boxes, self._is_plane, margin),
            )
        away = places[self._first] - places[self._second]
        reach = self._reach + (margin + _ROUNDING)
        near = np.flatnonzero(np.einsum("ni,ni->n", away, away) <= reach * reach)
        if not len(near):
            return []
        return near[~are_apart(instant, self._first[near], self._second[near], margin)].tolist()


def geoms_meet(instant: Instant, first: int, second: int, margin: float = 0.0) -> bool:
    """Return whether two geoms (MuJoCo ids) come nearer than the margin (m), whatever their objects."""
    if instant.surroundings.kinds[first] == instant.surroundings.kinds[second] == _PLANE:
        return False
    triangles = instant.surroundings.triangles
    if triangles.is_solid(first) and triangles.is_solid(second):
        limit = margin + _BEYOND
        return mujoco.mj_geomDistance(instant.model, instant.data, first, second, limit, None) <= margin
    return come_within(placed(instant, first, second), placed(instant, second, first), margin)


def are_apart(instant: Instant, first: Indices, second: Indices, margin: float = 0.0) -> NDArray[np.bool_]:
    """Return (n,) which pairs of geoms (n,) are surely farther apart than the margin, by the boxes around them."""
    is_plane = instant.model.geom_type == _PLANE
    flipped = is_plane[first]
    first, second = np.where(flipped, second, first), np.where(flipped, first, second)
    turns, places, halves = _boxes(instant, first)
    other_turns, other_places, other_halves = _boxes(instant, second)
    away = other_places - places
    turn = np.einsum("nji,njk->nik", turns, other_turns)
    spread = np.abs(turn)
    along = np.abs(np.einsum("nji,nj->ni", turns, away)) - halves
    along -= np.einsum("nij,nj->ni", spread, other_halves)
    other = np.abs(np.einsum("nji,nj->ni", other_turns, away)) - other_halves
    other -= np.einsum("nij,ni->nj", spread, halves)
    gaps = np.maximum(along, other).max(axis=1, initial=-np.inf)
    on_plane = np.flatnonzero(is_plane[second])
    if len(on_plane):  # a plane is endless: how far the box stays above it counts
        normals = other_turns[on_plane, :, 2]
        heights = places[on_plane] - instant.geom_xpos[second[on_plane]]
        reaches = np.abs(np.einsum("nj,nji->ni", normals, turns[on_plane])) * halves[on_plane]
        gaps[on_plane] = np.einsum("ni,ni->n", heights, normals) - reaches.sum(axis=1)
    return gaps > margin + _ROUNDING


def _boxes(instant: Instant, geoms: Indices) -> tuple[Array, Array, Array]:
    """Return the boxes around geoms (n,) in the world: rotations (n, 3, 3), middles and half sides (n, 3)."""
    boxes, turns = instant.model.geom_aabb[geoms], instant.geom_xmat[geoms].reshape(-1, 3, 3)
    middles = instant.geom_xpos[geoms] + np.einsum("nij,nj->ni", turns, boxes[:, :3])
    return turns, middles, boxes[:, 3:]
