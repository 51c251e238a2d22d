"""A mesh along a path: a section at each point, and triangles between one section and the next."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.poses.poses import Pose, matrix

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

MOST_CORNERS = 10_000
"""MuJoCo compiles two triangles for each."""

_SAME = 1e-6


def sweep(
    poses: Sequence[Pose], section: Sequence[Sequence[float]], *, is_closed: bool
) -> tuple[Array, Faces]:
    """Return points (n, 3) and triangles (m, 3) of a section along poses whose z axes point along the path.

    A closed section, whose last point is its first one, gives a solid with ends, unless the path is closed. An open one
    gives a sheet with two sides.

    Args:
        section: x and y of its points in the frames of the poses, metres.
        is_closed: the last pose is joined to the first one.

    Raises:
        CommandError: fewer than two poses or points, or too many.
    """
    profile = np.array(section, float).reshape(-1, 2)
    is_solid = len(profile) > 3 and bool(np.allclose(profile[0], profile[-1], atol=_SAME))
    if is_solid:
        profile = profile[:-1]
        if _area(profile) < 0:
            profile = profile[::-1]
    rings, size = len(poses), len(profile)
    if rings < 2 or size < 2:
        raise CommandError("a mesh along a path needs two points of the path and of the section, or more")
    if rings * size > MOST_CORNERS:
        raise CommandError(f"a mesh along a path has at most {MOST_CORNERS} corners, not {rings * size}")
    places = np.array([pose[0] for pose in poses])
    axes = np.array([matrix(pose[1]) for pose in poses])
    points = places[:, None, :] + np.einsum("rij,pj->rpi", axes[:, :, :2], profile)
    sides = np.arange(size if is_solid else size - 1)
    steps = np.arange(rings if is_closed else rings - 1)
    ring, side = (each.ravel() for each in np.meshgrid(steps, sides, indexing="ij"))
    beside, beyond = (side + 1) % size, (ring + 1) % rings
    a, b = ring * size + side, ring * size + beside
    d, e = beyond * size + side, beyond * size + beside
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([b, e, d], axis=1)])
    if not is_solid:
        faces = np.concatenate([faces, faces[:, ::-1]])
    elif not is_closed:
        fan = np.stack([np.zeros(size - 2, int), np.arange(1, size - 1), np.arange(2, size)], axis=1)
        faces = np.concatenate([faces, fan[:, ::-1], fan + (rings - 1) * size])
    return points.reshape(-1, 3), faces


def _area(profile: Array) -> float:
    """Return twice the area of a polygon, positive when it goes round counter-clockwise."""
    x, y = profile[:, 0], profile[:, 1]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
