"""Graphs: streams of numbers that scripts record over simulated time, and curves that plot streams against each other.

V-REP's graphs are separate objects; here any object, such as a dummy of that name, can represent one. A value that is
set is recorded when the graph is handled: at the end of each simulation step, or earlier by a script. The data of a run
stay until the next run starts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.world.part import Part

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

RAW, DERIVATIVE, INTEGRAL, CUMULATIVE = range(4)
"""`sim_stream_transf_*`."""

MOST_SAMPLES = 10_000
"""Most samples of a stream; the oldest are dropped first."""
_MOST_STREAMS = 100

Color = tuple[float, float, float]
Sample = tuple[float, float]
"""Time (s) and value."""


@dataclass(eq=False)
class Stream:
    """The samples recorded under one name."""

    name: str
    unit: str = ""
    color: Color = (1.0, 0.0, 0.0)
    transformation: int = RAW
    factor: float = 1.0
    offset: float = 0.0
    window: int = 1
    """Number of samples that are averaged."""
    pending: float | None = None
    """Value that was set but not recorded yet."""
    samples: deque[Sample] = field(default_factory=lambda: deque(maxlen=MOST_SAMPLES))

    def record(self, time: float) -> None:
        """Record the pending value at this time (s)."""
        if self.pending is not None:
            self.samples.append((time, self.pending))
            self.pending = None

    def data(self) -> list[Sample]:
        """Return the samples, transformed."""
        values = list(self.samples)
        steps = list(pairwise(values))
        match self.transformation:
            case _ if self.transformation == DERIVATIVE:
                values = [(t1, (v1 - v0) / (t1 - t0)) for (t0, v0), (t1, v1) in steps if t1 > t0]
            case _ if self.transformation == INTEGRAL:
                areas = [(t1 - t0) * (v0 + v1) / 2 for (t0, v0), (t1, v1) in steps]
                values = list(zip([t for t, _ in values], accumulate(areas, initial=0.0), strict=False))
            case _ if self.transformation == CUMULATIVE:
                values = list(zip([t for t, _ in values], accumulate(v for _, v in values), strict=True))
            case _:  # raw
                pass
        values = [(t, v * self.factor + self.offset) for t, v in values]
        if self.window > 1:
            recent = [[v for _, v in values[max(0, i + 1 - self.window) : i + 1]] for i in range(len(values))]
            values = [(t, sum(some) / len(some)) for (t, _), some in zip(values, recent, strict=True)]
        return values


@dataclass(eq=False)
class Curve:
    """Two or three streams plotted against each other, or constant numbers."""

    name: str
    streams: tuple[int, ...]
    """Ids of the streams; -1 for a constant."""
    defaults: tuple[float, ...]
    unit: str
    color: Color
    width: int
    fixed: tuple[tuple[float, ...], ...] | None = None
    """Coordinates of a static copy."""


@dataclass(eq=False)
class Graph:
    """Streams and curves by id; ids are unique over both."""

    streams: dict[int, Stream] = field(default_factory=dict[int, Stream])
    curves: dict[int, Curve] = field(default_factory=dict[int, Curve])
    next_id: int = 0

    def add(self, item: Stream | Curve) -> int:
        """Add a stream or curve and return its id. Raises CommandError when there are too many."""
        if len(self.streams) + len(self.curves) >= _MOST_STREAMS:
            raise CommandError(f"a graph has at most {_MOST_STREAMS} streams and curves")
        number, self.next_id = self.next_id, self.next_id + 1
        if isinstance(item, Stream):
            self.streams[number] = item
        else:
            self.curves[number] = item
        return number

    def stream(self, number: int) -> Stream:
        """Return the stream with this id. Raises CommandError."""
        if number not in self.streams:
            known = ", ".join(f"{n} '{s.name}'" for n, s in self.streams.items()) or "none"
            raise CommandError(f"the graph has no stream {number}; its streams are {known}")
        return self.streams[number]

    def named(self, name: str) -> Stream:
        """Return the stream with this name; create it if it does not exist."""
        for stream in self.streams.values():
            if stream.name == name:
                return stream
        return self.stream(self.add(Stream(name)))

    def curve(self, number: int) -> Curve:
        """Return the curve with this id. Raises CommandError."""
        if number not in self.curves:
            known = ", ".join(f"{n} '{each.name}'" for n, each in self.curves.items()) or "none"
            raise CommandError(f"the graph has no curve {number}; its curves are {known}")
        return self.curves[number]

    def points(self, curve: Curve) -> tuple[tuple[float, ...], ...]:
        """Return the coordinates of a curve, one tuple per axis, at the times that all its streams have."""
        if curve.fixed is not None:
            return curve.fixed
        series = [dict(self.stream(n).data()) if n >= 0 else None for n in curve.streams]
        known = [each for each in series if each is not None]
        times: list[float] = sorted(set[float].intersection(*(set(each) for each in known))) if known else []
        return tuple(
            tuple(constant if each is None else each[t] for t in times)
            for each, constant in zip(series, curve.defaults, strict=True)
        )


class Graphs(Part):
    """The graphs of the scene, by the handle of the object that represents each."""

    def __init__(self, sim: Simulation) -> None:
        """Attach the part after the scripts: a simulation step records the values that they set in it."""
        self._sim = sim
        self._graphs: dict[int, Graph] = {}

    def run_started(self) -> None:
        self._graphs.clear()

    def scene_changed(self) -> None:
        self._graphs.clear()

    def get(self, handle: int) -> Graph:
        """Return the graph of an object; empty at first. Raises UnknownHandle."""
        self._sim.scene.get(handle)
        return self._graphs.setdefault(handle, Graph())

    def handles(self) -> list[int]:
        """Return the handles of the objects with graphs."""
        return [handle for handle in self._graphs if handle in self._sim.scene.objects]

    def record(self, handle: int, time: float) -> None:
        """Handle a graph: record the values that were set. Raises UnknownHandle."""
        for stream in self.get(handle).streams.values():
            stream.record(time)

    def reset(self, handle: int) -> None:
        """Forget all samples. Raises UnknownHandle."""
        for stream in self.get(handle).streams.values():
            stream.samples.clear()
            stream.pending = None

    def record_all(self) -> None:
        time = self._sim.time + self._sim.time_step
        for handle in self.handles():
            self.record(handle, time)


def span(values: Sequence[float]) -> tuple[float, float]:
    """Return the least and greatest value; zeros for an empty sequence."""
    finite = [value for value in values if math.isfinite(value)]
    return (min(finite), max(finite)) if finite else (0.0, 0.0)
