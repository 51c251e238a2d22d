"""Plug-ins of V-REP that scripts look for: the server lists those whose functions it has."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import simx_server
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.plugin_infos import BAR_LEVEL, CONSOLE_LEVEL, DATE, INFOS, VERSION, VERSION_TEXT

from .base import ApiPart
from .effects import reads, runs_code

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


class PluginFunctions(ApiPart, effect="changes"):
    """Functions for plug-ins. The functions of IK, OMPL, RemoteApi, Vision and CustomUI are part of the server."""

    CONSTANTS = MappingProxyType(
        {
            f"{start}_{name}": number
            for start in ("moduleinfo", "plugininfo")
            for name, number in (
                ("extversionstr", VERSION_TEXT),
                ("builddatestr", DATE),
                ("extversionint", VERSION),
                ("verbosity", CONSOLE_LEVEL),
                ("statusbarverbosity", BAR_LEVEL),
            )
        }
    )

    @reads
    def getModuleName(self, index: int) -> tuple[str, int] | None:
        """Return name and version of the plug-in with an index from 0; nil after the last."""
        names = list(PLUGINS)
        return (names[index], _version()) if 0 <= index < len(names) else None

    @reads
    def getPluginName(self, index: int) -> tuple[str, int] | None:
        """Return name (``simIK``) and version of the plug-in with an index from 0; nil after the last."""
        names = list(PLUGINS.values())
        return (names[index], _version()) if 0 <= index < len(names) else None

    @reads
    def getLoadedPlugins(self) -> list[str]:
        """Return the names of all plug-ins."""
        return list(PLUGINS.values())

    @reads
    def isPluginLoaded(self, name: str) -> bool:
        """Return whether the server has the functions of this plug-in."""
        return name in PLUGINS or name in PLUGINS.values()

    @runs_code
    def loadModule(self, _file: str, name: str) -> int:
        """Return the handle of a plug-in that the server has; -3 for others, since none are loaded."""
        return self._load(name)

    @runs_code
    def loadPlugin(self, name: str) -> int:
        """Return the handle of a plug-in that the server has; -3 for others, since none are loaded."""
        return self._load(name)

    def unloadModule(self, _handle: int) -> int:
        """Return 0: the plug-ins are part of the server and stay."""
        return 0

    unloadPlugin = unloadModule

    @reads
    def getModuleInfo(self, name: int | str, what: int) -> str | int:
        """Return version, date or verbosity (sim.moduleinfo_*) of a plug-in by name or handle, as it was set."""
        plugin = self._known(name)
        if what not in INFOS:
            raise Unsupported(f"{what} is no information on a plug-in; those are 0 to {len(INFOS) - 1}")
        found = self._world.plugin_infos.get(plugin, what)
        if found is not None:
            return found
        match what:
            case 0:
                return simx_server.__version__
            case 1:
                return ""
            case 2:
                return _version()
            case 3:
                return self._script.console_verbosity
            case _:
                return self._script.bar_verbosity

    getPluginInfo = getModuleInfo

    def setModuleInfo(self, name: int | str, what: int, value: int | str) -> int:
        """Set information on a plug-in (sim.moduleinfo_*) and return 1. With a verbosity below sim.verbosity_warnings
        its notes do not come to the log or the status bar; sim.verbosity_useglobal shows them.
        """
        plugin = self._known(name)
        wanted = INFOS.get(what)
        if wanted is None:
            raise CommandError(f"{what} is no information on a plug-in; those are 0 to {len(INFOS) - 1}")
        if type(value).__name__ != wanted:
            raise CommandError(f"information {what} on a plug-in is of the type {wanted}")
        self._world.plugin_infos.put(plugin, what, value)
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

    def _known(self, name: int | str) -> str:
        """Return the namespace of a plug-in by a name or its handle. Raises Unsupported."""
        if isinstance(name, int) and 0 <= name < len(PLUGINS):
            return list(PLUGINS.values())[name]
        if not isinstance(name, str) or not self.isPluginLoaded(name):
            raise Unsupported(f"there is no plug-in {name!r}; plug-ins here are {', '.join(PLUGINS)}")
        return PLUGINS.get(name, name)


def _version() -> int:
    """Return the version as one number: 1.2.3 is 10203."""
    digits = [int(part) for part in simx_server.__version__.split(".")[:3] if part.isdigit()]
    return sum(part * 100 ** (2 - place) for place, part in enumerate(digits))
