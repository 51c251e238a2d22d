"""The bounding box of a shape in any orientation: scripts turn it, and the frame of the shape stays as it is."""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from itertools import combinations
from typing import TYPE_CHECKING, Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.editing import shape_looks
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import NO_TURN, Pose, Quaternion, from_rows, normalised, rotate

from .geom_boxes import box_of_geoms

if TYPE_CHECKING:
    from simx_server.world.world import World

_GEOM = mujoco.mjtGeom

Points = NDArray[np.float64]

_MOST_FACES = 200
"""Directions of faces, those of the largest area first, among which the smallest box is searched."""

_DIRECTION = 2
"""Decimals of the components of normals that count as one direction."""


class _Turn(IntEnum):
    """Components of the turn of a box in its shape's frame: numbers of kept parameters."""

    X = 90_005
    Y = 90_006
    Z = 90_007
    W = 90_008


def turn_of(world: World, handle: int) -> Quaternion:
    """Return the orientation of the box of a shape in its frame, w, x, y, z."""
    kept = world.object_settings.kept
    x, y, z = (kept(handle, each, 0.0) for each in (_Turn.X, _Turn.Y, _Turn.Z))
    return kept(handle, _Turn.W, 1.0), x, y, z


def set_turn(world: World, handle: int, turn: Quaternion) -> None:
    """Set the orientation of the box of a shape in its frame."""
    w, x, y, z = normalised(turn)
    for number, value in zip(_Turn, (x, y, z, w), strict=True):
        world.object_settings.keep(handle, number, value)


def box(world: World, handle: int) -> tuple[list[float], Pose]:
    """Return the sides of the box of a shape (m), and the pose of its centre in the shape's frame.

    Raises:
        UnknownHandle, WrongKind: it is not a shape.
    """
    sim, turn = world.simulation, turn_of(world, handle)
    item, instant = sim.scene.get_kind(handle, ObjectKind.SHAPE), world.instants.now()
    geoms: list[int] = instant.geoms_of((handle,)).tolist()
    found = box_of_geoms(instant.model, item, geoms, turn)
    if found is None:
        return [0.0] * 3, ((0.0, 0.0, 0.0), turn)
    return (found[1] - found[0]).tolist(), (rotate(turn, ((found[0] + found[1]) / 2).tolist()), turn)


def is_turned(world: World, handle: int) -> bool:
    """Return whether the box of a shape does not lie along the axes of its frame."""
    return turn_of(world, handle) != NO_TURN


def is_primitive(world: World, handle: int) -> bool:
    """Return whether a shape is a single primitive, whose box cannot be turned."""
    kinds = world.simulation.model.geom_type
    geoms = [part.geom for part in world.shape_colors.parts(handle)]
    return len(geoms) == 1 and int(kinds[geoms[0]]) not in (
        _GEOM.mjGEOM_MESH.value,
        _GEOM.mjGEOM_HFIELD.value,
    )


def natural_turn(world: World, handle: int) -> Quaternion:
    """Return the orientation of the smallest box about the surface of a shape, in its frame.

    A side of it lies on a face of the surface. Its shortest side is along x, its longest along z.

    Raises:
        CommandError: the shape is a plane.
    """
    parts = world.shape_colors.parts(handle)
    corners = np.concatenate([shape_looks.part_corners(world, handle, part.geom) for part in parts])
    points = np.unique(corners.reshape(-1, 3), axis=0)
    best, least = np.eye(3), np.inf
    for axes in _candidates(corners, points):
        along = points @ axes.T
        sides = along.max(axis=0) - along.min(axis=0)
        # Flat surfaces have boxes without a volume.
        size = float(sum(a * b for a, b in combinations(sides, 2))) + float(sides.prod())
        if size < least * (1 - 1e-9):
            best, least = axes[np.argsort(sides, kind="stable")], size
    if np.linalg.det(best) < 0:
        best[1] = -best[1]
    return from_rows(best.T.tolist())


def _candidates(corners: Points, points: Points) -> Iterator[Points]:
    """Yield rows of axes: the shape's own, and for each direction of a face that of the tightest rectangle on it."""
    yield np.eye(3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    units = normals[areas > 0] / areas[areas > 0, None]
    _, number = np.unique(units.round(_DIRECTION), axis=0, return_inverse=True)
    order = np.argsort(-np.bincount(number.reshape(-1), areas[areas > 0]), kind="stable")
    for place in order[:_MOST_FACES]:
        # The exact direction is that of one of the faces.
        across = units[np.flatnonzero(number.reshape(-1) == place)[0]]
        start = np.eye(3)[int(np.argmin(np.abs(across)))]
        first = _unit(np.cross(across, start))
        second = _unit(np.cross(across, first))
        flat = np.stack([points @ first, points @ second], axis=1)
        angle = np.radians(cv2.minAreaRect(flat.astype(np.float32))[2])
        one = _unit(np.cos(angle) * first + np.sin(angle) * second)
        yield np.stack([across, one, _unit(np.cross(across, one))])


def _unit(vector: NDArray[Any]) -> Points:
    return np.asarray(vector / np.linalg.norm(vector), np.float64)
