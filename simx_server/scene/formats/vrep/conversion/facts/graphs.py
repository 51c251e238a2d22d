"""Graphs: a frame each, and the streams that record the same as in V-REP."""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.texts.graph_streams import (
    DETECTED,
    DISTANCE,
    MOST_STREAMS,
    POSITION,
    USER,
    CurveNote,
    StreamNote,
    plain_name,
    write_curves,
    write_streams,
)
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.structure import add_site
from simx_server.scene.formats.vrep.conversion.unique_names import UniqueNames
from simx_server.scene.formats.vrep.objects import Graph, GraphStream
from simx_server.scene.poses.poses import Pose

from .registered import is_usable, name_of

_DISTANCE = 2102
_MEASURES = {
    **dict(zip((1, 2, 3), POSITION, strict=True)),
    **dict(zip((501, 502, 503), DETECTED, strict=True)),
    _DISTANCE: DISTANCE,
}
"""Kinds of streams, with the file's numbers; scripts set the values of all others."""

_USER, _BY_SCRIPT = 0, -1
"""Values set by clients and scripts of V-REP 3; a stream that a script of CoppeliaSim 4 adds when it starts."""


def add_graph(conversion: Conversion, graph: Graph, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a graph.

    Args:
        conversion: the conversion.
        graph: the graph.
        body: the body on which it rides.
        at: its frame in that body.
    """
    add_site(conversion, graph, body, at)
    name = conversion.name(graph)
    conversion.annotate("object", name, type="graph")
    streams: dict[int, StreamNote] = {}
    unique = UniqueNames("{}_{}")
    if len(graph.streams) + len(graph.curves) > MOST_STREAMS:
        conversion.report.leave_out(f"streams and curves of graphs beyond the first {MOST_STREAMS}", name)
    for stream in graph.streams[:MOST_STREAMS]:
        if stream.kind != _BY_SCRIPT:
            streams[stream.id] = _stream(conversion, graph, stream, unique)
    curves = [
        CurveNote(plain_name(curve.name) or "curve", tuple(streams[number].name for number in curve.streams))
        for curve in graph.curves
        if all(number in streams for number in curve.streams)
    ][: MOST_STREAMS - len(streams)]
    conversion.annotate(
        "graph",
        name,
        explicit=True if graph.is_explicit else None,
        streams=write_streams(list(streams.values())) if streams else None,
        curves=write_curves(curves) if curves else None,
    )


def _stream(conversion: Conversion, graph: Graph, stream: GraphStream, unique: UniqueNames) -> StreamNote:
    name = unique.take(plain_name(stream.name) or "stream")
    measures = _MEASURES.get(stream.kind, USER)
    if measures == DISTANCE:
        pairs = [pair for pair in conversion.file.distances if pair.id == stream.object]
        concerned = next((name_of(pair) for pair in pairs if is_usable(conversion, pair)), "")
    else:
        concerned = conversion.names.get(stream.object, "")
    if measures == USER and stream.kind != _USER:
        conversion.report.leave_out(
            f"graphs record no streams of kind {stream.kind}; scripts can set their values",
            conversion.name(graph),
        )
    if measures == USER or not concerned:
        return StreamNote(name, color=stream.color)
    return StreamNote(name, measures, concerned, stream.color)
