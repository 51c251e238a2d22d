"""The cells within cells of octrees and point clouds, as `decoding/clouds.py` reads them."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.decoding.clouds import DEEPEST, VERSION

_LEAST, _FARTHEST = 1e-30, 1e30
"""Edges of cells that are written, and coordinates; float32 holds them."""

_WITHIN = 1.01
"""Factor of the edge of a cell up to which a cube is such a cell."""


def octree_cells(
    middles: NDArray[np.float64], colors: NDArray[np.uint8], tags: NDArray[np.uint32], edge: float
) -> bytes:
    """Return the payload of an octree.

    Args:
        middles: (n, 3) middles of its filled cells: multiples of the edge, and a half.
        colors: (n, 3) red, green, blue.
        tags: (n,) whole numbers.
        edge: edge of the cells in metres.
    """

    def cell(inside: NDArray[np.intp], middle: NDArray[np.float64], size: float, depth: int) -> bytes:
        if not len(inside):
            return b"\0\0"
        if size <= edge * _WITHIN or depth >= DEEPEST:
            first = inside[0]
            return b"\1" + colors[first].tobytes() + struct.pack("<I", int(tags[first])) + b"\0"
        halves = _halves(middles, inside, middle, size)
        return b"\0\1" + b"".join(cell(*half, depth + 1) for half in halves)

    cube = _cube(middles, edge)
    start = _halves(middles, np.arange(len(middles)), np.zeros(3), cube)
    return struct.pack("<B5f", VERSION, cube, edge, 0, 0, 0) + b"".join(cell(*half, 1) for half in start)


def point_cells(points: NDArray[np.float64], colors: NDArray[np.uint8], edge: float, most: int) -> bytes:
    """Return the payload of a point cloud.

    Args:
        points: (n, 3) metres.
        colors: (n, 3) red, green, blue.
        edge: largest edge of a cell with points, in metres.
        most: most points of a cell.
    """

    def cell(inside: NDArray[np.intp], middle: NDArray[np.float64], size: float, depth: int) -> bytes:
        is_divided = len(inside) > 0 and (len(inside) > most or size > edge * _WITHIN) and depth < DEEPEST
        if is_divided:
            halves = _halves(points, inside, middle, size)
            return struct.pack("<iB", 0, 1) + b"".join(cell(*half, depth + 1) for half in halves)
        numbers = (points[inside] - middle).astype("<f4").tobytes()
        return struct.pack("<i", 3 * len(inside)) + numbers + colors[inside].tobytes() + b"\0"

    cube = _cube(points, edge)
    start = _halves(points, np.arange(len(points)), np.zeros(3), cube)
    head = struct.pack("<B5fi", VERSION, cube, edge, 0, 0, 0, most)
    return head + b"".join(cell(*half, 1) for half in start)


def _cube(points: NDArray[np.float64], edge: float) -> float:
    """Return the edge of a cube around the origin with all points: that of the cells, doubled some times.

    Raises:
        SceneError: numbers that are too large, or cells that are too small; scaling leads to both.
    """
    cube, farthest = 2 * edge, float(np.abs(points).max(initial=0.0))
    if not (_LEAST <= edge <= _FARTHEST and farthest <= _FARTHEST):
        raise SceneError(
            f"cells of {edge:g} m with points up to {farthest:g} m away do not fit into V-REP's files"
        )
    while farthest >= cube / 2:
        cube *= 2
    return cube


def _halves(
    points: NDArray[np.float64], inside: NDArray[Any], middle: NDArray[np.float64], size: float
) -> Iterator[tuple[NDArray[np.intp], NDArray[np.float64], float]]:
    """Yield points, middle and edge of the eight cells within a cell: x fastest, lower half first."""
    above = points[inside] >= middle
    for number in range(8):
        upper = np.array([number >> axis & 1 for axis in range(3)], bool)
        which = inside[(above == upper).all(axis=1)]
        yield which, middle + size / 4 * np.where(upper, 1.0, -1.0), size / 2
