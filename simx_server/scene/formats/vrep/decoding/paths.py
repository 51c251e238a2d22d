"""Paths, graphs, mills, mirrors, markers."""

from __future__ import annotations

from simx_server.scene.formats.vrep.chunks import Chunks
from simx_server.scene.formats.vrep.objects import (
    Graph,
    GraphCurve,
    GraphStream,
    OtherObject,
    Path,
    PathPoint,
)

from .colors import material_of
from .context import Reading
from .numbers import color, turn, vector
from .sensors import volume_of

EXPLICIT = 0x10
"""Bit of a graph that only scripts handle."""

CLOSED = 4
"""Bit of the attributes, which are V-REP's `sim_pathproperty_*`."""
SHAPED = 1


def fill_path(path: Path, own: Chunks, reading: Reading) -> None:
    """Fill a path. Raises SceneError."""
    _fill_section(path, own)
    points = own.child("Ntp")
    if points is None:
        return
    (path.attributes,) = points.ints("At2", 0)
    (path.size,) = points.reals("Si2", path.size)
    path.is_closed = bool(path.attributes & CLOSED)
    path.color = material_of(points.child("Cl0"))
    path.position, path.target_velocity = points.reals("Jm2", 0.0, 0.0)
    (path.angle_to_length,) = points.reals("Av3", path.angle_to_length)
    (path.virtual_to_length,) = points.reals("Av9", path.virtual_to_length)
    (path.length_method,) = points.ints("Av3", path.length_method)
    for each in points.each("Pat"):
        values = each.reals("At2")
        (count,) = each.ints("At2")
        (virtual_distance,) = each.reals("At3", 0.0)
        (flags,) = each.ints("At4", 0)
        path.points.append(
            PathPoint(
                pose=(vector(values), turn(each, "At2", values[3:7])),
                bezier=(values[7], values[8]),
                bezier_points=count,
                virtual_distance=virtual_distance,
                velocity=values[9],
                flags=flags,
                channels=each.reals("At4", *(0.0,) * 4),
            )
        )


def _fill_section(path: Path, own: Chunks) -> None:
    """Read the cross-section with which the path is drawn as a body."""
    (flags,) = own.ints("Var", 0)
    path.is_shaped = bool(flags & SHAPED)
    (scale,) = own.reals("Pss", 1.0)
    corners = own.reals("Sec")[: own.ints("Sec")[0] // 2 * 2] if own.has("Sec") else ()
    path.section = [(x * scale, y * scale) for x, y in zip(corners[::2], corners[1::2], strict=False)]
    (path.section_spacing,) = own.reals("Sha", 0.0)
    path.section_color = material_of(own.child("Scl"))


def fill_graph(graph: Graph, own: Chunks, reading: Reading) -> None:
    """Fill a graph."""
    (graph.size,) = own.reals("Ghg", graph.size)
    graph.capacity, _ = own.ints("Gbv", graph.capacity, 0)
    for tag in ("Ghd", "Dst"):
        for each in own.each(tag):
            kind, item, _ = each.ints("Dt2", -1, -1, -1)
            (number,) = each.ints("Oid", 0)
            graph.streams.append(
                GraphStream(
                    name=each.text("Nme"),
                    id=number,
                    kind=kind,
                    object=item,
                    color=color(each.reals("Col", 1.0, 0.0, 0.0)),
                )
            )
    # Since CoppeliaSim 4 a customization script handles each graph, which the flag says too.
    (flags,) = own.ints("Gps", 0)
    graph.is_explicit = bool(flags & EXPLICIT) and own.has("Ghd")
    for tag, dimensions in (("Gh2", 2), ("Gh3", 3)):
        for each in own.each(tag):
            streams = tuple(each.ints("Did", -1, -1, -1)[:dimensions])
            graph.curves.append(GraphCurve(name=each.text("Nme"), streams=streams))


def fill_other(item: OtherObject, own: Chunks, reading: Reading) -> None:
    """Fill an object of which little is known."""
    if own.name == "MIL" and (volume := own.child("Vod")) is not None:
        item.volume = volume_of(volume)
    if own.name == "MIR":
        width, height = own.reals("Msz", 0.0, 0.0)
        item.size = width, height
