"""Messages of a script to people: status bar, log, consoles, dialogs."""

from __future__ import annotations

import logging

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers.user_interface import consoles, dialogs
from simx_server.parts.status_bar import as_log_line

from .base import ApiPart
from .effects import reads, takes

logger = logging.getLogger(__name__)

_LEVEL = 0x0FFF
_UNDECORATED = 0xF000
_ONCE = 0x20000
_ERRORS, _WARNINGS, _USUAL = (200, 420), (300, 430), 450
"""sim.verbosity_errors and _scripterrors, _warnings and _scriptwarnings, _scriptinfos."""

_CLOSED = {0: 3, 1: 1, 2: 0, 3: 0}
"""sim.msgbox_buttons_ok, _yesno, _yesnocancel and _okcancel: the result of a box that is closed without a choice."""


class MessageFunctions(ApiPart, effect="changes"):
    """Functions for messages. The server stores every message and shows it in its web viewer."""

    def addStatusbarMessage(self, text: str | None = None) -> None:
        """Add a line to the status bar. Nil, which cleared V-REP's status bar, adds nothing."""
        if text is not None:
            self._world.status_bar.add(text)

    def addLog(self, verbosity: int | None = None, text: str | None = None) -> None:
        """Write to the status bar and the server's log, up to the script's sim.intparam_statusbarverbosity and
        sim.intparam_verbosity, at first sim.verbosity_scriptinfos; more detailed levels come in the log when it logs
        debug messages. Adding sim.verbosity_undecorated to the level omits the script's name; with
        sim.verbosity_once a text is written only the first time in a scene.
        """
        if text is None:
            return
        level = _USUAL if verbosity is None else verbosity
        kind = "error" if level & _LEVEL in _ERRORS else "warning" if level & _LEVEL in _WARNINGS else "info"
        item = self._sim.scene.objects.get(self._owner)
        shown = (
            text
            if level & _UNDECORATED == _UNDECORATED
            else f"[{item.name if item else 'script'}:{kind}] {text}"
        )
        if level & _ONCE and not self._world.scripts.told_once.is_first(text):
            return
        logged = logging.INFO if level & _LEVEL <= self._script.console_verbosity else logging.DEBUG
        if level & _LEVEL <= self._script.bar_verbosity:
            self._world.status_bar.add(shown, logged)
        else:
            logger.log(logged, "%s", as_log_line(shown))

    @takes
    def getSimulatorMessage(self) -> tuple[int, list[int], list[float]]:
        """Return and remove the script's next message, sim.message_object_selection_changed or
        sim.message_model_loaded (with the model's handle), and its numbers; -1 without one.

        Partly: messages do not come from keys, the mouse and custom UIs, which have sim.getUIEventButton.
        """
        found = self._world.simulator_messages.take(self._script.handle)
        return (-1, [], []) if found is None else (found.kind, list(found.values), [])

    def auxiliaryConsoleOpen(
        self,
        title: str,
        max_lines: int,
        mode: int,
        position: list[int] | None = None,
        size: list[int] | None = None,
        text_color: list[float] | None = None,
        background_color: list[float] | None = None,
    ) -> int:
        """Open a console and return its handle.

        Mode bits: 1 closes with the end of the run, 2 wraps lines, 4 a person may close it, 8 hidden in pauses, 16
        stays when another scene is loaded. Position and size are in pixels, colours RGB 0..1.
        """
        return consoles.open_console(
            self._world, title, max_lines, mode, position, size, text_color, background_color
        )

    def auxiliaryConsoleClose(self, console: int) -> int:
        """Close a console; return 1, or 0 when it does not exist."""
        known = any(each.handle == console for each in self._world.user_interface.consoles)
        consoles.close_console(self._world, console)
        return int(known)

    def auxiliaryConsolePrint(self, console: int, text: str | None = None) -> int:
        """Print to a console, or clear it with nil; return 1, or 0 when the console was closed."""
        consoles.print_to_console(self._world, console, text)
        return int(self._world.user_interface.consoles.find(console) is not None)

    def auxiliaryConsoleShow(self, console: int, shown: bool) -> int:
        """Show or hide a console; return 1, or 0 when the console was closed."""
        consoles.show_console(self._world, console, shown)
        return int(self._world.user_interface.consoles.find(console) is not None)

    def displayDialog(
        self,
        title: str,
        text: str,
        style: int,
        modal: bool = False,
        initial: str | None = None,
        title_colors: list[float] | None = None,
        dialog_colors: list[float] | None = None,
    ) -> tuple[int, int]:
        """Show a dialog and return its handle and the handle of its UI. `style`: sim.dlgstyle_*; colours: RGB of
        background and text, 0..1.

        Partly: a modal dialog does not wait for the user. It is printed to the status bar and shown, and as long as
        it is open, its result is that of a dialog closed without a choice: OK, no, or cancel.
        """
        dialog, ui = dialogs.display_dialog(
            self._world, title, text, style, initial or "", title_colors, dialog_colors
        )
        if modal:
            self._world.user_interface.dialogs.get(dialog).is_modal = True
            self._world.status_bar.add(f"{title}: {text}" if title else text)
        return dialog, ui

    @reads
    def getDialogResult(self, dialog: int) -> int:
        """Return the answer of a dialog, sim.dlgret_still_open until there is one; of one that does not exist
        sim.dlgret_cancel.
        """
        if dialog not in self._world.user_interface.dialogs:
            return c.sim_dlgret_cancel
        return self._world.user_interface.dialogs.get(dialog).read_result()

    @reads
    def getDialogInput(self, dialog: int) -> str | None:
        """Return the text of a dialog, nil for one that does not exist."""
        if dialog not in self._world.user_interface.dialogs:
            return None
        return dialogs.get_dialog_input(self._world, dialog)

    def endDialog(self, dialog: int) -> int:
        """End a dialog, if it exists; return 1."""
        if dialog in self._world.user_interface.dialogs:
            dialogs.end_dialog(self._world, dialog)
        return 1

    def msgBox(self, _kind: int, buttons: int, title: str, text: str) -> int:
        """Print a message to the status bar and return sim.msgbox_return_ok, as if it had been read.

        Partly: a box with a choice counts as closed without one, since waiting would stop the server: the result is
        sim.msgbox_return_no, or sim.msgbox_return_cancel where there is such a button.
        """
        if buttons not in _CLOSED:
            known = ", ".join(map(str, _CLOSED))
            raise CommandError(f"{buttons} is not a kind of buttons of a message box; those are {known}")
        self._world.status_bar.add(f"{title}: {text}" if title else text)
        return _CLOSED[buttons]
