"""Settings of plug-ins by scripts: how much each one says, and its version texts."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from simx_server.simulation.part import Part

VERSION_TEXT, DATE, VERSION, CONSOLE_LEVEL, BAR_LEVEL = range(5)
"""sim.moduleinfo_*."""

_KINDS: Mapping[int, type] = MappingProxyType(
    {VERSION_TEXT: str, DATE: str, VERSION: int, CONSOLE_LEVEL: int, BAR_LEVEL: int}
)

INFOS: Mapping[int, str] = MappingProxyType({number: kind.__name__ for number, kind in _KINDS.items()})
"""Kinds of information: an int or a text."""

MOST_LETTERS = 1000


class PluginInfos(Part):
    """The values that were set in the present scene, by plug-in and kind of information."""

    def __init__(self) -> None:
        self._set: dict[tuple[str, int], int | str] = {}

    def scene_changed(self) -> None:
        self._set.clear()

    def get(self, plugin: str, what: int) -> int | str | None:
        """Return a value that was set; None: none was."""
        return self._set.get((plugin, what))

    def put(self, plugin: str, what: int, value: int | str) -> None:
        """Set a value; the kind of information and the type of its value are known to fit."""
        self._set[plugin, what] = value[:MOST_LETTERS] if isinstance(value, str) else value

    def shows(self, plugin: str, what: int, level: int) -> bool:
        """Return whether messages of a plug-in with this level are shown, in the log or in the status bar."""
        chosen = self._set.get((plugin, what))
        return not isinstance(chosen, int) or chosen < 0 or level <= chosen
