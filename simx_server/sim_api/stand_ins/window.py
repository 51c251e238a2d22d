"""Functions that draw in V-REP's window or work on its files and editors: they return what V-REP returned."""

from __future__ import annotations

from typing import Any

from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_DRAWN = "banners, ghosts and points of V-REP's window (sim.addBanner, sim.addGhost, sim.addPointCloud) are not drawn"
_MACHINERY = "functions and variables for V-REP's editor are not registered"


class WindowFunctions(ApiPart, effect="changes"):
    """Functions for the drawing, the editor and the files of V-REP's window."""

    def addBanner(self, _text: str, _size: float, _options: int, *_more: Any) -> int:
        """Return 1. Stand-in: banners are not drawn."""
        return self._not_drawn()

    def removeBanner(self, _banner: int) -> int:
        """Return 1. Stand-in: banners are not drawn."""
        return 1

    def addGhost(self, _group: int, handle: int, *_more: Any) -> int:
        """Return 1. Stand-in: ghosts of objects are not drawn."""
        self._sim.scene.get(self._self(handle))
        return self._not_drawn()

    def modifyGhost(self, _group: int, _ghost: int, _operation: int, *_more: Any) -> int:
        """Return 1. Stand-in: ghosts of objects are not drawn."""
        self._say_once(_DRAWN)
        return 1

    def addPointCloud(self, _page_mask: int, _layer: int, _object: int, _options: int, *_more: Any) -> int:
        """Return 1. Stand-in: the points of V-REP 3's drawing are not drawn."""
        return self._not_drawn()

    def handleTracing(self) -> int:
        """Return 1. Stand-in: traces are not drawn."""
        return 1

    def resetTracing(self) -> int:
        """Return 1. Stand-in: traces are not drawn."""
        return 1

    def setDebugWatchList(self, _names: list[str] | None = None) -> int:
        """Return 1. Stand-in: the server has no window for the variables of scripts."""
        return 1

    def registerScriptFunction(self, _function: str, _tip: str = "") -> int:
        """Return 1. Stand-in: it served V-REP's editor."""
        self._say_once(_MACHINERY)
        return 1

    def registerScriptVariable(self, _variable: str) -> int:
        """Return 1. Stand-in: it served V-REP's editor."""
        self._say_once(_MACHINERY)
        return 1

    def lockInterface(self, _locked: bool) -> int:
        """Return 0, that it was not locked. Stand-in: the server has no window."""
        return 0

    @reads
    def getLastError(self) -> None:
        """Return nil: no error has happened. Stand-in: errors are in the log and the status bar."""

    @reads
    def getLastInfo(self) -> str:
        """Return an empty text: functions here raise errors, and leave no other information."""
        return ""

    @reads
    def isDeprecated(self, _name: str) -> int:
        """Return 0, as CoppeliaSim does."""
        return 0

    def fastIdleLoop(self, _enable: bool = True) -> None:
        """Do nothing: a server that is stopped answers calls at once."""

    @reads
    def getInstanceIndex(self) -> int:
        """Return 0: there is one scene at a time."""
        return 0

    getVisibleInstanceIndex = getInstanceIndex

    def _not_drawn(self) -> int:
        self._say_once(_DRAWN)
        return 1
