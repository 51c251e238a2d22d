"""One graph: streams of numbers over simulated time, and curves that plot streams against each other."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import field
from itertools import accumulate, pairwise

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.formats.texts.graph_streams import MOST_STREAMS

RAW, DERIVATIVE, INTEGRAL, CUMULATIVE = range(4)
"""`sim_stream_transf_*`."""

MOST_SAMPLES = 10_000
"""Most samples of a stream; the oldest are dropped first."""

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
    options: int = 0
    """Bits for a window that draws it: 1 invisible, 2 without a label, 4 points that are not linked."""
    cyclic_range: float = 0.0
    """Values this far apart are the same, as angles are; 0: none are."""
    source: Callable[[], float | None] | None = None
    """Measures the value that is recorded unless another one was set; None measured: nothing is recorded."""
    lasts: bool = False
    """Whether the stream stays, without its samples, when the next run starts."""
    is_vacant: bool = False
    """The file has it, and nothing measures it: a script that adds a stream of this name takes it over."""
    pending: float | None = None
    """Value that was set but not recorded yet."""
    samples: deque[Sample] = field(default_factory=lambda: deque(maxlen=MOST_SAMPLES))

    def record(self, time: float) -> None:
        """Record the pending value, or the measured one, at this time (s)."""
        value = self.pending
        if value is None and self.source is not None:
            value = self.source()
        if value is not None:
            self.samples.append((time, value))
        self.pending = None

    def data(self) -> list[Sample]:
        """Return the samples, transformed."""
        values = list(self.samples)
        steps = list(pairwise(values))
        match self.transformation:
            case _ if self.transformation == DERIVATIVE:
                values = [(t1, self._change(v0, v1) / (t1 - t0)) for (t0, v0), (t1, v1) in steps if t1 > t0]
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
            values = [(t, self._mean(some)) for (t, _), some in zip(values, recent, strict=True)]
        return values

    def _change(self, before: float, after: float) -> float:
        """Return the change of a value, the short way round where values are cyclic."""
        return _short_way(after - before, self.cyclic_range)

    def _mean(self, values: Sequence[float]) -> float:
        """Return the mean; of cyclic raw values that of their changes from the newest one."""
        if self.transformation != RAW:
            return sum(values) / len(values)
        newest, around = values[-1], self.cyclic_range * abs(self.factor)
        if around <= 0:
            return sum(values) / len(values)
        return newest + sum(_short_way(each - newest, around) for each in values) / len(values)


def _short_way(change: float, around: float) -> float:
    """Return a change of values that are the same this far apart; 0: none are. A change without end stays."""
    return math.remainder(change, around) if around > 0 and math.isfinite(change) else change


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
    options: int = 0
    """Bits as those of a stream."""
    fixed: tuple[tuple[float, ...], ...] | None = None
    """Coordinates of a static copy."""
    lasts: bool = False
    """Whether the curve stays when the next run starts."""


@dataclass(eq=False)
class Graph:
    """Streams and curves by id; ids are unique over both."""

    streams: dict[int, Stream] = field(default_factory=dict[int, Stream])
    curves: dict[int, Curve] = field(default_factory=dict[int, Curve])
    next_id: int = 0
    is_explicit: bool = False
    """Values are recorded only when a script handles the graph."""

    def begin_run(self) -> None:
        """Forget all samples, and what belongs to the run before: streams and curves that its scripts added."""
        self.streams = {number: each for number, each in self.streams.items() if each.lasts}
        self.curves = {
            number: each
            for number, each in self.curves.items()
            if each.lasts and all(stream in self.streams or stream == -1 for stream in each.streams)
        }
        for stream in self.streams.values():
            stream.samples.clear()
            stream.pending = None

    def add(self, item: Stream | Curve) -> int:
        """Add a stream or curve and return its id. Raises CommandError when there are too many."""
        vacant = [
            number for number, each in self.streams.items() if each.is_vacant and each.name == item.name
        ]
        if vacant and isinstance(item, Stream):
            self.streams[vacant[0]] = item
            return vacant[0]
        if len(self.streams) + len(self.curves) >= MOST_STREAMS:
            raise CommandError(f"a graph has at most {MOST_STREAMS} streams and curves")
        number, self.next_id = self.next_id, self.next_id + 1
        if isinstance(item, Stream):
            self.streams[number] = item
        else:
            self.curves[number] = item
        return number

    def put(self, item: Stream | Curve) -> int:
        """Add a stream or curve, or give the one of its name these settings; return its id.

        Raises CommandError when there are too many.
        """
        if isinstance(item, Stream):
            for number, each in self.streams.items():
                if each.name == item.name and not each.is_vacant:
                    each.unit, each.color, each.options = item.unit, item.color, item.options
                    each.cyclic_range, each.lasts = item.cyclic_range, each.lasts or item.lasts
                    return number
        else:
            for number, each in self.curves.items():
                if each.name == item.name and each.fixed is None:
                    self.curves[number] = item
                    return number
        return self.add(item)

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


def span(values: Sequence[float]) -> tuple[float, float]:
    """Return the least and greatest value; zeros for an empty sequence."""
    finite = [value for value in values if math.isfinite(value)]
    return (min(finite), max(finite)) if finite else (0.0, 0.0)
