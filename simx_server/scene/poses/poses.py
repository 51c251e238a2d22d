"""Rigid poses as plain tuples: (position, quaternion w x y z), which are faster than numpy for few numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simx_server.errors import CommandError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z: MuJoCo's order, used internally only."""
Pose = tuple[Vector, Quaternion]

NO_TURN: Quaternion = (1.0, 0.0, 0.0, 0.0)
IDENTITY: Pose = ((0.0, 0.0, 0.0), NO_TURN)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation b followed by a (both in the outer frame)."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


class NoRotation(CommandError, ValueError):
    """Error for four zeros, given by a caller or left by diverged physics."""


def conjugate(q: Quaternion) -> Quaternion:
    return (q[0], -q[1], -q[2], -q[3])


def normalised(q: Sequence[float]) -> Quaternion:
    """Return the quaternion scaled to length 1; raises NoRotation for length 0."""
    w, x, y, z = map(float, q)
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if length < 1e-12:
        raise NoRotation("a quaternion of length 0")
    if length == math.inf:  # the squares overflowed
        largest = max(abs(w), abs(x), abs(y), abs(z))
        return normalised((w / largest, x / largest, y / largest, z / largest))
    return (w / length, x / length, y / length, z / length)


def rotate(q: Quaternion, v: Sequence[float]) -> Vector:
    """Return the vector turned by the rotation: v + 2 w (u x v) + 2 u x (u x v)."""
    w, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx)


def add(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Sequence[float], factor: float) -> Vector:
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def compose(outer: Pose, inner: Pose) -> Pose:
    """Return `inner`, given in the frame `outer`, in the frame `outer` is given in."""
    # The functions above, written out: this is called more often than all others.
    (px, py, pz), (w, x, y, z) = outer
    (vx, vy, vz), (bw, bx, by, bz) = inner
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return (
        px + (vx + w * tx + y * tz - z * ty),
        py + (vy + w * ty + z * tx - x * tz),
        pz + (vz + w * tz + x * ty - y * tx),
    ), (
        w * bw - x * bx - y * by - z * bz,
        w * bx + x * bw + y * bz - z * by,
        w * by - x * bz + y * bw + z * bx,
        w * bz + x * by - y * bx + z * bw,
    )


def inverse(pose: Pose) -> Pose:
    back = conjugate(pose[1])
    return scale(rotate(back, pose[0]), -1.0), back


def about(axis: Sequence[float], angle: float) -> Quaternion:
    """Return the rotation about a unit axis. Raises CommandError for an infinite angle from diverged physics."""
    if math.isinf(angle):
        raise CommandError("a joint's value is infinite: physics has diverged; stop the simulation")
    s = math.sin(angle / 2)
    return (math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s)


_LARGER = 2.0**40


def turn_z_to(axis: Sequence[float]) -> Quaternion:
    """Return the smallest rotation that takes +z to a unit axis; for -z a half turn about x."""
    x, y, z = axis
    across = x * x + y * y
    if z < 0 and across < 1e-30:
        return (0.0, 1.0, 0.0, 0.0)
    # Near -z, 1 + z would consist of rounding errors only.
    w = across / (1.0 - z) if z < 0 else 1.0 + z
    # Near -z all three are tiny, and `normalised` refuses that. A power of two changes no bit of the result.
    return normalised((_LARGER * w, -_LARGER * y, _LARGER * x, 0.0))


def rotation_vector(q: Quaternion) -> Vector:
    """Return axis times angle, the angle in 0..pi."""
    if q[0] < 0:
        q = (-q[0], -q[1], -q[2], -q[3])
    s = math.sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if s < 1e-15:
        return (2 * q[1], 2 * q[2], 2 * q[3])
    factor = 2 * math.atan2(s, q[0]) / s
    return (q[1] * factor, q[2] * factor, q[3] * factor)


def matrix(q: Quaternion) -> tuple[Vector, Vector, Vector]:
    """Return the rows of the rotation matrix."""
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def from_rows(rows: Sequence[Sequence[float]]) -> Quaternion:
    """Return the quaternion of a rotation matrix, computed from its largest component (Shepperd's method)."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    w, x, y, z = 1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i
    if w >= x and w >= y and w >= z:
        return normalised((w, h - f, c - g, d - b))
    if x >= y and x >= z:
        return normalised((h - f, x, b + d, c + g))
    if y >= z:
        return normalised((c - g, b + d, y, f + h))
    return normalised((d - b, c + g, f + h, z))


def blend(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """Return the rotation on the shorter way from a to b: 0 gives a, 1 gives b."""
    vector = rotation_vector(multiply(conjugate(a), b))
    angle = math.sqrt(sum(component * component for component in vector))
    if angle < 1e-15:
        return a
    return multiply(a, about(scale(vector, 1 / angle), angle * share))
