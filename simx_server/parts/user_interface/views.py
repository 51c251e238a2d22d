"""Views of V-REP's window: pages, and floating views that scripts add. They are kept, and nothing is drawn in them.

The web viewer shows the images of cameras and vision sensors without them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError

from .registry import Registry

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

PAGES = 8
"""Pages of V-REP's window."""

_FIRST_FLOATING = 100
"""First handle of a floating view; smaller numbers are views of the present page, by index."""


@dataclass
class FloatingView:
    """A view in its own small window."""

    x: float
    y: float
    width: float
    height: float
    """Place and size as shares of the window."""
    options: int
    shown: int = -1
    """Handle of the camera, vision sensor or graph that it shows, -1 for none."""
    title: str = ""
    handle: int = 0


class Views(Registry[FloatingView]):
    """The floating views of the present scene, and its page. Physics thread only."""

    KIND = "floating view"
    LIMIT = "uis"
    WAY_OUT = "remove some with sim.floatingViewRemove"

    def __init__(self, sim: Simulation) -> None:
        super().__init__(sim)
        self._next_handle = _FIRST_FLOATING
        self.page = self.navigation_mode = 0

    def scene_changed(self) -> None:
        self.page = self.navigation_mode = 0
        self._opened.clear()

    def set_navigation_mode(self, mode: int) -> None:
        """Keep a mode of the mouse; nothing here depends on it."""
        self.navigation_mode = mode

    def set_page(self, page: int) -> None:
        """Turn to a page. Raises CommandError: no such page."""
        if not 0 <= page < PAGES:
            raise CommandError(f"{page} is not a page; those are 0 to {PAGES - 1}")
        self.page = page
