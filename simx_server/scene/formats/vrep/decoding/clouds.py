"""Point clouds and octrees, which keep their points in cells within cells.

`Co2` starts with the byte 2, the edge of the whole cube, the largest edge of a cell with points, and the cube's
middle (float32); in a point cloud, then an int32: most points in a cell. The eight cells that halve the cube follow,
in the order x, y, z with x fastest, lower half first. A cell is:

* octree: a byte, 1 if filled, and then red, green, blue (bytes) and an int32, the cell's tag
* point cloud: an int32, the number n of coordinates; n float32, relative to the cell's middle; n bytes, red, green,
  blue of each point
* both: a byte, 1 if the eight cells that halve this one follow
"""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import PointCloud

from .context import Reading

VERSION = 2
DEEPEST = 24
"""Halvings of the cube; an edge of 1 km is then 0.1 mm."""

Cell = tuple[float, float, float, float, int]
"""Middle, a quarter of the edge, and how many times the cube was halved."""


def fill_cloud(cloud: PointCloud, own: Chunks, reading: Reading) -> None:
    """Fill a point cloud or octree. Raises SceneError."""
    (cloud.size,) = own.reals("Siz", cloud.size)
    tag = "Mm2" if cloud.is_octree else "Mmd"
    if own.has(tag):
        cloud.bounds = own.reals(tag, *(0.0,) * 6)
    if not own.has("Co2"):
        return
    start, end = own.places["Co2"]
    head = 21 if cloud.is_octree else 25
    if end - start < head or own.body.data[start] != VERSION:
        own.note("Co2", "has cells of an unknown kind; the object has no points")
        return
    edge, _, *middle = np.frombuffer(own.body.data, "<f4", 5, start + 1).tolist()
    if not np.isfinite([edge, *middle]).all():
        raise own.error("Co2", "has a cube that is not finite")
    x, y, z = middle
    cells = _halves((x, y, z, edge / 4, 0))
    if cloud.is_octree:
        cloud.points, cloud.colors, cloud.tags = _read_octree(own, start + head, end, cells)
    else:
        cloud.points, cloud.colors = _read_points(own, start + head, end, cells)


def _halves(cell: Cell) -> list[Cell]:
    """Return the eight cells within a cell, the last one first."""
    x, y, z, quarter, depth = cell
    return [
        (x + quarter * i, y + quarter * j, z + quarter * k, quarter / 2, depth + 1)
        for k in (1, -1)
        for j in (1, -1)
        for i in (1, -1)
    ]


def _read_octree(
    own: Chunks, place: int, end: int, waiting: list[Cell]
) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.uint32]]:
    data = own.body.data
    points, colors, tags = array("f"), bytearray(), bytearray()
    while waiting:
        cell = waiting.pop()
        size = 9 if place < end and data[place] == 1 else 2
        if place + size > end or data[place] > 1 or data[place + size - 1] > 1:
            raise own.error("Co2", f"has no cell at byte {place}")
        if size == 9:
            points.extend(cell[:3])
            colors += data[place + 1 : place + 4]
            tags += data[place + 4 : place + 8]
        place += size
        if data[place - 1]:
            waiting += _inner(own, cell)
    found = _arrays(own, place, end, np.frombuffer(points, np.float32), np.frombuffer(colors, np.uint8))
    return *found, np.frombuffer(bytes(tags), "<u4").astype(np.uint32)


def _read_points(
    own: Chunks, place: int, end: int, waiting: list[Cell]
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    data = own.body.data
    points: list[NDArray[np.float32]] = []
    colors = bytearray()
    while waiting:
        cell = waiting.pop()
        (count,) = own.whole("Co2", place, end, "i")
        size = 5 + 5 * count
        if count < 0 or count % 3 or place + size > end or data[place + size - 1] > 1:
            raise own.error("Co2", f"has no cell at byte {place}")
        if count:
            offsets = np.frombuffer(data, "<f4", count, place + 4).reshape(-1, 3)
            points.append(offsets + np.array(cell[:3], np.float32))
            colors += data[place + 4 + 4 * count : place + 4 + 5 * count]
        place += size
        if data[place - 1]:
            waiting += _inner(own, cell)
    joined = np.concatenate(points) if points else np.zeros(0, np.float32)
    return _arrays(own, place, end, joined, np.frombuffer(colors, np.uint8))


def _inner(own: Chunks, cell: Cell) -> list[Cell]:
    if cell[4] >= DEEPEST:
        raise own.error("Co2", f"has cells that are nested more than {DEEPEST} deep")
    return _halves(cell)


def _arrays(
    own: Chunks, place: int, end: int, points: NDArray[np.float32], colors: NDArray[np.uint8]
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    if place != end:
        raise own.error("Co2", f"has {end - place} bytes after its last cell")
    if not np.isfinite(points).all():
        raise own.error("Co2", "has a point that is not finite")
    return points.reshape(-1, 3).copy(), colors.reshape(-1, 3).copy()
