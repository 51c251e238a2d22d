"""Show what programs display, and send the answers of users: dialogs, custom UIs, consoles, the status bar.

A dialog opens as a separate window above the scene, as in V-REP: a user may need to see the scene to answer it.
"""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import viser

from simx_client.protocol.constants import sim_dlgret_still_open
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Hands

from .custom_uis import UI, Card, key_of, operate, plain_label
from .elements import put
from .xml_uis import WindowCard, WindowView, key_of_window

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
        self._windows: dict[int, _Window] = {}
        self._cards: dict[int, _Section] = {}
        self._xml_cards: dict[int, WindowCard] = {}
        self._consoles: dict[int, _Console] = {}
        self._opened = 0
        self._note = gui.add_html("")
        self._uis_folder = gui.add_folder(None)
        self._xml_folder = gui.add_folder(None)
        self._consoles_folder = gui.add_folder(None)
        with gui.add_folder("Status bar"):
            self._status_bar = gui.add_html("")

    def update(self, survey: Survey, look: Look) -> None:
        """Update the elements."""
        shown = survey["interface"]
        uis: dict[int, UI] = {ui["handle"]: ui for ui in shown["custom_uis"]}
        dialogs = {
            dialog["ui"]: dialog
            for dialog in shown["dialogs"]
            if dialog["result"] == sim_dlgret_still_open and dialog["ui"] in uis
        }
        of_dialogs = {dialog["ui"] for dialog in shown["dialogs"]}
        self._show_dialogs(dialogs, uis)
        self._show_uis([ui for handle, ui in uis.items() if handle not in of_dialogs])
        self._show_windows(shown["windows"])
        self._show_consoles(shown["consoles"])
        is_empty = not (dialogs or self._cards or self._xml_cards or self._consoles)
        self._say(list(dialogs.values()), is_empty=is_empty)
        put(self._status_bar, content=_lines(shown["status_bar"], survey["messages"]))

    def close(self) -> None:
        """Do nothing."""

    def _show_dialogs(self, dialogs: dict[int, dict[str, Any]], uis: dict[int, UI]) -> None:
        for handle in [each for each in self._windows if each not in dialogs]:
            self._windows.pop(handle).remove()
        for handle, dialog in dialogs.items():
            window = self._windows.get(handle)
            if window is None or window.key != key_of(uis[handle]):
                if window is not None:
                    window.remove()
                self._opened += 1
                window = _Window(self._gui, self._hands, dialog["title"], uis[handle], self._opened)
                self._windows[handle] = window
            window.card.update(uis[handle])

    def _show_uis(self, uis: Sequence[UI]) -> None:
        there = {ui["handle"] for ui in uis}
        for handle in [each for each in self._cards if each not in there]:
            self._cards.pop(handle).remove()
        for ui in uis:
            section = self._cards.get(ui["handle"])
            if section is None or section.key != key_of(ui):
                if section is not None:
                    section.remove()
                with self._uis_folder:
                    section = _Section(self._gui, self._hands, ui)
                self._cards[ui["handle"]] = section
            section.update(ui)

    def _show_windows(self, windows: Sequence[WindowView]) -> None:
        there = {window["handle"] for window in windows}
        for handle in [each for each in self._xml_cards if each not in there]:
            self._xml_cards.pop(handle).remove()
        for window in windows:
            card = self._xml_cards.get(window["handle"])
            if card is None or card.key != key_of_window(window):
                if card is not None:
                    card.remove()
                with self._xml_folder:
                    card = WindowCard(self._gui, self._hands, window)
                self._xml_cards[window["handle"]] = card
            card.update(window)

    def _show_consoles(self, consoles: Sequence[dict[str, Any]]) -> None:
        there = {console["handle"] for console in consoles}
        for handle in [each for each in self._consoles if each not in there]:
            self._consoles.pop(handle).remove()
        for console in consoles:
            if console["handle"] not in self._consoles:
                with self._consoles_folder:
                    self._consoles[console["handle"]] = _Console(self._gui, self._hands, console)
            self._consoles[console["handle"]].update(console)

    def _say(self, dialogs: Sequence[dict[str, Any]], *, is_empty: bool) -> None:
        note = "<br>".join(
            f"<b>{html.escape(dialog['title']) or 'A dialog'}</b>, in its window: "
            f"{html.escape(plain_label(dialog['text']))}"
            for dialog in dialogs
        )
        note = note or (_NOTHING if is_empty else "")
        put(self._note, content=f"<div style='{_SMALL}'>{note}</div>", visible=bool(note))


class _Window:
    """An open dialog."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, title: str, ui: UI, number: int) -> None:
        self.key = key_of(ui)
        self._panel = gui.add_panel()
        with self._panel.add_tab(title or "Dialog", viser.Icon.MESSAGE_QUESTION):
            gui.add_html("<div style='height:0.75em'></div>")
            self.card = Card(gui, hands, ui)
        shift = 30.0 * (number % 10)
        self._panel.float(x=60 + shift, y=_BELOW + shift)
        self._panel.set_width(_WIDTH)

    def remove(self) -> None:
        self._panel.remove()


class _Section:
    """A custom UI in the tab."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, ui: UI) -> None:
        self.key = key_of(ui)
        self._folder = gui.add_folder(ui["title"] or ui["name"], order=ui["handle"])
        with self._folder:
            self._card = Card(gui, hands, ui)

    def update(self, ui: UI) -> None:
        put(self._folder, visible=ui["visible"])
        self._card.update(ui)

    def remove(self) -> None:
        self._folder.remove()


class _Console:
    """An auxiliary console."""

    def __init__(self, gui: viser.GuiApi, hands: Hands, console: dict[str, Any]) -> None:
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
