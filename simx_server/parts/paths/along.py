"""The points of a path of CoppeliaSim 4, made of its control points: positions, and orientations along the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import wxyz_from_xyzw, xyzw_from_wxyz
from simx_server.scene.poses.poses import NO_TURN, Pose, Quaternion, Vector, from_rows, subtract

from .flat_paths import BEZIER, CARTESIAN, QUATERNION, FlatPath, lengths_of

POSE = 7
"""Numbers of a point: x, y, z, then a quaternion x, y, z, w."""

TYPES = (CARTESIAN,) * 3 + (QUATERNION,) * 4

_AXES = ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1))
"""By orientation mode: the axis along the path, and the axis that points upwards."""

_FLAT = 1e-6


def poses_of(numbers: Sequence[float]) -> list[Pose]:
    """Return the poses in a list of numbers. Raises CommandError: no whole number of poses."""
    if not numbers or len(numbers) % POSE:
        raise CommandError(
            f"poses are {POSE} numbers each, x y z and a quaternion x y z w, not {len(numbers)} in all"
        )
    return [
        ((numbers[at], numbers[at + 1], numbers[at + 2]), wxyz_from_xyzw(numbers[at + 3 : at + POSE]))
        for at in range(0, len(numbers), POSE)
    ]


def numbers_of(poses: Sequence[Pose]) -> list[float]:
    """Return poses as a list of numbers."""
    return [number for place, turn in poses for number in (*place, *xyzw_from_wxyz(turn))]


def interpolated(control: Sequence[Pose], count: int, smoothness: float, *, is_closed: bool) -> list[Pose]:
    """Return the points of a path through control points, at equal lengths; a closed one ends at its start.

    Args:
        count: number of points.
        smoothness: 0 for straight lines, to 1 for Bezier curves that take up all of each way.

    Raises:
        CommandError: fewer than two control points or points.
    """
    if len(control) < 2:
        raise CommandError("a path needs two control points or more")
    numbers = numbers_of([*control, control[0]] if is_closed else control)
    coarse = FlatPath(numbers, lengths_of(numbers, POSE), TYPES)
    if smoothness <= 0:
        return poses_of(coarse.resampled(count, "linear", 1.0, is_open=not is_closed))
    # The curve is shorter than the lines between the control points: fine points first, then equal lengths on them.
    fine = coarse.resampled(max(count, 20 * len(control)) * 2, BEZIER, smoothness, is_open=not is_closed)
    curve = FlatPath(fine, lengths_of(fine, POSE), TYPES)
    return poses_of(curve.resampled(count, "linear", 1.0, is_open=not is_closed))


def oriented(points: Sequence[Pose], mode: int, up: Vector, *, is_closed: bool) -> list[Pose]:
    """Return the points with orientations along the way.

    Args:
        mode: 0 x along the path and y upwards, 1 x and z, 2 y and x, 3 y and z, 4 z and x, 5 z and y.
        up: the direction upwards.
        is_closed: the last point is the first one.

    Raises:
        CommandError: an unknown mode, or no direction upwards.
    """
    if not 0 <= mode < len(_AXES):
        raise CommandError(f"an orientation mode is 0 to {len(_AXES) - 1}, not {mode}")
    if math.hypot(*up) < _FLAT:
        raise CommandError("the vector upwards has no length")
    along, upwards = _AXES[mode]
    found: list[Pose] = []
    for place, way in zip((point[0] for point in points), _ways(points, is_closed=is_closed), strict=True):
        before = found[-1][1] if found else NO_TURN
        found.append((place, _turned(way, up, along, upwards, before)))
    return found


def _ways(points: Sequence[Pose], *, is_closed: bool) -> list[Vector]:
    """Return the direction of the path at each point."""
    places = [point[0] for point in points]
    if is_closed:
        before, after = [places[-2], *places[:-1]], [*places[1:], places[1]]
    else:
        before, after = [places[0], *places[:-1]], [*places[1:], places[-1]]
    return [subtract(b, a) for a, b in zip(before, after, strict=True)]


def _turned(way: Vector, up: Vector, along: int, upwards: int, before: Quaternion) -> Quaternion:
    forward = _unit(way)
    if forward is None:
        return before
    rise = sum(a * b for a, b in zip(forward, up, strict=True))
    across = _unit((up[0] - rise * forward[0], up[1] - rise * forward[1], up[2] - rise * forward[2]))
    if across is None:  # straight up or down
        return before
    axes = {along: forward, upwards: across}
    third = ({0, 1, 2} - axes.keys()).pop()
    first, second = axes[(third + 1) % 3], axes[(third + 2) % 3]
    axes[third] = (
        first[1] * second[2] - first[2] * second[1],
        first[2] * second[0] - first[0] * second[2],
        first[0] * second[1] - first[1] * second[0],
    )
    return from_rows(list(zip(axes[0], axes[1], axes[2], strict=True)))


def _unit(vector: Vector) -> Vector | None:
    length = math.hypot(*vector)
    return None if length < _FLAT else (vector[0] / length, vector[1] / length, vector[2] / length)


def has_overlapping_ends(points: Sequence[Pose]) -> bool:
    """Return whether a path ends where it starts, and has a way in between."""
    is_moving = any(math.dist(a[0], b[0]) > _FLAT for a, b in pairwise(points))
    return is_moving and math.dist(points[0][0], points[-1][0]) < 1e-4
