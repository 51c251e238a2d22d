"""Plots of two runs as SVG, drawn here so that the page needs neither a library nor the network."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np

from .trajectories import Floats, Series

WIDTH, HEIGHT = 640, 220
LEFT, RIGHT, TOP, BOTTOM = 64, 28, 12, 28

COLOURS = ("#1f6fb4", "#d1495b", "#2e8b57", "#8a5fb0")
"""Of the components of a quantity; the second run is dashed."""

MOST_POINTS = 1500
"""Points of a line; more would not be seen."""


def plot(one: Series, other: Series, labels: Sequence[str], mark: float | None, title: str) -> str:
    """Return an SVG with the values of two runs over time.

    Args:
        labels: of the components.
        mark: a time in seconds to mark with a vertical line; None: none.
        title: for readers of screens.
    """
    times = np.concatenate((one.times, other.times))
    values = np.concatenate((one.values.ravel(), other.values.ravel()))
    values = values[np.isfinite(values)]
    if not len(times) or not len(values):
        return ""
    across = _Scale(float(times.min()), float(times.max()), LEFT, WIDTH - RIGHT)
    up = _Scale(float(values.min()), float(values.max()), HEIGHT - BOTTOM, TOP)
    parts = [*_grid(across, up)]
    if mark is not None:
        x = across.at(mark)
        parts.append(f'<line class="mark" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>')
    for series, kind in ((one, "one"), (other, "other")):
        for place in range(series.values.shape[1]):
            points = _points(series.times, series.values[:, place], across, up)
            colour = COLOURS[place % len(COLOURS)]
            parts.append(f'<polyline class="{kind}" stroke="{colour}" points="{points}"/>')
    legend = " ".join(
        f'<tspan fill="{COLOURS[place % len(COLOURS)]}">{escape(label)}</tspan>'
        for place, label in enumerate(labels)
    )
    parts.append(f'<text x="{WIDTH - RIGHT}" y="{TOP + 12}" text-anchor="end">{legend}</text>')
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title, quote=True)}">'
        + "".join(parts)
        + "</svg>"
    )


class _Scale:
    """Maps an interval of values to one of pixels."""

    def __init__(self, low: float, high: float, start: float, end: float) -> None:
        if high - low < 1e-12:
            low, high = low - 0.5, high + 0.5
        self.low, self.high, self._start, self._end = low, high, start, end

    def at(self, value: float) -> float:
        return self._start + (value - self.low) / (self.high - self.low) * (self._end - self._start)

    def ticks(self) -> list[float]:
        """Return about five round values."""
        raw = (self.high - self.low) / 5
        size = 10.0 ** math.floor(math.log10(raw))
        step = next(factor * size for factor in (1, 2, 5, 10) if factor * size >= raw)
        first = math.ceil(self.low / step)
        return [number * step for number in range(first, math.floor(self.high / step) + 1)]


def _grid(across: _Scale, up: _Scale) -> list[str]:
    parts: list[str] = []
    for value in up.ticks():
        y = up.at(value)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:.4g}</text>')
    for value in across.ticks():
        x = across.at(value)
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - 8}" text-anchor="middle">{value:.4g} s</text>')
    return parts


def _points(times: Floats, values: Floats, across: _Scale, up: _Scale) -> str:
    every = max(1, -(-len(times) // MOST_POINTS))
    pairs = zip(times[::every], values[::every], strict=True)
    return " ".join(
        f"{across.at(float(time)):.1f},{up.at(float(value)):.1f}"
        for time, value in pairs
        if math.isfinite(value)
    )
