"""The windows made from XML: what programs set and read, and what people do to them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

from .widgets import CHECKED, MAX_TEXT, Widget

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

Fire = Callable[[str, tuple[Any, ...]], None]
"""Calls a function of the script by its name, with these values."""


@dataclass(eq=False)
class Window:
    """One window. `Windows.add` sets ``handle``."""

    title: str
    is_closeable: bool = False
    events: dict[str, str] = field(default_factory=dict[str, str])
    position: tuple[int, int] = (50, 50)
    size: tuple[int, int] = (-1, -1)
    is_enabled: bool = True
    widgets: dict[int, Widget] = field(default_factory=dict[int, Widget])
    """By id, in the order of the text."""
    handle: int = 0
    is_visible: bool = True
    fire: Fire = lambda _function, _values: None
    is_alive: Callable[[], bool] = lambda: True
    """Return whether the script that made it still runs; its window goes with it."""

    def widget(self, widget_id: int, *kinds: str) -> Widget:
        """Return a widget, of one of these kinds if any are given. Raises CommandError."""
        found = self.widgets.get(widget_id)
        if found is None:
            known = ", ".join(f"{each.id} ({each.kind})" for each in self.widgets.values()) or "none"
            raise CommandError(
                f"UI {self.handle} ('{self.title}') has no widget {widget_id}; it has: {known[:2000]}"
            )
        if kinds and found.kind not in kinds:
            raise CommandError(f"widget {widget_id} is a {found.kind}, not a {' or '.join(kinds)}")
        return found

    def release_others(self, widget: Widget) -> None:
        """Release the buttons that exclude each other with one that was pressed: those in the same container."""
        if widget.kind == "radiobutton" or widget.is_exclusive:
            for other in self.widgets.values():
                is_rival = other is not widget and other.parent is widget.parent and other.kind == widget.kind
                if is_rival and (other.kind == "radiobutton" or other.is_exclusive):
                    other.value = 0

    def set_value(self, widget: Widget, value: float, *, fires: bool) -> None:
        """Set a number of a widget; `fires`: the script is told if it has changed."""
        before = widget.value
        widget.change(value)
        if widget.value and widget.kind in ("radiobutton", "button"):
            self.release_others(widget)
        if fires and widget.value != before:
            event = "on-click" if widget.kind in ("radiobutton", "button") else "on-change"
            self.tell(widget, event, *(() if event == "on-click" else (widget.value,)))

    def set_text(self, widget: Widget, text: str, *, fires: bool) -> None:
        """Set the text of a widget; `fires`: the script is told if it has changed."""
        before, widget.text = widget.text, text[:MAX_TEXT]
        if fires and widget.text != before:
            self.tell(widget, "on-change", widget.text)

    def tell(self, widget: Widget, event: str, *values: Any) -> None:
        """Call the script's function for an event of a widget, if it has one."""
        function = widget.events.get(event)
        if function is not None:
            self.fire(function, (self.handle, widget.id, *values))

    def close(self) -> None:
        """Close it as its user does: the script is asked, or the window is hidden."""
        if not self.is_closeable:
            raise CommandError(f"UI {self.handle} ('{self.title}') cannot be closed by its user")
        function = self.events.get("on-close")
        if function is None:
            self.is_visible = False
        else:
            self.fire(function, (self.handle,))

    def is_shown(self, widget: Widget) -> bool:
        """Return whether a widget is visible, with all containers, and on the present one of several tabs."""
        inner = widget
        for container in (widget, *widget.containers()):
            if not container.is_visible:
                return False
            if container.kind == "tabs" and inner.kind == "tab" and inner.place != container.value:
                return False
            inner = container
        return True

    def describe(self) -> dict[str, Any]:
        """Return it as plain data."""
        described = [
            each.describe(is_visible=self.is_shown(each))
            for each in self.widgets.values()
            if each.kind != "tab"
        ]
        return {
            "handle": self.handle,
            "title": self.title,
            "visible": self.is_visible,
            "closeable": self.is_closeable,
            "widgets": described,
        }


class Windows(Part):
    """All windows made from XML. Physics thread only."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._windows: dict[int, Window] = {}
        self._next_handle = 1

    def scene_changed(self) -> None:
        self._windows.clear()

    def add(self, window: Window) -> int:
        """Add a window and return its handle. Raises CommandError: there would be too many."""
        self._forget_the_gone()
        self._sim.limits.check("uis", len(self._windows) + 1, "remove some with simUI.destroy")
        window.handle = self._next_handle
        self._next_handle += 1
        self._windows[window.handle] = window
        return window.handle

    def get(self, handle: int) -> Window:
        """Return a window. Raises CommandError that lists the existing ones."""
        window = self._windows.get(handle)
        if window is None or not window.is_alive():
            known = ", ".join(f"{each.handle} ('{each.title}')" for each in self._windows.values()) or "none"
            raise CommandError(f"no UI with handle {handle}; there are: {known[:2000]}")
        return window

    def remove(self, handle: int) -> None:
        """Remove a window. Raises CommandError: no such window."""
        del self._windows[self.get(handle).handle]

    def describe(self) -> list[dict[str, Any]]:
        """Return every window as plain data."""
        self._forget_the_gone()
        return [window.describe() for window in self._windows.values()]

    # --- the user's side -------------------------------------------------------------------------

    def press(self, handle: int, widget_id: int) -> None:
        """Click a button, a check box or a radio button. Raises CommandError: it does not exist or cannot be used."""
        window, widget = self._operated(handle, widget_id, "button", "checkbox", "radiobutton")
        if widget.kind == "checkbox":
            window.set_value(widget, 0 if widget.value else CHECKED, fires=True)
            return
        if widget.kind == "radiobutton" or widget.is_checkable:
            is_released = widget.kind == "button" and widget.value and not widget.is_exclusive
            window.set_value(widget, 0 if is_released else 1, fires=False)
        window.tell(widget, "on-click")

    def enter(self, handle: int, widget_id: int, text: str) -> None:
        """Enter a value: a number for a slider, spin box, combo box, check box or tabs, or a text.

        Raises:
            CommandError: the widget does not exist or cannot be used, or the text is not a number.
        """
        window, widget = self._operated(handle, widget_id)
        if widget.kind in ("edit", "text-browser") and not widget.is_read_only:
            window.set_text(widget, text, fires=True)
            window.tell(widget, "on-editing-finished", widget.text)
        elif widget.kind in ("slider", "spinbox", "combobox", "checkbox", "tabs"):
            try:
                number = float(text)
            except ValueError:
                number = math.nan
            if not math.isfinite(number):
                raise CommandError(
                    f"widget {widget_id} is a {widget.kind}; its value is a number, not {text[:40]!r}"
                )
            window.set_value(widget, number, fires=True)
        else:
            raise CommandError(f"widget {widget_id} is a {widget.kind}, in which nothing can be entered")

    def close(self, handle: int) -> None:
        """Close a window as its user does. Raises CommandError."""
        self.get(handle).close()

    def _operated(self, handle: int, widget_id: int, *kinds: str) -> tuple[Window, Widget]:
        window = self.get(handle)
        widget = window.widget(widget_id, *kinds)
        if not window.is_visible or not window.is_shown(widget):
            raise CommandError(f"widget {widget_id} of UI '{window.title}' is hidden, so it cannot be used")
        if not window.is_enabled or not widget.is_usable:
            raise CommandError(f"widget {widget_id} of UI '{window.title}' cannot be used: it is not enabled")
        return window, widget

    def _forget_the_gone(self) -> None:
        self._windows = {handle: each for handle, each in self._windows.items() if each.is_alive()}
