"""Meshes that are not convex."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Mesh = tuple[NDArray[np.float32], NDArray[np.int32]]


def notched() -> Mesh:
    """A bar bent to an L: two boxes joined to one surface, of 12 points."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
    points = np.concatenate([np.insert(outline, 2, z, axis=1) for z in (0.0, 1.0)])
    ring = [(i, (i + 1) % 6) for i in range(6)]
    sides = [f for a, b in ring for f in ((a, b, b + 6), (a, b + 6, a + 6))]
    lids = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = sides + [(a + 6, b + 6, c + 6) for a, b, c in lids] + [(c, b, a) for a, b, c in lids]
    return points.astype(np.float32), np.array(faces, np.int32)


def room(width: float = 0.1) -> Mesh:
    """Walls around 2 x 2 m, 0.8 m high, of 44 triangles, with a doorway from -0.4 to 0.4 m in the wall at -y."""
    e = 1 + width
    inner = [(-0.4, -1), (-1, -1), (-1, 1), (1, 1), (1, -1), (0.4, -1)]
    outer = [(-0.4, -e), (-e, -e), (-e, e), (e, e), (e, -e), (0.4, -e)]
    count = len(inner)
    points = np.array([(*at, z) for z in (0, 0.8) for ring in (inner, outer) for at in ring])
    quads: list[tuple[int, int, int, int]] = []
    for a in range(count - 1):
        b, c, d, h = a + 1, a + count, a + 1 + count, 2 * count
        quads += [(a + h, c + h, d + h, b + h), (a, b, d, c), (a, a + h, b + h, b), (c, d, d + h, c + h)]
    last = count - 1
    quads += [(0, count, 3 * count, 2 * count), (last, last + 2 * count, last + 3 * count, last + count)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return points.astype(np.float32), np.array(faces, np.int32)


def bowl(rings: int = 6, around: int = 16, radius: float = 0.5, wall: float = 0.01) -> Mesh:
    """The lower half of a hollow ball around the origin, open above."""
    layers = 2 * rings * around
    points = [
        (r * math.sin(tilt) * math.cos(turn), r * math.sin(tilt) * math.sin(turn), -r * math.cos(tilt))
        for r in (radius, radius - wall)
        for tilt in np.linspace(0, math.pi / 2, rings + 1)[1:]
        for turn in np.arange(around) * 2 * math.pi / around
    ]
    points += [(0, 0, -radius), (0, 0, wall - radius)]
    faces: list[tuple[int, int, int]] = []
    for side in range(2):
        start = side * rings * around
        for a in range(around):
            b = (a + 1) % around
            some = [(layers + side, start + b, start + a)]
            for ring in range(start, start + (rings - 1) * around, around):
                c, d = ring + around + b, ring + around + a
                some += [(ring + a, ring + b, c), (ring + a, c, d)]
            faces += [(z, y, x) for x, y, z in some] if side else some
    rim = (rings - 1) * around
    for a in range(rim, rim + around):
        b = rim + (a + 1 - rim) % around
        c, d = b + rings * around, a + rings * around
        faces += [(a, b, c), (a, c, d)]
    return np.array(points, np.float32), np.array(faces, np.int32)
