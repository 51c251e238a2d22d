"""One custom UI of the legacy API as elements of the web viewer: buttons, labels, sliders and edit boxes.

A dialog is a custom UI, too: a click on one of its buttons answers it.
"""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from typing import Any

import viser

from simx_client import Client
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.parts.user_interface import ADD_ON_NAME
from simx_server.viewer.page.link import Hands

from .elements import Latest, put

_MAX_SLIDER = 1000
_DOWN = "orange"

_COMMANDS = re.compile(r"&&(?:[fb]g\d{3}|(?P<symbol>n|[A-Z][A-Za-z]*))")
"""Commands in a label or text of V-REP: colours of its front and back, symbols, and the end of a line."""

_SYMBOLS = {
    "ArrowDown": "▼",
    "ArrowLeft": "◀",
    "ArrowRight": "▶",
    "ArrowUp": "▲",
    "Box": "■",
    "Check": "✓",
    "Circle": "●",
    "Cross": "✕",
    "Minimize": "–",
    "Minus": "−",
    "Pause": "||",
    "Plus": "+",
    "Square": "□",
    "n": "\n",
}

UI = dict[str, Any]
"""The form that `CustomUIs.describe` returns."""


def operate(client: Client, function: str, *numbers: int, text: str | None = None) -> None:
    """Send an action of the mouse in V-REP's UI. Raises RemoteError."""
    strings = [] if text is None else [text]
    client.call(function, ADD_ON_NAME, numbers, (), strings, script_type=ADD_ON_TYPE)


def key_of(ui: UI) -> tuple[object, ...]:
    """Return a key that changes when the elements must be made again."""
    return ui["handle"], ui["title"], tuple((each["id"], each["kind"]) for each in ui["elements"])


class Card:
    """The elements of one UI, in the container that is open when it is made."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, ui: UI) -> None:
        self._hands, self._handle = hands, int(ui["handle"])
        self._elements: dict[int, Any] = {}
        self._texts: dict[int, str] = {}
        """The server's text of each edit box."""

        self._latest: dict[int, Latest[Any]] = {}
        for element in _in_order(ui["elements"]):
            self._elements[element["id"]] = self._make(gui, element)

    def update(self, ui: UI) -> None:
        """Show the program's present values; an element that a user is changing stays as it is."""
        for element in ui["elements"]:
            flags = element["flags"]
            shown = self._elements[element["id"]]
            is_there = not ui["rolled_up"] or "rollupaction" in flags
            is_off = "enabled" not in flags or "ignoremouse" in flags
            if element["kind"] == "label":
                put(shown, content=_text(element), visible=is_there and bool(element["label"]))
                continue
            put(shown, visible=is_there, disabled=is_off)
            if element["kind"] == "button":
                is_down = "isdown" in flags
                label = plain_label((is_down and element["down_label"]) or element["label"])
                put(
                    shown, label=label or f"button {element['id']}", color=_color_of(element, is_down=is_down)
                )
            elif element["kind"] == "slider":
                put(shown, label=plain_label(element["label"]))
                if not self._latest[element["id"]].is_held:
                    put(shown, value=element["position"])
            else:
                self._update_box(element["id"], shown, element["label"])

    def _update_box(self, box: int, shown: viser.GuiTextHandle, text: str) -> None:
        """Send typed text after a pause in typing; otherwise show the text that the program has set."""
        latest = self._latest[box]
        if latest.is_held:
            return
        if shown.value != self._texts[box]:
            latest.hold()  # until the server returns the new text
            self._hands.do(self._type)
            return
        put(shown, value=text)  # first: a click may send a difference meanwhile
        self._texts[box] = text

    def _make(self, gui: viser.GuiApi, element: dict[str, Any]) -> Any:
        number, kind = int(element["id"]), element["kind"]
        if kind == "label":
            return gui.add_html(_text(element))
        if kind == "button":
            button = gui.add_button(plain_label(element["label"]) or f"button {number}")
            button.on_click(lambda _: self._click(number))
            return button
        if kind == "slider":
            slider = gui.add_slider(plain_label(element["label"]), 0, _MAX_SLIDER, 1, element["position"])
            latest: Latest[int] = Latest(
                self._hands,
                lambda client, position: operate(client, "moveSlider", self._handle, number, position),
            )
            self._latest[number] = latest
            slider.on_update(lambda event: latest.change(event.target.value) if event.client else None)
            return slider
        box = gui.add_text("Text", element["label"])
        self._texts[number] = element["label"]
        typing: Latest[None] = Latest(self._hands, lambda client, _: self._type(client))
        self._latest[number] = typing
        box.on_update(lambda event: typing.hold() if event.client else None)
        return box

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _click(self, button: int) -> None:
        def act(client: Client) -> None:
            self._type(client)
            operate(client, "click", self._handle, button)

        self._hands.do(act)

    def _type(self, client: Client) -> None:
        """Send the texts of the edit boxes that the server does not have."""
        for box, known in self._texts.items():
            text = self._elements[box].value
            if text != known:
                self._texts[box] = text
                operate(client, "typeText", self._handle, box, text=text)


def _in_order(elements: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the elements by row and column if all have a position, else as they are."""
    if all(element["place"] for element in elements):
        return sorted(elements, key=lambda element: (element["place"][1], element["place"][0]))
    return list(elements)


def plain_label(label: str) -> str:
    """Return a label of V-REP as text: its symbols as letters, without its commands for colours."""
    return _COMMANDS.sub(lambda found: _SYMBOLS.get(found["symbol"] or "", found["symbol"] or ""), label)


def _color_of(element: dict[str, Any], *, is_down: bool) -> str | tuple[int, int, int] | None:
    """Return the colour of a button: the program's, else that of a button which is down, else the default."""
    up, down, _ = element["colors"]
    given = down if is_down else up
    return _bytes(given) if given is not None else _DOWN if is_down else None


def _text(element: dict[str, Any]) -> str:
    up, _, text = element["colors"]
    style = "padding:0 0.75em 0.5em;white-space:pre-wrap;overflow-wrap:anywhere;"
    if up is not None and text is not None:
        style += f"background-color:rgb{_bytes(up)};color:rgb{_bytes(text)};"
    return f"<div style='{style}'>{html.escape(plain_label(element['label']))}</div>"


def _bytes(color: Sequence[float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in color)
    return red, green, blue
