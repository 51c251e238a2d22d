"""Point clouds and octrees as meshes: a small triangle at each point, or the outer faces of an octree's cells.

A mesh has no colours in MuJoCo, so each face shows one square of a texture of all colours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass

MOST_SHOWN = 20_000
"""Points of one object that its mesh shows; they are chosen evenly."""

_MARK = 0.1
"""Half the size of a point's mark, in sizes of the cells that a cloud keeps its points in."""

_MARKS = (0.0005, 0.005)
"""Smallest and largest half size of a mark in metres."""

_SQUARE = 4
"""Pixels along a side of a colour's square: neighbours must not shine through where a texture is smoothed."""

_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32) / 2
_SIDES = {
    (-1, 0, 0): (0, 1, 3, 2),
    (1, 0, 0): (4, 6, 7, 5),
    (0, -1, 0): (0, 4, 5, 1),
    (0, 1, 0): (2, 3, 7, 6),
    (0, 0, -1): (0, 2, 6, 4),
    (0, 0, 1): (1, 5, 7, 3),
}
"""Direction of a cell's face, to its corners, counter-clockwise from outside."""

_SQUARE_FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)

_TRIANGLE = np.array([[1.0, 0.0, 0.0], [-0.5, 0.75, 0.5], [-0.5, -0.75, 0.5]], np.float32)
_TURNS = np.array([np.roll(_TRIANGLE, axis, axis=1) for axis in range(3)])
"""(3, 3, 3): a triangle that faces along z, x or y; neighbours differ, so some are seen from anywhere."""
_BOTH_SIDES = np.array([[0, 1, 2], [0, 2, 1]], np.int32)


@dataclass(frozen=True)
class PointForm:
    """The mesh and the image of its colours."""

    vertices: NDArray[np.float32]
    """(n, 3) in the object's frame, metres."""
    faces: NDArray[np.int32]
    """(m, 3)."""
    texture: NDArray[np.float32]
    """(n, 2) texture coordinates."""
    image: NDArray[np.uint8]
    """(height, width, 3), the first row at v = 0."""


def point_form(
    points: NDArray[np.float32], colors: NDArray[np.uint8], size: float, *, as_cells: bool
) -> PointForm:
    """Return the mesh of some points, at least one, of which `MOST_SHOWN` are shown.

    Args:
        points: (n, 3), or the middles of cells.
        colors: (n, 3).
        size: edge of a cell in metres.
        as_cells: the points are cells of an octree.
    """
    if len(points) > MOST_SHOWN:
        chosen = np.linspace(0, len(points) - 1, MOST_SHOWN).astype(np.intp)
        points, colors = points[chosen], colors[chosen]
    codes = colors.astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
    found, number = np.unique(codes, return_inverse=True)
    palette = (found[:, np.newaxis] >> np.array([16, 8, 0]) & 0xFF).astype(np.uint8)
    vertices, faces, source = (_cells if as_cells else _marks)(points, size)
    texture = _places(number.reshape(-1)[source], len(palette))
    return PointForm(vertices, faces, texture, _image(palette))


def _cells(
    points: NDArray[np.float32], size: float
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.intp]]:
    """Return the faces of cells that no other cell covers: corners, faces, and for each corner its cell."""
    places: NDArray[np.int64] = np.rint((points - points.min(axis=0)) / size).astype(np.int64) + 1
    width: list[int] = (places.max(axis=0) + 2).tolist()
    keys = (places[:, 0] * width[1] + places[:, 1]) * width[2] + places[:, 2]
    corners: list[NDArray[np.float32]] = []
    source: list[NDArray[np.intp]] = []
    for (x, y, z), side in _SIDES.items():
        free = np.flatnonzero(~np.isin(keys + (x * width[1] + y) * width[2] + z, keys))
        around = points[free, np.newaxis] + _CORNERS[list(side)] * size
        corners.append(around.reshape(-1, 3).astype(np.float32))
        source.append(np.repeat(free, 4))
    count = sum(len(each) for each in source) // 4
    first = 4 * np.arange(count, dtype=np.int32)[:, np.newaxis, np.newaxis]
    faces = (first + _SQUARE_FACES).reshape(-1, 3).astype(np.int32)
    return np.concatenate(corners), faces, np.concatenate(source)


def _marks(
    points: NDArray[np.float32], size: float
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.intp]]:
    """Return a triangle around each point, seen from both sides: corners, faces, and for each corner its point."""
    half = min(max(size * _MARK, _MARKS[0]), _MARKS[1])
    turn = _TURNS[np.arange(len(points)) % 3]
    corners = (points[:, np.newaxis] + turn * half).reshape(-1, 3).astype(np.float32)
    first = 3 * np.arange(len(points), dtype=np.int32)[:, np.newaxis, np.newaxis]
    faces = (first + _BOTH_SIDES).reshape(-1, 3).astype(np.int32)
    return corners, faces, np.repeat(np.arange(len(points)), 3)


def _image(palette: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return an image of equal squares, one for each colour (n, 3), row by row."""
    across = _across(len(palette))
    squares = np.zeros((-(-len(palette) // across) * across, 3), np.uint8)
    squares[: len(palette)] = palette
    return squares.reshape(-1, across, 3).repeat(_SQUARE, axis=0).repeat(_SQUARE, axis=1)


def _places(number: NDArray[np.intp], count: int) -> NDArray[np.float32]:
    """Return the texture coordinates (n, 2) of the middles of the squares of some colours."""
    across = _across(count)
    rows = -(-count // across)
    return np.stack([(number % across + 0.5) / across, (number // across + 0.5) / rows], axis=1).astype(
        np.float32
    )


def _across(count: int) -> int:
    return max(1, int(np.ceil(np.sqrt(count))))
