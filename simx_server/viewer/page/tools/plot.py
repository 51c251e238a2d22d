"""One plot over simulated time: the values of one or more quantities, kept for half a minute, to be saved as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from simx_server.viewer.messages import Survey
from simx_server.viewer.page.mirror import Copy

_WINDOW = 30.0
"""Simulated seconds."""

_ENOUGH = 150
"""Samples that are kept even when they are older: a fast simulation has few in half a minute."""

_MOST_SAMPLES = 600
_COLOURS = ("#1f6f8b", "#d9480f", "#2b8a3e", "#862e9c", "#e8b008", "#c2255c", "#495057", "#15aabf")
MOST_CURVES = 4
"""Quantities in one plot."""

_HEIGHT = 170
_HIGHER = 12
"""Pixels that the legend needs for each value, where there are several quantities."""

_LABELS = 64
"""Pixels of the numbers beside the vertical axis."""

Values = tuple[float, ...]
Axis = tuple[float, float]


@dataclass(frozen=True)
class Curve:
    """A quantity to plot. `read` returns one number for each of `names`, None while there is none."""

    title: str
    names: tuple[str, ...]
    read: Callable[[Survey, Copy | None], Values | None]
    least: float = 0.0
    """Least span of the vertical axis, in the curve's unit: smaller changes are noise."""

    least_share: float = 0.0
    """The same as a share of the largest value, for values without a unit."""


class Plot:
    """Curves with one axis of time. `name` is what users choose it by."""

    def __init__(self, gui: viser.GuiApi, name: str, curve: Curve) -> None:
        self._gui, self.name = gui, name
        self.curves = [curve]
        self.is_unwanted = False
        self._samples: deque[tuple[float, Values]] = deque(maxlen=_MOST_SAMPLES)
        self._axis: Axis | None = None
        self._folder = gui.add_folder(None)
        with self._folder:
            self._chart = self._make_chart()
            save = gui.add_button(
                "Save as CSV", icon=viser.Icon.DOWNLOAD, hint="what the plot shows, as a table"
            )
            remove = gui.add_button("Remove plot", icon=viser.Icon.TRASH, hint=name)
        save.on_click(lambda event: self._save(event.client))

        @remove.on_click
        def _(_: object) -> None:
            self.is_unwanted = True

    @property
    def names(self) -> list[str]:
        """Return the names of all values; those of several quantities tell which one."""
        if len(self.curves) == 1:
            return list(self.curves[0].names)
        return [f"{curve.title.partition(' / ')[0]}: {name}" for curve in self.curves for name in curve.names]

    def add(self, curve: Curve) -> None:
        """Plot another quantity too; earlier samples have no value of it."""
        if len(self.curves) >= MOST_CURVES or any(each.title == curve.title for each in self.curves):
            return
        self.curves.append(curve)
        gap = (math.nan,) * len(curve.names)
        for place, (time, values) in enumerate(self._samples):
            self._samples[place] = time, values + gap
        order = self._chart.order
        self._chart.remove()
        with self._folder:
            self._chart = self._make_chart(order)

    def sample(self, time: float, survey: Survey, copy: Copy | None) -> None:
        """Add the present values; a quantity without a value adds a gap, and nothing is added if none has one."""
        read = [curve.read(survey, copy) for curve in self.curves]
        if all(values is None for values in read):
            return
        gaps = [(math.nan,) * len(curve.names) for curve in self.curves]
        values = [gap if each is None else each for each, gap in zip(read, gaps, strict=True)]
        self._samples.append((time, tuple(number for each in values for number in each)))
        while len(self._samples) > _ENOUGH and self._samples[0][0] < time - _WINDOW:
            self._samples.popleft()
        data = self._data()
        axis = (
            vertical_axis(np.array(data[1:]), self.curves[0], self._axis) if len(self.curves) == 1 else None
        )
        if axis != self._axis:
            self._axis = axis
            self._chart.scales = _scales(axis)
        self._chart.data = data

    def clear(self) -> None:
        """Remove all samples, because time starts again."""
        self._samples.clear()
        self._chart.data = self._data()

    def remove(self) -> None:
        self._folder.remove()  # with everything in it

    def table(self) -> str:
        """Return the samples as CSV: a line of names, then a line for each sample; a gap is empty."""
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t / s", *_plain_names(self.curves)])
        for time, values in list(self._samples):
            writer.writerow([f"{time:.6g}", *("" if math.isnan(each) else f"{each:.9g}" for each in values)])
        return file.getvalue()

    def _save(self, client: viser.ClientHandle | None) -> None:
        if client is not None:
            name = f"simx-{self.name.replace(' ', '-')}.csv"
            client.send_file_download(name, self.table().encode(), save_immediately=True)

    def _make_chart(self, order: float | None = None) -> viser.GuiUplotHandle:
        titles = ", ".join(curve.title for curve in self.curves)
        return self._gui.add_uplot(
            self._data(),
            (
                {"label": "t / s"},
                *(
                    {"label": name, "stroke": _COLOURS[number % len(_COLOURS)], "width": 2.0}
                    for number, name in enumerate(self.names)
                ),
            ),
            title=titles if len(self.curves) == 1 else self.name,
            scales=_scales(self._axis),
            axes=({}, {"size": _LABELS}),
            height=_HEIGHT if len(self.curves) == 1 else _HEIGHT + _HIGHER * len(self.names),
            order=order,
        )

    def _data(self) -> tuple[np.ndarray, ...]:
        count = sum(len(curve.names) for curve in self.curves)
        rows = np.array([(time, *values) for time, values in self._samples], float)
        return tuple(rows.reshape(-1, 1 + count).T.copy())


def _plain_names(curves: Sequence[Curve]) -> list[str]:
    """Return a name for each column: the quantity with its unit, and the value."""
    return [
        curve.title if len(curve.names) == 1 else f"{curve.title}: {name}"
        for curve in curves
        for name in curve.names
    ]


def vertical_axis(values: np.ndarray, curve: Curve, before: Axis | None) -> Axis | None:
    """Return the ends of the vertical axis; None where the values differ enough for the chart to choose them.

    The axis of constant values stays as it was while the values lie within, so that noise does not move it.
    """
    low, high = float(values.min()), float(values.max())
    least = max(curve.least, curve.least_share * max(abs(low), abs(high)))
    if high - low >= least:
        return None
    if before is not None and before[0] <= low and high <= before[1]:
        return before
    step = least / 4
    middle = round((low + high) / 2 / step) * step
    return middle - 3 * step, middle + 3 * step


def _scales(axis: Axis | None) -> dict[str, uplot.Scale]:
    return {
        "x": {"time": False, "auto": True},
        "y": {"auto": True} if axis is None else {"auto": False, "range": axis},
    }
