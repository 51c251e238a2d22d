"""One window that a script made from XML (`simUI`), as elements of the web viewer.

Plots, trees, images and the like are left out: the server keeps them for the script, and sends nothing of them.
"""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Any

import viser

from simx_client import Client
from simx_server.viewer.page.link import Hands

from .custom_uis import operate
from .elements import Latest, put

WindowView = dict[str, Any]
"""The form that `Window.describe` returns."""

_Widget = dict[str, Any]

_CHECKED = 2
_PRESSED = "orange"
_NONE = "(none)"
_MOST_ROWS, _MOST_COLUMNS = 50, 20
_CELL = "padding:0.1em 0.5em;border:1px solid rgba(128,128,128,0.4)"
_TEXT = "padding:0 0.75em 0.5em;white-space:pre-wrap;overflow-wrap:anywhere"


def key_of_window(window: WindowView) -> tuple[object, ...]:
    """Return a key that changes when the elements must be made again."""
    widgets = tuple(
        (each["id"], each["kind"], each["minimum"], each["maximum"], each["step"], tuple(each["items"]))
        for each in window["widgets"]
    )
    return window["handle"], window["title"], window["closeable"], widgets


class WindowCard:
    """The widgets of one window, in a folder of the container that is open when it is made."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, window: WindowView) -> None:
        self.key = key_of_window(window)
        self._gui, self._hands, self._handle = gui, hands, int(window["handle"])
        self._shown: dict[int, tuple[Any, Callable[[Any, _Widget], None]]] = {}
        """The element of each widget, and the function that shows the widget's state in it."""
        self._latest: dict[int, Latest[str]] = {}
        self._folder = gui.add_folder(window["title"] or f"UI {self._handle}", order=window["handle"])
        with self._folder:
            for widget in window["widgets"]:
                made = self._make(widget)
                if made is not None:
                    self._shown[widget["id"]] = made
            if window["closeable"]:
                close = gui.add_button("Close", icon=viser.Icon.X)
                close.on_click(
                    lambda _: hands.do(lambda client: operate(client, "closeWindow", self._handle))
                )

    def update(self, window: WindowView) -> None:
        """Show the script's present values; a widget that a user is changing stays as it is."""
        put(self._folder, visible=window["visible"])
        for widget in window["widgets"]:
            element, show = self._shown.get(widget["id"], (None, None))
            if show is not None:
                put(element, visible=widget["visible"])
                latest = self._latest.get(widget["id"])
                if latest is None or not latest.is_held:
                    show(element, widget)

    def remove(self) -> None:
        self._folder.remove()

    # --- widgets ---------------------------------------------------------------------------------

    def _make(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]] | None:
        makers = {
            "label": self._label,
            "text-browser": self._label,
            "table": self._table,
            "button": self._button,
            "radiobutton": self._button,
            "checkbox": self._checkbox,
            "slider": self._slider,
            "spinbox": self._spinbox,
            "combobox": self._choice,
            "tabs": self._choice,
            "edit": self._edit,
            "progressbar": self._progress,
        }
        maker = makers.get(widget["kind"])
        return None if maker is None else maker(widget)

    def _label(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        return self._gui.add_html(_as_text(widget)), lambda shown, each: put(shown, content=_as_text(each))

    def _table(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        return self._gui.add_html(_as_table(widget)), lambda shown, each: put(shown, content=_as_table(each))

    def _button(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        number = int(widget["id"])
        button = self._gui.add_button(widget["text"] or " ")
        button.on_click(
            lambda _: self._hands.do(lambda client: operate(client, "pressWidget", self._handle, number))
        )

        def show(shown: viser.GuiButtonHandle, each: _Widget) -> None:
            mark = ("◉ " if each["value"] else "○ ") if each["kind"] == "radiobutton" else ""
            color = _PRESSED if each["value"] and not mark else None
            put(shown, label=(mark + each["text"]) or " ", color=color, disabled=not each["enabled"])

        return button, show

    def _checkbox(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        box = self._gui.add_checkbox(widget["text"], bool(widget["value"]))
        latest = self._entering(widget)
        box.on_update(
            lambda event: latest.change(str(_CHECKED * event.target.value)) if event.client else None
        )
        return box, lambda shown, each: put(
            shown, label=each["text"], value=bool(each["value"]), disabled=not each["enabled"]
        )

    def _slider(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        low, high = int(widget["minimum"]), int(widget["maximum"])
        # viser refuses a slider that cannot move.
        slider = self._gui.add_slider("", low, max(high, low + 1), 1, int(widget["value"]))
        latest = self._entering(widget)
        slider.on_update(lambda event: latest.change(str(event.target.value)) if event.client else None)
        return slider, lambda shown, each: put(shown, value=int(each["value"]), disabled=not each["enabled"])

    def _spinbox(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        low, high, step = widget["minimum"], widget["maximum"], widget["step"]
        box = self._gui.add_number(
            "", float(widget["value"]), min=float(low), max=float(high), step=float(step) or None
        )
        latest = self._entering(widget)
        box.on_update(lambda event: latest.change(repr(event.target.value)) if event.client else None)
        return box, lambda shown, each: put(shown, value=float(each["value"]), disabled=not each["enabled"])

    def _choice(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]] | None:
        items = _distinct(widget["items"])
        if not items:
            return None
        options = [*items, _NONE]
        box = self._gui.add_dropdown("Tab" if widget["kind"] == "tabs" else "", options)
        latest = self._entering(widget)

        def choose(event: Any) -> None:
            if event.client and event.target.value != _NONE:
                latest.change(str(items.index(event.target.value)))

        box.on_update(choose)
        return box, lambda shown, each: put(
            shown, value=options[int(each["value"])], disabled=not each["enabled"]
        )

    def _edit(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        box = self._gui.add_text("", widget["text"])
        latest = self._entering(widget)
        box.on_update(lambda event: latest.change(event.target.value) if event.client else None)
        return box, lambda shown, each: put(shown, value=each["text"], disabled=not each["enabled"])

    def _progress(self, widget: _Widget) -> tuple[Any, Callable[[Any, _Widget], None]]:
        bar = self._gui.add_progress_bar(_percent(widget))
        return bar, lambda shown, each: put(shown, value=_percent(each))

    def _entering(self, widget: _Widget) -> Latest[str]:
        number = int(widget["id"])

        def enter(client: Client, text: str) -> None:
            operate(client, "enterValue", self._handle, number, text=text)

        latest = self._latest[number] = Latest[str](self._hands, enter)
        return latest


def _as_text(widget: _Widget) -> str:
    return f"<div style='{_TEXT}'>{html.escape(widget['text'])}</div>"


def _as_table(widget: _Widget) -> str:
    rows = "".join(
        "<tr>"
        + "".join(f"<td style='{_CELL}'>{html.escape(text[:200])}</td>" for text in row[:_MOST_COLUMNS])
        + "</tr>"
        for row in widget["rows"][:_MOST_ROWS]
    )
    return (
        f"<div style='{_TEXT};font-size:0.85em'><table style='border-collapse:collapse'>{rows}</table></div>"
    )


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
