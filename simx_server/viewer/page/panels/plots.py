"""Plots over simulated time: values that the panels show, kept for half a minute."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from simx_server.viewer.messages import Look, SceneItem, Survey
from simx_server.viewer.page.mirror import Copy, Mirror

_MOST_PLOTS = 4
_WINDOW = 30.0
"""Simulated seconds."""

_ENOUGH = 150
"""Samples that are kept even when they are older: a fast simulation has few in half a minute."""

_MOST_SAMPLES = 600
_COLOURS = ("#1f6f8b", "#d9480f", "#2b8a3e")
_HEIGHT = 170
_LABELS = 64
"""Pixels of the numbers beside the vertical axis."""

_NOTHING_YET: str = "(nothing to plot)"

_POSITIONS = {
    "body": "xpos",
    "geom": "geom_xpos",
    "site": "site_xpos",
    "camera": "cam_xpos",
    "light": "light_xpos",
    "joint": "xanchor",
}
"""By type of model element: the array with its position in the copy."""

_AT_REST = 0.01
"""Radians or metres that an axis spans at least."""

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


class Plots:
    """The folder. Clicks are stored, and handled at the next `update`: one thread makes and removes elements."""

    def __init__(self, gui: viser.GuiApi, mirror: Mirror) -> None:
        self._gui, self._mirror = gui, mirror
        self._tree: list[SceneItem] = []
        self._curves: dict[str, Curve] = {}
        self._wanted: deque[Curve] = deque()
        self._plots: list[_Plot] = []
        self._time = 0.0
        self._place = gui.add_folder("Plots")
        with self._place:
            self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Of", (_NOTHING_YET,), hint="joints, numeric signals, and the object that is selected"
            )
            self._add = gui.add_button("Add plot", icon=viser.Icon.CHART_LINE, hint=f"{_MOST_PLOTS} at most")
        self._add.on_click(lambda _: self._want())

    def update(self, survey: Survey, look: Look) -> None:
        """Offer the present quantities, make and remove clicked plots, and take a sample when time has moved on."""
        if survey["tree"] is not None:
            self._tree = survey["tree"]
        self._curves = _curves(self._tree, survey, look)
        options = tuple(self._curves) or (_NOTHING_YET,)
        if self._choice.options != options:
            self._choice.options = options
        self._make_and_remove()
        time = look["time"]
        if time < self._time:
            for plot in self._plots:
                plot.clear()
        if time != self._time and not self._mirror.is_past:
            self._time = time
            for plot in self._plots:
                plot.sample(time, plot.curve.read(survey, self._mirror.copy))

    def _want(self) -> None:
        """Store the present choice: it may no longer be offered when the plot is made. A thread of viser's."""
        curve = self._curves.get(self._choice.value)
        if curve is not None:
            self._wanted.append(curve)

    def _make_and_remove(self) -> None:
        for plot in [plot for plot in self._plots if plot.is_unwanted]:
            plot.remove()
            self._plots.remove(plot)
        while self._wanted:
            curve = self._wanted.popleft()
            if len(self._plots) < _MOST_PLOTS:
                with self._place:
                    self._plots.append(_Plot(self._gui, curve))
        self._add.disabled = len(self._plots) >= _MOST_PLOTS


class _Plot:
    def __init__(self, gui: viser.GuiApi, curve: Curve) -> None:
        self.curve = curve
        self.is_unwanted = False
        self._samples: deque[tuple[float, Values]] = deque(maxlen=_MOST_SAMPLES)
        self._axis: Axis | None = None
        self._folder = gui.add_folder(None)
        with self._folder:
            self._chart = gui.add_uplot(
                self._data(),
                (
                    {"label": "t / s"},
                    *(
                        {"label": name, "stroke": colour, "width": 2.0}
                        for name, colour in zip(curve.names, _COLOURS, strict=False)
                    ),
                ),
                title=curve.title,
                scales=_scales(None),
                axes=({}, {"size": _LABELS}),
                height=_HEIGHT,
            )
            remove = gui.add_button("Remove plot", icon=viser.Icon.TRASH, hint=curve.title)

        @remove.on_click
        def _(_: object) -> None:
            self.is_unwanted = True

    def sample(self, time: float, values: Values | None) -> None:
        """Add the present values; None adds nothing."""
        if values is None:
            return
        self._samples.append((time, values))
        while len(self._samples) > _ENOUGH and self._samples[0][0] < time - _WINDOW:
            self._samples.popleft()
        data = self._data()
        axis = vertical_axis(np.array(data[1:]), self.curve, self._axis)
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

    def _data(self) -> tuple[np.ndarray, ...]:
        rows = np.array([(time, *values) for time, values in self._samples], float)
        return tuple(rows.reshape(-1, 1 + len(self.curve.names)).T.copy())


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


def _curves(tree: list[SceneItem], survey: Survey, look: Look) -> dict[str, Curve]:
    """Return the curves by title: the selection, signals, joints."""
    curves: list[Curve] = []
    selected = set(look["selection"])
    curves += [_position(item) for item in tree if item["handle"] in selected]
    signals = survey["signals"]
    curves += [_signal("float", name) for name in sorted(signals["floats"])]
    curves += [_signal("integer", name) for name in sorted(signals["integers"])]
    joints = survey["joints"]
    curves += [
        _joint(item)
        for item in tree
        if item["handle"] in joints and item["joint"] in ("revolute", "prismatic")
    ]
    return {curve.title: curve for curve in curves}


def _joint(item: SceneItem) -> Curve:
    handle = item["handle"]
    unit = "m" if item["joint"] == "prismatic" else "rad"

    def read(survey: Survey, copy: Copy | None) -> Values | None:
        joint = survey["joints"].get(handle)
        if joint is None or joint["position"] is None or joint["target"] is None:
            return None
        return joint["position"], joint["target"]

    return Curve(f"joint {item['name']} / {unit}", ("position", "target"), read, _AT_REST)


def _signal(kind: str, name: str) -> Curve:
    def read(survey: Survey, copy: Copy | None) -> Values | None:
        signals = survey["signals"]
        value = signals["floats"].get(name) if kind == "float" else signals["integers"].get(name)
        # A value that is not finite has no place on an axis.
        return (float(value),) if value is not None and math.isfinite(value) else None

    least = (0.0, 1e-3) if kind == "float" else (2.0, 0.0)
    return Curve(f"{kind} signal {name}", (name,), read, *least)


def _position(item: SceneItem) -> Curve:
    array, number = _POSITIONS.get(item["element"]), item["id"]

    def read(survey: Survey, copy: Copy | None) -> Values | None:
        if copy is None or array is None:
            return None
        places: np.ndarray = getattr(copy.data, array)
        return tuple(map(float, places[number])) if number < len(places) else None

    return Curve(f"position of {item['name']} / m", ("x", "y", "z"), read, _AT_REST)
