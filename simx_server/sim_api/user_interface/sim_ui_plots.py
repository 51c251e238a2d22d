"""Plots, images and other widgets of ``simUI`` that are not shown. The points of curves are kept for the script."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

from simx_server.errors import CommandError, Unsupported
from simx_server.scripting.interpreter import Constant

from .sim_ui import UiPart

MAX_POINTS = 10_000
"""Most points of a curve that are kept; the oldest are dropped first."""

MAX_CURVES = 100

_SHAPES = (
    *("none", "dot", "cross", "plus", "circle", "disc", "square", "diamond", "star", "triangle"),
    *("triangle_inverted", "cross_square", "plus_square", "cross_circle", "plus_circle", "peace"),
)
_STYLES = ("scatter", "line", "line_and_scatter", "step_left", "step_center", "step_right", "impulse")

_Curve = list[list[float]]
"""The values t (empty in a time curve), x and y."""


def _numbered(first: int, *names: str) -> dict[str, int]:
    return {name: number for number, name in enumerate(names, first)}


_ENUMS: dict[str, dict[str, int]] = {
    "curve_type": _numbered(20400, "time", "xy"),
    "curve_style": _numbered(22400, *_STYLES),
    "curve_scatter_shape": _numbered(28400, *_SHAPES),
    "line_style": _numbered(32000, "solid", "dotted", "dashed"),
    "mouse": _numbered(20400, "left_button_down", "left_button_up", "move"),
}

OLD_CONSTANTS: Mapping[str, Constant] = MappingProxyType(
    {f"customui_{enum}_{name}": number for enum, names in _ENUMS.items() for name, number in names.items()}
)
"""The same constants as V-REP 3 named them, sim_customui_curve_type_time."""


class UiPlotFunctions(UiPart):
    """Plots. Nothing is drawn: graphs of the scene are drawn by the web viewer."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType({**_ENUMS})

    def _curves(self, handle: int, id: int) -> dict[str, _Curve]:
        return self._widget(handle, id, "plot").kept.setdefault("curves", {})

    def _curve(self, handle: int, id: int, name: str) -> _Curve:
        curves = self._curves(handle, id)
        if name not in curves:
            known = ", ".join(curves) or "none"
            raise CommandError(f"plot {id} has no curve '{name[:80]}'; it has: {known[:1000]}")
        return curves[name]

    def addCurve(
        self,
        handle: int,
        id: int,
        _kind: int,
        name: str,
        _color: list[float] | None = None,
        _style: int = 22401,
        _options: Any = None,
    ) -> None:
        """Add a curve to a plot. Stand-in: its points are kept and not drawn."""
        curves = self._curves(handle, id)
        if len(curves) >= MAX_CURVES:
            raise Unsupported(f"plot {id} has {MAX_CURVES} curves already; remove some")
        curves[name] = [[], [], []]

    def addCurveTimePoints(self, handle: int, id: int, name: str, x: list[float], y: list[float]) -> None:
        """Add points to a curve. Stand-in: they are kept and not drawn."""
        _add(self._curve(handle, id, name), [], x, y)

    def addCurveXYPoints(
        self, handle: int, id: int, name: str, t: list[float], x: list[float], y: list[float]
    ) -> None:
        """Add points to a curve. Stand-in: they are kept and not drawn."""
        _add(self._curve(handle, id, name), t, x, y)

    def getCurveData(self, handle: int, id: int, name: str) -> tuple[list[float], list[float], list[float]]:
        """Return t, x and y of the kept points."""
        t, x, y = self._curve(handle, id, name)
        return list(t), list(x), list(y)

    def clearCurve(self, handle: int, id: int, name: str) -> None:
        """Remove the points of a curve."""
        for values in self._curve(handle, id, name):
            values.clear()

    def removeCurve(self, handle: int, id: int, name: str) -> None:
        """Remove a curve."""
        self._curve(handle, id, name)
        del self._curves(handle, id)[name]

    def _nothing(self, handle: int, id: int, *_values: Any) -> None:
        """Do nothing to an existing plot. Stand-in: plots are not drawn."""
        self._curves(handle, id)

    replot = setPlotRanges = setPlotXRange = setPlotYRange = _nothing
    growPlotRanges = growPlotXRange = growPlotYRange = _nothing
    setPlotLabels = setPlotXLabel = setPlotYLabel = _nothing
    rescaleAxes = rescaleAxesAll = setMouseOptions = setLegendVisibility = _nothing


class UiUnseenFunctions(UiPart):
    """Widgets that are not shown: images, properties, 3D scenes, web pages."""

    def _unseen(self, handle: int, id: int, *_values: Any) -> None:
        """Do nothing to an existing widget. Stand-in: such widgets are not shown."""
        self._widget(handle, id)

    setImageData = svgLoadFile = svgLoadData = setUrl = setItemImage = setItems = _unseen
    setProperties = setPropertiesRows = setPropertiesSelection = _unseen
    setPropertiesContextMenu = setPropertiesState = _unseen
    addScene3DNode = removeScene3DNode = setScene3DNodeEnabled = setScene3DNodeParam = _unseen
    setScene3DNodeIntParam = setScene3DNodeFloatParam = setScene3DNodeStringParam = _unseen
    setScene3DNodeVector2Param = setScene3DNodeVector3Param = setScene3DNodeVector4Param = _unseen

    def getPropertiesState(self, handle: int, id: int) -> str:
        """Return the state of a list of properties. Stand-in: an empty text."""
        self._widget(handle, id)
        return ""


def _add(curve: _Curve, *values: list[float]) -> None:
    _, x, y = values
    if len(x) != len(y):
        raise Unsupported(f"a curve needs as many values of x as of y, not {len(x)} and {len(y)}")
    for kept, new in zip(curve, values, strict=True):
        kept.extend(new)
        del kept[:-MAX_POINTS]
