"""Dialogs of ``simUI``: none of them waits for the user."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

from simx_server.errors import CommandError
from simx_server.files.image_files import SUFFIXES
from simx_server.parts.user_interface.widgets import MAX_TEXT, Widget
from simx_server.parts.user_interface.xml_windows.windows import XmlWindow
from simx_server.scripting.interpreter import Constant

from .sim_ui import UiPart

_TEXT = 1
"""Id of the text of a banner; the buttons have the next ones."""

_MOST_BUTTONS = 20

_BUTTONS = {"ok": 0, "yesno": 1, "yesnocancel": 2, "okcancel": 3}
_RESULTS = {"cancel": 0, "no": 1, "yes": 2, "ok": 3}
_CLOSED = {"ok": "ok", "yesno": "no", "yesnocancel": "cancel", "okcancel": "cancel"}
"""Result of a box that is closed without a choice."""


class UiDialogFunctions(UiPart, effect="changes"):
    """Message boxes and dialogs. A script cannot wait for the user, so they are closed at once."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = MappingProxyType(
        {
            "msgbox_type": {"info": 0, "question": 1, "warning": 2, "critical": 3},
            "msgbox_buttons": _BUTTONS,
            "msgbox_result": _RESULTS,
            "filedialog_type": {"load": 0, "load_multiple": 1, "save": 2, "folder": 3},
        }
    )

    def msgBox(self, _kind: int, buttons: int, title: str, text: str) -> int:
        """Print a message to the status bar and return simUI.msgbox_result.ok.

        Partly: a box with a choice counts as closed without one: the result is no, or cancel where it can be.
        """
        self._world.status_bar.add(f"{title}: {text}" if title else text)
        return next((_RESULTS[_CLOSED[name]] for name, each in _BUTTONS.items() if each == buttons), 3)

    def inputDialog(self, _initial: str = "", label: str = "", title: str = "") -> None:
        """Return nil, as for a dialog that the user cancels. Stand-in: the user is not asked."""
        self._say_once(f"simUI.inputDialog was closed at once: {title or label}")

    def fileDialog(self, _kind: int, title: str, *_more: Any) -> list[str]:
        """Return no files, as for a dialog that the user cancels. Stand-in: a script sees no files of the server."""
        self._say_once(f"simUI.fileDialog was closed at once: {title}")
        return []

    def colorDialog(self, _initial: list[float] | None = None, title: str = "", *_more: Any) -> None:
        """Return nil, as for a dialog that the user cancels. Stand-in: the user is not asked."""
        self._say_once(f"simUI.colorDialog was closed at once: {title}")

    def bannerCreate(
        self,
        text: str,
        keys: list[str] | None = None,
        labels: list[str] | None = None,
        callback: str | None = None,
    ) -> int:
        """Show a text with buttons in a window and return its handle. A click calls the function with the key of the
        button.
        """
        names, shown = list(keys or ()), list(labels or ())
        if len(shown) != len(names) or len(names) > _MOST_BUTTONS:
            raise CommandError(f"a banner has a key and a label for each button, at most {_MOST_BUTTONS}")
        window = XmlWindow("Banner")
        window.widgets[_TEXT] = Widget(_TEXT, "label", text=text[:MAX_TEXT])
        for number, label in enumerate(shown, _TEXT + 1):
            events = {"on-click": callback} if callback else {}
            window.widgets[number] = Widget(number, "button", text=label[:MAX_TEXT], events=events)
        interpreter = self._script.interpreter
        window.is_alive = lambda: interpreter is None or self._script.interpreter is interpreter

        def fire(function: str, values: tuple[Any, ...]) -> None:
            self._fire(function, (names[int(values[1]) - _TEXT - 1],))

        window.fire = fire
        return self._world.user_interface.windows.add(window)[0]

    def bannerDestroy(self, banner: int) -> None:
        """Remove a banner."""
        self._world.user_interface.windows.remove(banner)

    def setClipboardText(self, _text: str) -> None:
        """Do nothing. Stand-in: the server has no clipboard."""

    def getKeyboardModifiers(self) -> dict[str, bool]:
        """Return the keys that are held down. Stand-in: none."""
        return {"control": False, "shift": False, "alt": False, "meta": False}

    def qtVersion(self) -> list[int]:
        """Return the version of Qt. Stand-in: zeros, since there is none."""
        return [0, 0, 0]

    def supportedImageFormats(self, separator: str | None = None) -> tuple[list[str], str | None]:
        """Return the endings of image files that can be shown, and as one text with a separator between them."""
        found = [suffix.removeprefix(".") for suffix in (*SUFFIXES, ".svg")]
        return found, None if separator is None else separator.join(found)
