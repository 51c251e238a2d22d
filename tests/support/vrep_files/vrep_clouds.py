"""Cells within cells, as octrees and point clouds have them in V-REP's files."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

Point = Sequence[float]


def octree_cells(middles: Sequence[Point], edge: float, rgb: tuple[int, int, int]) -> bytes:
    """Return `Co2` of an octree whose cells with this edge have these middles, multiples of the edge plus a half."""
    points = np.asarray(middles, np.float64).reshape(-1, 3)
    cube = edge * 2
    while np.abs(points).max(initial=0.0) > cube / 2:
        cube *= 2

    def cell(inside: np.ndarray, middle: np.ndarray, size: float) -> bytes:
        if not len(inside):
            return b"\0\0"
        if size <= edge * 1.01:
            return bytes([1, *rgb]) + struct.pack("<i", 0) + b"\0"
        return b"\0\1" + b"".join(cell(*each) for each in _halves(inside, middle, size))

    start = _halves(points, np.zeros(3), cube)
    return struct.pack("<B5f", 2, cube, edge, 0, 0, 0) + b"".join(cell(*each) for each in start)


def point_cells(points: Sequence[Point], rgb: tuple[int, int, int], most: int = 4) -> bytes:
    """Return `Co2` of a point cloud with at most this many points in a cell."""
    array = np.asarray(points, np.float64).reshape(-1, 3)
    cube = 2.0
    while np.abs(array).max(initial=0.0) > cube / 2:
        cube *= 2

    def cell(inside: np.ndarray, middle: np.ndarray, size: float) -> bytes:
        if len(inside) > most:
            return struct.pack("<iB", 0, 1) + b"".join(cell(*each) for each in _halves(inside, middle, size))
        numbers = (inside - middle).astype("<f4").tobytes()
        return struct.pack("<i", 3 * len(inside)) + numbers + bytes(rgb) * len(inside) + b"\0"

    start = _halves(array, np.zeros(3), cube)
    head = struct.pack("<B5fi", 2, cube, 0.02, 0, 0, 0, most)
    return head + b"".join(cell(*each) for each in start)


def _halves(
    inside: np.ndarray, middle: np.ndarray, size: float
) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Return the points, middle and edge of the eight cells within a cell, x fastest, lower half first."""
    found: list[tuple[np.ndarray, np.ndarray, float]] = []
    for number in range(8):
        upper = np.array([number >> axis & 1 for axis in range(3)], bool)
        which = ((inside >= middle) == upper).all(axis=1)
        found.append((inside[which], middle + size / 4 * np.where(upper, 1, -1), size / 2))
    return found
