"""Plots over simulated time: values that the panels show, kept for half a minute."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import viser

from simx_server.viewer.messages import Look, SceneItem, Survey
from simx_server.viewer.page.mirror import Copy, Mirror
from simx_server.viewer.page.tools.plot import MOST_CURVES, Curve, Plot, Values

_MOST_PLOTS = 4
_NEW: str = "a new plot"
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


class Plots:
    """The folder. Clicks are stored, and handled at the next `update`: one thread makes and removes elements."""

    def __init__(self, gui: viser.GuiApi, mirror: Mirror) -> None:
        self._gui, self._mirror = gui, mirror
        self._tree: list[SceneItem] = []
        self._curves: dict[str, Curve] = {}
        self._wanted: deque[tuple[Curve, str]] = deque()
        """Curves, and the plots into which they are to go."""

        self._made = 0
        self._plots: list[Plot] = []
        self._time = 0.0
        self._place = gui.add_folder("Plots")
        with self._place:
            self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Of", (_NOTHING_YET,), hint="joints, numeric signals, and the object that is selected"
            )
            self._into: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Into",
                (_NEW,),
                hint=f"one of {_MOST_PLOTS} plots, each of up to {MOST_CURVES} quantities",
            )
            self._add = gui.add_button("Add plot", icon=viser.Icon.CHART_LINE)
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
                plot.sample(time, survey, self._mirror.copy)

    def _want(self) -> None:
        """Store the present choice: it may no longer be offered when the plot is made. A thread of viser's."""
        curve = self._curves.get(self._choice.value)
        if curve is not None:
            self._wanted.append((curve, self._into.value))

    def _make_and_remove(self) -> None:
        for plot in [plot for plot in self._plots if plot.is_unwanted]:
            plot.remove()
            self._plots.remove(plot)
        while self._wanted:
            curve, into = self._wanted.popleft()
            plot = next((each for each in self._plots if each.name == into), None)
            if plot is not None:
                plot.add(curve)
            elif len(self._plots) < _MOST_PLOTS:
                self._made += 1
                with self._place:
                    self._plots.append(Plot(self._gui, f"plot {self._made}", curve))
        options = (_NEW, *(plot.name for plot in self._plots if len(plot.curves) < MOST_CURVES))
        if self._into.options != options:
            chosen = self._into.value
            self._into.options = options
            if chosen in options:
                self._into.value = chosen
        self._add.disabled = len(self._plots) >= _MOST_PLOTS and self._into.value == _NEW


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
