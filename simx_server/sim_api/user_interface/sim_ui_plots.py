"""Plots and images of ``simUI``, and its widgets that are not shown."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import cv2
import numpy as np

from simx_server.errors import CommandError, Unsupported
from simx_server.files import workspace
from simx_server.parts.user_interface.contents.plot import MAX_CURVES, Curve, Plot
from simx_server.parts.user_interface.widgets import MAX_TEXT
from simx_server.scripting.interpreter import Constant

from .sim_ui import UiPart

_SHAPES = (
    *("none", "dot", "cross", "plus", "circle", "disc", "square", "diamond", "star", "triangle"),
    *("triangle_inverted", "cross_square", "plus_square", "cross_circle", "plus_circle", "peace"),
)
_STYLES = ("scatter", "line", "line_and_scatter", "step_left", "step_center", "step_right", "impulse")


def _numbered(first: int, *names: str) -> dict[str, int]:
    return {name: number for number, name in enumerate(names, first)}


_ENUMS: dict[str, dict[str, int]] = {
    "curve_type": _numbered(20400, "time", "xy"),
    "curve_style": _numbered(22400, *_STYLES),
    "curve_scatter_shape": _numbered(28400, *_SHAPES),
    "line_style": _numbered(32000, "solid", "dotted", "dashed"),
    "mouse": _numbered(20400, "left_button_down", "left_button_up", "move"),
}

_LINE, _LINES = _ENUMS["curve_style"]["line"], _ENUMS["line_style"]
_MOST_PIXELS = 50.0

_WIDEST, _SHOWN = 4096, 320
"""Most pixels a side of an image, and of the image that viewers get."""
_FAST = (cv2.IMWRITE_PNG_COMPRESSION, 1)

OLD_CONSTANTS: Mapping[str, Constant] = MappingProxyType(
    {f"customui_{enum}_{name}": number for enum, names in _ENUMS.items() for name, number in names.items()}
)
"""The same constants as V-REP 3 named them, sim_customui_curve_type_time."""


class UiPlotFunctions(UiPart, effect="changes"):
    """Plots, which the web viewer draws. A plot without ranges shows all its points."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType({**_ENUMS})

    def _plot(self, handle: int, id: int) -> Plot:
        return self._widget(handle, id, "plot").plot

    def _curve(self, handle: int, id: int, name: str) -> Curve:
        curves = self._plot(handle, id).curves
        if name not in curves:
            known = ", ".join(curves) or "none"
            raise CommandError(f"plot {id} has no curve '{name[:80]}'; it has: {known[:1000]}")
        return curves[name]

    def addCurve(
        self,
        handle: int,
        id: int,
        kind: int,
        name: str,
        color: list[float] | None = None,
        style: int = _LINE,
        options: dict[str, Any] | None = None,
    ) -> None:
        """Add a curve to a plot. `kind`: a simUI.curve_type; `color`: red, green, blue, 0 to 255; `style`: a
        simUI.curve_style. Options: `line_size` and `scatter_size` in pixels, `line_style`, `add_to_legend`; points of
        all `scatter_shape`s are discs.
        """
        curves = self._plot(handle, id).curves
        if len(curves) >= MAX_CURVES:
            raise Unsupported(f"plot {id} has {MAX_CURVES} curves already; remove some")
        styles = dict(zip(_ENUMS["curve_style"].values(), _STYLES, strict=True))
        asked = options or {}
        red, green, blue = (min(max(round(part), 0), 255) for part in [*(color or []), 0.0, 0.0, 0.0][:3])
        curves[name] = Curve(
            is_over_time=kind != _ENUMS["curve_type"]["xy"],
            color=(red, green, blue),
            style=styles.get(style, "line"),
            line_size=_size(asked.get("line_size"), 1.0),
            scatter_size=_size(asked.get("scatter_size"), 4.0),
            is_dashed=asked.get("line_style") in (_LINES["dotted"], _LINES["dashed"]),
            is_in_legend=bool(asked.get("add_to_legend", True)),
        )

    def addCurveTimePoints(self, handle: int, id: int, name: str, x: list[float], y: list[float]) -> None:
        """Add points to a curve, which are joined in the order of x."""
        _check(x, y)
        self._curve(handle, id, name).add([], x, y)

    def addCurveXYPoints(
        self, handle: int, id: int, name: str, t: list[float], x: list[float], y: list[float]
    ) -> None:
        """Add points to a curve, which are joined in the order of t."""
        _check(x, y)
        self._curve(handle, id, name).add(t, x, y)

    def getCurveData(self, handle: int, id: int, name: str) -> tuple[list[float], list[float], list[float]]:
        """Return t, x and y of the kept points."""
        curve = self._curve(handle, id, name)
        return list(curve.t), list(curve.x), list(curve.y)

    def clearCurve(self, handle: int, id: int, name: str) -> None:
        """Remove the points of a curve."""
        self._curve(handle, id, name).clear()

    def removeCurve(self, handle: int, id: int, name: str) -> None:
        """Remove a curve."""
        self._curve(handle, id, name)
        del self._plot(handle, id).curves[name]

    def replot(self, handle: int, id: int) -> None:
        """Do nothing to an existing plot: viewers always show the newest points."""
        self._plot(handle, id)

    def setPlotRanges(self, handle: int, id: int, xmin: float, xmax: float, ymin: float, ymax: float) -> None:
        """Set the ranges of x and y that are shown."""
        self.setPlotXRange(handle, id, xmin, xmax)
        self.setPlotYRange(handle, id, ymin, ymax)

    def setPlotXRange(self, handle: int, id: int, xmin: float, xmax: float) -> None:
        """Set the range of x that is shown."""
        self._plot(handle, id).ranges[0] = min(xmin, xmax), max(xmin, xmax)

    def setPlotYRange(self, handle: int, id: int, ymin: float, ymax: float) -> None:
        """Set the range of y that is shown."""
        self._plot(handle, id).ranges[1] = min(ymin, ymax), max(ymin, ymax)

    def growPlotRanges(
        self, handle: int, id: int, xmin: float, xmax: float, ymin: float, ymax: float
    ) -> None:
        """Move the limits of the ranges by these amounts."""
        self._grow(handle, id, 0, xmin, xmax)
        self._grow(handle, id, 1, ymin, ymax)

    def growPlotXRange(self, handle: int, id: int, xmin: float, xmax: float) -> None:
        """Move the limits of the range of x by these amounts."""
        self._grow(handle, id, 0, xmin, xmax)

    def growPlotYRange(self, handle: int, id: int, ymin: float, ymax: float) -> None:
        """Move the limits of the range of y by these amounts."""
        self._grow(handle, id, 1, ymin, ymax)

    def rescaleAxes(
        self, handle: int, id: int, name: str, only_enlarge_x: bool = False, only_enlarge_y: bool = False
    ) -> None:
        """Set the ranges to those of a curve; a range that may only be enlarged is not reduced."""
        self._curve(handle, id, name)
        self._plot(handle, id).fit([name], only_enlarge=(only_enlarge_x, only_enlarge_y))

    def rescaleAxesAll(
        self, handle: int, id: int, only_enlarge_x: bool = False, only_enlarge_y: bool = False
    ) -> None:
        """Set the ranges to those of all curves; a range that may only be enlarged is not reduced."""
        self._plot(handle, id).fit(None, only_enlarge=(only_enlarge_x, only_enlarge_y))

    def setPlotLabels(self, handle: int, id: int, x: str, y: str) -> None:
        """Set the labels of both axes."""
        self._plot(handle, id).labels[:] = x[:MAX_TEXT], y[:MAX_TEXT]

    def setPlotXLabel(self, handle: int, id: int, label: str) -> None:
        """Set the label of the axis of x."""
        self._plot(handle, id).labels[0] = label[:MAX_TEXT]

    def setPlotYLabel(self, handle: int, id: int, label: str) -> None:
        """Set the label of the axis of y."""
        self._plot(handle, id).labels[1] = label[:MAX_TEXT]

    def setLegendVisibility(self, handle: int, id: int, visible: bool) -> None:
        """Set whether the names of the curves are shown; they are not at first."""
        self._plot(handle, id).has_legend = visible

    def setMouseOptions(
        self, handle: int, id: int, _pan_x: bool, _pan_y: bool, _zoom_x: bool, _zoom_y: bool
    ) -> None:
        """Do nothing to an existing plot. Stand-in: the mouse does not move plots."""
        self._plot(handle, id)

    def _grow(self, handle: int, id: int, axis: int, low: float, high: float) -> None:
        plot = self._plot(handle, id)
        least, greatest = plot.ranges[axis] or plot.extent()[axis]
        least, greatest = least + low, greatest + high
        if not (math.isfinite(least) and math.isfinite(greatest)):
            raise CommandError("the range of a plot is too large")
        plot.ranges[axis] = min(least, greatest), max(least, greatest)


class UiImageFunctions(UiPart, effect="changes"):
    """Images of windows, which the web viewer shows."""

    def setImageData(self, handle: int, id: int, data: bytes, width: int, height: int) -> None:
        """Show an image: red, green, blue of each pixel, the rows from the top. Viewers get it with at most 320 pixels
        a side.
        """
        widget = self._widget(handle, id, "image")
        if not (0 < width <= _WIDEST and 0 < height <= _WIDEST):
            raise CommandError(f"an image has 1 to {_WIDEST} pixels a side, not {width} x {height}")
        if len(data) != 3 * width * height:
            raise CommandError(f"{width} x {height} pixels have {3 * width * height} bytes, not {len(data)}")
        pixels = np.frombuffer(data, np.uint8).reshape(height, width, 3)
        shrink = max(width, height) / _SHOWN
        if shrink > 1:
            size = max(1, round(width / shrink)), max(1, round(height / shrink))
            pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
        _, png = cv2.imencode(".png", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), _FAST)
        widget.kept["png"] = base64.b64encode(png.tobytes()).decode()

    def svgLoadData(self, handle: int, id: int, data: str) -> None:
        """Show vector graphics (SVG) as an image."""
        widget = self._widget(handle, id, "svg")
        if len(data) > MAX_TEXT:
            raise CommandError(f"vector graphics have at most {MAX_TEXT} characters, not {len(data)}")
        widget.kept["svg"] = data

    def svgLoadFile(self, handle: int, id: int, file: str) -> None:
        """Show vector graphics (SVG) of a file of the workspace."""
        path = workspace.path_within(self._sim.files.workspace, file)
        if not path.is_file():
            raise CommandError(f"there is no file '{file[:80]}' in the server's workspace")
        self._sim.limits.check("file", path.stat().st_size, "make the image smaller")
        self.svgLoadData(handle, id, path.read_text("utf-8", "replace"))


class UiUnseenFunctions(UiPart, effect="changes"):
    """Widgets that are not shown: properties, 3D scenes, web pages."""

    def _unseen(self, handle: int, id: int, *_values: Any) -> None:
        """Do nothing to an existing widget. Stand-in: such widgets are not shown."""
        self._widget(handle, id)

    setUrl = setItemImage = setItems = _unseen
    setProperties = setPropertiesRows = setPropertiesSelection = _unseen
    setPropertiesContextMenu = setPropertiesState = _unseen
    addScene3DNode = removeScene3DNode = setScene3DNodeEnabled = setScene3DNodeParam = _unseen
    setScene3DNodeIntParam = setScene3DNodeFloatParam = setScene3DNodeStringParam = _unseen
    setScene3DNodeVector2Param = setScene3DNodeVector3Param = setScene3DNodeVector4Param = _unseen

    def getPropertiesState(self, handle: int, id: int) -> str:
        """Return the state of a list of properties. Stand-in: an empty text."""
        self._widget(handle, id)
        return ""


def _size(given: Any, usual: float) -> float:
    is_number = isinstance(given, (int, float)) and not isinstance(given, bool)
    return min(max(float(given), 0.5), _MOST_PIXELS) if is_number and given > 0 else usual


def _check(x: list[float], y: list[float]) -> None:
    if len(x) != len(y):
        raise Unsupported(f"a curve needs as many values of x as of y, not {len(x)} and {len(y)}")
