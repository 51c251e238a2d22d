"""Functions for the window of V-REP: its pages and views, and dialogs for files. The web viewer is that window."""

from __future__ import annotations

from typing import Any

from simx_server.handlers.objects import fitting
from simx_server.parts.user_interface.views import FloatingView
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_NAVIGATION = (
    "modes of the mouse for cameras have no effect: buttons of the mouse move the camera of a browser"
)
_FILES = "file dialogs are closed at once as if the user had cancelled; write the file's name into the script"

_ASKS_WHETHER, _ASKS_WHAT = 256, 512
"""Options of adjustView that change nothing."""

_THERE, _GONE = 2, 1
_CAMERA = 0x0040_0000
"""sim.handleflag_camera."""

_OBJECT_MODES = (0, 7, 8)
"""Modes of the mouse that do not concern the camera."""

_INDIVIDUAL, _SQUARE = 1, 2
"""Options of cameraFitToView."""


class ViewFunctions(ApiPart, effect="changes"):
    """Functions for views and dialogs for files."""

    def setNavigationMode(self, mode: int) -> int:
        """Set what the mouse does in web viewers and return 1: sim.navigation_objectshift shows arrows at the selected
        object, by which it is dragged, sim.navigation_objectrotate rings. Partly: modes for cameras have no effect,
        since each browser moves its camera by the buttons of the mouse.
        """
        if mode & 0xFF not in _OBJECT_MODES:
            self._say_once(_NAVIGATION)
        self._world.user_interface.views.set_navigation_mode(mode)
        return 1

    @reads
    def getNavigationMode(self) -> int:
        """Return the mode of the mouse that was set last, 0 at first."""
        return self._world.user_interface.views.navigation_mode

    def setPage(self, page: int) -> int:
        """Turn to a page of the window, 0 to 7, and return 1. Web viewers show its floating views, and look from the
        camera of its first view, which is the scene's first camera unless sim.adjustView chose another one.
        """
        self._world.user_interface.views.set_page(page)
        return 1

    @reads
    def getPage(self) -> int:
        """Return the page of the window."""
        return self._world.user_interface.views.page

    def adjustView(self, view: int, handle: int, options: int, label: str | None = None) -> int:
        """Show a camera, vision sensor or graph in a view, or nothing with -1, and return 1; 0 without such a view. The
        view is the handle of a floating one, or the index of one of the page; web viewers show floating ones, and look
        from the camera of view 0. Options: 64 the end of the run removes it, 256 only return whether it exists (2, else
        1), 512 only return what it shows.
        """
        views = self._world.user_interface.views
        found = views.find(view)
        if options & _ASKS_WHETHER:
            return _GONE if found is None else _THERE
        if found is None:
            return 0
        if options & _ASKS_WHAT:
            return found.shown
        views.show(view, handle if handle == -1 else self._self(handle), options, label)
        return 1

    def cameraFitToView(
        self, view: int, handles: list[int] | None = None, options: int = 0, scaling: float = 1.0
    ) -> int:
        """Move the camera of a view so that its image shows objects, or all that is visible, as large as possible, and
        return 1; 0 if the view shows no camera. `view`: as sim.adjustView, or a camera plus sim.handleflag_camera.
        Options: 1 model bases do not stand for their models, 2 the image is a square. `scaling`: of the opening angle.
        """
        views = self._world.user_interface.views
        is_camera = view >= 0 and bool(view & _CAMERA)
        found = None if is_camera else views.find(view)
        camera = view & ~_CAMERA if is_camera else -1 if found is None else found.shown
        if not is_camera and camera not in self._sim.scene.of_kind(ObjectKind.CAMERA):
            return 0
        self._sim.scene.get_kind(camera, ObjectKind.CAMERA)
        fitting.fit(
            self._world,
            camera,
            [self._self(handle) for handle in handles or ()],
            fitting.SQUARE if is_camera or options & _SQUARE else fitting.WINDOW,
            with_models=not options & _INDIVIDUAL,
            scaling=scaling,
        )
        if not is_camera:
            views.turn(view)
        return 1

    def floatingViewAdd(self, x: float, y: float, width: float, height: float, options: int) -> int:
        """Add a floating view to the page and return its handle; web viewers show it. The place of its centre and its
        size are shares of the window, 0 to 1, y from below. Option 2: it has no close button.
        """
        views = self._world.user_interface.views
        x, y, width, height = (min(max(value, 0.0), 1.0) for value in (x, y, width, height))
        new = FloatingView(x=x, y=y, width=width, height=height, add_options=options, page=views.page)
        return views.add(new)[0]

    def floatingViewRemove(self, view: int) -> int:
        """Remove a floating view and return 1, or 0 for one that does not exist."""
        if view not in self._world.user_interface.views:
            return 0
        self._world.user_interface.views.remove(view)
        return 1

    def auxFunc(self, name: str, *_values: Any) -> None:
        """Return nil. Stand-in: these functions belong to V-REP's window, such as `activateMainWindow`."""
        self._say_once(f"sim.auxFunc('{name[:80]}') does nothing here")

    def fileDialog(self, _mode: int, _title: str, _path: str, _name: str, _ending: str, _text: str) -> None:
        """Return nil, as for a dialog that the user cancels. Stand-in: a script sees no files of the server."""
        self._say_once(_FILES)
