"""Custom user interfaces: windows with buttons, sliders, labels and edit boxes, in place of V-REP's OpenGL UIs.

A program loads them and reads how they were operated; people, or clients that act for them, operate them: `click`,
`move_slider` and `type_text`. They belong to their scene; start and stop do not change them.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.formats.texts.old_uis import (
    FLAGS,
    MAX_ELEMENTS,
    MAX_PROPERTIES,
    check_property,
    kind_of,
)
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

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


@dataclass
class Element:
    """A button, label, slider or edit box; ``prop`` consists of the sim_buttonproperty bits."""

    id: int
    prop: int
    label: str = ""
    """Label of a button that is up; an edit box keeps its text here."""
    down_label: str = ""
    position: int = 0
    """Position of a slider, 0..1000."""
    place: list[int] | None = None
    """[column, row, columns, rows] in the grid of the UI; None: after the previous element."""
    colors: list[Color | None] = field(default_factory=lambda: [None, None, None])
    """RGB 0..1 of the background when it is up, when it is down, and of the label; None: the default of the viewer."""

    @property
    def kind(self) -> str:
        return kind_of(self.prop)

    def has(self, flag: int) -> bool:
        return bool(self.prop & flag)


@dataclass
class CustomUI:
    """One window. `CustomUIs.add` sets ``handle``."""

    name: str
    title: str
    elements: dict[int, Element]
    handle: int = 0
    properties: int = VISIBLE
    """sim_ui_property_ bits."""
    size: tuple[int, int] = (1, 1)
    """Columns and rows."""
    position: tuple[int, int] = (0, 0)
    """In pixels; kept for the program."""
    events: deque[Event] = field(default_factory=lambda: deque(maxlen=MAX_EVENTS))
    on_click: Callable[[int], None] | None = None
    """Function called with the id of a button that was clicked."""

    @property
    def is_open(self) -> bool:
        """Return whether it was neither closed by a button with the close action nor hidden by its program, whose
        functions work in any case.
        """
        return bool(self.properties & c.sim_ui_property_visible)

    @property
    def is_rolled_up(self) -> bool:
        return bool(self.properties & c.sim_ui_property_rolledup)

    def is_shown(self, *, is_running: bool) -> bool:
        """Return whether people can see and use it now."""
        return self.is_open and (
            is_running or not self.properties & c.sim_ui_property_visibleduringsimulationonly
        )

    def element(self, element_id: int, *kinds: str) -> Element:
        """Return an element, of one of these kinds if any are given. Raises CommandError."""
        element = self.elements.get(element_id)
        if element is None:
            listed = ", ".join(f"{each.id} ({each.kind})" for each in self.elements.values()) or "none"
            raise CommandError(f"UI '{self.name}' has no button {element_id}; it has: {listed}")
        if kinds and element.kind not in kinds:
            raise CommandError(f"button {element_id} of UI '{self.name}' is a {element.kind}, no {kinds[0]}")
        return element


class CustomUIs(Part):
    """All custom UIs. Physics thread only."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._uis: dict[int, CustomUI] = {}
        self._next_handle = 1

    def scene_changed(self) -> None:
        self._uis.clear()

    def __iter__(self) -> Iterator[CustomUI]:
        return iter(tuple(self._uis.values()))

    def __len__(self) -> int:
        return len(self._uis)

    # --- the program's side ----------------------------------------------------------------------

    def add(self, *uis: CustomUI) -> list[int]:
        """Add UIs, all or none, and return their handles; a name that is taken gets a suffix #0, #1, ...

        Raises:
            CommandError: there would be too many.
        """
        self._sim.limits.check("uis", len(self._uis) + len(uis), "remove some with simxRemoveUI")
        for ui in uis:
            ui.name = self._free_name(ui.name)
            ui.handle = self._next_handle
            self._next_handle += 1
            self._uis[ui.handle] = ui
        return [ui.handle for ui in uis]

    def remove(self, handle: int) -> None:
        """Remove a UI. Raises CommandError: no such UI."""
        del self._uis[self.get(handle).handle]

    def get(self, handle: int) -> CustomUI:
        """Return a UI. Raises CommandError that lists the existing UIs."""
        ui = self._uis.get(handle)
        if ui is None:
            raise CommandError(f"no custom UI with handle {handle}; there are: {self._list()}")
        return ui

    def find(self, name: str) -> int:
        """Return the handle of the UI with this name. Raises CommandError that lists the existing UIs."""
        for ui in self._uis.values():
            if ui.name == name:
                return ui.handle
        raise CommandError(f"no custom UI named '{name}'; there are: {self._list()}")

    def slider(self, handle: int, element_id: int) -> int:
        """Return a slider's position, 0..1000. Raises CommandError."""
        return self.get(handle).element(element_id, "slider").position

    def set_slider(self, handle: int, element_id: int, position: int) -> None:
        """Set a slider's position, clipped to 0..1000, without an event. Raises CommandError."""
        self.get(handle).element(element_id, "slider").position = min(max(position, 0), MAX_SLIDER)

    def set_property(self, handle: int, element_id: int, prop: int) -> None:
        """Set all property bits at once, including the kind. Raises CommandError."""
        element = self.get(handle).element(element_id)
        check_property(prop)
        element.prop = prop

    def set_properties(self, handle: int, properties: int) -> None:
        """Set all sim_ui_property_ bits of a UI. Raises CommandError."""
        if not 0 <= properties <= MAX_PROPERTIES:
            raise CommandError(f"{properties} is not made of the sim_ui_property_ bits")
        self.get(handle).properties = properties

    def add_element(self, handle: int, prop: int, place: list[int]) -> int:
        """Add an element to a UI and return its id, the first that is free.

        Raises:
            CommandError: no such UI, no such property, or too many elements.
        """
        ui = self.get(handle)
        check_property(prop)
        if len(ui.elements) >= MAX_ELEMENTS:
            raise CommandError(f"UI '{ui.name}' has {MAX_ELEMENTS} buttons already; a UI cannot have more")
        number = next(each for each in range(len(ui.elements) + 1) if each not in ui.elements)
        ui.elements[number] = Element(number, prop, place=place)
        return number

    def set_colors(self, handle: int, element_id: int, colors: list[Color | None]) -> None:
        """Set the colours of an element that are not None, in the order of `Element.colors`. Raises CommandError."""
        element = self.get(handle).element(element_id)
        element.colors = [new or old for new, old in zip(colors, element.colors, strict=True)]

    def set_label(self, handle: int, element_id: int, up: str | None, down: str | None) -> None:
        """Set the labels of an element; None leaves one as it is. Raises CommandError."""
        element = self.get(handle).element(element_id)
        if up is not None:
            element.label = up[:MAX_LABEL]
        if down is not None:
            element.down_label = down[:MAX_LABEL]

    def take_event(self, handle: int) -> Event | None:
        """Return the oldest unread event and remove it; None without events or for an unknown UI (as V-REP)."""
        ui = self._uis.get(handle)
        return ui.events.popleft() if ui is not None and ui.events else None

    # --- the user's side -------------------------------------------------------------------------

    def click(self, handle: int, element_id: int) -> None:
        """Press and release a button; one with the staydown property goes down, or up again.

        Raises:
            CommandError: no such button, or it cannot be used now.
        """
        ui, button = self._operated(handle, element_id, "button")
        if button.has(c.sim_buttonproperty_staydown):
            button.prop ^= c.sim_buttonproperty_isdown
            ui.events.append(Event(button.id, button.prop, int(button.has(c.sim_buttonproperty_isdown))))
        else:
            ui.events.append(Event(button.id, button.prop, 1))
            if button.has(c.sim_buttonproperty_downupevent):
                ui.events.append(Event(button.id, button.prop, 0))
        if button.has(c.sim_buttonproperty_rollupaction):
            ui.properties ^= c.sim_ui_property_rolledup
        if button.has(c.sim_buttonproperty_closeaction):
            ui.properties &= ~c.sim_ui_property_visible
        if ui.on_click is not None:
            ui.on_click(button.id)

    def move_slider(self, handle: int, element_id: int, position: int) -> None:
        """Move a slider. Raises CommandError: no such slider, or it cannot be used now."""
        ui, slider = self._operated(handle, element_id, "slider")
        slider.position = min(max(position, 0), MAX_SLIDER)
        ui.events.append(Event(slider.id, slider.prop, slider.position))

    def type_text(self, handle: int, element_id: int, text: str) -> None:
        """Replace the text of an edit box. Raises CommandError: no such box, or it cannot be used now."""
        ui, box = self._operated(handle, element_id, "editbox")
        box.label = text[:MAX_LABEL]
        ui.events.append(Event(box.id, box.prop, 0))

    def describe(self) -> list[dict[str, Any]]:
        """Return every UI as plain data, in the order of their handles."""
        return [
            {
                "handle": ui.handle,
                "name": ui.name,
                "title": ui.title,
                "visible": ui.is_shown(is_running=self._sim.is_running),
                "rolled_up": ui.is_rolled_up,
                "elements": [
                    {
                        "id": element.id,
                        "kind": element.kind,
                        "flags": [name for name, bit in FLAGS.items() if element.has(bit)],
                        "label": element.label,
                        "down_label": element.down_label,
                        "position": element.position,
                        "place": element.place,
                        "colors": element.colors,
                    }
                    for element in ui.elements.values()
                ],
            }
            for ui in self._uis.values()
        ]

    def _operated(self, handle: int, element_id: int, kind: str) -> tuple[CustomUI, Element]:
        ui = self.get(handle)
        element = ui.element(element_id, kind)
        if not ui.is_open:
            raise CommandError(f"UI '{ui.name}' is closed, so nothing on it can be used")
        if not ui.is_shown(is_running=self._sim.is_running):
            raise CommandError(f"UI '{ui.name}' is there only during a simulation; start it first")
        if not element.has(c.sim_buttonproperty_enabled) or element.has(c.sim_buttonproperty_ignoremouse):
            raise CommandError(f"{kind} {element_id} of UI '{ui.name}' cannot be used: it is not enabled")
        return ui, element

    def _free_name(self, name: str) -> str:
        taken = {ui.name for ui in self._uis.values()}
        candidate, number = name, 0
        while candidate in taken:
            candidate, number = f"{name}#{number}", number + 1
        return candidate

    def _list(self) -> str:
        return ", ".join(f"{ui.handle} ('{ui.name}')" for ui in self._uis.values()) or "none"
