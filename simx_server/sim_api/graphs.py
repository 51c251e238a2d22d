"""Graphs: record streams of numbers over simulated time, make curves of them, and read both back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.parts.graphs import CUMULATIVE, Color, Curve, Graph, Stream, span
from simx_server.scripting.interpreter import Constant
from simx_server.scripting.script import ScriptKind

from .base import ApiPart
from .effects import no_edit, reads

_TIME_CURVE, _XYZ_CURVE = 0, 2


class GraphFunctions(ApiPart, effect="changes"):
    """Functions for graphs. Any object can represent a graph: beside graph objects a dummy of its name is enough."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "stream_transf_raw": 0,
        "stream_transf_derivative": 1,
        "stream_transf_integral": 2,
        "stream_transf_cumulative": 3,
    }

    @no_edit
    def setGraphUserData(self, graph: int, name: str, value: float) -> int:
        """Set a stream's value, recorded at the end of the simulation step; V-REP 3's form. A missing stream is
        created.
        """
        self._graph(graph).named(name).pending = value
        return 1

    def addGraphStream(
        self,
        graph: int,
        name: str,
        unit: str = "",
        options: int = 0,
        color: list[float] | None = None,
        cyclic_range: float = 0.0,
    ) -> int:
        """Add a stream, or change the one of this name; return its id. Since CoppeliaSim 4.

        `options`: 1 invisible, 2 without a label, 4 points that are not linked; sim.getGraphCurve returns them.
        `cyclic_range`: values this far apart are the same for derivatives and means, such as 2 pi for angles.
        """
        if cyclic_range < 0:
            raise CommandError(f"the range of cyclic values is not below 0; it is {cyclic_range:g}")
        stream = Stream(
            name,
            unit,
            _color(color, (1.0, 0.0, 0.0)),
            lasts=self._stays,
            options=options,
            cyclic_range=cyclic_range,
        )
        return self._graph(graph).put(stream)

    @no_edit
    def setGraphStreamValue(self, graph: int, stream: int, value: float) -> None:
        """Set a stream's value, recorded at the end of the simulation step or by sim.handleGraph."""
        self._graph(graph).stream(stream).pending = value

    def setGraphStreamTransformation(
        self, graph: int, stream: int, kind: int, factor: float = 1.0, offset: float = 0.0, window: int = 1
    ) -> None:
        """Set the transformation of a stream's values: `kind` (a sim.stream_transf_*), then factor and offset, then
        the mean of the last `window` samples.
        """
        if not 0 <= kind <= CUMULATIVE:
            raise CommandError(
                f"{kind} is no transformation; those are 0 raw, 1 derivative, 2 integral, 3 cumulative"
            )
        found = self._graph(graph).stream(stream)
        found.transformation, found.factor, found.offset, found.window = kind, factor, offset, max(1, window)

    def addGraphCurve(
        self,
        graph: int,
        name: str,
        dimensions: int,
        streams: list[int],
        defaults: list[float] | None,
        unit: str = "",
        options: int = 0,
        color: list[float] | None = None,
        width: int = 2,
    ) -> int:
        """Add a curve of two or three streams against each other, or change the one of this name; return its id. Stream
        -1 stands for a default value. `options`: 2 without a label, 4 points that are not linked.
        """
        found = self._graph(graph)
        if dimensions not in (2, 3) or len(streams) < dimensions:
            raise CommandError("a curve has 2 or 3 dimensions and a stream, or -1, for each")
        for stream in streams[:dimensions]:
            if stream != -1:
                found.stream(stream)
        constants = [*(defaults or []), 0.0, 0.0, 0.0][:dimensions]
        curve = Curve(
            name,
            tuple(streams[:dimensions]),
            tuple(constants),
            unit,
            _color(color, (1.0, 1.0, 0.0)),
            width,
            options,
            lasts=self._stays,
        )
        return found.put(curve)

    def destroyGraphCurve(self, graph: int, curve: int) -> None:
        """Remove a curve, but not its streams."""
        found = self._graph(graph)
        found.curve(curve)
        del found.curves[curve]

    def duplicateGraphCurveToStatic(self, graph: int, curve: int, name: str = "") -> int:
        """Copy the present state of a curve as a static one and return the copy's id."""
        found = self._graph(graph)
        given = found.curve(curve)
        points = found.points(given)
        label = name or f"{given.name} [STATIC]"
        return found.add(
            Curve(
                label,
                given.streams,
                given.defaults,
                given.unit,
                given.color,
                given.width,
                given.options,
                points,
            )
        )

    @reads
    def getGraphCurve(self, graph: int, kind: int, index: int) -> tuple[Any, ...] | None:
        """Return the curve with an index from 0, nil after the last. `kind`: 0 streams over time, 1 curves of two
        streams, 2 of three.

        The results are label, options, colour, a table of numbers for each axis, {least, greatest, ...} of
        each axis (nil without numbers), id and width.
        """
        found = self._graph(graph)
        if not _TIME_CURVE <= kind <= _XYZ_CURVE:
            raise CommandError(f"{kind} is no kind of curve; those are 0 over time, 1 x and y, 2 x, y and z")
        if kind == _TIME_CURVE:
            streams = list(found.streams.items())
            if not 0 <= index < len(streams):
                return None
            number, stream = streams[index]
            data = stream.data()
            axes = [[t for t, _ in data], [v for _, v in data]]
            label, options, color, width = stream.name, stream.options, stream.color, 1
        else:
            curves = [(n, each) for n, each in found.curves.items() if len(each.streams) == kind + 1]
            if not 0 <= index < len(curves):
                return None
            number, curve = curves[index]
            axes = [list(axis) for axis in found.points(curve)]
            label, options, color, width = curve.name, curve.options, curve.color, curve.width
        limits = [end for axis in axes for end in span(axis)] if axes[0] else None
        return label, options, list(color), *axes, limits, number, width

    @no_edit
    def handleGraph(self, graph: int, time: float) -> int:
        """Record the values that were set, with this time; sim.handle_all and similar handles mean all graphs."""
        every = graph in (c.sim_handle_all, c.sim_handle_all_except_explicit)
        for handle in self._world.graphs.handles() if every else [self._self(graph)]:
            self._world.graphs.record(handle, time)
        return 1

    @no_edit
    def resetGraph(self, graph: int) -> int:
        """Delete the recorded values; sim.handle_all and similar handles mean all graphs."""
        every = graph in (c.sim_handle_all, c.sim_handle_all_except_explicit)
        for handle in self._world.graphs.handles() if every else [self._self(graph)]:
            self._world.graphs.reset(handle)
        return 1

    @property
    def _stays(self) -> bool:
        """Return whether the script outlives the run, and with it what it adds to a graph."""
        return self._script.kind == ScriptKind.CUSTOMIZATION

    def _graph(self, handle: int) -> Graph:
        return self._world.graphs.get(self._self(handle))


def _color(given: list[float] | None, default: Color) -> Color:
    if given is None or len(given) < 3:
        return default
    red, green, blue = given[:3]
    return red, green, blue
