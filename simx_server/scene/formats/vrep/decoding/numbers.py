"""Poses, triples and the like from a record's numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import Color
from simx_server.scene.poses.poses import NO_TURN, NoRotation, Pose, Quaternion, Vector, normalised


def quaternion_first(chunks: Chunks, tag: str) -> Pose:
    """Return the pose in a record that starts with w, x, y, z. Raises SceneError."""
    values = chunks.reals(tag)
    return vector(values[4:]), turn(chunks, tag, values[:4])


def position_first(chunks: Chunks, tag: str) -> Pose:
    """Return the pose in a record that starts with x, y, z. Raises SceneError."""
    values = chunks.reals(tag)
    return vector(values), turn(chunks, tag, values[3:7])


def turn(chunks: Chunks, tag: str, values: Sequence[float]) -> Quaternion:
    """Return the quaternion with length 1. Raises SceneError where it has none."""
    if values == NO_TURN:
        return NO_TURN
    try:
        return normalised(values)
    except NoRotation:
        raise chunks.error(tag, "has a quaternion of length 0") from None


def as_typed(value: float) -> float:
    """Return the shortest decimal number with the same float32: 0.05 for 0.05000000074505806, which was never typed.

    Other numbers than float32 stay as they are.
    """
    if not abs(value) < 1e30:
        return value
    short = np.float32(value)
    return float(str(short)) if float(short) == value else value


def vector(values: Sequence[float]) -> Vector:
    """Return the first three numbers."""
    x, y, z = values[:3]
    return x, y, z


def color(values: Sequence[float]) -> Color:
    """Return three parts of a colour, cut to 0 to 1."""
    red, green, blue = (min(max(value, 0.0), 1.0) for value in values[:3])
    return red, green, blue
