"""The menu of modules, to which scripts add entries. The web viewer shows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .registry import Registry

KEEP, DESTROY = -1, -2
"""States of `sim.moduleEntry` that are none: leave it as it is, remove the entry."""

ENABLED, CHECKED, CHECKABLE = 1, 2, 4

MOST_LETTERS = 1000


@dataclass(eq=False)
class MenuEntry:
    """One entry."""

    title: str
    """Its label; names of menus stand in front of it, each on a line."""
    select: Callable[[int], object]
    """Called with the handle when a person selects it."""
    state: int = ENABLED
    is_alive: Callable[[], bool] = lambda: True
    """Return whether the script that made it still runs; the entry goes with it."""
    handle: int = 0


class ModuleMenu(Registry[MenuEntry]):
    """All entries. Physics thread only."""

    KIND = "module entry"
    LIMIT = "uis"
    WAY_OUT = "remove some with sim.moduleEntry(handle, nil, -2)"

    def scene_changed(self) -> None:
        self._opened.clear()

    def select(self, handle: int) -> None:
        """Select an entry as a person does. Raises CommandError: no such entry, or it is not enabled."""
        entry = self.get(handle)
        if not entry.state & ENABLED:
            raise CommandError(
                f"module entry {handle} ('{entry.title}') cannot be selected: it is not enabled"
            )
        entry.select(handle)

    def view(self) -> list[dict[str, Any]]:
        """Return all entries for the web viewer."""
        return [
            {
                "handle": entry.handle,
                "path": entry.title[:MOST_LETTERS].split("\n"),
                "enabled": bool(entry.state & ENABLED),
                "checked": bool(entry.state & CHECKED and entry.state & CHECKABLE),
            }
            for entry in self
            if entry.is_alive()
        ]

    def _prepare(self, new: MenuEntry) -> None:
        self._opened = {handle: each for handle, each in self._opened.items() if each.is_alive()}

    def _is_alive(self, opened: MenuEntry) -> bool:
        return opened.is_alive()
