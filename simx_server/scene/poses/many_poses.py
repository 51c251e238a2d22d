"""Poses of many objects at once, bit for bit those of `frames.py`, which computes one pose at a time.

The arithmetic of `poses.py` works on arrays as well as on numbers: element by element, in the same order of operations,
so with the same rounding. Trigonometric functions are those of `math`, because NumPy's may round differently.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from simx_server.scene.objects import SceneObject

from . import poses
from .frames import GIMBAL_LOCK, WORLD
from .placing import moving_pose, object_pose

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

Columns = tuple[npt.NDArray[np.float64], ...]
"""One array for each number of a pose, position x y z or quaternion w x y z; an element for each object."""


def get_poses(sim: LiveScene, handles: Sequence[int], relative_to: int) -> tuple[Columns, Columns]:
    """Return the positions and quaternions (w, x, y, z) of objects.

    Args:
        relative_to: `frames.WORLD` or `frames.PARENT`.
    """
    sim.refresh()
    items = list(map(sim.scene.get, handles))
    found = _world_poses(sim, items)
    if relative_to == WORLD:
        return _columns(found)
    below = [place for place, item in enumerate(items) if item.parent != -1]
    if below:
        outer: Any = _columns(_reference_poses(sim, [items[place].parent for place in below]))
        inner: Any = _columns(found[below])
        with np.errstate(all="ignore"):  # of diverged physics; plain numbers do not warn either
            position, quat = poses.compose(poses.inverse(outer), inner)
        found[below] = np.stack((*position, *quat), axis=1)
    return _columns(found)


def positions(columns: tuple[Columns, Columns]) -> Columns:
    """Return the columns x, y, z."""
    return columns[0]


def quaternions(columns: tuple[Columns, Columns]) -> Columns:
    """Return the columns x, y, z, w of the quaternions with w >= 0."""
    w, *others = columns[1]
    is_negative = w < 0
    return tuple(np.where(is_negative, -each, each) for each in (*others, w))


def orientations(columns: tuple[Columns, Columns]) -> Columns:
    """Return the columns alpha, beta, gamma of the Euler angles in radians."""
    quat: Any = columns[1]
    with np.errstate(all="ignore"):
        rows: tuple[Columns, ...] = poses.matrix(quat)  # pyright: ignore[reportAssignmentType]
    # As max(-1, min(1, sine)) does it, also for a number that is not one.
    sine = np.where(rows[0][2] < 1.0, rows[0][2], 1.0)
    sine = np.where(sine > -1.0, sine, -1.0)
    is_locked = np.abs(sine) >= GIMBAL_LOCK
    alpha = _angles(-rows[1][2], rows[2][2])
    alpha[is_locked] = 0.0
    gamma = _angles(np.where(is_locked, rows[1][0], -rows[0][1]), np.where(is_locked, rows[1][1], rows[0][0]))
    return alpha, np.array(list(map(math.asin, sine.tolist()))), gamma


def flat(columns: Sequence[npt.NDArray[np.float64]]) -> list[float]:
    """Return the numbers object by object."""
    numbers: list[float] = np.stack(columns, axis=1).ravel().tolist()
    return numbers


def _angles(y: npt.NDArray[np.float64], x: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.array(list(map(math.atan2, y.tolist(), x.tolist())))


def _columns(found: npt.NDArray[np.float64]) -> tuple[Columns, Columns]:
    each = tuple(found.T)
    return each[:3], each[3:]


def _world_poses(sim: LiveScene, items: Sequence[SceneObject]) -> npt.NDArray[np.float64]:
    """Return a row for each object: position, quaternion w x y z."""
    # The pose of a body with an object is the row of its id; 0 is the world, which is none.
    ids = [item.id if item.element == "body" else 0 for item in items]
    found = np.empty((len(items), 7))
    found[:, :3], found[:, 3:] = sim.data.xpos[ids], sim.data.xquat[ids]
    if 0 in ids:
        for place, item in enumerate(items):
            if not ids[place]:
                position, quat = object_pose(sim, item)
                found[place] = (*position, *quat)
    return found


def _reference_poses(sim: LiveScene, handles: Sequence[int]) -> npt.NDArray[np.float64]:
    """Return a row for each object: the pose of the frame that its children are given in."""
    once = [sim.scene.get(handle) for handle in dict.fromkeys(handles)]
    found = _world_poses(sim, once)
    for place, item in enumerate(once):
        if item.element in ("joint", "tendon"):
            position, quat = moving_pose(sim, item)
            found[place] = (*position, *quat)
    places = {item.handle: place for place, item in enumerate(once)}
    return found[[places[handle] for handle in handles]]
