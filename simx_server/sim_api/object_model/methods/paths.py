"""The class `Path`: its constructors, which are methods of the server here, and its methods."""

from __future__ import annotations

import itertools
from typing import Any, cast

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics.environment import Environment
from simx_server.kinematics.whole_turns import alternatives
from simx_server.parts.drawing import ITEM_COLORS
from simx_server.parts.paths.along import oriented
from simx_server.parts.paths.configurations import POSE, Array, Coordinate, limits_that_turn
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import wxyz_from_xyzw, xyzw_from_wxyz
from simx_server.scene.poses.poses import Pose, rotate
from simx_server.scripting.conversion.strings import with_texts
from simx_server.sim_api.object_model import targets
from simx_server.sim_api.object_model.classes import FIRST_MARKER
from simx_server.sim_api.object_model.instances.path import (
    Carrier,
    Look,
    PathInstance,
    columns,
    made,
    rows,
    vector,
)
from simx_server.sim_api.object_model.targets import ModelTarget
from simx_server.sim_api.object_model.values import Matrix, Ref, from_script, plain, to_script

from .method import Call, Options, method, numbers, option, whole

_AXIS = 0.03
"""Length of the axes that markers show, m."""


def _path(call: Call) -> PathInstance:
    return call.world.instances.get(call.handle, PathInstance)


def _kept(call: Call, path: PathInstance) -> Ref:
    path.owner = call.script.signal_owner
    return Ref(call.world.instances.add(path).handle)


@method("app", "Path", "changes", takes_values=True)
def new_path(call: Call, points: Any = None, options: Options = None) -> Ref:
    """Make a path of control points, the columns of a matrix; options as of CoppeliaSim's constructor."""
    return _kept(call, made(points, options or {}))


@method("app", "Path.fromObject", "changes", takes_values=True)
def path_of_object(call: Call, target: Any, options: Options = None) -> Ref:
    """Make an empty path of poses; appendFromObject adds those of an object."""
    handle = _object(call, target)
    return _kept(
        call, made(None, {**(options or {}), "types": ["lin"] * 3 + ["quat"] * 4}, Carrier(object=handle))
    )


@method("app", "Path.fromJoints", "changes", takes_values=True)
def path_of_joints(call: Call, tip: Any, base: Any = None, options: Options = None) -> Ref:
    """Make an empty path of the joints between an object and its base; appendFromJoints adds their positions."""
    scene = call.world.simulation.scene
    end, start = _object(call, tip), -1 if base is None else _object(call, base)
    joints: list[int] = []
    handle = scene.get(end).parent
    while handle != start:
        if handle == -1:
            raise CommandError(f"'{scene.get(start).name}' is not above '{scene.get(end).name}'")
        if scene.get(handle).kind == ObjectKind.JOINT:
            joints.insert(0, handle)
        handle = scene.get(handle).parent
    if not joints:
        raise CommandError(f"no joint lies between '{scene.get(end).name}' and the base")
    types: list[str] = []
    bounds: list[list[float]] = []
    for joint in joints:
        kind = call.world.simulation.joints.joint_type(joint)
        is_single = kind != _SPHERICAL
        types += [_TYPES[kind]] if is_single else ["quat"] * 4
        cyclic, least, extent = (
            call.world.simulation.joints.interval(joint) if is_single else (True, 0.0, 0.0)
        )
        bounds += [[] if cyclic or extent >= _ENDLESS else [least, least + extent]] * (1 if is_single else 4)
    carrier = Carrier(tuple(joints), end, start)
    return _kept(call, made(None, {**(options or {}), "types": types, "bounds": bounds}, carrier))


_SPHERICAL, _ENDLESS = 12, 1e9
_TYPES = {10: "ang", 11: "lin"}


def _object(call: Call, value: Any) -> int:
    handle = plain(value)
    if type(handle) is not int:
        raise CommandError("a path is made from an object of the scene")
    call.world.simulation.scene.get(handle)
    return handle


@method("app", "Path.fromBuffer", "changes", takes_values=True)
def path_from_buffer(call: Call, content: bytes, objects: Options = None) -> Ref:
    """Make a path of what toBuffer has returned: bytes, and objects."""
    found = call.sim.unpackTable(content)
    values = cast(list[Any], found) if isinstance(found, list) else []
    data = from_script(with_texts(values[0])) if values else None
    if not isinstance(data, dict) or "opt" not in data:
        raise CommandError("the bytes are not those of Path:toBuffer")
    parts = cast(dict[str, dict[str, Any]], data)
    carried = {name: plain(value) for name, value in (objects or {}).items()}
    carrier = Carrier(
        tuple(carried.get("joints", ())), *(carried.get(name, -1) for name in ("tip", "base", "object"))
    )
    options = {**parts["opt"], **{name: parts[name].get("opt") for name in ("ctrlPoints", "pathPoints")}}
    path = made(None, options, carrier)
    path.path.keep(path.space.checked(rows(parts["ctrlPoints"]["points"], len(path.space))))
    return _kept(call, path)


@method("Path", "toBuffer", "reads")
def to_buffer(call: Call) -> Any:
    """Return the path as bytes, and the objects that it belongs to, for fromBuffer."""
    path = _path(call)
    data = path.data()
    data["ctrlPoints"] = {
        "opt": data["ctrlPoints"]["opt"],
        "points": columns(path.path.control.points, len(path.space)),
    }
    data["pathPoints"] = {"opt": data["pathPoints"]["opt"]}
    carrier = path.carrier
    objects: dict[str, Any] = {
        name: Ref(handle)
        for name, handle in (("tip", carrier.tip), ("base", carrier.base), ("object", carrier.object))
        if handle != -1
    }
    if carrier.joints:
        objects["joints"] = [Ref(joint) for joint in carrier.joints]
    return call.sim.packTable([to_script(data)], 1), objects


@method("Path", "data", "reads")
def data_of_path(call: Call) -> dict[str, Any]:
    """Return the control points, the points of the way with their distances, and the options."""
    return _path(call).data()


@method("Path", "setPoints", "changes", takes_values=True)
def set_points(call: Call, points: Any = None) -> None:
    """Replace the control points."""
    path = _path(call)
    length = len(path.space)
    path.path.set_points(np.zeros((0, length)) if points is None else rows(points, length))
    _fill(call, path)


@method("Path", "clearPoints", "changes")
def clear_points(call: Call) -> None:
    """Remove the control points."""
    set_points(call)


@method("Path", "appendPoints", "changes", takes_values=True)
def append_points(call: Call, points: Any, update: bool = True) -> None:
    """Add control points; without `update` the path follows when it is used next."""
    path = _path(call)
    given = rows(points, len(path.space))
    if not len(given):
        raise CommandError("there is no point to append")
    path.path.append(given, update=update)
    _fill(call, path)


@method("Path", "appendFromJoints", "changes")
def append_from_joints(call: Call, update: bool = True) -> None:
    """Add the present positions of the path's joints."""
    path = _path(call)
    if not path.carrier.joints:
        raise CommandError("the path belongs to no joints: make it with Path.fromJoints")
    values: list[float] = []
    for joint in path.carrier.joints:
        values += targets.read(ModelTarget.of(call.world, joint, call.script), "configuration", None)
    path.path.append_moved(np.array(values), update=update)
    _fill(call, path)


@method("Path", "appendFromObject", "changes")
def append_from_object(call: Call, update: bool = True) -> None:
    """Add the present pose of the path's object."""
    path = _path(call)
    if path.carrier.object == -1:
        raise CommandError("the path belongs to no object: make it with Path.fromObject")
    path.path.append_moved(np.array(call.sim.getObjectPose(path.carrier.object)), update=update)
    _fill(call, path)


@method("Path", "distance", "reads", takes_values=True)
def distance(call: Call, first: Any, second: Any) -> float:
    """Return the distance between two points."""
    space = _path(call).space
    a, b = space.checked(np.array([vector(each, len(space)) for each in (first, second)]))
    return space.distance(a, b)


@method("Path", "interpolate", "reads", takes_values=True)
def interpolate(call: Call, first: Any, second: Any, share: float) -> Matrix:
    """Return the point at a share of the way from a point to another one."""
    space = _path(call).space
    a, b = space.checked(np.array([vector(each, len(space)) for each in (first, second)]))
    return Matrix.vector(space.between(a, b, share).tolist())


@method("Path", "configs", "reads", takes_values=True)
def configs(call: Call, point: Any) -> Matrix:
    """Return the points that mean the same, since bounded angles may turn further, as columns of a matrix."""
    space = _path(call).space
    found = alternatives(vector(point, len(space)).tolist(), limits_that_turn(space))
    return columns(np.array(found, dtype=float).reshape(len(found), len(space)), len(space))


@method("Path", "closest", "reads", takes_values=True)
def closest(call: Call, point: Any) -> Any:
    """Return the nearest point of the path, and its share of the length."""
    path = _path(call)
    found, share = path.path.nearest(vector(point, len(path.space)))
    return Matrix.vector(found.tolist()), share


@method("Path", "getPoint", "reads")
def get_point(call: Call, share: float) -> Matrix:
    """Return the point at a share of the path's length, 0 to 1."""
    return Matrix.vector(_path(call).path.at(share).tolist())


@method("Path", "remove", "changes")
def remove(call: Call, _options: Options = None) -> None:
    """Remove the path with its markers: it would go with the script or the client that made it."""
    remove_markers(call)
    call.world.instances.remove(call.handle)


# --- shapes and markers ------------------------------------------------------------------------------


_SECTION = [-0.01, -0.01, 0.01, -0.01, 0.01, 0.01, -0.01, 0.01, -0.01, -0.01]
_CLOSED, _SECTION_IN_XY = 4, 5
"""Bit of the options of sim.generateShapeFromPath, and the mode of orientation that its sections need."""


@method("Path", "createShape", "changes", takes_values=True)
def create_shape(call: Call, options: Options = None) -> Ref:
    """Create a shape along the path; options `section` (2 x n), `upVector`, and `axis`: 1 to 3 take the x, y or z axis
    of each point in its place.
    """
    path = _path(call)
    path.path.update()
    count = path.shown_coordinates
    if not count or len(path.path.way.points) < 2:
        raise CommandError("a shape needs a path with two points whose first coordinates are places")
    axis = whole(options, "axis", 0)
    if axis not in (0, 1, 2, 3):
        raise CommandError("'axis' is 0 for the upVector, or 1, 2, 3 for x, y, z of the points")
    poses = _poses(path, path.path.way.points)
    given = (options or {}).get("section")
    section = _SECTION if given is None else rows(given, 2).ravel().tolist()
    up = numbers(option(options, "upVector", [0.0, 0.0, 1.0]), "upVector")
    if axis:
        poses, up = _turned(poses, axis - 1, is_closed=path.path.rules.is_closed), [0.0, 0.0, 0.0]
    flat = [number for place, turn in poses for number in (*place, *xyzw_from_wxyz(turn))]
    bits = _CLOSED if path.path.rules.is_closed else 0
    return Ref(call.sim.generateShapeFromPath(flat, section, bits, up))


def _turned(poses: list[Pose], axis: int, *, is_closed: bool) -> list[Pose]:
    """Return poses along the way, each with one of its axes upwards."""
    count = len(poses)
    found: list[Pose] = []
    for place, (_, turn) in enumerate(poses):
        first, last = (
            (place - 1, (place + 1) % count) if is_closed else (max(0, place - 1), min(place + 1, count - 1))
        )
        unit = tuple(float(number == axis) for number in range(3))
        up = rotate(turn, unit)
        near = [poses[first], poses[place], poses[last]]
        found.append(oriented(near, _SECTION_IN_XY, up, is_closed=False)[1])
    return found


def _poses(path: PathInstance, points: Array) -> list[Pose]:
    """Return points as poses, as far as they have the coordinates."""
    count = path.shown_coordinates
    places = np.zeros((len(points), 3))
    places[:, : min(count, 3)] = points[:, : min(count, 3)]
    turns = points[:, 3:7] if count == len(POSE) else np.tile([0.0, 0.0, 0.0, 1.0], (len(points), 1))
    return [
        ((x, y, z), wxyz_from_xyzw(turn))
        for (x, y, z), turn in zip(places.tolist(), turns.tolist(), strict=True)
    ]


def _poses_of_joints(call: Call, path: PathInstance, points: Array) -> list[Pose]:
    """Return where the end of the path's joints is at each point."""
    if any(kind == Coordinate.QUATERNION for kind in path.space.kinds):
        raise CommandError("markers of a path of spherical joints are not available")
    environment = Environment(call.world.simulation)
    found: list[Pose] = []
    for point in points.tolist():
        for joint, value in zip(path.carrier.joints, point, strict=True):
            environment.set_joint_position(joint, value)
        found.append(environment.pose(path.carrier.tip))
    return found


@method("Path", "createMarkers", "changes")
def create_markers(call: Call) -> dict[str, Any]:
    """Create markers for the points and lines of the path; return them by group."""
    path = _path(call)
    path.path.update()
    remove_markers(call)
    looks = {"ctrlPointMarkers": path.control_look}
    if not path.path.rules.only_control_points:
        looks["pathPointMarkers"] = path.way_look
    if path.shown_coordinates or path.carrier.joints:
        path.markers = {group: _markers(call, look) for group, look in looks.items()}
        _fill(call, path)
    return {
        group: {name: Ref(FIRST_MARKER + marker) for name, marker in markers.items()}
        for group, markers in path.markers.items()
    }


_LINES, _SPHERES, _CUBES = 1, 7, 12
"""Kinds of drawing objects."""


def _markers(call: Call, look: Look) -> dict[str, int]:
    found: dict[str, int] = {}
    if look.point_type != "none":
        kind, size = (_SPHERES, 2.0) if look.point_type == "sphere" else (_CUBES, 2.0)
        found["pointMarker"] = _drawn(call, kind, size * look.point_radius, look.point_color.parts)
    if look.line_type != "none":
        width = 2.0 if look.line_type == "line" else 4.0
        found["lineMarker"] = _drawn(call, _LINES, width, look.line_color.parts)
    if look.shows_axes:
        found["axesMarker"] = _drawn(call, _LINES | ITEM_COLORS, 2.0, [1.0, 1.0, 1.0])
    return found


def _drawn(call: Call, bits: int, size: float, color: list[float]) -> int:
    return call.sim.addDrawingObject(bits, size, 0.0, -1, 0, color)


def _fill(call: Call, path: PathInstance) -> None:
    """Draw the present points again, where the path has markers."""
    if not path.markers:
        return
    path.path.update()
    for group, way in (("ctrlPointMarkers", path.path.control), ("pathPointMarkers", path.path.way)):
        markers = {
            name: each for name, each in path.markers.get(group, {}).items() if each in call.world.drawings
        }
        for marker in markers.values():
            call.world.drawings.clear(marker)
        if not markers or not len(way.points):
            continue
        poses = _poses_of_joints(call, path, way.points) if path.carrier.joints else _poses(path, way.points)
        if "pointMarker" in markers:
            _draw(call, markers["pointMarker"], poses)
        if "lineMarker" in markers and len(poses) > 1:
            ring = [*poses, poses[0]] if way.is_closed else poses
            ends = [number for a, b in itertools.pairwise(ring) for number in (*a[0], *b[0])]
            call.world.drawings.draw(markers["lineMarker"], ends)
        if "axesMarker" in markers:
            call.world.drawings.draw(markers["axesMarker"], _axes(poses))


def _draw(call: Call, marker: int, poses: list[Pose]) -> None:
    layout = call.world.drawings.get(marker).layout
    flat: list[float] = []
    for place, turn in poses:
        flat += [*place, *(xyzw_from_wxyz(turn) if layout.has_quaternion else ())]
    call.world.drawings.draw(marker, flat)


def _axes(poses: list[Pose]) -> list[float]:
    """Return a red, a green and a blue line for each pose, as items of a drawing object."""
    found: list[float] = []
    for place, turn in poses:
        for axis in range(3):
            unit = [float(number == axis) for number in range(3)]
            end = rotate(turn, [_AXIS * each for each in unit])
            found += [*place, *(a + b for a, b in zip(place, end, strict=True)), *unit]
    return found


@method("Path", "removeMarkers", "changes")
def remove_markers(call: Call) -> None:
    """Remove the markers of createMarkers."""
    path = _path(call)
    for markers in path.markers.values():
        for marker in markers.values():
            if marker in call.world.drawings:
                call.world.drawings.remove(marker)
    path.markers = {}
