"""Curves of cost against size as a small PNG, with OpenCV, which is there anyway."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .report import Panel, Plot

WIDTH, HEIGHT = 520, 340
"""Of one panel, pixels."""

LEFT, RIGHT, TOP, BOTTOM = 66, 16, 40, 46
LEGEND_LINE = 19
INK, GRID = (60, 60, 60), (228, 228, 228)
COLOURS = ((180, 90, 20), (40, 120, 220), (90, 150, 60), (150, 60, 130))
BASELINE = (150, 150, 150)
"""Colours, BGR."""

FILLED = 0.35
"""Part of the range that is left free above the curves, for their names."""


class Axis:
    """From a value to a share of the way along the axis."""

    def __init__(self, low: float, high: float, *, is_log: bool) -> None:
        self._scale = math.log10 if is_log else float
        self._low, self._high = self._scale(low), self._scale(high)

    def share(self, value: float) -> float:
        """0 at the beginning, 1 at the end."""
        return (self._scale(value) - self._low) / ((self._high - self._low) or 1.0)


def draw(folder: Path, plot: Plot) -> Path:
    """Write the image into a folder, which is made if it is not there.

    Raises:
        OSError: it could not be written.
    """
    picture = np.hstack([_draw_panel(panel) for panel in plot.panels])
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{plot.name}.png"
    # Few colours: a tenth of the bytes of all shades that smoothing makes.
    few = (picture // 16 * 17).astype(np.uint8)
    if not cv2.imwrite(str(path), few, [cv2.IMWRITE_PNG_COMPRESSION, 9]):
        raise OSError(f"the image could not be written to {path}")
    return path


def _draw_panel(panel: Panel) -> NDArray[np.uint8]:
    picture = np.full((HEIGHT, WIDTH, 3), 255, dtype=np.uint8)
    curves = {**panel.curves, **panel.baselines}
    points = [point for curve in curves.values() for point in curve]
    xs, ys = ([point[axis] for point in points] for axis in (0, 1))
    y_ticks = decades(min(ys), max(ys)) if panel.is_log else steps(max(ys))
    x_axis = Axis(min(xs), max(xs), is_log=True)
    y_axis = _y_axis(y_ticks, is_log=panel.is_log)

    def place(x: float, y: float) -> tuple[int, int]:
        across, up = x_axis.share(x), y_axis.share(y)
        return (
            round(LEFT + across * (WIDTH - LEFT - RIGHT)),
            round(HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)),
        )

    for tick in y_ticks:
        cv2.line(picture, place(min(xs), tick), place(max(xs), tick), GRID, 1)
        _write(picture, f"{tick:g}", (LEFT - 8, place(min(xs), tick)[1] + 4), align=1.0)
    for x in sorted(set(xs)):
        at = place(x, y_ticks[0])
        cv2.line(picture, at, (at[0], at[1] + 4), INK, 1)
        _write(picture, f"{x:g}", (at[0], at[1] + 18), align=0.5)
    for number, (name, curve) in enumerate(curves.items()):
        colour = BASELINE if name in panel.baselines else COLOURS[number % len(COLOURS)]
        _draw_curve(picture, [place(*point) for point in curve], colour)
        level = TOP + 8 + number * LEGEND_LINE
        cv2.line(picture, (LEFT + 8, level), (LEFT + 30, level), colour, 2, cv2.LINE_AA)
        _write(picture, name, (LEFT + 37, level + 4), align=0.0)
    _write(picture, panel.title, (LEFT, 22), align=0.0, size=0.5)
    _write(picture, panel.x, ((WIDTH + LEFT) // 2, HEIGHT - 8), align=0.5)
    return picture


def _y_axis(ticks: Sequence[float], *, is_log: bool) -> Axis:
    low, high = ticks[0], ticks[-1]
    above = (high / low) ** FILLED * high if is_log else high + (high - low) * FILLED
    return Axis(low, above, is_log=is_log)


def _draw_curve(picture: NDArray[np.uint8], at: Sequence[tuple[int, int]], colour: Sequence[int]) -> None:
    cv2.polylines(picture, [np.array(at, np.int32)], False, colour, 2, cv2.LINE_AA)
    for point in at:
        cv2.circle(picture, point, 3, colour, -1, cv2.LINE_AA)


def steps(high: float) -> list[float]:
    """Four to nine round numbers from zero to what is above."""
    size = 10.0 ** math.floor(math.log10(high))
    size = next(each for each in (size / 5, size / 2, size, size * 2) if high / each <= 8)
    return [size * number for number in range(math.ceil(high / size) + 1)]


def decades(low: float, high: float) -> list[float]:
    """Powers of ten around a range."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    return [10.0**power for power in range(first, max(last, first + 1) + 1)]


def _write(
    picture: NDArray[np.uint8], text: str, at: tuple[int, int], *, align: float, size: float = 0.42
) -> None:
    """Text whose left edge (0), middle (0.5) or right edge (1) is at a place."""
    font = cv2.FONT_HERSHEY_SIMPLEX
    (width, _), _ = cv2.getTextSize(text, font, size, 1)
    cv2.putText(picture, text, (at[0] - round(align * width), at[1]), font, size, INK, 1, cv2.LINE_AA)
