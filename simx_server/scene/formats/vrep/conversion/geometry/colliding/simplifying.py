"""Meshes with fewer faces: points that lie near to each other become one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.geometry.topology import Faces, Points, sound

_FINEST = 256
"""Cells along a mesh at first."""

_COARSER = 1.2


def simplified(points: Points, faces: Faces, most: int) -> tuple[Points, Faces, float]:
    """Return a mesh with at most this number of faces, and how far in metres a point has moved at most."""
    used, place = np.unique(faces, return_inverse=True)
    at, corners = points[used].astype(np.float64), place.reshape(-1, 3).astype(np.int64)
    low = at.min(axis=0)
    cell = float(np.ptp(at, axis=0).max()) / _FINEST
    while True:
        _, number = np.unique(((at - low) / cell).astype(np.int64), axis=0, return_inverse=True)
        number = number.reshape(-1)
        middles = _means(at, number)
        left = _without_doubles(number[corners])
        if len(left) <= most:
            moved = float(np.linalg.norm(at - middles[number], axis=1).max())
            single, left = middles.astype(np.float32), left.astype(np.int32)
            return single, left[sound(single, left)], moved
        cell *= _COARSER


def _means(points: NDArray[np.float64], number: NDArray[np.int64]) -> NDArray[np.float64]:
    count = np.bincount(number)
    return np.stack([np.bincount(number, points[:, axis]) / count for axis in range(3)], axis=1)


def _without_doubles(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the faces that still have three corners, each once; two that look at each other vanish."""
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    if not len(faces):
        return faces
    first = faces.argmin(axis=1)
    turned = faces[np.arange(len(faces))[:, np.newaxis], (first[:, np.newaxis] + np.arange(3)) % 3]
    unique = np.unique(turned, axis=0)
    _, compact = np.unique(unique, return_inverse=True)
    compact = compact.reshape(-1, 3)
    key = (int(compact.max()) + 1) ** np.arange(3)
    return unique[~np.isin(compact @ key, compact[:, [0, 2, 1]] @ key)]
