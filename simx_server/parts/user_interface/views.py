"""Views of V-REP's window: pages, and floating views that scripts add. They are kept, and nothing is drawn in them.

The web viewer shows the images of cameras and vision sensors without them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

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
    label: str = ""


@dataclass
class Views(Part):
    """The views of the present scene. Physics thread only."""

    sim: Simulation
    page: int = 0
    navigation_mode: int = 0
    floating: dict[int, FloatingView] = field(default_factory=dict[int, FloatingView])
    _next_handle: int = _FIRST_FLOATING

    def scene_changed(self) -> None:
        self.page = self.navigation_mode = 0
        self.floating.clear()

    def add(self, view: FloatingView) -> int:
        """Add a floating view and return its handle. Raises CommandError: there would be too many."""
        self.sim.limits.check("uis", len(self.floating) + 1, "remove some with sim.floatingViewRemove")
        handle, self._next_handle = self._next_handle, self._next_handle + 1
        self.floating[handle] = view
        return handle

    def get(self, handle: int) -> FloatingView:
        """Return a floating view. Raises CommandError that lists the existing ones."""
        view = self.floating.get(handle)
        if view is None:
            known = ", ".join(map(str, self.floating)) or "none"
            raise CommandError(f"no floating view with handle {handle}; there are: {known}")
        return view

    def remove(self, handle: int) -> None:
        """Remove a floating view. Raises CommandError: no such view."""
        self.get(handle)
        del self.floating[handle]

    def set_page(self, page: int) -> None:
        """Turn to a page. Raises CommandError: no such page."""
        if not 0 <= page < PAGES:
            raise CommandError(f"{page} is not a page; those are 0 to {PAGES - 1}")
        self.page = page
