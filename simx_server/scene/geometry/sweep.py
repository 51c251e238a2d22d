"""A mesh along a path: a section at each point, and triangles between one section and the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.poses.poses import Pose, matrix

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

MOST_CORNERS = 10_000
"""MuJoCo compiles two triangles for each."""

_MOST_OF_ENDS = 200
"""Points of a section whose ends are divided into triangles; the work grows with their cube."""

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
        end = triangulated(profile)
        faces = np.concatenate([faces, end[:, ::-1], end + (rings - 1) * size])
    return points.reshape(-1, 3), faces


def triangulated(profile: Array) -> Faces:
    """Return triangles (n - 2, 3) that fill a polygon (n, 2) whose corners go round counter-clockwise.

    Ears are cut off, one after the other: triangles of three corners in sequence without another corner in them.
    """
    count = len(profile)
    before, after = np.roll(profile, 1, axis=0), np.roll(profile, -1, axis=0)
    if np.all(_cross(profile - before, after - profile) >= 0):
        return np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    if count > _MOST_OF_ENDS:
        raise CommandError(
            f"the section of a solid with ends has at most {_MOST_OF_ENDS} points where it is not convex, not {count}"
        )
    left, found = list(range(count)), list[tuple[int, int, int]]()
    while len(left) > 3:
        ears = ((left[at - 1], left[at], left[(at + 1) % len(left)]) for at in range(len(left)))
        # A polygon that crosses itself may have no ear; then its ends are not right, but closed.
        ear = next((each for each in ears if _is_ear(profile, left, each)), (left[-1], left[0], left[1]))
        found.append(ear)
        left.remove(ear[1])
    found.append((left[0], left[1], left[2]))
    return np.array(found, dtype=np.int64)


def _is_ear(profile: Array, left: list[int], corners: tuple[int, int, int]) -> bool:
    a, b, c = (profile[each] for each in corners)
    if _turn(a, b, c) <= 0:
        return False
    others = profile[[each for each in left if each not in corners]]
    inside = (_turn(a, b, others) >= 0) & (_turn(b, c, others) >= 0) & (_turn(c, a, others) >= 0)
    return not inside.any()


def _turn(a: Array, b: Array, c: Array) -> Any:
    """Return twice the area of a triangle of points (2,) or (n, 2), positive counter-clockwise."""
    return _cross(b - a, c - a)


def _cross(u: Array, v: Array) -> Any:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def _area(profile: Array) -> float:
    """Return twice the area of a polygon, positive when it goes round counter-clockwise."""
    x, y = profile[:, 0], profile[:, 1]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
