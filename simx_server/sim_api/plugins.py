"""Plug-ins of V-REP that scripts look for: the server lists those whose functions it has."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import simx_server
from simx_server.errors import Unsupported

from .base import ApiPart

PLUGINS = MappingProxyType(
    {
        "IK": "simIK",
        "OMPL": "simOMPL",
        "RemoteApi": "simRemoteApi",
        "Vision": "simVision",
        "CustomUI": "simUI",
    }
)
"""Names in V-REP 3 and in CoppeliaSim 4.6; scripts look for both."""

_CANNOT_LOAD = -3
"""V-REP's result for a plug-in that cannot be loaded."""

_VERSION_TEXT, _DATE, _VERSION, _VERBOSITY, _BAR_VERBOSITY = range(5)
"""sim.moduleinfo_*."""


class PluginFunctions(ApiPart):
    """Functions for plug-ins. The functions of IK, OMPL, RemoteApi, Vision and CustomUI are part of the server."""

    CONSTANTS = MappingProxyType(
        {
            f"{start}_{name}": number
            for start in ("moduleinfo", "plugininfo")
            for name, number in (
                ("extversionstr", _VERSION_TEXT),
                ("builddatestr", _DATE),
                ("extversionint", _VERSION),
                ("verbosity", _VERBOSITY),
                ("statusbarverbosity", _BAR_VERBOSITY),
            )
        }
    )

    def getModuleName(self, index: int) -> tuple[str, int] | None:
        """Return name and version of the plug-in with an index from 0; nil after the last."""
        names = list(PLUGINS)
        return (names[index], _version()) if 0 <= index < len(names) else None

    def getPluginName(self, index: int) -> tuple[str, int] | None:
        """Return name (``simIK``) and version of the plug-in with an index from 0; nil after the last."""
        names = list(PLUGINS.values())
        return (names[index], _version()) if 0 <= index < len(names) else None

    def getLoadedPlugins(self) -> list[str]:
        """Return the names of all plug-ins."""
        return list(PLUGINS.values())

    def isPluginLoaded(self, name: str) -> bool:
        """Return whether the server has the functions of this plug-in."""
        return name in PLUGINS or name in PLUGINS.values()

    def loadModule(self, _file: str, name: str) -> int:
        """Return the handle of a plug-in that the server has; -3 for others, since none are loaded."""
        return self._load(name)

    def loadPlugin(self, name: str) -> int:
        """Return the handle of a plug-in that the server has; -3 for others, since none are loaded."""
        return self._load(name)

    def unloadModule(self, _handle: int) -> int:
        """Return 0: the plug-ins are part of the server and stay."""
        return 0

    unloadPlugin = unloadModule

    def getModuleInfo(self, name: int | str, what: int) -> str | int:
        """Return version, date or verbosity (sim.moduleinfo_*) of a plug-in by name or handle."""
        self._known(name)
        match what:
            case 0:
                return simx_server.__version__
            case 1:
                return ""
            case 2:
                return _version()
            case 3 | 4:
                return 0
            case _:
                raise Unsupported(f"{what} is no information on a plug-in; those are 0 to 4")

    getPluginInfo = getModuleInfo

    def setModuleInfo(self, name: int | str, _what: int, _value: Any) -> int:
        """Return 1. Stand-in: the verbosity of a plug-in is not separate from the server's log."""
        self._known(name)
        return 1

    setPluginInfo = setModuleInfo

    def sendModuleMessage(self, _message: int, _values: Any = None, _text: Any = None) -> int:
        """Return -1: no plug-in receives messages."""
        return -1

    def _load(self, name: str) -> int:
        if self.isPluginLoaded(name):
            return [*PLUGINS, *PLUGINS.values()].index(name) % len(PLUGINS)
        self._say_once(
            f"plug-in '{name}' cannot be loaded: the server has {', '.join(PLUGINS)}, and no others"
        )
        return _CANNOT_LOAD

    def _known(self, name: int | str) -> None:
        if isinstance(name, int) and 0 <= name < len(PLUGINS):
            return
        if not isinstance(name, str) or not self.isPluginLoaded(name):
            raise Unsupported(f"there is no plug-in {name!r}; plug-ins here are {', '.join(PLUGINS)}")


def _version() -> int:
    """Return the version as one number: 1.2.3 is 10203."""
    digits = [int(part) for part in simx_server.__version__.split(".")[:3] if part.isdigit()]
    return sum(part * 100 ** (2 - place) for place, part in enumerate(digits))
