"""``simUI``: windows that scripts make from XML. `parts/user_interface/xml_windows/reading.py` explains them."""

from __future__ import annotations

from typing import Any

from simx_server.parts.user_interface.widgets import MAX_TEXT, SHOWN, Widget
from simx_server.parts.user_interface.xml_windows.reading import read_window
from simx_server.parts.user_interface.xml_windows.windows import XmlWindow
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.targets import split_target
from simx_server.sim_api.base import ApiPart


class UiPart(ApiPart):
    """Functions of one topic of ``simUI``; `handle` is a window's, `id` a widget's in it."""

    def _window(self, handle: int) -> XmlWindow:
        return self._world.user_interface.windows.get(handle)

    def _widget(self, handle: int, id: int, *kinds: str) -> Widget:
        return self._window(handle).widget(id, *kinds)

    def _fire(self, function: str, values: tuple[Any, ...]) -> None:
        """Call a function of the script, which a `@` and a target may follow; an error is printed."""
        name, _ = split_target(function, "")
        try:
            self._world.scripts.run(self._script, name, *values)
        except ScriptError as problem:
            self._world.status_bar.add(str(problem))


class UiWindowFunctions(UiPart, effect="changes"):
    """Windows. They exist as long as the script that made them runs."""

    def create(self, xml: str) -> int:
        """Create a window from XML and return its handle. The web viewer shows it, and calls the script's functions.

        Partly: layouts, sizes and style sheets are ignored; lists of properties, 3D scenes and web pages are not shown.
        """
        window = read_window(xml)
        interpreter = self._script.interpreter
        window.is_alive = lambda: interpreter is not None and self._script.interpreter is interpreter
        window.fire = self._fire
        (handle,) = self._world.user_interface.windows.add(window)
        hidden = sorted({each.kind for each in window.widgets.values()} - {*SHOWN})
        if hidden:
            self._say_once(f"simUI: these widgets are kept and not shown: {', '.join(hidden)}")
        return handle

    def destroy(self, handle: int) -> None:
        """Remove a window."""
        self._world.user_interface.windows.remove(handle)

    def hide(self, handle: int) -> None:
        self._window(handle).is_visible = False

    def show(self, handle: int) -> None:
        self._window(handle).is_visible = True

    def isVisible(self, handle: int) -> bool:
        return self._window(handle).is_visible

    def setWindowEnabled(self, handle: int, enabled: bool) -> None:
        """Enable or disable all widgets of a window."""
        self._window(handle).is_enabled = enabled

    def isWindowEnabled(self, handle: int) -> bool:
        return self._window(handle).is_enabled

    def getTitle(self, handle: int) -> str:
        return self._window(handle).title

    def setTitle(self, handle: int, title: str, _suppress: bool = True) -> None:
        self._window(handle).title = title[:MAX_TEXT]

    def getPosition(self, handle: int) -> tuple[int, int]:
        """Return x and y in pixels. Partly: as the script has set them, 50 and 50 at first."""
        return self._window(handle).position

    def setPosition(self, handle: int, x: int, y: int, _suppress: bool = True) -> None:
        """Keep a position in pixels. Partly: the web viewer shows windows one below the other."""
        self._window(handle).position = x, y

    def getSize(self, handle: int) -> tuple[int, int]:
        """Return width and height in pixels. Partly: as the script has set them, -1 and -1 at first."""
        return self._window(handle).size

    def setSize(self, handle: int, width: int, height: int, _suppress: bool = True) -> None:
        """Keep a size in pixels. Partly: the web viewer gives windows their size."""
        self._window(handle).size = width, height

    def adjustSize(self, handle: int) -> None:
        """Do nothing to an existing window. Stand-in: the web viewer gives windows their size."""
        self._window(handle)

    def setStyleSheet(self, handle: int, id: int, _style: str) -> None:
        """Do nothing to an existing widget. Stand-in: style sheets are ignored."""
        self._widget(handle, id)
