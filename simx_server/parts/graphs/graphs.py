"""The graphs of the scene, by the handle of the object that represents each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.texts.graph_streams import (
    DISTANCE,
    USER,
    CurveNote,
    StreamNote,
    plain_name,
    read_curves,
    read_streams,
    write_curves,
    write_streams,
)
from simx_server.simulation.part import Part

from .sources import Sources
from .streams import Curve, Graph, Stream

if TYPE_CHECKING:
    from collections.abc import Mapping

    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.saved import Saved
    from simx_server.sensors.distance.meters import Meters
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.simulation.simulation import Simulation


class Graphs(Part):
    """All graphs of one simulation. Physics thread only."""

    def __init__(self, sim: Simulation, proximity: ProximitySensors, meters: Meters) -> None:
        """Attach the part before the scripts: a run's start forgets the streams that scripts added in the run before.

        A simulation step records the values after the scripts have set them (`World.step`).
        """
        self._sim = sim
        self._sources = Sources(sim, proximity, meters)
        self._graphs: dict[int, Graph] = {}

    def run_started(self) -> None:
        for graph in self._graphs.values():
            graph.begin_run()

    def scene_changed(self) -> None:
        self._graphs.clear()

    def model_changed(self, twins: Twins | None) -> None:
        self._find()

    def scene_edited(self) -> None:
        self._find()

    def saving(self, saved: Saved) -> None:
        for handle in self.handles():
            if handle in saved.names:
                note = saved.objects[handle].get("graph", {})
                graph = self._graphs[handle]
                measured = {each.name: each for each in read_streams(str(note.get("streams", "")))}
                streams = [self._note(each, measured, saved) for each in graph.streams.values() if each.lasts]
                names = {
                    number: plain_name(each.name) for number, each in graph.streams.items() if each.lasts
                }
                curves = [
                    CurveNote(plain_name(each.name), tuple(names[stream] for stream in each.streams))
                    for each in graph.curves.values()
                    if each.lasts and each.fixed is None and names.keys() >= set(each.streams)
                ]
                saved.put(
                    handle,
                    "graph",
                    explicit=graph.is_explicit,
                    streams=write_streams(streams) or None,
                    curves=write_curves(curves) or None,
                )

    def get(self, handle: int) -> Graph:
        """Return the graph of an object; empty at first. Raises UnknownHandle."""
        self._sim.scene.get(handle)
        graph = self._graphs.get(handle)
        if graph is None:
            graph = self._graphs[handle] = Graph()
            self._sim.parts.replan()
        return graph

    def handles(self) -> list[int]:
        """Return the handles of the objects with graphs."""
        return [handle for handle in self._graphs if handle in self._sim.scene.objects]

    def record(self, handle: int, time: float) -> None:
        """Handle a graph: record the values that were set or are measured. Raises UnknownHandle."""
        for stream in self.get(handle).streams.values():
            stream.record(time)

    def reset(self, handle: int) -> None:
        """Forget all samples. Raises UnknownHandle."""
        for stream in self.get(handle).streams.values():
            stream.samples.clear()
            stream.pending = None

    @property
    def has_work(self) -> bool:
        """Return whether there are graphs."""
        return bool(self._graphs)

    def record_all(self) -> None:
        """Handle all graphs that are not explicit, with the time at the end of the present simulation step."""
        time = self._sim.time + self._sim.time_step
        for handle in self.handles():
            if not self._graphs[handle].is_explicit:
                self.record(handle, time)

    def _find(self) -> None:
        """Add the graphs that the scene's file, or a model's, defines."""
        scene = self._sim.scene
        for name, notes in scene.annotations.objects.items():
            handle = scene.by_name(name) if "graph" in notes else None
            if handle is not None and handle not in self._graphs:
                self._graphs[handle] = self._read(notes["graph"])

    def _read(self, note: Annotation) -> Graph:
        graph = Graph(is_explicit=bool(note.get("explicit", False)))
        numbers: dict[str, int] = {}
        for stream in read_streams(str(note.get("streams", ""))):
            numbers[stream.name] = graph.add(self._stream(stream))
        for curve in read_curves(str(note.get("curves", ""))):
            streams = tuple(numbers[name] for name in curve.streams)
            graph.add(Curve(curve.name, streams, (0.0,) * len(streams), "", (1.0, 1.0, 0.0), 2, lasts=True))
        return graph

    @staticmethod
    def _note(stream: Stream, measured: Mapping[str, StreamNote], saved: Saved) -> StreamNote:
        """Return the annotation of a stream; one that measures what is not saved has no source then."""
        name = plain_name(stream.name)
        known = measured.get(stream.name, StreamNote(name))
        has_source = known.measures != USER and known.object in (
            saved.registered.get("distance", {}) if known.measures == DISTANCE else saved.names.values()
        )
        source = (known.measures, known.object) if has_source else (USER, "")
        return StreamNote(name, *source, stream.color)

    def _stream(self, note: StreamNote) -> Stream:
        source = self._sources.find(note.measures, note.object)
        is_vacant = note.measures == USER
        return Stream(note.name, color=note.color, source=source, lasts=True, is_vacant=is_vacant)
