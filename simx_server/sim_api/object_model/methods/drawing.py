"""Methods of point clouds, octrees, graphs and markers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import to_bytes
from simx_server.sim_api.object_model.values import to_color

from .method import (
    Call,
    Options,
    handles,
    method,
    number,
    numbers,
    option,
    points_of,
    text_option,
    unpacked,
    whole,
)

_OWN_FRAME, _EACH_COLOR = 1, 2
"""Bits of API 1's options: points are in the object's frame; each has a colour."""


def _packed(data: bytes) -> list[float]:
    """Return the numbers of packed points, doubles. Raises CommandError."""
    if len(data) % 24:
        raise CommandError(f"packed points are 3 doubles each, which {len(data)} bytes are not")
    return unpacked(data)


def _given(points: Any, packed: bool) -> list[float]:
    if not packed:
        return points_of(points)
    try:
        return _packed(to_bytes(points))
    except TypeError as problem:
        raise CommandError(f"packed points must be {problem} of bytes") from None


def _frame(options: Options) -> int:
    return _OWN_FRAME if option(options, "relative", False) else 0


def _bytes_of(color: Any) -> list[float]:
    """Return a colour as three parts from 0 to 255."""
    try:
        return [float(each) for each in to_color(color).rgba[:3]]
    except TypeError as problem:
        raise CommandError(f"the option color must be {problem}") from None


def _colors(options: Options, count: int) -> tuple[int, list[float] | None]:
    """Return bits of API 1's options, and the colour of all points or of each."""
    each = option(options, "colors")
    if each is not None:
        parts = points_of(each, 4)
        if len(parts) != 4 * count:
            raise CommandError(f"{count} points have as many colours, not {len(parts) // 4}")
        scale = 255.0 if max(parts, default=0.0) <= 1 else 1.0
        return _EACH_COLOR, [parts[4 * i + j] * scale for i in range(count) for j in range(3)]
    color = (options or {}).get("color")
    return 0, None if color is None else _bytes_of(color)


def _tolerance(options: Options, name: str) -> float | None:
    """Return a distance; None, which is API 1's own, without it. Raises CommandError."""
    return None if option(options, name) is None else number(options, name, 0.0)


def _add_points(call: Call, points: list[float], options: Options) -> None:
    bits, colors = _colors(options, len(points) // 3)
    tolerance = _tolerance(options, "tolerance")
    call.sim.insertPointsIntoPointCloud(call.handle, bits | _frame(options), points, colors, tolerance)


def _subtract_points(call: Call, points: list[float], options: Options) -> None:
    call.sim.removePointsFromPointCloud(
        call.handle, _frame(options), points, number(options, "tolerance", 0.0)
    )


def _intersect_points(call: Call, points: list[float], options: Options) -> None:
    tolerance = number(options, "tolerance", 0.0)
    call.sim.intersectPointsWithPointCloud(call.handle, _frame(options), points, tolerance)


def _add_voxels(call: Call, points: list[float], options: Options) -> None:
    bits, colors = _colors(options, len(points) // 3)
    tags = option(options, "tags")
    tag = [round(each) for each in numbers(tags, "tags")] if tags is not None else [whole(options, "tag", 0)]
    if bits and tags is None:
        tag *= len(points) // 3
    call.sim.insertVoxelsIntoOctree(call.handle, bits | _frame(options), points, colors, tag)


def _subtract_voxels(call: Call, points: list[float], options: Options) -> None:
    call.sim.removeVoxelsFromOctree(call.handle, _frame(options), points)


def _check_points(call: Call, points: list[float], options: Options) -> Any:
    found = call.sim.checkOctreePointOccupancy(call.handle, _frame(options), points)
    values = found if isinstance(found, tuple) else (found, 0, 0, 0)
    return bool(values[0]), *values[1:]


_Act = Callable[[Call, list[float], Options], Any]


def _points(act: _Act, *, packed: bool) -> Callable[..., Any]:
    def run(call: Call, points: Any, options: Options = None) -> Any:
        return act(call, _given(points, packed), options)

    return run


for _kind, _name, _act in (
    ("pointCloud", "add{}Points", _add_points),
    ("pointCloud", "subtract{}Points", _subtract_points),
    ("pointCloud", "intersect{}Points", _intersect_points),
    ("ocTree", "add{}Voxels", _add_voxels),
    ("ocTree", "subtract{}Voxels", _subtract_voxels),
):
    method(_kind, _name.format(""), "changes", takes_values=True)(_points(_act, packed=False))
    method(_kind, _name.format("Packed"), "changes", takes_values=True)(_points(_act, packed=True))
method("ocTree", "checkPoints", "reads", takes_values=True)(_points(_check_points, packed=False))
method("ocTree", "checkPackedPoints", "reads", takes_values=True)(_points(_check_points, packed=True))


@method("pointCloud", "addFromObjects", "changes", takes_values=True)
def add_objects_to_cloud(call: Call, objects: list[Any], options: Options = None) -> None:
    """Add the points of objects; options color, gridSize, duplicateTolerance."""
    _, color = _colors(options, 0)
    grid = number(options, "gridSize", 0.02)
    for handle in handles(objects):
        tolerance = _tolerance(options, "duplicateTolerance")
        call.sim.insertObjectIntoPointCloud(call.handle, handle, 0, grid, color, tolerance)


@method("pointCloud", "subtractFromObjects", "changes")
def subtract_objects_from_cloud(call: Call, objects: list[Any], options: Options = None) -> None:
    """Remove the points near objects; option tolerance."""
    for handle in handles(objects):
        call.sim.subtractObjectFromPointCloud(call.handle, handle, 0, number(options, "tolerance", 0.0))


@method("ocTree", "addFromObjects", "changes", takes_values=True)
def add_objects_to_octree(call: Call, objects: list[Any], options: Options = None) -> None:
    """Fill the voxels that objects meet; options color and tag."""
    _, color = _colors(options, 0)
    for handle in handles(objects):
        call.sim.insertObjectIntoOctree(call.handle, handle, 0, color, whole(options, "tag", 0))


@method("ocTree", "subtractFromObjects", "changes")
def subtract_objects_from_octree(call: Call, objects: list[Any]) -> None:
    """Empty the voxels that objects meet."""
    for handle in handles(objects):
        call.sim.subtractObjectFromOctree(call.handle, handle, 0)


@method("pointCloud", "clear", "changes")
def clear_cloud(call: Call) -> None:
    """Remove all points."""
    call.sim.removePointsFromPointCloud(call.handle, 0, None)


@method("ocTree", "clear", "changes")
def clear_octree(call: Call) -> None:
    """Empty all voxels."""
    call.sim.removeVoxelsFromOctree(call.handle, 0, None)


# --- graphs ------------------------------------------------------------------------------------------


def _shown_color(options: Options, default: tuple[float, float, float]) -> list[float]:
    color = (options or {}).get("color")
    return list(default) if color is None else to_color(color).parts


@method("graph", "addSignal", "changes", takes_values=True)
def add_signal(call: Call, options: Options = None) -> int:
    """Add a signal and return its number; options name, unit, color, transformation."""
    name, unit = text_option(options, "name", "signal"), text_option(options, "unit")
    signal = call.sim.addGraphStream(call.handle, name, unit, 0, _shown_color(options, (1.0, 0.0, 0.0)))
    if option(options, "transformation") is not None:
        change = cast(dict[str, Any], option(options, "transformation"))
        kinds = {"raw": 0, "derivative": 1, "integral": 2, "cumulative": 3}
        word = text_option(change, "type", "raw")
        if word not in kinds:
            raise CommandError(f"'{word[:40]}' is no transformation; those are {', '.join(kinds)}")
        scale, offset = number(change, "scale", 1.0), number(change, "offset", 0.0)
        smoothing = whole(change, "smoothing", 1)
        call.sim.setGraphStreamTransformation(call.handle, signal, kinds[word], scale, offset, smoothing)
    return signal


@method("graph", "addCurve", "changes", takes_values=True)
def add_curve(call: Call, signals: list[int], options: Options = None) -> int:
    """Add a curve of two or three signals and return its number; options name, unit, color, default, width."""
    defaults = numbers(option(options, "default", [0.0] * len(signals)), "default")
    name, unit = text_option(options, "name", "curve"), text_option(options, "unit")
    color, width = _shown_color(options, (0.0, 1.0, 0.0)), whole(options, "width", 2)
    return call.sim.addGraphCurve(call.handle, name, len(signals), signals, defaults, unit, 0, color, width)


@method("graph", "setSignalPoint", "changes")
def set_signal_point(call: Call, signal: int, value: float) -> None:
    """Set a signal's value, which the next step records."""
    call.sim.setGraphStreamValue(call.handle, signal, value)


@method("graph", "step", "changes")
def step_graph(call: Call, time: float) -> None:
    """Record the values at a time."""
    call.sim.handleGraph(call.handle, time)


@method("graph", "reset", "changes")
def reset_graph(call: Call) -> None:
    """Remove what was recorded."""
    call.sim.resetGraph(call.handle)


@method("graph", "removeTrace", "changes")
def remove_trace(call: Call, curve: int) -> None:
    """Remove a curve."""
    call.sim.destroyGraphCurve(call.handle, curve)


@method("graph", "snapshotTrace", "changes")
def snapshot_trace(call: Call, curve: int, options: Options = None) -> int:
    """Copy the present state of a curve and return the copy's number; option name."""
    return call.sim.duplicateGraphCurveToStatic(call.handle, curve, text_option(options, "name", "snapshot"))


# --- markers -----------------------------------------------------------------------------------------


@method("marker", "addItems", "changes", takes_values=True)
def add_items(call: Call, points: Any, options: Options = None) -> list[int]:
    """Add items at points, 3 rows in a matrix; options colors, quaternions and sizes, a column for each item.

    Returns the numbers of the items, from 0.
    """
    drawing = call.world.drawings.get(call.old)
    layout, places = drawing.layout, points_of(points)
    per = 3 * layout.points
    if not places or len(places) % per:
        raise CommandError(f"an item of this marker has {layout.points} points, each x, y, z")
    count = len(places) // per
    turns = option(options, "quaternions")
    turn_numbers = [0.0, 0.0, 0.0, 1.0] * count if turns is None else points_of(turns, 4)
    if len(turn_numbers) != 4 * count:
        raise CommandError(f"{count} items have as many quaternions, not {len(turn_numbers) // 4}")
    if option(options, "sizes") is not None:
        raise CommandError("all items of a marker have one size here: give itemSize to createObject")
    colors = _item_colors(options, count, drawing.color)
    before = len(drawing.items)
    for place in range(count):
        item = places[per * place : per * (place + 1)]
        if layout.has_normal:
            item += [0.0, 0.0, 1.0]
        if layout.has_quaternion:
            item += turn_numbers[4 * place : 4 * place + 4]
        call.world.drawings.draw(call.old, [*item, *colors[place][: layout.extras]])
    return list(range(before, len(drawing.items)))


def _item_colors(options: Options, count: int, first: tuple[float, float, float]) -> list[list[float]]:
    """Return red, green, blue of each item, 0 to 1."""
    given = option(options, "colors")
    if given is None:
        return [list(first)] * count
    if isinstance(given, (bytes, str)):
        data = given.encode("utf-8", "surrogateescape") if isinstance(given, str) else given
        parts = [each / 255 for each in data]
    else:
        parts = points_of(given, 4)
        parts = [each / 255 for each in parts] if max(parts, default=0.0) > 1 else parts
    if len(parts) != 4 * count:
        raise CommandError(f"{count} items have as many colours of 4 parts, not {len(parts) / 4:g}")
    return [parts[4 * place : 4 * place + 3] for place in range(count)]


@method("marker", "clearItems", "changes")
def clear_items(call: Call) -> None:
    """Remove all items."""
    call.world.drawings.clear(call.old)


@method("marker", "removeItems", "changes")
def remove_items(call: Call, numbers: list[int] | None = None) -> None:
    """Remove items by the numbers of addItems, or all of them; those behind them move up."""
    drawing = call.world.drawings.get(call.old)
    if numbers is None:
        call.world.drawings.clear(call.old)
        return
    gone = set(numbers)
    if unknown := [each for each in gone if not 0 <= each < len(drawing.items)]:
        raise CommandError(f"the marker has {len(drawing.items)} items, and none is {unknown[0]}")
    drawing.items[:] = [item for place, item in enumerate(drawing.items) if place not in gone]
    call.world.drawings.version += 1


@method("marker", "remove", "changes")
def remove_marker(call: Call, _options: Options = None) -> None:
    """Remove this marker."""
    call.world.drawings.remove(call.old)
