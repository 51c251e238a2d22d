"""Facts about point clouds and octrees, and their records."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.parts.clouds.clouds import Settings
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.writing.clouds import octree_cells, point_cells
from simx_server.scene.objects import ObjectKind

from ..field import Field, Fields, NotInVrepFiles, Writing, unwritable

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_OCTREE = "OCT"


def _content(world: World, handle: int) -> tuple[Any, ...]:
    """Return size of cells, most points of a cell, and as bytes: places, colours, tags (none in point clouds)."""
    settings = world.clouds.settings(handle)
    is_octree = world.simulation.scene.objects[handle].kind == ObjectKind.OCTREE
    content = world.clouds.voxels(handle) if is_octree else world.clouds.points(handle)
    tags = world.clouds.voxels(handle).tags if is_octree else np.zeros(0, np.uint32)
    places = np.asarray(content.places, np.float64)
    colors = np.asarray(content.colors, np.uint8)
    return settings.voxel, settings.most, places.tobytes(), colors.tobytes(), tags.astype("<u4").tobytes()


def _put_content(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    size, most, places, colors, tags = value
    points: NDArray[np.float64] = np.frombuffer(places).reshape(-1, 3)
    paint = np.frombuffer(colors, np.uint8).reshape(-1, 3)
    is_octree = records.tag == _OCTREE
    records.own.put_numbers("Siz", size, None)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.zeros(3))
    records.own.put_numbers("Mm2" if is_octree else "Mmd", *low.tolist(), *high.tolist())
    try:
        if is_octree:
            cells = octree_cells(points, paint, np.frombuffer(tags, "<u4"), size)
        else:
            cells = point_cells(points, paint, size, most)
    except SceneError as problem:
        raise NotInVrepFiles(f"the points, since {problem}") from None
    records.own.put("Co2", cells)


def _other_settings(world: World, handle: int) -> Settings:
    return replace(world.clouds.settings(handle), voxel=0.0, most=0)


CLOUDS: Fields = {
    "points": Field(_content, _put_content),
    "settings of points": Field(_other_settings, unwritable("settings of points"), of_new=False),
}
