"""``createObject``: a new object of a type, with its first properties."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

import mujoco

from simx_client.protocol.nearest import did_you_mean
from simx_server.editing.creating import add as add_object
from simx_server.errors import CommandError
from simx_server.parts.drawing import CYCLIC, ITEM_COLORS, LOCAL
from simx_server.sim_api.object_model import targets
from simx_server.sim_api.object_model.classes import FIRST_COLLECTION, FIRST_INSTANCE, FIRST_MARKER
from simx_server.sim_api.object_model.enumerations import number_of
from simx_server.sim_api.object_model.instances.custom import class_named
from simx_server.sim_api.object_model.targets import ModelTarget
from simx_server.sim_api.object_model.values import Matrix, Ref, plain, to_color, to_matrix

from .custom import make_object, new_console, new_editor
from .method import Call, finite, method, numbers, pair, points_of, text_option, whole

_Fields = dict[str, Any]

_SHAPES = (
    "cuboid",
    "spheroid",
    "cylinder",
    "cone",
    "capsule",
    "disc",
    "plane",
    "heightField",
    "mesh",
    "text",
)
_KINDS = {"plane": 1, "disc": 2, "cuboid": 3, "spheroid": 4, "cylinder": 5, "cone": 6, "capsule": 8}


@method("scene app", "createObject", "changes", takes_values=True)
def create_object(call: Call, fields: dict[str, Any]) -> Ref:
    """Create an object: `type` and the fields of the type; all other fields are properties that are set then."""
    kind = text_option(fields, "type")
    if not kind:
        raise CommandError("unsupported object type: the map has no field 'type'")
    make = _MAKERS.get(kind)
    rest = {name: value for name, value in fields.items() if name not in ("type", "objectType")}
    if make is not None:
        handle = make(call, rest)
    elif (own := class_named(call.world, kind)) is not None:
        handle = make_object(replace(call, handle=own.handle)).handle
    else:
        raise CommandError(
            f"unknown type: {kind[:40]}{did_you_mean(kind, list(_MAKERS))}; valid: {', '.join(_MAKERS)}"
        )
    target = ModelTarget.of(call.world, handle, call.script)
    try:
        for name, value in rest.items():
            targets.write(target, name, value, None)
    except CommandError:
        _remove(call, handle)
        raise
    return Ref(handle)


def _remove(call: Call, handle: int) -> None:
    if handle >= FIRST_MARKER:
        call.world.drawings.remove(handle - FIRST_MARKER)
    elif handle >= FIRST_INSTANCE:
        call.world.instances.remove(handle)
    elif handle >= FIRST_COLLECTION:
        call.sim.destroyCollection(handle - FIRST_COLLECTION)
    else:
        call.sim.removeObjects([handle])


def _taken(fields: _Fields, name: str, default: Any) -> Any:
    """Take a field out; its default where it is missing or nil."""
    value = plain(fields.pop(name, None))
    return default if value is None else value


def _number(fields: _Fields, name: str, default: float) -> float:
    return finite(_taken(fields, name, default), name)


def _numbers(fields: _Fields, name: str, default: list[float]) -> list[float]:
    found = numbers(_taken(fields, name, default), name)
    if default and not found:
        raise CommandError(f"'{name}' must be a table of numbers that is not empty")
    return found


def _word(fields: _Fields, name: str, default: str) -> str:
    value = _taken(fields, name, default)
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _map(value: Any, name: str) -> _Fields:
    if isinstance(value, dict):
        return dict(cast(_Fields, value))
    if value == []:  # an empty table of Lua
        return {}
    raise CommandError(f"'{name}' is a map")


# --- shapes ------------------------------------------------------------------------------------------


def _shape(call: Call, fields: _Fields) -> int:
    given = [name for name in _SHAPES if name in fields]
    if len(given) != 1:
        raise CommandError(
            f"a shape has one of the fields {', '.join(_SHAPES)}, not {', '.join(given) or 'none'}"
        )
    form = given[0]
    values = _map(fields.pop(form), form)
    angle = finite(fields.get("shadingAngle", 0.0), "shadingAngle")
    for part in ("diffuse", "specular", "emission"):
        if (color := fields.pop(f"color.{part}", None)) is not None:
            fields[f"applyColor.{part}"] = to_color(color)
    if form == "heightField":
        handle = _height_field(call, values)
    elif form == "mesh":
        handle = _mesh(call, values, angle)
    elif form == "text":
        height, centred = _number(values, "height", 0.5), bool(_taken(values, "center", False))
        handle = call.sim.generateTextShape(_word(values, "text", "Hello"), None, height, centred)
    else:
        handle = call.sim.createPrimitiveShape(_KINDS[form], _sizes(form, values))
    return handle


def _sizes(form: str, values: _Fields) -> list[float]:
    """Return the sizes along x, y, z of a primitive."""
    if form in ("cuboid", "plane") or "size" in values:
        sizes = _numbers(values, "size", [0.1] * 3)
        return [*sizes, 0.1, 0.1][:3]
    radius = _number(values, "radius", 0.05)
    if form == "spheroid":
        return [2 * radius] * 3
    height = _number(values, "height", 0.1) if form == "cone" else _number(values, "length", 0.1)
    if form == "capsule" and "length" not in values:
        height = max(height, 2 * radius)
    return [2 * radius, 2 * radius, 0.0 if form == "disc" else height]


def _height_field(call: Call, values: _Fields) -> int:
    heights = to_matrix(values.get("heights", []))
    if heights.rows < 2 or heights.columns < 2:
        raise CommandError("'heights' is a matrix of at least 2 x 2")
    cell = _number(values, "cellSize", 0.5)
    width = cell * (heights.columns - 1)
    return call.sim.createHeightfieldShape(0, 0.0, heights.columns, heights.rows, width, heights.numbers)


def _mesh(call: Call, values: _Fields, angle: float) -> int:
    if "texture" in values:
        raise CommandError("a new mesh has no texture: apply one with texture.set")
    indices = [int(each) for each in _numbers(values, "indices", [])]
    return call.sim.createShape(0, angle, points_of(values.get("vertices", [])), indices)


# --- others ------------------------------------------------------------------------------------------


def _joint(call: Call, fields: _Fields) -> int:
    kind = number_of("jointType", _word(fields, "joint.type", "revolute"))
    mode = _taken(fields, "mode", "dynamic")
    mode = number_of("jointMode", mode.decode("utf-8", "replace") if isinstance(mode, bytes) else mode)
    return call.sim.createJoint(kind, mode, 0)


def _dummy(call: Call, fields: _Fields) -> int:
    return call.sim.createDummy(_number(fields, "size", 0.01))


def _force_sensor(call: Call, fields: _Fields) -> int:
    samples = int(_number(fields, "filterSampleSize", 1))
    return call.sim.createForceSensor(
        0, [0, samples, 1, 0, 0], [_number(fields, "size", 0.01), 100.0, 10.0, 0.0, 0.0]
    )


def _vision_sensor(call: Call, fields: _Fields) -> int:
    width, height = pair(fields, "resolution") or [256, 256]
    fields.pop("resolution", None)
    planes = _numbers(fields, "clippingPlanes", [0.01, 10.0])
    if len(planes) != 2:
        raise CommandError("'clippingPlanes' is two numbers, near and far")
    near, far = planes
    size = fields.pop("viewSize", None)
    angle = _number(fields, "viewAngle", math.radians(60))
    view = [near, far, angle if size is None else finite(size, "viewSize"), 0.0, 0.0, 0.0]
    return call.sim.createVisionSensor(
        0 if size is not None else 2, [width, height, 0, 0], [*view, *[0.0] * 5]
    )


def _proximity_sensor(call: Call, fields: _Fields) -> int:
    kind = number_of("proximitySensorType", _word(fields, "proximitySensor.type", "cone"))

    def pair(name: str, default: float) -> list[float]:
        found = _numbers(fields, name, [default])
        return [found[0], found[-1]]

    for name in [each for each in fields if each.startswith("volume_")]:
        fields[f"volume.{name.removeprefix('volume_')}"] = fields.pop(name)
    offset, reach = _number(fields, "volume.offset", 0.0), _number(fields, "volume.range", 0.2)
    angle, gap = [*_numbers(fields, "volume.angle", [math.radians(90)]), 0.0][:2]
    (x, x_far), (y, y_far), (radius, radius_far) = (
        pair("volume.xSize", 0.2),
        pair("volume.ySize", 0.2),
        pair("volume.radius", 0.0 if kind == number_of("proximitySensorType", "cone") else 0.1),
    )
    sizes = [offset, reach, x, y, x_far, y_far, gap, radius, radius_far, angle, 0.0, 0.0, 0.01, 0.0, 0.0]
    return call.sim.createProximitySensor(kind, 16, 0, [0] * 8, sizes)


def _script(call: Call, fields: _Fields) -> int:
    kind = number_of("scriptType", _word(fields, "script.type", "simulation"))
    code, language = _word(fields, "code", ""), _word(fields, "language", "lua")
    return call.sim.createScript(kind, code.encode("utf-8", "surrogateescape"), 0, language)


def _point_cloud(call: Call, fields: _Fields) -> int:
    cell, most = _number(fields, "cellSize", 0.02), int(_number(fields, "maxPointsInCell", 20))
    return call.sim.createPointCloud(cell, most, 0, _number(fields, "pointSize", 2.0))


def _octree(call: Call, fields: _Fields) -> int:
    return call.sim.createOctree(_number(fields, "voxelSize", 0.01), 0)


_DRAWN = {0: 0, 1: 1, 2: 2, 7: 7, 9: 10, 10: 11, 11: 12}
"""Kinds of drawing objects by types of markers."""


def _marker(call: Call, fields: _Fields) -> int:
    word = _word(fields, "marker.type", "spheres")
    kind = _DRAWN.get(number_of("markerType", word))
    if kind is None:
        raise CommandError(
            f"markers of type {word} are not drawn here; use points, lines, triangles, spheres or cubes"
        )
    sizes = _numbers(fields, "itemSize", [0.005] * 3)
    color = to_color(fields.pop("itemColor", [1.0, 1.0, 0.0])).parts
    tolerance, most = _number(fields, "duplicateTolerance", 0.0), int(_number(fields, "itemCnt", 0))
    parent = whole({"parent": _taken(fields, "parent", -1)}, "parent", -1)
    bits = kind | ITEM_COLORS
    bits |= CYCLIC if _taken(fields, "cyclic", False) else 0
    bits |= LOCAL if _taken(fields, "local", False) else 0
    return FIRST_MARKER + call.sim.addDrawingObject(bits, sizes[0], tolerance, parent, most, color)


def _collection(call: Call, fields: _Fields) -> int:
    return FIRST_COLLECTION + call.sim.createCollection(0, int(bool(_taken(fields, "override", False))))


def _path(call: Call, fields: _Fields) -> int:
    points = fields.pop("ctrlPts", None)
    if points is None:
        raise CommandError("a path has the field ctrlPts, poses as columns of a matrix of 7 rows")
    poses = points_of(points, 7) if isinstance(points, Matrix) else points_of(to_matrix(points), 7)
    bits = (2 if _taken(fields, "closed", False) else 0) | bool(_taken(fields, "hiddenDuringSim", False))
    smooth = _number(fields, "bezierSmoothing", 1.0)
    if _word(fields, "path.type", "quadraticBezier") == "linear":
        smooth = 0.0
    _number(fields, "samplingDistance", 0.05)
    return call.sim.createPath(poses, bits, 100, smooth)


def _graph(call: Call, _fields: _Fields) -> int:
    def build(spec: mujoco.MjSpec, name: str) -> None:
        spec.worldbody.add_site(name=name, group=4)

    return add_object(call.world, "Graph", "site", build, {"object": {"type": "graph"}})


def _absent(what: str) -> Callable[[Call, _Fields], int]:
    def make(_call: Call, _fields: _Fields) -> int:
        raise CommandError(f"{what} cannot be made here: {_ABSENT[what]}")

    return make


_ABSENT = {
    "camera": "cameras show views of a window; make a visionSensor",
    "light": "lights are written in the scene's MJCF",
    "detachedScript": "add-ons are programs that the server's flag --add-on starts",
    "customSceneObject": "make a class of an object with makeClass, and objects with its makeObject",
}

_MAKERS: Mapping[str, Callable[[Call, _Fields], int]] = {
    "shape": _shape,
    "joint": _joint,
    "dummy": _dummy,
    "forceSensor": _force_sensor,
    "visionSensor": _vision_sensor,
    "proximitySensor": _proximity_sensor,
    "script": _script,
    "pointCloud": _point_cloud,
    "ocTree": _octree,
    "marker": _marker,
    "collection": _collection,
    "path": _path,
    "graph": _graph,
    "console": new_console,
    "textEditor": new_editor,
    **{what: _absent(what) for what in _ABSENT},
}
