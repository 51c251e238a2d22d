"""Detection of points, segments and triangles that a script gives, instead of the shapes of the scene."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from simx_server.scene.poses.poses import Vector

from .detection import Detection
from .nearest import nearest_points
from .optics import Optics
from .seen import Triangles
from .volume import Array


class Items(IntEnum):
    """Kinds of items that a script gives; the values are V-REP's."""

    POINTS = 0
    SEGMENTS = 1
    TRIANGLES = 2


NO_OBJECT = -1
"""Handle in the detection of something that belongs to no object."""


def detect_given(looks: Optics, items: Array) -> Detection | None:
    """Return the nearest of some points, segments or triangles within a sensor's volume.

    A ray meets triangles only. The normal of a point or of a segment is the direction back to the sensor.

    Args:
        looks: the sensor's optics, without random rays.
        items: (n, k, 3) n items with k = 1, 2 or 3 corners each, in the sensor's frame, metres.
    """
    if looks.faces == "none" or len(items) == 0:
        return None
    if items.shape[1] == 3:
        triangles = Triangles.of(items)
        found = _on_ray(looks, triangles) if looks.kind == "ray" else _in_volume(looks, triangles)
    else:
        found = None if looks.kind == "ray" else _of_lines(looks, items)
    if found is None or math.hypot(*found.point) < looks.least_distance:
        return None
    return found


def _in_volume(looks: Optics, triangles: Triangles) -> Detection | None:
    if looks.faces != "both":
        seen = (triangles.heights < 0) == (looks.faces == "front")
        triangles = triangles.take(np.flatnonzero(seen))
    if len(triangles.rows) == 0:
        return None
    nearest = nearest_points(looks.volume, triangles, np.full(1, np.inf), looks.least_cosine)
    row = int(nearest.rows[0])
    if row < 0:
        return None
    normal = triangles.normals[np.searchsorted(triangles.rows, row)]
    return Detection(_vector(nearest.points[0]), _vector(normal), NO_OBJECT)


def _on_ray(looks: Optics, triangles: Triangles) -> Detection | None:
    """Return the first triangle on the segment of the z axis that the sensor sees."""
    with np.errstate(divide="ignore", invalid="ignore"):
        heights = triangles.heights / triangles.normals[:, 2]
    points = np.zeros((len(heights), 3))
    points[:, 2] = np.where(np.isfinite(heights), heights, np.nan)
    met = triangles.hold(points) & (heights >= looks.offset) & (heights <= looks.offset + looks.reach)
    hits = np.flatnonzero(met)
    for row in hits[np.argsort(heights[hits])].tolist():
        normal = _vector(triangles.normals[row])
        if looks.accepts((0.0, 0.0, float(heights[row])), normal):
            return Detection((0.0, 0.0, float(heights[row])), normal, NO_OBJECT)
    return None


def _of_lines(looks: Optics, items: Array) -> Detection | None:
    """Return the nearest of points (n, 1, 3), or of the points of segments (n, 2, 3)."""
    starts = items[:, 0]
    along = items[:, -1] - starts
    squares = np.einsum("ni,ni->n", along, along)
    towards = -np.einsum("ni,ni->n", starts, along)
    closest = np.divide(towards, squares, out=np.zeros(len(items)), where=squares > 0)
    ends = np.tile([0.0, 1.0], (len(items), 1))
    where = np.concatenate([closest[:, np.newaxis], ends, looks.volume.crossings(starts, along)], axis=1)
    where = np.where((where >= 0.0) & (where <= 1.0), where, np.nan)
    points = (starts[:, np.newaxis] + where[..., np.newaxis] * along[:, np.newaxis]).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    points = points[looks.volume.contains(points)]
    if len(points) == 0:
        return None
    point = points[np.einsum("ni,ni->n", points, points).argmin()]
    away = math.hypot(*point.tolist())
    return Detection(_vector(point), _vector(-point / away) if away else (0.0, 0.0, -1.0), NO_OBJECT)


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
