"""Leaves without damage: later modules need not expect indices, sizes and numbers that cannot be."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.objects import Leaf, Primitive, TextureUse
from simx_server.scene.poses.poses import Pose, normalised

from .topology import Faces, Points

_LONGEST = 1.001
"""Largest part of a normal of length 1."""

FARTHEST = 1e6
"""Largest coordinate in metres of a point, and largest size, that a file can mean."""


def undamaged(leaf: Leaf) -> Leaf | None:
    """Return a leaf whose parts fit together; None where nothing of it is left."""
    points, faces = leaf.vertices, leaf.triangles
    if not is_frame(leaf.pose) or points.ndim != 2 or faces.ndim != 2:
        return None
    usable: NDArray[np.bool_] = np.logical_and.reduce(np.abs(points) <= FARTHEST, axis=1)  # False for NaN
    chosen = _faces_of(usable, faces)
    if not chosen.all() or not usable.all():
        points, faces = np.where(usable[:, np.newaxis], points, 0).astype(np.float32), faces[chosen]
    is_sized = all(math.isfinite(size) and 0 <= size <= FARTHEST for size in leaf.size)
    return replace(
        leaf,
        pose=(leaf.pose[0], normalised(leaf.pose[1])),
        vertices=points,
        triangles=faces,
        normals=_normals(leaf.normals, chosen),
        primitive=leaf.primitive if is_sized else Primitive.MESH,
        texture=_texture(leaf.texture, chosen),
        heights=_heights(leaf.heights),
    )


def is_frame(pose: Pose) -> bool:
    """Return whether a pose is one: finite, near enough, and with a rotation."""
    position, turn = pose
    return (
        all(math.isfinite(each) and abs(each) <= FARTHEST for each in position)
        and all(map(math.isfinite, turn))
        and 1e-12 < sum(each * each for each in turn) < 1e12
    )


def within(value: float, default: float = 0.5) -> float:
    """Return a number between 0 and 1, such as a part of a colour."""
    return min(max(value, 0.0), 1.0) if math.isfinite(value) else default


def _faces_of(usable: NDArray[np.bool_], faces: Faces) -> NDArray[np.bool_]:
    """Return (n,): which faces have points, all of them usable."""
    if not len(faces) or not len(usable):
        return np.zeros(len(faces), bool)
    exists = (faces >= 0) & (faces < len(usable))
    return np.logical_and.reduce(exists & usable[np.where(exists, faces, 0)], axis=1)


def _normals(normals: Points | None, chosen: NDArray[np.bool_]) -> Points | None:
    if normals is None or normals.shape != (len(chosen), 3, 3):
        return None
    if chosen.all() and (np.abs(normals) <= _LONGEST).all():
        return normals
    return np.clip(np.nan_to_num(normals[chosen], nan=0.0), -1.0, 1.0)


def _texture(use: TextureUse | None, chosen: NDArray[np.bool_]) -> TextureUse | None:
    if use is None or not is_frame(use.frame):
        return None
    if use.coordinates is None:
        return replace(use, frame=(use.frame[0], normalised(use.frame[1])))
    whole = use.coordinates[: 3 * len(chosen)]
    if len(whole) < 3 * len(chosen) or not np.isfinite(whole).all():
        return None
    return replace(use, coordinates=whole.reshape(-1, 3, 2)[chosen].reshape(-1, 2))


def _heights(heights: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    if heights is None or heights.ndim != 2 or not np.isfinite(heights).all():
        return None
    return heights if np.abs(heights).max(initial=0.0) <= FARTHEST else None
