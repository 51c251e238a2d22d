"""Boxes among convex solids, and bodies that consist of boxes: all their faces are parallel to three planes."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.geometry.topology import (
    Faces,
    Points,
    area_vectors,
    volume_of,
)
from simx_server.scene.poses.poses import Pose

Array = NDArray[np.float64]
Cell = NDArray[np.intp]

_ALIKE = 1e-4
"""Difference, in sizes, up to which corners lie at the same place."""

_UPRIGHT = 1e-3
"""Sine of the angle up to which a face is parallel to a plane."""

_MOST_CELLS = 50_000
"""Most cells between the planes of a body; one with more is not tried."""


class Box(NamedTuple):
    """A box anywhere."""

    middle: Array
    axes: Array
    """(3, 3), its unit axes as columns, right-handed."""
    half: Array
    """(3,), half its size along each axis."""

    def placed(self) -> tuple[Pose, Array]:
        """Return its pose, and half its size."""
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, self.axes.ravel())
        x, y, z = self.middle.tolist()
        w, i, j, k = quat.tolist()
        return ((x, y, z), (w, i, j, k)), self.half


def box_around(points: Points) -> Box:
    """Return the upright box around points."""
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    return Box((low + high) / 2, np.eye(3), (high - low) / 2)


def box_of(points: Points) -> Box | None:
    """Return the box with these corners; None for any other solid."""
    corners = np.unique(points, axis=0).astype(np.float64)
    if len(corners) != 8:
        return None
    middle, limit = corners.mean(axis=0), _ALIKE * float(np.ptp(corners, axis=0).max())
    away = corners[1:] - corners[0]
    lengths = np.linalg.norm(away, axis=1)
    order = np.argsort(lengths, kind="stable")
    x, y = away[order[0]], away[order[1]]
    normal = np.cross(x, y)
    size = float(np.linalg.norm(normal))
    if size <= limit * limit:
        return None
    third = lengths[order[2:]] - np.abs(away[order[2:]] @ normal) / size
    z = away[order[2 + int(third.argmin())]]
    signs = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    wanted = middle + signs @ np.stack([x, y, z])
    gaps = np.linalg.norm(wanted[:, np.newaxis] - corners, axis=2).min(axis=1)
    half = np.array([float(np.linalg.norm(each)) / 2 for each in (x, y, z)])
    axes = np.stack([x, y, z], axis=1) / (2 * half)
    if gaps.max() > limit or np.abs(axes.T @ axes - np.eye(3)).max() > _UPRIGHT:
        return None
    if np.linalg.det(axes) < 0:
        axes[:, 2] *= -1
    return Box(middle, axes, half)


def as_boxes(points: Points, faces: Faces) -> list[Points] | None:
    """Return the corners of boxes that together are exactly a closed body; None for one that has another form."""
    axes = _axes(points, faces)
    if axes is None:
        return None
    within = points @ axes
    levels = [_levels(within[:, axis]) for axis in range(3)]
    sizes = [len(each) - 1 for each in levels]
    if min(sizes) < 1 or sizes[0] * sizes[1] * sizes[2] > _MOST_CELLS:
        return None
    filled = _filled(within, faces, levels)
    found = min(
        (_merged(filled, order) for order in itertools.permutations(range(3))),
        key=len,
    )
    boxes = [(low, high) for low, high in (_extent(each, levels) for each in found)]
    volume = sum(float(np.prod(high - low)) for low, high in boxes)
    if abs(volume - abs(volume_of(points, faces))) > 1e-3 * volume:
        return None
    choices = np.array(list(itertools.product((0, 1), repeat=3)))
    return [(np.where(choices, high, low) @ axes.T).astype(np.float32) for low, high in boxes]


def _axes(points: Points, faces: Faces) -> Array | None:
    """Return the three directions, as columns, in which all faces look; None if there are others."""
    vectors = area_vectors(points, faces)
    areas = np.linalg.norm(vectors, axis=1)
    x = vectors[areas.argmax()] / areas.max()
    normals = vectors / areas[:, np.newaxis]
    across = np.where(np.abs(normals @ x) < _UPRIGHT, areas, 0.0)
    if not across.any():
        return None
    y = normals[across.argmax()]
    y = y - (y @ x) * x
    y /= np.linalg.norm(y)
    axes = np.stack([x, y, np.cross(x, y)], axis=1)
    looking = np.sort(np.abs(normals @ axes), axis=1)
    return axes if looking[:, 1].max() < _UPRIGHT else None


def _levels(heights: Array) -> Array:
    ordered = np.sort(heights)
    limit = _ALIKE * float(ordered[-1] - ordered[0])
    return ordered[np.append(True, np.diff(ordered) > limit)]


def _filled(points: Array, faces: Faces, levels: list[Array]) -> NDArray[np.bool_]:
    """Return which cells between the levels lie in a body: those below which its surface was entered, and not left."""
    # Not the middles, through which diagonals go.
    x, y = (each[:-1] + share * np.diff(each) for each, share in zip(levels, (0.4370, 0.5614), strict=False))
    corners = points[faces]
    sizes = area_vectors(points, faces)
    depth = np.zeros((len(x), len(y), len(levels[2]) - 1))
    for face in np.flatnonzero(np.abs(sizes[:, 2]) > 0.5 * np.linalg.norm(sizes, axis=1)):
        (ax, ay, az), (bx, by, _), (cx, cy, _) = corners[face]
        covers = np.ones((len(x), len(y)), bool)
        for px, py, qx, qy in ((ax, ay, bx, by), (bx, by, cx, cy), (cx, cy, ax, ay)):
            turn = (qx - px) * (y[np.newaxis] - py) - (qy - py) * (x[:, np.newaxis] - px)
            covers &= turn * sizes[face, 2] > 0
        level = int(np.abs(levels[2] - az).argmin())
        depth[covers, level:] -= np.sign(sizes[face, 2])
    return np.abs(depth) > 0.5


def _merged(filled: NDArray[np.bool_], order: tuple[int, ...]) -> list[tuple[Cell, Cell]]:
    """Return boxes of cells, first and end, that together are the filled ones; each grows along the axes in order."""
    left = filled.copy()
    found: list[tuple[Cell, Cell]] = []
    for first in np.argwhere(filled):
        if not left[tuple(first)]:
            continue
        end = first + 1
        for axis in order:
            while end[axis] < left.shape[axis]:
                low, high = first.copy(), end.copy()
                low[axis], high[axis] = end[axis], end[axis] + 1
                if not left[_cells(low, high)].all():
                    break
                end[axis] += 1
        left[_cells(first, end)] = False
        found.append((first, end))
    return found


def _cells(low: Cell, high: Cell) -> tuple[slice, ...]:
    return tuple(slice(int(start), int(end)) for start, end in zip(low, high, strict=True))


def _extent(cells: tuple[Cell, Cell], levels: list[Array]) -> tuple[Array, Array]:
    low, high = (np.array([each[int(at)] for each, at in zip(levels, end, strict=True)]) for end in cells)
    return low, high
