"""Points with one normal and one texture coordinate each, as MJCF wants them, from V-REP's normals per corner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .topology import Faces, Points, normals_of

_LEVELS = 511.0
"""Half the number of steps in which a component of a normal is compared; 10 bits each."""


_UPRIGHT = 1e-3
"""Cosine between a corner's normal and its face's above which nothing is wrong with it."""


@dataclass(frozen=True)
class Surface:
    """A mesh as MuJoCo takes it: everything per point."""

    points: Points
    """(n, 3), metres."""
    faces: Faces
    """(m, 3), counter-clockwise seen from the side that is drawn."""
    normals: Points | None = None
    """(n, 3) unit normals; None: MuJoCo computes them."""
    texture: NDArray[np.float32] | None = None
    """(n, 2): u, v."""


def surface(
    points: Points,
    faces: Faces,
    normals: NDArray[np.float32] | None = None,
    texture: NDArray[np.float32] | None = None,
) -> Surface:
    """Return a mesh with as many copies of a point as it has different normals and texture coordinates.

    Args:
        points: (n, 3).
        faces: (m, 3), each with an area.
        normals: (m, 3, 3), per corner; those of length 0 become the face's, those that point backwards are turned.
        texture: (m, 3, 2), per corner.
    """
    key = faces.astype(np.int64).ravel()
    if normals is not None:
        normals = _facing(points, faces, normals)
        levels = ((normals.reshape(-1, 3) + 1.0) * _LEVELS + 0.5).astype(np.int64)
        # 30 bits; indices of points have 31.
        key = key << 30 | levels[:, 0] | levels[:, 1] << 10 | levels[:, 2] << 20
    if texture is not None:
        flat = np.ascontiguousarray(texture.reshape(-1, 2), np.float32)
        key = _combine(key, flat.view(np.int64).ravel())
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    return Surface(
        points[faces.ravel()[first]],
        inverse.reshape(-1, 3).astype(np.int32),
        None if normals is None else normals.reshape(-1, 3)[first].astype(np.float32),
        None if texture is None else texture.reshape(-1, 2)[first].astype(np.float32),
    )


def _combine(key: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a key that is equal where both keys are."""
    places = [np.unique(each, return_inverse=True)[1].reshape(-1) for each in (key, other)]
    return places[0] * (int(places[1].max()) + 1) + places[1]


def _facing(points: Points, faces: Faces, normals: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return normals (m, 3, 3) on the side of their face, and the face's own where they have no length."""
    own = normals_of(points, faces)
    along = np.einsum("mci,mi->mc", normals, own)
    if along.min() > _UPRIGHT:
        return normals
    lengths = np.einsum("mci,mci->mc", normals, normals)[..., np.newaxis]
    turned = np.where(along[..., np.newaxis] < 0.0, -normals, normals)
    return np.where(lengths > 0.25, turned, own[:, np.newaxis]).astype(np.float32)
