"""Custom user interfaces: windows with buttons, sliders, labels and edit boxes, in place of V-REP's OpenGL UIs.

A program loads them and reads how they were operated; people, or clients that act for them, operate them: `click`,
`move_slider` and `type_text`. They belong to their scene; start and stop do not change them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import field
from typing import Any, NamedTuple

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.formats.texts.old_uis import FLAGS, MAX_ELEMENTS, check_property, kind_of

from .labels import plain_label
from .registry import Registry
from .widgets import Widget
from .windows import Window

MAX_EVENTS = 64
"""Most unread events of one UI; the oldest are dropped first."""

MAX_SLIDER = 1000

MAX_LABEL = 10_000
"""Most characters of a label or of typed text; longer texts are cut."""

VISIBLE = c.sim_ui_property_visible | c.sim_ui_property_moveable
"""Properties of a UI for which none are given."""

Color = tuple[float, float, float]


class Event(NamedTuple):
    """One operation: the element, its property at that time, and a slider's position or 1 down, 0 up."""

    element: int
    prop: int
    value: int


@dataclass(eq=False)
class Element(Widget):
    """A button, label, slider or edit box. Its text is the label of a button that is up, or what is in a box."""

    maximum: float = MAX_SLIDER
    prop: int = 0
    """sim_buttonproperty_ bits, checked; `set_property` sets them."""
    down_label: str = ""
    cells: list[int] | None = None
    """[column, row, columns, rows] in the grid of the UI; None: after the previous element."""
    colors: list[Color | None] = field(default_factory=lambda: [None, None, None])
    """RGB 0..1 of the background when it is up, when it is down, and of the label; None: the default of the viewer."""

    def __post_init__(self) -> None:
        self.set_property(self.prop)

    def set_property(self, prop: int) -> None:
        """Set all bits at once, including the kind."""
        self.prop, self.kind = prop, kind_of(prop)
        self.is_enabled = self.has(c.sim_buttonproperty_enabled) and not self.has(
            c.sim_buttonproperty_ignoremouse
        )

    def has(self, flag: int) -> bool:
        return bool(self.prop & flag)

    @property
    def is_down(self) -> bool:
        return self.has(c.sim_buttonproperty_isdown)

    def view(self, *, is_visible: bool) -> dict[str, Any]:
        up, down, label = self.colors
        view = super().view(is_visible=is_visible)
        if self.kind == "editbox":
            return {**view, "caption": "Text"}
        text = plain_label((self.is_down and self.down_label) or self.text)
        if self.kind == "slider":
            return {**view, "caption": text}
        if self.kind == "label":
            return {**view, "text": text, "colors": [up, label]}
        text, colors = text or f"button {self.id}", [down if self.is_down else up, None]
        return {**view, "text": text, "value": int(self.is_down), "colors": colors}

    def describe(self) -> dict[str, Any]:
        """Return it as V-REP's API describes it."""
        return {
            "id": self.id,
            "kind": self.kind,
            "flags": [name for name, bit in FLAGS.items() if self.has(bit)],
            "label": self.text,
            "down_label": self.down_label,
            "position": self.value,
            "place": self.cells,
            "colors": self.colors,
        }


@dataclass(eq=False)
class CustomUI(Window[Element]):
    """One custom UI."""

    UNKNOWN = "UI '{0.name}' has no button {1}; it has: {2}"
    OTHER_KIND = "button {1.id} of UI '{0.name}' is a {1.kind}, no {2}"

    name: str = ""
    properties: int = VISIBLE
    """sim_ui_property_ bits."""
    size: list[int] = field(default_factory=lambda: [1, 1])
    """Columns and rows."""
    events: deque[Event] = field(default_factory=lambda: deque(maxlen=MAX_EVENTS))
    on_click: Callable[[int], None] = lambda _button: None
    """Function called with the id of a button that was clicked."""
    is_running: Callable[[], bool] = lambda: False
    """Return whether a simulation runs."""

    @property
    def is_open(self) -> bool:
        """Return whether it was neither closed by a button with the close action nor hidden by its program, whose
        functions work in any case.
        """
        return bool(self.properties & c.sim_ui_property_visible)

    @property
    def is_there(self) -> bool:
        needs_run = self.properties & c.sim_ui_property_visibleduringsimulationonly
        return self.is_open and (not needs_run or self.is_running())

    @property
    def is_rolled_up(self) -> bool:
        return bool(self.properties & c.sim_ui_property_rolledup)

    def is_shown(self, widget: Element) -> bool:
        is_left_out = self.is_rolled_up and not widget.has(c.sim_buttonproperty_rollupaction)
        return not is_left_out and (widget.kind != "label" or bool(widget.text))

    def view(self) -> dict[str, Any]:
        """Return it as plain data: its elements by row and column if all have a position, else as they are."""
        view, cells = super().view(), [each.cells for each in self.widgets.values()]
        places = [(each[1], each[0]) for each in cells if each]
        if len(places) == len(cells):
            order = sorted(range(len(cells)), key=places.__getitem__)
            view["widgets"] = [view["widgets"][index] for index in order]
        return {**view, "name": self.name}

    def describe(self) -> dict[str, Any]:
        """Return it as V-REP's API describes it."""
        return {
            "handle": self.handle,
            "name": self.name,
            "title": self.title,
            "visible": self.is_there,
            "rolled_up": self.is_rolled_up,
            "elements": [each.describe() for each in self.widgets.values()],
        }

    def add_element(self, prop: int, cells: list[int]) -> int:
        """Add an element and return its id, the first that is free.

        Raises:
            CommandError: no such property, or too many elements.
        """
        check_property(prop)
        if len(self.widgets) >= MAX_ELEMENTS:
            raise CommandError(f"UI '{self.name}' has {MAX_ELEMENTS} buttons already; a UI cannot have more")
        number = next(each for each in range(len(self.widgets) + 1) if each not in self.widgets)
        self.widgets[number] = Element(number, prop=prop, cells=cells)
        return number

    # --- the user's side -------------------------------------------------------------------------

    def click(self, number: int) -> None:
        """Press and release a button; one with the staydown property goes down, or up again.

        Raises:
            CommandError: no such button, or it cannot be used now.
        """
        button = self._operated(number, "button")
        if button.has(c.sim_buttonproperty_staydown):
            button.prop ^= c.sim_buttonproperty_isdown
            self._note(button, int(button.is_down))
        else:
            self._note(button, 1)
            if button.has(c.sim_buttonproperty_downupevent):
                self._note(button, 0)
        if button.has(c.sim_buttonproperty_rollupaction):
            self.properties ^= c.sim_ui_property_rolledup
        if button.has(c.sim_buttonproperty_closeaction):
            self.properties &= ~c.sim_ui_property_visible
        self.on_click(number)

    def move_slider(self, number: int, position: int) -> None:
        """Move a slider. Raises CommandError: no such slider, or it cannot be used now."""
        slider = self._operated(number, "slider")
        slider.change(position)
        self._note(slider, int(slider.value))

    def type_text(self, number: int, text: str) -> None:
        """Replace the text of an edit box. Raises CommandError: no such box, or it cannot be used now."""
        box = self._operated(number, "editbox")
        box.text = text[:MAX_LABEL]
        self._note(box, 0)

    def _note(self, element: Element, value: int) -> None:
        self.events.append(Event(element.id, element.prop, value))

    def _operated(self, number: int, kind: str) -> Element:
        element = self.widget(number, kind)
        if not self.is_open:
            raise CommandError(f"UI '{self.name}' is closed, so nothing on it can be used")
        if not self.is_there:
            raise CommandError(f"UI '{self.name}' is there only during a simulation; start it first")
        if not element.is_enabled:
            raise CommandError(f"{kind} {number} of UI '{self.name}' cannot be used: it is not enabled")
        return element


class CustomUIs(Registry[CustomUI]):
    """All custom UIs. Physics thread only."""

    KIND = "custom UI"
    LIMIT = "uis"
    WAY_OUT = "remove some with simxRemoveUI"

    def scene_changed(self) -> None:
        self._opened.clear()

    def _prepare(self, new: CustomUI) -> None:
        """Give it a name that is free: one that is taken gets a suffix #0, #1, ..."""
        taken = {ui.name for ui in self}
        candidate, number = new.name, 0
        while candidate in taken:
            candidate, number = f"{new.name}#{number}", number + 1
        new.name, new.is_running = candidate, lambda: self._sim.is_running

    def find(self, name: str) -> int:
        """Return the handle of the UI with this name. Raises CommandError that lists the existing UIs."""
        for ui in self:
            if ui.name == name:
                return ui.handle
        raise CommandError(f"no custom UI named '{name}'; there are: {self.listed()}")

    def listed(self) -> str:
        return ", ".join(f"{ui.handle} ('{ui.name}')" for ui in self) or "none"
