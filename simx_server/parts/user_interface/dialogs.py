"""Dialogs: questions to people who watch a running simulation.

A dialog is a custom UI with a text, perhaps an edit box, and the buttons of its style. A click on one of them, or
`Dialogs.answer`, closes the window; the result stays until `end` or the end of the run. The legacy API has no
function to answer a dialog: the web viewer does it, or a client through the add-on (see `add_on.py`).
"""

from __future__ import annotations

import logging
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.status_bar import as_log_line

from .custom_uis import MAX_LABEL, CustomUI, CustomUIs, Element
from .registry import Registry

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

TEXT_ID = 1
INPUT_ID = 2
FIRST_BUTTON_ID = 3
"""Ids of the elements of a dialog's UI; the buttons' ids are consecutive."""

_RESULTS = {
    "OK": c.sim_dlgret_ok,
    "Cancel": c.sim_dlgret_cancel,
    "Yes": c.sim_dlgret_yes,
    "No": c.sim_dlgret_no,
}


class _Style(NamedTuple):
    """A style of dialogs. A plain message has no buttons and stays until it is ended."""

    name: str
    buttons: tuple[str, ...] = ()
    closed: int = c.sim_dlgret_ok
    """Result of a modal dialog without an answer."""


_STYLES = {
    c.sim_dlgstyle_message: _Style("message"),
    c.sim_dlgstyle_input: _Style("input", ("OK",), c.sim_dlgret_cancel),
    c.sim_dlgstyle_ok: _Style("ok", ("OK",)),
    c.sim_dlgstyle_ok_cancel: _Style("ok_cancel", ("OK", "Cancel"), c.sim_dlgret_cancel),
    c.sim_dlgstyle_yes_no: _Style("yes_no", ("Yes", "No"), c.sim_dlgret_no),
}


@dataclass(eq=False)
class Dialog:
    """One dialog; ``result`` is sim_dlgret_still_open until it is answered."""

    title: str
    text: str
    style: _Style
    is_centred: bool
    title_colors: list[float] | None
    """RGB of the background, then of the text, 0..1; None: the default of the web viewer."""
    dialog_colors: list[float] | None
    ui: CustomUI
    handle: int = 0
    is_modal: bool = False
    """Whether its program does not wait for the answer, as it would have in V-REP: see `read_result`."""
    result: int = c.sim_dlgret_still_open

    @property
    def is_open(self) -> bool:
        return self.result == c.sim_dlgret_still_open

    def read_result(self) -> int:
        """Return the result for the program. An open modal dialog counts as closed without a choice."""
        return self.style.closed if self.is_open and self.is_modal else self.result

    @property
    def input(self) -> str:
        """Return the text in the edit box; '' for a style without one."""
        box = self.ui.widgets.get(INPUT_ID)
        return "" if box is None else box.text

    def describe(self) -> dict[str, Any]:
        """Return it as plain data; its window is the custom UI with the handle `ui`."""
        return {
            "handle": self.handle,
            "title": self.title,
            "text": self.text,
            "style": self.style.name,
            "centred": self.is_centred,
            "title_colors": self.title_colors,
            "dialog_colors": self.dialog_colors,
            "ui": self.ui.handle,
            "result": self.result,
            "input": self.input,
        }


class Dialogs(Registry[Dialog]):
    """All dialogs of the present run. Physics thread only."""

    KIND = "dialog"
    LIMIT = "dialogs"
    WAY_OUT = "end some with simxEndDialog"

    def __init__(self, sim: Simulation, uis: CustomUIs) -> None:
        super().__init__(sim)
        self._uis = uis

    def run_stopped(self) -> None:
        for dialog in self:
            self.remove(dialog.handle)

    def listed(self) -> str:
        return f"{super().listed()}; they end with the simulation"

    def display(
        self,
        title: str,
        text: str,
        dialog_type: int,
        initial_text: str = "",
        title_colors: list[float] | None = None,
        dialog_colors: list[float] | None = None,
    ) -> Dialog:
        """Show a dialog.

        Raises:
            CommandError: the simulation is stopped, the type is unknown, or too many dialogs were not ended.
        """
        if not self._sim.is_running:
            raise Unsupported("a dialog can be shown only during a simulation; start it first")
        style = _STYLES.get(dialog_type & ~c.sim_dlgstyle_dont_center)
        if style is None:
            known = ", ".join(f"{number} ({each.name})" for number, each in _STYLES.items())
            raise CommandError(
                f"{dialog_type} is no dialog type; valid: {known}, plus {c.sim_dlgstyle_dont_center} for not centred"
            )
        title, text, initial_text = title[:MAX_LABEL], text[:MAX_LABEL], initial_text[:MAX_LABEL]
        ui = _make_ui(title, text, style, initial_text)
        is_centred = not dialog_type & c.sim_dlgstyle_dont_center
        dialog = Dialog(title, text, style, is_centred, title_colors, dialog_colors, ui)
        ui.on_click = partial(self._clicked, dialog)
        self.add(dialog)
        logger.info("dialog %d '%s' is open: %s", dialog.handle, as_log_line(title), as_log_line(text))
        return dialog

    def answer(self, handle: int, result: int, text: str | None = None) -> None:
        """Answer an open dialog with one of its buttons, given as sim_dlgret_, and a text for the edit box.

        Raises:
            CommandError: no such dialog, it was answered already, or it lacks this button or an edit box.
        """
        dialog = self.get(handle)
        if not dialog.is_open:
            raise CommandError(f"dialog {handle} ('{dialog.title}') was answered already")
        results = [_RESULTS[name] for name in dialog.style.buttons]
        if result not in results:
            valid = ", ".join(f"{_RESULTS[name]} ({name})" for name in dialog.style.buttons)
            raise CommandError(
                f"dialog {handle} ('{dialog.title}') cannot be answered with {result}; valid: "
                + (valid or "nothing, it is a message that its program ends")
            )
        ui = self._uis.get(dialog.ui.handle)
        if text is not None:
            ui.type_text(INPUT_ID, text)
        ui.click(FIRST_BUTTON_ID + results.index(result))

    def remove(self, handle: int) -> None:
        """Close a dialog and forget it. Raises CommandError: no such dialog."""
        dialog = self.get(handle)
        super().remove(handle)
        self._close_window(dialog)

    def _prepare(self, new: Dialog) -> None:
        self._uis.add(new.ui)

    def _clicked(self, dialog: Dialog, button: int) -> None:
        index = button - FIRST_BUTTON_ID
        if 0 <= index < len(dialog.style.buttons):  # a program may have turned the text into a button
            name = dialog.style.buttons[index]
            dialog.result = _RESULTS[name]
            logger.info("dialog %d is answered with %s", dialog.handle, name)
            self._close_window(dialog)

    def _close_window(self, dialog: Dialog) -> None:
        if dialog.ui.handle in self._uis:  # simxRemoveUI may have removed it already
            self._uis.remove(dialog.ui.handle)


def _make_ui(title: str, text: str, style: _Style, initial_text: str) -> CustomUI:
    wanted = [(TEXT_ID, c.sim_buttonproperty_label, text)]
    if style.name == "input":
        wanted.append((INPUT_ID, c.sim_buttonproperty_editbox, initial_text))
    wanted += [
        (number, c.sim_buttonproperty_button, name)
        for number, name in enumerate(style.buttons, start=FIRST_BUTTON_ID)
    ]
    elements = {
        number: Element(number, prop=kind | c.sim_buttonproperty_enabled, text=shown)
        for number, kind, shown in wanted
    }
    return CustomUI(title, elements, name=title)
