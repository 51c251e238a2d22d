"""Functions that act on the window of V-REP, which this server does not have: their values are kept."""

from __future__ import annotations

from typing import Any

from simx_server.parts.user_interface.views import FloatingView
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_FLOATING = (
    "views of V-REP's window are kept and not drawn; the web viewer (--view) shows cameras and sensors"
)
_NAVIGATION = "the navigation mode and page of V-REP's window are kept and have no effect"
_FILES = "file dialogs are closed at once as if the user had cancelled; write the file's name into the script"
_EDITORS = (
    "text editors return their text unchanged; sim.displayDialog with sim.dlgstyle_input asks for a text"
)

_LAST_FIXED = 9
"""Greatest index of a view on a page."""


class ViewFunctions(ApiPart, effect="changes"):
    """Functions for views, dialogs for files, and text editors."""

    def setNavigationMode(self, mode: int) -> int:
        """Keep the mode of the mouse and return 1. Stand-in: a web viewer is moved by the person who looks at it."""
        self._say_once(_NAVIGATION)
        self._world.user_interface.views.set_navigation_mode(mode)
        return 1

    @reads
    def getNavigationMode(self) -> int:
        """Return the mode of the mouse. Stand-in: it is the mode that a script has set, 0 at first."""
        return self._world.user_interface.views.navigation_mode

    def setPage(self, page: int) -> int:
        """Keep the page of the window, 0 to 7, and return 1. Stand-in: no page is shown."""
        self._say_once(_NAVIGATION)
        self._world.user_interface.views.set_page(page)
        return 1

    @reads
    def getPage(self) -> int:
        """Return the page of the window. Stand-in: it is the page that a script has set, 0 at first."""
        return self._world.user_interface.views.page

    def adjustView(self, view: int, handle: int, _options: int, label: str | None = None) -> int:
        """Keep which object a view shows, and return 1, or 0 for a view that does not exist. The view is the handle
        of a floating one, or the index of one of the page; bit 8 of the options only asks whether it exists.

        Stand-in: nothing is drawn in the view.
        """
        self._say_once(_FLOATING)
        if 0 <= view <= _LAST_FIXED:
            return 1
        views = self._world.user_interface.views
        if view not in views:
            return 0
        if not _options & 256:
            found = views.get(view)
            found.shown = -1 if handle == -1 else self._sim.scene.get(self._self(handle)).handle
            found.title = label or ""
        return 1

    def cameraFitToView(self, _view: int, _handles: list[int] | None = None, *_options: Any) -> int:
        """Return 1. Stand-in: cameras keep their places."""
        self._say_once(_FLOATING)
        return 1

    def floatingViewAdd(self, x: float, y: float, width: float, height: float, options: int) -> int:
        """Add a floating view and return its handle. Place and size are shares of the window, 0 to 1.

        Stand-in: nothing is drawn in the view.
        """
        self._say_once(_FLOATING)
        return self._world.user_interface.views.add(FloatingView(x, y, width, height, options))[0]

    def floatingViewRemove(self, view: int) -> int:
        """Remove a floating view and return 1, or 0 for one that does not exist. Stand-in: nothing was drawn in it."""
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

    def textEditorOpen(self, text: str = "", _properties: str | None = None) -> str:
        """Return the text. Stand-in: the text stays as it is."""
        self._say_once(_EDITORS)
        return text

    def openTextEditor(self, _text: str, _properties: str | None = None, _callback: str | None = None) -> int:
        """Return -1, for an editor that could not be opened. Stand-in: the server has no editor."""
        self._say_once(_EDITORS)
        return -1
