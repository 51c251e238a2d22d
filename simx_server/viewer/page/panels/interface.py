"""Show what programs display, and send the answers of users: dialogs and other windows, consoles, the status bar.

A dialog opens as a separate window above the scene, as in V-REP: a user may need to see the scene to answer it.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import viser

from simx_server.parts.user_interface.interface import CUSTOM, XML
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands

from .elements import put
from .window_card import Card, WindowView, key_of, operate

_CONSOLE = "console"
"""Place of consoles in the tab, as windows have their API."""

_SMALL = "padding:0 0.75em 0.5em;font-size:0.85em;overflow-wrap:anywhere"
_LINES = (
    # Reversed, so that the newest line stays in view.
    "display:flex;flex-direction:column-reverse;max-height:18em;overflow:auto;padding:0.4em 0.75em;margin:0 0.5em;"
    "font-family:monospace;font-size:0.8em;line-height:1.35;"
)
_NOTHING = "Programs show dialogs, custom UIs and consoles here; none does now."
_WIDTH = 340
"""Pixels of a dialog's window."""

_BELOW = 140
"""Pixels at the top that are left to viser's notifications."""


class Interface:
    """The tab."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._gui, self._hands = gui, hands
        self._shown: dict[tuple[str, int], _Section | _Dialog | _Console] = {}
        """By place in the tab and handle."""
        self._opened = 0
        self._note = gui.add_html("")
        self._folders = {place: gui.add_folder(None) for place in (CUSTOM, XML, _CONSOLE)}
        self._menu = _Menu(gui, hands)
        with gui.add_folder("Status bar"):
            self._status_bar = gui.add_html("")

    def update(self, survey: Survey, look: Look) -> None:
        """Update the elements."""
        shown = survey["interface"]
        windows = [each for each in shown["windows"] if each["visible"] or each["question"] is None]
        views = {(window["api"], window["handle"]): window for window in windows}
        views |= {(_CONSOLE, console["handle"]): console for console in shown["consoles"]}
        for place in [each for each in self._shown if each not in views]:
            self._shown.pop(place).remove()
        for (place, handle), view in views.items():
            self._show(place, handle, view)
        asked = [window for window in windows if window["question"] is not None]
        self._menu.update(shown["menu"])
        self._say(asked, is_empty=not views)
        put(self._status_bar, content=_lines(shown["status_bar"], survey["messages"]))

    def close(self) -> None:
        """Do nothing."""

    def _show(self, place: str, handle: int, view: dict[str, Any]) -> None:
        """Show one of them, made again if it needs other elements."""
        shown = self._shown.get((place, handle))
        if shown is None or (place != _CONSOLE and shown.key != key_of(view)):
            if shown is not None:
                shown.remove()
            kind = _Console if place == _CONSOLE else _Section if view["question"] is None else _Dialog
            self._opened += kind is _Dialog
            with self._folders[place]:
                shown = self._shown[place, handle] = kind(self._gui, self._hands, view, self._opened)
        shown.update(view)

    def _say(self, dialogs: Sequence[WindowView], *, is_empty: bool) -> None:
        note = "<br>".join(
            f"<b>{html.escape(dialog['title']) or 'A dialog'}</b>, in its window: "
            f"{html.escape(dialog['question'])}"
            for dialog in dialogs
        )
        note = note or (_NOTHING if is_empty else "")
        put(self._note, content=f"<div style='{_SMALL}'>{note}</div>", visible=bool(note))


class _Menu:
    """The menu of modules: a button for each entry."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._gui, self._hands = gui, hands
        self._folder = gui.add_folder("Modules", visible=False)
        self._buttons: dict[int, viser.GuiButtonHandle] = {}

    def update(self, entries: Sequence[dict[str, Any]]) -> None:
        """Show these entries."""
        put(self._folder, visible=bool(entries))
        handles = {entry["handle"] for entry in entries}
        for handle in [handle for handle in self._buttons if handle not in handles]:
            self._buttons.pop(handle).remove()
        for entry in entries:
            label = ("☑ " if entry["checked"] else "") + " › ".join(entry["path"])
            button = self._buttons.get(entry["handle"])
            if button is None:
                button = self._buttons[entry["handle"]] = self._make(label, entry["handle"])
            put(button, label=label, disabled=not entry["enabled"])

    def _make(self, label: str, handle: int) -> viser.GuiButtonHandle:
        with self._folder:
            button = self._gui.add_button(label or " ", order=handle)
        button.on_click(lambda _: self._hands.do(lambda client: operate(client, "selectEntry", handle)))
        return button


class _Dialog:
    """An open dialog, in a separate window."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, window: WindowView, number: int) -> None:
        self.key = key_of(window)
        self._panel = gui.add_panel()
        with self._panel.add_tab(window["title"] or "Dialog", viser.Icon.MESSAGE_QUESTION):
            gui.add_html("<div style='height:0.75em'></div>")
            self.update = Card(gui, hands, window).update
        shift = 30.0 * (number % 10)
        self._panel.float(x=60 + shift, y=_BELOW + shift)
        self._panel.set_width(_WIDTH)

    def remove(self) -> None:
        self._panel.remove()


class _Section:
    """Any other window, in the tab."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, window: WindowView, _number: int) -> None:
        self.key, handle = key_of(window), window["handle"]
        title = window["title"] or window.get("name") or f"UI {handle}"
        self._folder = gui.add_folder(title, order=handle)
        with self._folder:
            self._card = Card(gui, hands, window)

    def update(self, window: WindowView) -> None:
        put(self._folder, visible=window["visible"])
        self._card.update(window)

    def remove(self) -> None:
        self._folder.remove()


class _Console:
    """An auxiliary console."""

    key: object = None

    def __init__(self, gui: viser.GuiApi, hands: Hands, console: dict[str, Any], _number: int) -> None:
        handle = console["handle"]
        self._folder = gui.add_folder(console["title"] or f"Console {handle}", order=handle)
        with self._folder:
            self._text = gui.add_html("")
            if console["user_may_close"]:
                close = gui.add_button("Close", icon=viser.Icon.X)
                close.on_click(lambda _: hands.do(lambda client: operate(client, "closeConsole", handle)))

    def update(self, console: dict[str, Any]) -> None:
        put(self._folder, visible=console["visible"])
        style = (
            "white-space:pre-wrap;overflow-wrap:anywhere;" if console["wrap_lines"] else "white-space:pre;"
        )
        for name, color in (
            ("color", console["text_color"]),
            ("background-color", console["background_color"]),
        ):
            if color is not None:
                style += f"{name}:rgb({','.join(str(round(255 * part)) for part in color)});"
        put(self._text, content=_lines(console["lines"], style=style))

    def remove(self) -> None:
        self._folder.remove()


def _lines(
    lines: Sequence[str], count: int = 0, style: str = "white-space:pre-wrap;overflow-wrap:anywhere;"
) -> str:
    """Return lines as HTML, with the newest in view; `count` is the number of lines ever written."""
    text = html.escape("\n".join(lines)) or "&nbsp;"
    left_out = count - len(lines)
    before = f"<i>({left_out} older lines are in the server's log)</i>\n" if left_out > 0 else ""
    return f"<div style='{_LINES}{style}'><div>{before}{text}</div></div>"
