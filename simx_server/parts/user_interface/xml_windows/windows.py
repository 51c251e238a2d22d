"""The windows made from XML: what programs set and read, and what people do to them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import field
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from ..registry import Registry
from ..widgets import CHECKED, MAX_TEXT, Widget
from ..windows import Window

Fire = Callable[[str, tuple[Any, ...]], None]
"""Calls a function of the script by its name, with these values."""


@dataclass(eq=False)
class XmlWindow(Window[Widget]):
    """One window of a script."""

    UNKNOWN = "UI {0.handle} ('{0.title}') has no widget {1}; it has: {2:.2000}"
    OTHER_KIND = "widget {1.id} is a {1.kind}, not a {2}"

    events: dict[str, str] = field(default_factory=dict[str, str])
    """Name of the script's function by event: `on-close`."""
    size: tuple[int, int] = (-1, -1)
    is_enabled: bool = True
    is_visible: bool = True
    fire: Fire = lambda _function, _values: None
    is_alive: Callable[[], bool] = lambda: True
    """Return whether the script that made it still runs; its window goes with it."""

    @property
    def is_there(self) -> bool:
        return self.is_visible

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

    # --- the user's side -------------------------------------------------------------------------

    def press(self, number: int) -> None:
        """Click a button, a check box or a radio button. Raises CommandError: it does not exist or cannot be used."""
        widget = self._operated(number, "button", "checkbox", "radiobutton")
        if widget.kind == "checkbox":
            self.set_value(widget, 0 if widget.value else CHECKED, fires=True)
            return
        if widget.kind == "radiobutton" or widget.is_checkable:
            is_released = widget.kind == "button" and widget.value and not widget.is_exclusive
            self.set_value(widget, 0 if is_released else 1, fires=False)
        self.tell(widget, "on-click")

    def enter(self, number: int, text: str) -> None:
        """Enter a value: a number for a slider, spin box, combo box, check box or tabs, or a text.

        Raises:
            CommandError: the widget does not exist or cannot be used, or the text is not a number.
        """
        widget = self._operated(number)
        if widget.kind in ("edit", "text-browser") and not widget.is_read_only:
            self.set_text(widget, text, fires=True)
            self.tell(widget, "on-editing-finished", widget.text)
        elif widget.kind in ("slider", "spinbox", "combobox", "checkbox", "tabs"):
            try:
                value = float(text)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise CommandError(
                    f"widget {number} is a {widget.kind}; its value is a number, not {text[:40]!r}"
                )
            self.set_value(widget, value, fires=True)
        else:
            raise CommandError(f"widget {number} is a {widget.kind}, in which nothing can be entered")

    def close(self) -> None:
        """Close it as its user does: the script is asked, or the window is hidden. Raises CommandError."""
        if not self.is_closeable:
            raise CommandError(f"UI {self.handle} ('{self.title}') cannot be closed by its user")
        function = self.events.get("on-close")
        if function is None:
            self.is_visible = False
        else:
            self.fire(function, (self.handle,))

    def _operated(self, number: int, *kinds: str) -> Widget:
        widget = self.widget(number, *kinds)
        if not self.is_visible or not self.is_shown(widget):
            raise CommandError(f"widget {number} of UI '{self.title}' is hidden, so it cannot be used")
        if not self.is_enabled or not widget.is_usable:
            raise CommandError(f"widget {number} of UI '{self.title}' cannot be used: it is not enabled")
        return widget


class XmlWindows(Registry[XmlWindow]):
    """All windows made from XML. Physics thread only."""

    KIND = "UI"
    LIMIT = "uis"
    WAY_OUT = "remove some with simUI.destroy"

    def scene_changed(self) -> None:
        self._opened.clear()

    def add(self, *new: XmlWindow) -> list[int]:
        self.forget_the_gone()
        return super().add(*new)

    def _is_alive(self, opened: XmlWindow) -> bool:
        return opened.is_alive()

    def listed(self) -> str:
        return super().listed()[:2000]

    def forget_the_gone(self) -> None:
        """Remove windows whose scripts have ended."""
        self._opened = {handle: each for handle, each in self._opened.items() if each.is_alive()}
