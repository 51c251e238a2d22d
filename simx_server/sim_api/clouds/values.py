"""Arguments of the functions of point clouds and octrees: points, colours, and the points of other objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from simx_server.editing import shape_looks
from simx_server.errors import CommandError
from simx_server.parts.clouds.clouds import FARTHEST, LEAST_VOXEL, rows_of
from simx_server.parts.clouds.near import Array
from simx_server.parts.clouds.points import Colors
from simx_server.parts.clouds.voxels import Voxels
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix

if TYPE_CHECKING:
    from simx_server.world.world import World

LOCAL, EACH = 1, 2
"""Bits of the options: points are in the frame of the cloud or octree; each point has its own colour and tag."""

_MOST_SAMPLES = 4_000_000


def places_of(world: World, handle: int, options: int, numbers: Sequence[float]) -> Array:
    """Return points (n, 3) in the frame of a cloud or octree from a script's numbers. Raises CommandError."""
    places = np.array(numbers[: len(numbers) // 3 * 3], np.float64).reshape(-1, 3)
    if not options & LOCAL:
        places = world.clouds.local(handle, places)
    if len(places) and not np.abs(places).max() <= FARTHEST:
        raise CommandError(f"coordinates of points are at most {FARTHEST:g} m")
    return places


def colors_of(world: World, handle: int, given: Sequence[float] | None, options: int, count: int) -> Colors:
    """Return the colours (count, 3) that a script gives as numbers 0..255; none: that of the cloud or octree.

    Raises CommandError.
    """
    if not given:
        return world.clouds.default_colors(handle, count)
    wanted = 3 * count if options & EACH else 3
    if len(given) < wanted:
        raise CommandError(f"colours of {count} points are {wanted} numbers from 0 to 255; got {len(given)}")
    numbers = np.clip(np.array(given[:wanted], np.float64), 0, 255).astype(np.uint8)
    return numbers.reshape(-1, 3) if options & EACH else rows_of(numbers.tolist(), count)


def size_of(size: float, what: str) -> float:
    """Return a size in metres. Raises CommandError."""
    if not LEAST_VOXEL <= size <= FARTHEST:
        raise CommandError(f"{what} is from {LEAST_VOXEL:g} to {FARTHEST:g} m, not {size}")
    return size


def triangles_in(world: World, shape: int, handle: int) -> Array:
    """Return the triangles (n, 3, 3) of a shape in the frame of a cloud or octree. Raises CommandError: a plane."""
    points, faces = shape_looks.triangles(world, shape)
    position, quat = frames.get_pose(world.simulation, shape)
    placed = points @ np.array(matrix(quat)).T + np.array(position)
    return world.clouds.local(handle, placed)[faces]


def inside_of(world: World, octree: int, handle: int, size: float) -> Array:
    """Return points (n, 3) in the cells of an octree, in the frame of another one, dense enough for all of its cells.

    Args:
        octree: the one with the cells.
        handle: the one that the points are for.
        size: its cells' edge in metres.

    Raises:
        CommandError: too many points.
    """
    voxels = world.clouds.voxels(octree)
    across = int(np.ceil(2 * voxels.size / size)) + 1
    if len(voxels) * across**3 > _MOST_SAMPLES:
        raise CommandError(
            f"the voxels of {size:g} m are too small for those of {voxels.size:g} m; choose larger ones"
        )
    # Not quite as far as the faces, which belong to the neighbours too.
    steps = np.linspace(-0.4995, 0.4995, across) * voxels.size
    offsets = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    inside = (voxels.places[:, np.newaxis] + offsets).reshape(-1, 3)
    position, quat = frames.get_pose(world.simulation, octree)
    placed = inside @ np.array(matrix(quat)).T + np.array(position)
    return world.clouds.local(handle, placed)


def in_cells(voxels: Voxels, places: Array) -> np.ndarray:
    """Return (n,) which points (n, 3) in its frame lie in filled cells of an octree."""
    found = np.zeros(len(places), bool)
    within = np.flatnonzero((np.abs(places) < voxels.reach).all(axis=1))
    found[within] = voxels.holds(voxels.cells_of(places[within]))
    return found
