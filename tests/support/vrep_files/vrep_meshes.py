"""Meshes of the primitives in V-REP's files: vertices and triangles with exactly the primitive's size."""

from __future__ import annotations

import numpy as np

SIDES = 16


def mesh_of(kind: str, size: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return (n, 3) vertices and (m, 3) triangles, counter-clockwise from outside.

    Args:
        kind: plane, disc, cuboid, spheroid, cylinder or cone.
        size: full size in x, y, z.
    """
    make = {"plane": _plane, "cuboid": _cuboid, "spheroid": _spheroid}.get(kind)
    vertices, triangles = make() if make else _round(kind)
    vertices = np.array(vertices, np.float64)
    extent = np.maximum(np.ptp(vertices, axis=0), 1e-12)
    middle = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    return (vertices - middle) / extent * np.array(size), np.array(triangles, np.int32)


def normals_of(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return (triangles, 3, 3): a flat normal for each corner."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    found = np.cross(b - a, c - a)
    found /= np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)
    return np.repeat(found[:, None, :], 3, axis=1)


def _plane() -> tuple[list[tuple[float, ...]], list[tuple[int, ...]]]:
    return [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)]


def _cuboid() -> tuple[list[tuple[float, ...]], list[tuple[int, ...]]]:
    corners: list[tuple[float, ...]] = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]


def _ring(radius: float, z: float) -> list[tuple[float, ...]]:
    angles = np.arange(SIDES) * 2 * np.pi / SIDES
    return [(radius * np.cos(angle), radius * np.sin(angle), z) for angle in angles]


def _round(kind: str) -> tuple[list[tuple[float, ...]], list[tuple[int, ...]]]:
    """A disc, cylinder or cone."""
    following = [(side, (side + 1) % SIDES) for side in range(SIDES)]
    if kind == "disc":
        return [*_ring(1, 0), (0, 0, 0)], [(a, b, SIDES) for a, b in following]
    top = 0.0 if kind == "cone" else 1.0
    points = [*_ring(1, -1), *_ring(top, 1), (0, 0, -1), (0, 0, 1)]
    triangles: list[tuple[int, ...]] = []
    for a, b in following:
        triangles += [(b, a, 2 * SIDES), (a, b, SIDES + b), (a, SIDES + b, SIDES + a)]
        triangles.append((SIDES + a, SIDES + b, 2 * SIDES + 1))
    return points, triangles


def _spheroid() -> tuple[list[tuple[float, ...]], list[tuple[int, ...]]]:
    rings = SIDES // 2 - 1
    points: list[tuple[float, ...]] = [(0, 0, -1)]
    for ring in range(rings):
        angle = np.pi * (ring + 1) / (rings + 1)
        points += _ring(float(np.sin(angle)), float(-np.cos(angle)))
    points.append((0, 0, 1))
    triangles: list[tuple[int, ...]] = []
    for a, b in [(side, (side + 1) % SIDES) for side in range(SIDES)]:
        triangles.append((0, 1 + b, 1 + a))
        for ring in range(rings - 1):
            low, high = 1 + ring * SIDES, 1 + (ring + 1) * SIDES
            triangles += [(low + a, low + b, high + b), (low + a, high + b, high + a)]
        last = 1 + (rings - 1) * SIDES
        triangles.append((last + a, last + b, len(points) - 1))
    return points, triangles
