"""Functions that need a simulator with a window. The server has none, so each of them raises an error."""

from __future__ import annotations

from typing import NoReturn

from ...errors import CommandError
from .base import ApiPart


def _no_window(instead: str) -> NoReturn:
    raise CommandError(f"needs the simulator's own window, which this server does not have; {instead}")


_NAVIGATE = "a viewer is moved by the person who looks through it"
_VIEWS = "pictures come from vision sensors: see sim.getVisionSensorImg"


class WindowFunctions(ApiPart):
    """Functions that all raise an error."""

    def setNavigationMode(self, _mode: int) -> None:
        """Raise an error. Not here: the server has no window."""
        _no_window(_NAVIGATE)

    def getNavigationMode(self) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_NAVIGATE)

    def setPage(self, _page: int) -> None:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def getPage(self) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def adjustView(self, _view: int, _handle: int, _options: int, _label: str | None = None) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def cameraFitToView(self, _view: int, _handles: list[int] | None = None) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def floatingViewAdd(self, _x: float, _y: float, _width: float, _height: float, _options: int) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def floatingViewRemove(self, _view: int) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window(_VIEWS)

    def fileDialog(self, _mode: int, _title: str, _path: str, _name: str, _ending: str, _text: str) -> str:
        """Raise an error. Not here: the server has no window."""
        _no_window("say the file's name in the script, or let a client tell it by a signal")

    def textEditorOpen(self, _text: str, _properties: str) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window("text is asked for with sim.displayDialog, style sim.dlgstyle_input")

    def openTextEditor(self, _text: str, _properties: str | None = None) -> int:
        """Raise an error. Not here: the server has no window."""
        _no_window("text is asked for with sim.displayDialog, style sim.dlgstyle_input")
