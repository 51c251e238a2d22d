"""Poses of objects: positions, Euler angles and quaternions relative to the world, a parent or any other object.

Relative to: -1 the world, -11 the parent (the world when there is none), else a handle. A joint as reference means its
moving frame; with 0x400000 added to the queried handle, its fixed frame (then quaternions are w, x, y, z).
Euler angles: R = Rx(alpha) Ry(beta) Rz(gamma), radians. Quaternions in arguments and results are x, y, z, w (else
noted). All functions raise UnknownHandle; the setters raise CommandError for a wrong count of numbers or for infinite
ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.objects import SceneObject

from . import poses
from .joint_chain import joint_frames
from .placing import moving_pose, object_pose, place
from .poses import Pose, Quaternion, compose, inverse, normalised

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

WORLD = -1
PARENT = -11
JOINT_BASE_FLAG = 0x400000
"""`sim_handleflag_reljointbaseframe`; on quaternions also `sim_handleflag_wxyzquat`."""

_OFF_ROTATION = 1e-2
"""Tolerance of the products of a matrix's columns against 0 and 1; single precision and a user's rounding are finer."""

GIMBAL_LOCK = 0.999995
"""|sin beta| from which alpha is set to 0 (V-REP's own limit)."""


def get_pose(sim: LiveScene, handle: int, relative_to: int = WORLD) -> Pose:
    """Return the pose as (position, quaternion w x y z): the form for use inside the server."""
    item, base = _split(sim, handle)
    sim.refresh()
    pose = object_pose(sim, item)
    reference = _reference(sim, item, relative_to, base)
    return pose if reference is None else compose(inverse(reference), pose)


def get_position(sim: LiveScene, handle: int, relative_to: int = WORLD) -> list[float]:
    """Return the position [x, y, z] in metres."""
    if relative_to == WORLD:  # what most streams ask for
        item = sim.scene.objects.get(handle)
        if item is not None and item.element == "body" and item.id:
            sim.refresh()
            position: list[float] = sim.data.xpos[item.id].tolist()
            return position
    return list(get_pose(sim, handle, relative_to)[0])


def get_orientation(sim: LiveScene, handle: int, relative_to: int = WORLD) -> list[float]:
    """Return the Euler angles [alpha, beta, gamma] in radians."""
    return euler_from_quat(get_pose(sim, handle, relative_to)[1])


def get_quaternion(sim: LiveScene, handle: int, relative_to: int = WORLD) -> list[float]:
    """Return the quaternion [x, y, z, w], w >= 0; with the flag [w, x, y, z]."""
    quat = xyzw_from_wxyz(get_pose(sim, handle, relative_to)[1])
    return [quat[3], *quat[:3]] if _has_flag(handle) else quat


def set_position(sim: LiveScene, handle: int, relative_to: int, position: Sequence[float]) -> None:
    """Move an object and all below it; the velocity of dynamic bodies becomes zero."""
    x, y, z = _checked(position, 3, "a position")
    _change(sim, handle, relative_to, lambda local: ((x, y, z), local[1]))


def set_orientation(sim: LiveScene, handle: int, relative_to: int, euler: Sequence[float]) -> None:
    """Turn an object about its own origin, with all below it."""
    quat = quat_from_euler(_checked(euler, 3, "an orientation"))
    _change(sim, handle, relative_to, lambda local: (local[0], quat))


def set_quaternion(sim: LiveScene, handle: int, relative_to: int, quaternion: Sequence[float]) -> None:
    """Turn an object as `set_orientation`, by [x, y, z, w] (with the flag [w, x, y, z]) of any length but zero."""
    values = _checked(quaternion, 4, "a quaternion")
    if not _has_flag(handle):
        values = [values[3], *values[:3]]
    try:
        quat = normalised(values)
    except ValueError as error:
        raise CommandError(f"{error} is no rotation; give [x, y, z, w]") from None
    _change(sim, handle, relative_to, lambda local: (local[0], quat))


def set_pose(sim: LiveScene, handle: int, relative_to: int, pose: Pose) -> None:
    """Move and turn an object at once, with all below it."""
    _checked([*pose[0], *pose[1]], 7, "a pose")
    _change(sim, handle, relative_to, lambda _local: pose)


def euler_from_quat(quat_wxyz: Quaternion) -> list[float]:
    """Return [alpha, beta, gamma] with R = Rx(alpha) Ry(beta) Rz(gamma)."""
    rows = poses.matrix(quat_wxyz)
    sine = max(-1.0, min(1.0, rows[0][2]))
    if abs(sine) >= GIMBAL_LOCK:
        return [0.0, math.asin(sine), math.atan2(rows[1][0], rows[1][1])]
    return [math.atan2(-rows[1][2], rows[2][2]), math.asin(sine), math.atan2(-rows[0][1], rows[0][0])]


def quat_from_euler(euler: Sequence[float]) -> Quaternion:
    """Return the quaternion w, x, y, z of Rx(alpha) Ry(beta) Rz(gamma)."""
    about_x = poses.about((1.0, 0.0, 0.0), euler[0])
    about_y = poses.about((0.0, 1.0, 0.0), euler[1])
    about_z = poses.about((0.0, 0.0, 1.0), euler[2])
    return poses.multiply(poses.multiply(about_x, about_y), about_z)


def xyzw_from_wxyz(quat_wxyz: Sequence[float]) -> list[float]:
    """Return the quaternion with the scalar last and not negative."""
    w, x, y, z = quat_wxyz
    return [-x, -y, -z, -w] if w < 0 else [x, y, z, w]


def matrix12(pose: Pose) -> list[float]:
    """Return a pose as V-REP's 12 numbers: three rows of rotation and position."""
    (a, b, c), (d, e, f), (g, h, i) = poses.matrix(pose[1])
    x, y, z = pose[0]
    return [a, b, c, x, d, e, f, y, g, h, i, z]


def pose_from_matrix12(values: Sequence[float]) -> Pose:
    """Return the pose of 12 numbers; an inexact upper 3 x 3 part is replaced by the nearest rotation.

    Raises CommandError: not 12 finite numbers, or the columns are far from perpendicular unit vectors.
    """
    numbers = _checked(values, 12, "a matrix")
    a, b, c, x, d, e, f, y, g, h, i, z = numbers
    products = (
        a * a + d * d + g * g - 1.0, b * b + e * e + h * h - 1.0, c * c + f * f + i * i - 1.0,
        a * b + d * e + g * h, a * c + d * f + g * i, b * c + e * f + h * i,
    )  # fmt: skip
    if max(products) > _OFF_ROTATION or min(products) < -_OFF_ROTATION:
        raise CommandError(
            f"the matrix {numbers} holds no rotation: its columns must be perpendicular and of length 1"
        )
    return (x, y, z), poses.from_rows(((a, b, c), (d, e, f), (g, h, i)))


def wxyz_from_xyzw(quat_xyzw: Sequence[float]) -> Quaternion:
    """Return the quaternion with the scalar first, of length 1.

    Raises CommandError: not 4 finite numbers, or all of them 0.
    """
    x, y, z, w = _checked(quat_xyzw, 4, "a quaternion")
    try:
        return normalised((w, x, y, z))
    except ValueError as error:
        raise CommandError(f"{error} is no rotation; give [x, y, z, w]") from None


def _has_flag(handle: int) -> bool:
    return handle > 0 and bool(handle & JOINT_BASE_FLAG)


def _split(sim: LiveScene, handle: int) -> tuple[SceneObject, bool]:
    """Return the object, and whether a reference joint's fixed frame is meant."""
    flagged = _has_flag(handle)
    return sim.scene.get(handle & ~JOINT_BASE_FLAG if flagged else handle), flagged


def _reference(sim: LiveScene, item: SceneObject, relative_to: int, base: bool) -> Pose | None:
    """Return the world pose of the reference frame; None for the world."""
    if relative_to == PARENT:
        relative_to = item.parent
    if relative_to == WORLD:
        return None
    reference = sim.scene.get(relative_to)
    if base and reference.element == "joint":
        return joint_frames(sim, reference.id)[0]
    return object_pose(sim, reference) if base else moving_pose(sim, reference)


def _change(sim: LiveScene, handle: int, relative_to: int, changed: Callable[[Pose], Pose]) -> None:
    """Place an object; `changed` maps its pose in the frame of the reference to the new one."""
    item, base = _split(sim, handle)
    if sim.waiting is not None and item.handle in sim.waiting.loose:
        if relative_to not in (WORLD, PARENT):
            sim.scene.get(relative_to)
        sim.waiting.call(lambda: _change(sim, handle, relative_to, changed))
        return
    sim.refresh()
    reference, present = _reference(sim, item, relative_to, base), object_pose(sim, item)
    if reference is None:
        place(sim, item, changed(present), present=present)
    else:
        local = compose(inverse(reference), present)
        place(sim, item, compose(reference, changed(local)), present=present)


def _checked(values: Sequence[float], count: int, what: str) -> list[float]:
    numbers = list(map(float, values[:count]))  # what is left over is ignored, as in V-REP
    if len(numbers) < count or not (math.isfinite(sum(numbers)) or all(map(math.isfinite, numbers))):
        raise CommandError(f"{what} is {count} finite numbers, not {list(values)}")
    return numbers
