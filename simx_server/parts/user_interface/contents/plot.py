"""The plot of a window: curves of a program, their ranges and labels."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass

MAX_POINTS = 10_000
"""Most points of a curve that are kept; the oldest are dropped first."""

MAX_CURVES = 100

_MOST_SHOWN_CURVES, _MOST_SHOWN_POINTS = 20, 300

Range = tuple[float, float]


@dataclass(eq=False)
class Curve:
    """One curve. A curve over time has no `t`."""

    is_over_time: bool = True
    color: tuple[int, int, int] = (0, 0, 0)
    """Red, green, blue, 0 to 255."""
    style: str = "line"
    line_size: float = 1.0
    """Pixels."""
    scatter_size: float = 4.0
    is_dashed: bool = False
    is_in_legend: bool = True
    t: list[float] = field(default_factory=list[float])
    x: list[float] = field(default_factory=list[float])
    y: list[float] = field(default_factory=list[float])

    def add(self, t: list[float], x: list[float], y: list[float]) -> None:
        """Add points; only the newest are kept."""
        for kept, new in ((self.t, t), (self.x, x), (self.y, y)):
            kept.extend(new)
            del kept[:-MAX_POINTS]

    def clear(self) -> None:
        """Remove all points."""
        for values in (self.t, self.x, self.y):
            values.clear()

    def points(self) -> list[tuple[float, float]]:
        """Return the points in the order in which they are joined: by x, or by t."""
        pairs = list(zip(self.x, self.y, strict=True))
        if self.is_over_time:
            return sorted(pairs, key=lambda pair: pair[0])
        if len(self.t) != len(pairs):
            return pairs
        return [pair for _, pair in sorted(zip(self.t, pairs, strict=True), key=lambda each: each[0])]


@dataclass(eq=False)
class Plot:
    """The curves by name, and how they are shown."""

    curves: dict[str, Curve] = field(default_factory=dict[str, Curve])
    ranges: list[Range | None] = field(default_factory=lambda: [None, None])
    """Of x and y; None: those of all points."""
    labels: list[str] = field(default_factory=lambda: ["", ""])
    has_legend: bool = False

    def extent(self, names: list[str] | None = None) -> tuple[Range, Range]:
        """Return the ranges of x and y of some curves, or of all; 0 to 1 without points."""
        chosen = [curve for name, curve in self.curves.items() if names is None or name in names]
        return _span([curve.x for curve in chosen]), _span([curve.y for curve in chosen])

    def fit(self, names: list[str] | None, *, only_enlarge: tuple[bool, bool]) -> None:
        """Show some curves, or all, as a whole."""
        for axis, (wanted, enlarges) in enumerate(zip(self.extent(names), only_enlarge, strict=True)):
            present = self.ranges[axis]
            if enlarges and present is not None:
                wanted = min(present[0], wanted[0]), max(present[1], wanted[1])
            self.ranges[axis] = wanted

    def view(self) -> dict[str, Any]:
        """Return what a viewer shows, ready for JSON: the newest points of the first curves."""
        x_range, y_range = self.ranges
        if x_range is None or y_range is None:
            x_extent, y_extent = self.extent()
            x_range, y_range = x_range or x_extent, y_range or y_extent
        return {
            "x": x_range,
            "y": y_range,
            "labels": self.labels,
            "legend": self.has_legend,
            "curves": [
                {
                    "name": name,
                    "color": curve.color,
                    "style": curve.style,
                    "line": curve.line_size,
                    "scatter": curve.scatter_size,
                    "dashed": curve.is_dashed,
                    "listed": curve.is_in_legend,
                    "points": _thinned(curve.points()),
                }
                for name, curve in list(self.curves.items())[:_MOST_SHOWN_CURVES]
            ],
        }


def _span(columns: list[list[float]]) -> Range:
    finite = [value for values in columns for value in filter(math.isfinite, values)]
    if not finite:
        return 0.0, 1.0
    low, high = min(finite), max(finite)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _thinned(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return at most `_MOST_SHOWN_POINTS` points, evenly chosen, with the first and the last."""
    count = len(points)
    if count <= _MOST_SHOWN_POINTS:
        return points
    last = _MOST_SHOWN_POINTS - 1
    return [points[index * (count - 1) // last] for index in range(_MOST_SHOWN_POINTS)]
