"""One window that a program shows, as elements of the web viewer: a custom UI, a dialog, or a window made from XML.

3D scenes, web pages and the like are left out: the server keeps them for the script, and sends nothing of them.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import viser

from simx_client import Client
from simx_server.parts.add_ons import ADD_ON_TYPE
from simx_server.parts.user_interface.add_on import ADD_ON_NAME
from simx_server.parts.user_interface.interface import CUSTOM
from simx_server.viewer.page.link import Hands

from .elements import Latest, put
from .plot_drawing import as_svg

WindowView = dict[str, Any]
"""The form that `Window.view` returns, with the keys that `UserInterface.view` adds."""

_Widget = dict[str, Any]
_Show = Callable[[_Widget], None]
"""Shows the state of a widget in its element."""

_CHECKED = 2
_PRESSED = "orange"
_NONE = "(none)"
_MOST_ROWS, _MOST_COLUMNS = 50, 20
_CELL = "padding:0.1em 0.5em;border:1px solid rgba(128,128,128,0.4)"
_TEXT = "padding:0 0.75em 0.5em;white-space:pre-wrap;overflow-wrap:anywhere"


class _Shown:
    """A widget on the page."""

    def __init__(self, element: Any, show: _Show, latest: Latest[str] | None = None) -> None:
        self.element, self.show, self.latest = element, show, latest


def operate(client: Client, function: str, *numbers: int, text: str | None = None) -> None:
    """Send an action of the mouse in V-REP's UI. Raises RemoteError."""
    strings = [] if text is None else [text]
    client.call(function, ADD_ON_NAME, numbers, (), strings, script_type=ADD_ON_TYPE)


def key_of(window: WindowView) -> tuple[object, ...]:
    """Return a key that changes when the elements must be made again."""
    widgets = tuple(
        (
            *(each["id"], each["kind"], each["minimum"], each["maximum"], each["step"], tuple(each["items"])),
            each["kind"] == "text-browser" and each["enabled"],
        )
        for each in window["widgets"]
    )
    return window["title"], window["closeable"], widgets


class Card:
    """The widgets of one window, in the container that is open when it is made."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, window: WindowView) -> None:
        self._gui, self._hands, self._handle = gui, hands, int(window["handle"])
        self._is_custom = window["api"] == CUSTOM
        self._typed: dict[int, str] = {}
        """The server's text of each box whose text is sent after a pause in typing."""
        self._shown: dict[int, _Shown] = {}
        for widget in window["widgets"]:
            made = self._make(widget)
            if made is not None:
                self._shown[widget["id"]] = made
        if window["closeable"]:
            close = gui.add_button("Close", icon=viser.Icon.X)
            close.on_click(lambda _: hands.do(lambda client: operate(client, "closeWindow", self._handle)))

    def update(self, window: WindowView) -> None:
        """Show the program's present values; a widget that a user is changing stays as it is."""
        for widget in window["widgets"]:
            shown = self._shown.get(widget["id"])
            if shown is not None:
                put(shown.element, visible=widget["visible"])
                if shown.latest is None or not shown.latest.is_held:
                    shown.show(widget)
                    if hasattr(shown.element, "disabled"):
                        put(shown.element, disabled=not widget["enabled"])

    # --- widgets ---------------------------------------------------------------------------------

    def _make(self, widget: _Widget) -> _Shown | None:
        makers = {
            "label": self._label,
            "text-browser": self._text_browser,
            "table": self._label,
            "plot": self._label,
            "tree": self._label,
            "image": self._label,
            "svg": self._label,
            "button": self._button,
            "radiobutton": self._button,
            "checkbox": self._checkbox,
            "slider": self._slider,
            "spinbox": self._spinbox,
            "combobox": self._choice,
            "tabs": self._choice,
            "edit": self._edit,
            "editbox": self._edit_box,
            "progressbar": self._progress,
        }
        maker = makers.get(widget["kind"])
        return None if maker is None else maker(widget)

    def _label(self, widget: _Widget) -> _Shown:
        content = _CONTENTS.get(widget["kind"], _as_text)
        label = self._gui.add_html(content(widget))
        return _Shown(label, lambda each: put(label, content=content(each)))

    def _button(self, widget: _Widget) -> _Shown:
        number = int(widget["id"])
        button = self._gui.add_button(widget["text"] or " ")
        button.on_click(lambda _: self._hands.do(lambda client: self._press(client, number)))

        def show(each: _Widget) -> None:
            mark = ("◉ " if each["value"] else "○ ") if each["kind"] == "radiobutton" else ""
            given = each.get("colors", [None])[0]
            color = _bytes(given) if given else _PRESSED if each["value"] and not mark else None
            put(button, label=(mark + each["text"]) or " ", color=color)

        return _Shown(button, show)

    def _checkbox(self, widget: _Widget) -> _Shown:
        box = self._gui.add_checkbox(widget["text"], bool(widget["value"]))
        latest = self._entering(widget, box, lambda checked: str(_CHECKED * checked))
        return _Shown(box, lambda each: put(box, label=each["text"], value=bool(each["value"])), latest)

    def _slider(self, widget: _Widget) -> _Shown:
        low, high = int(widget["minimum"]), int(widget["maximum"])
        # viser refuses a slider that cannot move.
        slider = self._gui.add_slider(_caption(widget), low, max(high, low + 1), 1, int(widget["value"]))
        latest = self._entering(widget, slider)
        return _Shown(
            slider, lambda each: put(slider, label=_caption(each), value=int(each["value"])), latest
        )

    def _spinbox(self, widget: _Widget) -> _Shown:
        low, high, step = widget["minimum"], widget["maximum"], widget["step"]
        box = self._gui.add_number(
            "", float(widget["value"]), min=float(low), max=float(high), step=float(step) or None
        )
        latest = self._entering(widget, box, repr)
        return _Shown(box, lambda each: put(box, value=float(each["value"])), latest)

    def _choice(self, widget: _Widget) -> _Shown | None:
        items = _distinct(widget["items"])
        if not items:
            return None
        options = [*items, _NONE]
        box = self._gui.add_dropdown("Tab" if widget["kind"] == "tabs" else "", options)
        latest = self._entering(widget, box, lambda item: None if item == _NONE else str(items.index(item)))
        return _Shown(box, lambda each: put(box, value=options[int(each["value"])]), latest)

    def _edit(self, widget: _Widget) -> _Shown:
        box = self._gui.add_text("", widget["text"])
        latest = self._entering(widget, box)
        return _Shown(box, lambda each: put(box, value=each["text"]), latest)

    def _text_browser(self, widget: _Widget) -> _Shown:
        if not widget["enabled"]:
            return self._label(widget)
        box = self._gui.add_text("", widget["text"], multiline=True)
        latest = self._entering(widget, box)
        return _Shown(box, lambda each: put(box, value=each["text"]), latest)

    def _edit_box(self, widget: _Widget) -> _Shown:
        """Make a box whose text is sent after a pause in typing, or with a click on a button."""
        number = int(widget["id"])
        box = self._gui.add_text(_caption(widget), widget["text"])
        self._typed[number] = widget["text"]
        latest = Latest[str](self._hands, lambda client, _: self._send_typed(client))
        box.on_update(lambda event: latest.hold() if event.client else None)

        def show(each: _Widget) -> None:
            if box.value != self._typed[number]:
                latest.hold()  # until the server returns the new text
                self._hands.do(self._send_typed)
            else:
                put(box, value=each["text"])  # first: a click may send a difference meanwhile
                self._typed[number] = each["text"]

        return _Shown(box, show, latest)

    def _progress(self, widget: _Widget) -> _Shown:
        bar = self._gui.add_progress_bar(_percent(widget))
        return _Shown(bar, lambda each: put(bar, value=_percent(each)))

    # --- actions of users; on threads of viser's -------------------------------------------------

    def _entering(
        self, widget: _Widget, element: Any, as_text: Callable[[Any], str | None] = str
    ) -> Latest[str]:
        """Send what a user enters in an element; `as_text` returns None for what is not sent."""
        latest = Latest[str](self._hands, lambda client, text: self._enter(client, widget, text))

        def changed(event: viser.GuiEvent[Any]) -> None:
            text = as_text(event.target.value) if event.client else None
            if text is not None:
                latest.change(text)

        element.on_update(changed)
        return latest

    def _press(self, client: Client, number: int) -> None:
        self._send_typed(client)
        operate(client, "click" if self._is_custom else "pressWidget", self._handle, number)

    def _enter(self, client: Client, widget: _Widget, text: str) -> None:
        number = int(widget["id"])
        if self._is_custom:
            operate(client, "moveSlider", self._handle, number, int(text))
        else:
            operate(client, "enterValue", self._handle, number, text=text)

    def _send_typed(self, client: Client) -> None:
        """Send the texts of the edit boxes that the server does not have."""
        for number, known in self._typed.items():
            text = self._shown[number].element.value
            if text != known:
                self._typed[number] = text
                operate(client, "typeText", self._handle, number, text=text)


def _caption(widget: _Widget) -> str:
    return widget.get("caption", "")


def _as_text(widget: _Widget) -> str:
    style = _TEXT
    back, front = widget.get("colors", (None, None))
    if back is not None and front is not None:
        style += f";background-color:rgb{_bytes(back)};color:rgb{_bytes(front)};"
    return f"<div style='{style}'>{html.escape(widget['text'])}</div>"


def _as_table(widget: _Widget) -> str:
    columns, names = widget.get("columns", []), widget.get("names", [])
    head = ""
    if any(columns):
        shown = [_cell(text, widget, -1, place, "th") for place, text in enumerate(columns[:_MOST_COLUMNS])]
        head = "<tr>" + ("<th></th>" if any(names) else "") + "".join(shown) + "</tr>"
    rows = "".join(
        "<tr>"
        + (f"<th style='{_CELL}'>{html.escape(names[number][:200])}</th>" if any(names) else "")
        + "".join(_cell(text, widget, number, place) for place, text in enumerate(row[:_MOST_COLUMNS]))
        + "</tr>"
        for number, row in enumerate(widget["rows"][:_MOST_ROWS])
    )
    return f"<div style='{_TEXT};font-size:0.85em'><table style='border-collapse:collapse'>{head}{rows}</table></div>"


def _cell(text: str, widget: _Widget, row: int, column: int, tag: str = "td") -> str:
    """Return a cell; row -1 is the header."""
    style = _CELL
    for sizes, place, name in ((widget["widths"], column, "width"), (widget["heights"], row, "height")):
        if (size := sizes.get(place)) is not None:
            style += f";min-{name}:{size[0]:d}px;max-{name}:{size[1]:d}px;overflow:hidden"
    if widget.get("selected") is not None and tuple(widget["selected"]) == (row, column):
        style += ";background:rgba(31,111,139,0.3)"
    return f"<{tag} style='{style}'>{html.escape(text[:200])}</{tag}>"


def _as_svg_image(widget: _Widget) -> str:
    """Return vector graphics as an image: a browser runs no script in it and loads nothing for it."""
    if not widget["svg"]:
        return ""
    data = base64.b64encode(widget["svg"].encode()).decode()
    return f"<div style='{_TEXT}'><img style='max-width:100%' src='data:image/svg+xml;base64,{data}'/></div>"


def _as_plot(widget: _Widget) -> str:
    return as_svg(widget["plot"])


def _as_tree(widget: _Widget) -> str:
    rows = "".join(
        f"<tr{' style=font-weight:bold' if row['selected'] else ''}>"
        + "".join(
            f"<td style='{_tree_cell(widget, row, column)}'>{html.escape(text)}</td>"
            for column, text in enumerate(row["texts"])
        )
        + "</tr>"
        for row in widget["tree"]
    )
    return (
        f"<div style='{_TEXT};font-size:0.85em'><table style='border-collapse:collapse'>{rows}</table></div>"
    )


def _tree_cell(widget: _Widget, row: Mapping[str, Any], column: int) -> str:
    style = f"{_CELL};padding-left:{0.5 + (row['depth'] if not column else 0):g}em"
    size = widget["widths"].get(column)
    return style if size is None else f"{style};min-width:{size[0]:d}px;max-width:{size[1]:d}px"


def _as_image(widget: _Widget) -> str:
    if not widget["png"]:
        return ""
    return f"<div style='{_TEXT}'><img style='max-width:100%' src='data:image/png;base64,{widget['png']}'/></div>"


_CONTENTS: Mapping[str, Callable[[_Widget], str]] = MappingProxyType(
    {"table": _as_table, "plot": _as_plot, "tree": _as_tree, "image": _as_image, "svg": _as_svg_image}
)
"""The text of a widget as HTML, where it is more than a text."""


def _bytes(color: Sequence[float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in color)
    return red, green, blue


def _percent(widget: _Widget) -> float:
    span = widget["maximum"] - widget["minimum"]
    return 100.0 * (widget["value"] - widget["minimum"]) / span if span else 0.0


def _distinct(items: list[str]) -> list[str]:
    """Return texts for a list of choices, which must differ and not be empty."""
    found: list[str] = []
    for number, item in enumerate(items):
        text = item or f"({number})"
        found.append(text if text not in found else f"{text} ({number})")
    return found
