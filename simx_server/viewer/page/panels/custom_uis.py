"""One custom UI of the legacy API as elements of the page: buttons, labels, sliders and edit boxes.

A dialog is a custom UI, too: a click on one of its buttons answers it.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import viser

from simx_client import Client
from simx_server.user_interface import ADD_ON_NAME
from simx_server.viewer.messages import ADD_ON_TYPE
from simx_server.viewer.page.link import Hands

from .elements import Latest, put

_MAX_SLIDER = 1000
_DOWN = "orange"

UI = dict[str, Any]
"""As `CustomUIs.describe` gives it."""


def operate(client: Client, function: str, *numbers: int, text: str | None = None) -> None:
    """What the mouse was in V-REP. Raises RemoteError."""
    strings = [] if text is None else [text]
    client.call(function, ADD_ON_NAME, numbers, (), strings, script_type=ADD_ON_TYPE)


def key_of(ui: UI) -> tuple[object, ...]:
    """Changes when the elements must be made anew."""
    return ui["handle"], ui["title"], tuple((each["id"], each["kind"]) for each in ui["elements"])


class Card:
    """The elements of one UI, in the container that is open when it is made."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, ui: UI) -> None:
        self._hands, self._handle = hands, int(ui["handle"])
        self._elements: dict[int, Any] = {}
        self._typed: dict[int, str] = {}
        """What people have typed and was not sent yet, by edit box."""

        self._latest: dict[int, Latest[Any]] = {}
        for element in _in_order(ui["elements"]):
            self._elements[element["id"]] = self._make(gui, element)

    def update(self, ui: UI) -> None:
        """What the program shows now; what somebody is changing is left alone."""
        for element in ui["elements"]:
            flags = element["flags"]
            shown = self._elements[element["id"]]
            is_there = not ui["rolled_up"] or "rollupaction" in flags
            is_off = "enabled" not in flags or "ignoremouse" in flags
            if element["kind"] == "label":
                put(shown, content=_text(element), visible=is_there)
                continue
            put(shown, visible=is_there, disabled=is_off)
            if element["kind"] == "button":
                is_down = "isdown" in flags
                label = (is_down and element["down_label"]) or element["label"]
                put(shown, label=label or f"button {element['id']}", color=_DOWN if is_down else None)
            elif element["kind"] == "slider":
                put(shown, label=element["label"])
                if not self._latest[element["id"]].is_held:
                    put(shown, value=element["position"])
            elif not self._latest[element["id"]].is_held and element["id"] not in self._typed:
                put(shown, value=element["label"])
        for box, text in list(self._typed.items()):
            if not self._latest[box].is_held:  # nobody has typed for a while
                self._typed.pop(box, None)
                self._hands.do(lambda client, box=box, text=text: self._type(client, {box: text}))

    def _make(self, gui: viser.GuiApi, element: dict[str, Any]) -> Any:
        number, kind = int(element["id"]), element["kind"]
        if kind == "label":
            return gui.add_html(_text(element))
        if kind == "button":
            button = gui.add_button(element["label"] or f"button {number}")
            button.on_click(lambda _: self._click(number))
            return button
        if kind == "slider":
            slider = gui.add_slider(element["label"], 0, _MAX_SLIDER, 1, element["position"])
            latest: Latest[int] = Latest(
                self._hands,
                lambda client, position: operate(client, "moveSlider", self._handle, number, position),
            )
            self._latest[number] = latest
            slider.on_update(lambda event: latest.change(event.target.value) if event.client else None)
            return slider
        box = gui.add_text("Text", element["label"])
        self._latest[number] = Latest(self._hands, lambda client, text: None)
        box.on_update(lambda event: self._note(number, event.target.value) if event.client else None)
        return box

    # --- what people do; on threads of viser's ---------------------------------------------------

    def _click(self, button: int) -> None:
        typed, self._typed = self._typed, {}

        def act(client: Client) -> None:
            self._type(client, typed)
            operate(client, "click", self._handle, button)

        self._hands.do(act)

    def _note(self, box: int, text: str) -> None:
        """A letter more: it is sent when no other has come for a while, or with the next click."""
        self._typed[box] = text
        self._latest[box].change(text)

    def _type(self, client: Client, typed: dict[int, str]) -> None:
        for box, text in typed.items():
            operate(client, "typeText", self._handle, box, text=text)


def _in_order(elements: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """By row and column if all have a place, else as they are."""
    if all(element["place"] for element in elements):
        return sorted(elements, key=lambda element: (element["place"][1], element["place"][0]))
    return list(elements)


def _text(element: dict[str, Any]) -> str:
    return (
        "<div style='padding:0 0.75em 0.5em;white-space:pre-wrap;overflow-wrap:anywhere'>"
        f"{html.escape(element['label'])}</div>"
    )
