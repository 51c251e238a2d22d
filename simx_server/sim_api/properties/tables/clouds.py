"""Properties of point clouds and octrees: metres; points in the frame of the object."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.parts.clouds.clouds import UNSTRUCTURED
from simx_server.sim_api.clouds.values import size_of
from simx_server.sim_api.properties.entry import Property
from simx_server.sim_api.properties.property_types import BOOL, FLOAT, FLOAT_ARRAY, INT

if TYPE_CHECKING:
    from simx_server.world.world import World


def _change(world: World, handle: int, **values: Any) -> None:
    world.clouds.set_settings(handle, replace(world.clouds.settings(handle), **values))


def _set_cell_size(world: World, handle: int, size: float) -> None:
    size_of(size, "the largest size of a cell")
    _change(world, handle, voxel=size)


def _set_most(world: World, handle: int, most: int) -> None:
    if most < 1:
        raise CommandError(f"a cell has at least one point, not {most}")
    _change(world, handle, most=most)


def _set_point_size(world: World, handle: int, size: int) -> None:
    if size < 0:
        raise CommandError(f"a point has a size of 0 or more pixels, not {size}")
    _change(world, handle, point_size=float(size))


def _is_structured(world: World, handle: int) -> bool:
    return not world.clouds.settings(handle).options & UNSTRUCTURED


def _set_structured(world: World, handle: int, is_structured: bool) -> None:
    options = world.clouds.settings(handle).options & ~UNSTRUCTURED
    _change(world, handle, options=options if is_structured else options | UNSTRUCTURED)


POINT_CLOUDS = (
    Property("cellSize", FLOAT, lambda world, handle: world.clouds.settings(handle).voxel, _set_cell_size),
    Property("maxPointsInCell", INT, lambda world, handle: world.clouds.settings(handle).most, _set_most),
    Property(
        "pointSize",
        INT,
        lambda world, handle: round(world.clouds.settings(handle).point_size),
        _set_point_size,
    ),
    Property("ocTreeStruct", BOOL, _is_structured, _set_structured),
    Property(
        "points",
        FLOAT_ARRAY,
        lambda world, handle: world.clouds.points(handle).places.ravel().tolist(),
        is_large=True,
    ),
)

OCTREES = (
    Property("voxelSize", FLOAT, lambda world, handle: world.clouds.settings(handle).voxel),
    Property(
        "voxels",
        FLOAT_ARRAY,
        lambda world, handle: world.clouds.voxels(handle).places.ravel().tolist(),
        is_large=True,
    ),
)
