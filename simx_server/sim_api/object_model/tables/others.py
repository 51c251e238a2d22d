"""Properties of dummies, lights, scripts, graphs, point clouds, octrees, collections and markers."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.parts.drawing import CYCLIC, LOCAL
from simx_server.sim_api.object_model.classes import FIRST_COLLECTION, FIRST_MARKER
from simx_server.sim_api.object_model.enumerations import word_of
from simx_server.sim_api.object_model.types import COLOR, MATRIX
from simx_server.sim_api.object_model.values import Color, Matrix
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed
from simx_server.sim_api.properties.tables.clouds import OCTREES, POINT_CLOUDS
from simx_server.sim_api.properties.tables.others import DUMMIES, LIGHTS, SCRIPTS

from .making import Old, constant, kept, kept_colors, refused

if TYPE_CHECKING:
    from simx_server.parts.clouds.points import Points
    from simx_server.parts.clouds.voxels import Voxels
    from simx_server.parts.drawing import DrawingObject
    from simx_server.world.world import World

_DUMMY, _LIGHT, _SCRIPT = Old(DUMMIES), Old(LIGHTS), Old(SCRIPTS)
_CLOUD, _OCTREE = Old(POINT_CLOUDS), Old(OCTREES)

DUMMY = (
    *_DUMMY.same("color.diffuse color.emission color.specular linkedDummy"),
    _DUMMY.named("dummySize", "size"),
    _DUMMY.worded("dummyType", "dummy.type", "dummyType"),
    refused("assemblyTag", t.STRING, "assembly is not available"),
    fixed("dynamics.engineProperties", t.STRING, "{}", "MuJoCo has no options for dummies"),
)

LIGHT = (
    *_LIGHT.same("attenuationFactors enabled povray.castShadows spotCutoffAngle spotExponent"),
    _LIGHT.worded("lightType", "light.type", "lightType"),
    *kept_colors("color"),
    _LIGHT.named("color.diffuse", "lightColor.diffuse"),
    _LIGHT.named("color.specular", "lightColor.specular"),
    constant("lightColor.emission", COLOR, Color.of((0, 0, 0))),
    kept("size", t.FLOAT, 0.05),
)
"""`color` is that of the light's sign in a window, `lightColor` that of its light."""

SCRIPT = (
    *_SCRIPT.same("detachedScript"),
    _SCRIPT.worded("scriptType", "script.type", "scriptType"),
    fixed(
        "resetAfterSimError", t.BOOL, True, "a script that an error stopped starts again with the next run"
    ),
    kept("size", t.FLOAT, 0.01),
    *kept_colors("color"),
)

GRAPH = (
    kept("bufferSize", t.INT, 1000),
    kept("cyclic", t.BOOL, True),
    kept("size", t.FLOAT, 0.1),
    kept("backgroundColor", COLOR, Color.of((0.1, 0.1, 0.1))),
    kept("foregroundColor", COLOR, Color.of((0.8, 0.8, 0.8))),
    *kept_colors("color"),
)


def _packed(numbers: list[float]) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def _points(cloud: Callable[[World, int], Points | Voxels]) -> list[Property]:
    """Return the points of a cloud or octree, as a matrix of columns and as bytes, and their colours."""

    def places(world: World, handle: int) -> list[float]:
        return cloud(world, handle).places.ravel().tolist()

    def colors(world: World, handle: int) -> bytes:
        return cloud(world, handle).colors.tobytes()

    return [
        Property(
            "points", MATRIX, lambda world, handle: Matrix.of_points(places(world, handle), 3), is_large=True
        ),
        Property(
            "packedPoints", t.BUFFER, lambda world, handle: _packed(places(world, handle)), is_large=True
        ),
        Property("colors", t.BUFFER, colors, is_large=True),
    ]


OC_TREE = (
    *_OCTREE.same("voxelSize"),
    *_points(lambda world, handle: world.clouds.voxels(handle)),
    fixed("randomColors", t.BOOL, False, "colours are set when voxels are inserted"),
    kept("showPoints", t.BOOL, False),
    *kept_colors("color"),
)

POINT_CLOUD = (
    *_CLOUD.same("cellSize maxPointsInCell pointSize"),
    _CLOUD.named("ocTreeStruct", "octreeStruct"),
    *_points(lambda world, handle: world.clouds.points(handle)),
    fixed("randomColors", t.BOOL, False, "colours are set when points are inserted"),
    fixed("pointDisplayFraction", t.FLOAT, 1.0, "all points are drawn"),
    *kept_colors("color"),
)

COLLECTION = (
    Property(
        "objects", t.HANDLE_ARRAY, lambda world, handle: world.collections.members(handle - FIRST_COLLECTION)
    ),
)


def _drawing(world: World, handle: int) -> DrawingObject:
    return world.drawings.get(handle - FIRST_MARKER)


def _part_of_items(start: int, length: int) -> Callable[[World, int], list[float]]:
    """Return the getter of some numbers of every item, one item after the other."""

    def get(world: World, handle: int) -> list[float]:
        return [number for item in _drawing(world, handle).items for number in item[start : start + length]]

    return get


def _points_of_items(world: World, handle: int) -> list[float]:
    """Return the points of the items; of lines and triangles all of them."""
    drawing = _drawing(world, handle)
    return _part_of_items(0, 3 * drawing.layout.points)(world, handle)


def _turns_of_items(world: World, handle: int) -> list[float]:
    drawing = _drawing(world, handle)
    if drawing.layout.has_quaternion:
        return _part_of_items(3 * drawing.layout.points, 4)(world, handle)
    return [0.0, 0.0, 0.0, 1.0] * len(drawing.items)


def _sizes_of_items(world: World, handle: int) -> list[float]:
    drawing = _drawing(world, handle)
    return [drawing.size] * (3 * len(drawing.items))


def _colors_of_items(world: World, handle: int) -> bytes:
    drawing = _drawing(world, handle)
    return Color.of(drawing.color).rgba * len(drawing.items)


_DRAWN = {0: 0, 1: 1, 2: 2, 3: 2, 4: 9, 5: 10, 6: 11, 7: 7, 8: 1, 9: 2, 10: 9, 11: 10, 12: 11}
"""Types of markers by kinds of drawing objects."""


def _marker_type(world: World, handle: int) -> str:
    return word_of("markerType", _DRAWN.get(_drawing(world, handle).kind, 0))


def _numbers(name: str, rows: int, get: Callable[[World, int], list[float]]) -> list[Property]:
    packed = f"packed{name[0].upper()}{name[1:]}"
    return [
        Property(
            name, MATRIX, lambda world, handle: Matrix.of_points(get(world, handle), rows), is_large=True
        ),
        Property(packed, t.BUFFER, lambda world, handle: _packed(get(world, handle)), is_large=True),
    ]


_NO_MESH = "a marker is drawn by the viewer, which has its own mesh for each type"

MARKER = (
    Property("marker.type", t.STRING, _marker_type),
    Property("cyclic", t.BOOL, lambda world, handle: bool(_drawing(world, handle).flags & CYCLIC)),
    Property("local", t.BOOL, lambda world, handle: bool(_drawing(world, handle).flags & LOCAL)),
    fixed("overlay", t.BOOL, False, "markers are drawn in the scene"),
    Property("parent", t.HANDLE, lambda world, handle: _drawing(world, handle).parent),
    Property("defaultItemSize", t.VECTOR3, lambda world, handle: [_drawing(world, handle).size] * 3),
    *_numbers("points", 3, _points_of_items),
    *_numbers("quaternions", 4, _turns_of_items),
    *_numbers("sizes", 3, _sizes_of_items),
    Property("colors", t.BUFFER, _colors_of_items),
    refused("indices", t.INT_ARRAY, _NO_MESH),
    refused("vertices", MATRIX, _NO_MESH),
    refused("normals", MATRIX, _NO_MESH),
)
"""A marker is a drawing object: it has no place in the tree of the scene, only a parent."""
