"""Views of V-REP's window: eight pages with their views, and floating views that scripts add.

The web viewer is that window. It shows floating views as small windows, and when the main view of the page changes its
camera, all browsers look from there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind

from .registry import Registry

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

PAGES, VIEWS = 8, 10
"""Pages of V-REP's window, and most views of a page."""

_FIRST_FLOATING = 10_000
"""First handle of a floating view; smaller numbers are views of the present page, by index."""

_WITHOUT_CLOSE_BUTTON = 2
_ENDS_WITH_RUN = 64
"""Options of `sim.floatingViewAdd` and `sim.adjustView`."""

VIEWABLE = (ObjectKind.CAMERA, ObjectKind.VISION_SENSOR, ObjectKind.GRAPH)


@dataclass
class View:
    """A view of a page."""

    shown: int = -1
    """Handle of the camera, vision sensor or graph that it shows, -1 for none."""
    options: int = 0
    title: str = ""


@dataclass
class FloatingView(View):
    """A view in a small window over a page."""

    x: float = 0.5
    y: float = 0.5
    width: float = 0.2
    height: float = 0.2
    """Place of the centre and size as shares of the window; y counts from below."""
    add_options: int = 0
    page: int = 0
    handle: int = 0


class Views(Registry[FloatingView]):
    """The views of the present scene. Physics thread only."""

    KIND = "floating view"
    LIMIT = "uis"
    WAY_OUT = "remove some with sim.floatingViewRemove"

    def __init__(self, sim: Simulation) -> None:
        super().__init__(sim)
        self._next_handle = _FIRST_FLOATING
        self.page = self.navigation_mode = 0
        self._fixed: dict[tuple[int, int], View] = {}
        """Views of pages that scripts have changed, by page and index."""
        self._turns = 0

    def scene_changed(self) -> None:
        self.page = self.navigation_mode = 0
        self._fixed.clear()
        self._opened.clear()

    def run_stopped(self) -> None:
        for view in self:
            if view.options & _ENDS_WITH_RUN:
                self.remove(view.handle)

    def set_navigation_mode(self, mode: int) -> None:
        """Set what the mouse does in the web viewer: 7 shifts the selected object, 8 turns it."""
        self.navigation_mode = mode

    def set_page(self, page: int) -> None:
        """Turn to a page, and look from the camera of its main view. Raises CommandError: no such page."""
        if not 0 <= page < PAGES:
            raise CommandError(f"{page} is not a page; those are 0 to {PAGES - 1}")
        self.page = page
        self._turns += 1

    def find(self, view: int) -> View | None:
        """Return a view by the handle of a floating one or the index of one of the page; None: it does not exist."""
        if 0 <= view < VIEWS:
            return self._fixed.get((self.page, view)) or View(self._first_camera() if view == 0 else -1)
        return self._opened.get(view)

    def show(self, view: int, shown: int, options: int, title: str | None) -> None:
        """Show an object in a view, which exists.

        Args:
            view: as `find`.
            shown: a camera, vision sensor or graph; -1 for nothing.
            options: of `sim.adjustView`.
            title: None for the name of the object.

        Raises:
            UnknownHandle: no such object.
            CommandError: it cannot be shown in a view.
        """
        if shown != -1:
            item = self._sim.scene.get(shown)
            if item.kind not in VIEWABLE:
                raise CommandError(
                    f"'{item.name}', a {item.kind.text}, cannot be shown in a view; "
                    "cameras, vision sensors and graphs can"
                )
        found = self.find(view)
        if found is None:
            raise CommandError(f"no {self.KIND} with handle {view}; there are: {self.listed()}")
        found.shown, found.options, found.title = shown, options, title or ""
        if not isinstance(found, FloatingView):
            self._fixed[self.page, view] = found
            self.turn(view)

    def turn(self, view: int) -> None:
        """Let all browsers look from the camera of a view, if it is the main view of the page."""
        self._turns += view == 0

    def close_by_user(self, handle: int) -> None:
        """Close a floating view as a person does. Raises CommandError: no such view, or it has no close button."""
        if self.get(handle).add_options & _WITHOUT_CLOSE_BUTTON:
            raise CommandError(f"floating view {handle} has no close button; its program closes it")
        self.remove(handle)

    def view(self) -> dict[str, Any]:
        """Return it for the web viewer: `turns` counts when browsers are to look from the `camera`."""
        objects = self._sim.scene.objects
        main = self.find(0)
        camera = -1 if main is None else main.shown
        return {
            "camera": camera if camera in objects else -1,
            "turns": self._turns,
            "navigation": self.navigation_mode,
            "floating": [
                {
                    "handle": view.handle,
                    "title": view.title or objects[view.shown].name,
                    "shown": view.shown,
                    "kind": objects[view.shown].kind.value,
                    "place": (view.x, view.y, view.width, view.height),
                    "closeable": not view.add_options & _WITHOUT_CLOSE_BUTTON,
                }
                for view in self
                if view.page == self.page and view.shown in objects
            ],
        }

    def _first_camera(self) -> int:
        return next(iter(self._sim.scene.of_kind(ObjectKind.CAMERA)), -1)
