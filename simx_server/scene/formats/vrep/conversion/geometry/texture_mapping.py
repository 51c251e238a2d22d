"""Texture coordinates per corner of a triangle, by V-REP's ways to project a texture onto a shape.

The projection on a plane was compared with V-REP's own image of its floor. The cylinder, the sphere and the
box could not be compared: the texture goes once around, and its middle lies where the frame's x axis points.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.objects import Leaf, TextureUse
from simx_server.scene.poses.poses import compose, inverse, matrix

CYLINDER, SPHERE, CUBE = 1, 2, 3
"""Modes besides the projection on a plane, 0."""

INTERPOLATED, DECAL, REPEATED_U, REPEATED_V = 1, 2, 4, 8
"""Flags of a texture's use."""

_MOST_REPEATS = 1e5
"""Repetitions of a texture beyond which no camera sees one of them."""

_BEYOND = 0.01
"""Part of a texture by which coordinates may lie beside it."""

Coordinates = NDArray[np.float32]
"""(triangles, 3, 2): u, v per corner; the texture has the size 1 and is repeated."""


def coordinates_of(leaf: Leaf, use: TextureUse) -> Coordinates:
    """Return the texture coordinates of a leaf."""
    count = len(leaf.triangles)
    if use.coordinates is not None and len(use.coordinates) >= 3 * count:
        return use.coordinates[: 3 * count].reshape(count, 3, 2).astype(np.float32)
    corners = _in_frame(leaf, use)
    if use.mode == CYLINDER:
        around = _around(corners)
        return _stack(around / _scale(use, 0), corners[..., 2] / _scale(use, 1) + 0.5)
    if use.mode == SPHERE:
        away = np.maximum(np.linalg.norm(corners, axis=2), 1e-12)
        height = np.arcsin(np.clip(corners[..., 2] / away, -1.0, 1.0)) / math.pi
        return _stack(_around(corners) / _scale(use, 0), height / _scale(use, 1) + 0.5)
    if use.mode == CUBE:
        return _on_a_box(corners, use)
    return _flat(corners[..., 0], corners[..., 1], use)


def ends_within(leaf: Leaf, use: TextureUse) -> bool:
    """Return whether a texture that is not repeated ends on a leaf: V-REP goes on with its last pixels there."""
    flags = (REPEATED_U, REPEATED_V)
    if all(use.flags & flag for flag in flags) or not len(leaf.triangles):
        return False
    coordinates = coordinates_of(leaf, use).reshape(-1, 2)
    return any(
        not use.flags & flag
        and (coordinates[:, axis].min() < -_BEYOND or coordinates[:, axis].max() > 1 + _BEYOND)
        for axis, flag in enumerate(flags)
    )


def _in_frame(leaf: Leaf, use: TextureUse) -> NDArray[np.float64]:
    """Return (triangles, 3, 3) the corners in the frame of the projection."""
    position, turn = compose(inverse(use.frame), leaf.pose)
    points = leaf.vertices.astype(np.float64) @ np.array(matrix(turn)).T + np.array(position)
    return points[leaf.triangles]


def _flat(x: NDArray[np.float64], y: NDArray[np.float64], use: TextureUse) -> Coordinates:
    return _stack(x / _scale(use, 0) + 0.5, y / _scale(use, 1) + 0.5)


def _around(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far around the z axis corners lie, 0 to 1; those of one triangle lie less than half a turn apart."""
    turns = np.arctan2(corners[..., 1], corners[..., 0]) / (2 * math.pi) + 0.5
    turns += np.round(turns[:, :1] - turns)
    on_axis = np.hypot(corners[..., 0], corners[..., 1]) < 1e-9
    weights = np.where(on_axis, 0.0, 1.0)
    mean = (turns * weights).sum(axis=1, keepdims=True) / np.maximum(weights.sum(axis=1, keepdims=True), 1.0)
    return np.where(on_axis, mean, turns)


def _on_a_box(corners: NDArray[np.float64], use: TextureUse) -> Coordinates:
    """Project each triangle along the axis that its normal is nearest to."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normals).argmax(axis=1)
    rows = np.arange(len(corners))
    side = np.where(normals[rows, axis] < 0, -1.0, 1.0)[:, np.newaxis]
    x, y, z = corners[..., 0], corners[..., 1], corners[..., 2]
    which = axis[:, np.newaxis]
    # Seen from outside, u points to the right and, on the four sides around z, v points up.
    u = np.select([which == 0, which == 1], [y * side, -x * side], x * side)
    v = np.where(which == 2, y, z)
    return _flat(u, v, use)


def _scale(use: TextureUse, axis: int) -> float:
    scale = use.scale[axis]
    return scale if math.isfinite(scale) and abs(scale) > 1e-9 else 1.0


def _stack(u: NDArray[np.float64], v: NDArray[np.float64]) -> Coordinates:
    return np.clip(np.stack([u, v], axis=2), -_MOST_REPEATS, _MOST_REPEATS).astype(np.float32)
