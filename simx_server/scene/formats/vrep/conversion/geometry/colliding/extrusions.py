"""Bodies that are an outline of any form, with a height: walls, plates, gears, channels."""

from __future__ import annotations

import numpy as np

from simx_server.scene.formats.vrep.conversion.geometry.topology import (
    Faces,
    Points,
    area_vectors,
    volume_of,
)

from .facets import facets_of

_ALIKE = 1e-4
"""Difference, in sizes of a mesh, up to which points lie in one plane."""

_UPRIGHT = 1e-3
"""Cosine of the angle to the axis up to which the normal of a side is across it."""

_DIRECTIONS = 4
"""Directions that are tried: those of the largest faces."""


def as_columns(points: Points, faces: Faces) -> list[Points] | None:
    """Return the points of convex columns that together are exactly a closed body; None for one of another form."""
    vectors = area_vectors(points, faces)
    areas = np.linalg.norm(vectors, axis=1)
    normals = vectors / areas[:, np.newaxis]
    limit = _ALIKE * float(np.ptp(points, axis=0).max())
    tried: list[np.ndarray] = []
    for face in np.argsort(-areas, kind="stable"):
        axis = normals[face]
        if any(abs(float(axis @ other)) > 1 - _UPRIGHT for other in tried):
            continue
        tried.append(axis)
        heights = points @ axis
        top, bottom = float(heights.max()), float(heights.min())
        is_top, is_bottom = heights >= top - limit, heights <= bottom + limit
        if (is_top | is_bottom).all() and top - bottom > 2 * limit:
            upper = is_top[faces].all(axis=1)
            sides = ~upper & ~is_bottom[faces].all(axis=1)
            if np.abs(normals[sides] @ axis).max(initial=0.0) > _UPRIGHT:
                return None
            lids = faces[upper]
            volume = float((vectors[upper] @ axis).sum()) * (top - bottom)
            if abs(volume - volume_of(points, faces)) > 1e-3 * volume:
                return None
            return [
                np.concatenate([each.corners, each.corners - (top - bottom) * axis]).astype(np.float32)
                for each in facets_of(points, lids)
            ]
        if len(tried) == _DIRECTIONS:
            break
    return None
