"""Dialogs: questions to people who watch a running simulation.

A dialog is a custom UI with a text, perhaps an edit box, and the buttons of its style. A click on one of them, or
`Dialogs.answer`, closes the window; the result stays until `end` or the end of the run. The legacy API has no
function to answer a dialog: the web viewer does it, or a client through the add-on (see `add_on.py`).
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.status_bar import as_log_line
from simx_server.simulation.part import Part

from .custom_uis import MAX_LABEL, CustomUI, CustomUIs, Element

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

_STYLES: dict[int, tuple[str, tuple[str, ...]]] = {
    c.sim_dlgstyle_message: ("message", ()),
    c.sim_dlgstyle_input: ("input", ("OK",)),
    c.sim_dlgstyle_ok: ("ok", ("OK",)),
    c.sim_dlgstyle_ok_cancel: ("ok_cancel", ("OK", "Cancel")),
    c.sim_dlgstyle_yes_no: ("yes_no", ("Yes", "No")),
}
"""Name and buttons of each style; a plain message has no buttons and stays until it is ended."""


_CLOSED = {
    c.sim_dlgstyle_input: c.sim_dlgret_cancel,
    c.sim_dlgstyle_ok_cancel: c.sim_dlgret_cancel,
    c.sim_dlgstyle_yes_no: c.sim_dlgret_no,
}
"""Result of a modal dialog without an answer, by style; of other styles it is OK."""


@dataclass
class Dialog:
    """One dialog; ``result`` is sim_dlgret_still_open until it is answered."""

    handle: int
    title: str
    text: str
    style: int
    is_centred: bool
    title_colors: list[float] | None
    """RGB of the background, then of the text, 0..1; None: the default of the web viewer."""
    dialog_colors: list[float] | None
    ui: CustomUI
    is_modal: bool = False
    """Whether its program does not wait for the answer, as it would have in V-REP: see `read_result`."""
    result: int = c.sim_dlgret_still_open

    @property
    def is_open(self) -> bool:
        return self.result == c.sim_dlgret_still_open

    def read_result(self) -> int:
        """Return the result for the program. An open modal dialog counts as closed without a choice."""
        if self.is_open and self.is_modal:
            return _CLOSED.get(self.style, c.sim_dlgret_ok)
        return self.result

    @property
    def buttons(self) -> tuple[str, ...]:
        return _STYLES[self.style][1]

    @property
    def input(self) -> str:
        """Return the text in the edit box; '' for a style without one."""
        box = self.ui.elements.get(INPUT_ID)
        return "" if box is None else box.label


class Dialogs(Part):
    """All dialogs of the present run. Physics thread only."""

    def __init__(self, sim: Simulation, uis: CustomUIs) -> None:
        self._sim = sim
        self._uis = uis
        self._dialogs: dict[int, Dialog] = {}
        self._next_handle = 1

    def run_stopped(self) -> None:
        self._end_run()

    def __contains__(self, handle: int) -> bool:
        return handle in self._dialogs

    def __iter__(self) -> Iterator[Dialog]:
        return iter(tuple(self._dialogs.values()))

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
        style = dialog_type & ~c.sim_dlgstyle_dont_center
        if style not in _STYLES:
            known = ", ".join(f"{number} ({name})" for number, (name, _) in _STYLES.items())
            raise CommandError(
                f"{dialog_type} is no dialog type; valid: {known}, plus {c.sim_dlgstyle_dont_center} for not centred"
            )
        self._sim.limits.check("dialogs", len(self._dialogs) + 1, "end some with simxEndDialog")
        title, text, initial_text = title[:MAX_LABEL], text[:MAX_LABEL], initial_text[:MAX_LABEL]
        dialog = Dialog(
            self._next_handle,
            title,
            text,
            style,
            not dialog_type & c.sim_dlgstyle_dont_center,
            title_colors,
            dialog_colors,
            _make_ui(title, text, style, initial_text),
        )
        dialog.ui.on_click = partial(self._clicked, dialog)
        self._uis.add(dialog.ui)
        self._dialogs[dialog.handle] = dialog
        self._next_handle += 1
        logger.info(
            "dialog %d '%s' is open: %s", dialog.handle, as_log_line(dialog.title), as_log_line(dialog.text)
        )
        return dialog

    def get(self, handle: int) -> Dialog:
        """Return a dialog. Raises CommandError that lists the existing dialogs."""
        dialog = self._dialogs.get(handle)
        if dialog is None:
            listed = ", ".join(f"{each.handle} ('{each.title}')" for each in self) or "none"
            raise CommandError(
                f"no dialog with handle {handle}; there are: {listed}; they end with the simulation"
            )
        return dialog

    def answer(self, handle: int, result: int, text: str | None = None) -> None:
        """Answer an open dialog with one of its buttons, given as sim_dlgret_, and a text for the edit box.

        Raises:
            CommandError: no such dialog, it was answered already, or it lacks this button or an edit box.
        """
        dialog = self.get(handle)
        if not dialog.is_open:
            raise CommandError(f"dialog {handle} ('{dialog.title}') was answered already")
        results = [_RESULTS[name] for name in dialog.buttons]
        if result not in results:
            valid = ", ".join(f"{_RESULTS[name]} ({name})" for name in dialog.buttons)
            raise CommandError(
                f"dialog {handle} ('{dialog.title}') cannot be answered with {result}; valid: "
                + (valid or "nothing, it is a message that its program ends")
            )
        if text is not None:
            self._uis.type_text(dialog.ui.handle, INPUT_ID, text)
        self._uis.click(dialog.ui.handle, FIRST_BUTTON_ID + results.index(result))

    def end(self, handle: int) -> None:
        """Close a dialog and forget it. Raises CommandError: no such dialog."""
        dialog = self.get(handle)
        del self._dialogs[handle]
        self._close_window(dialog)

    def describe(self) -> list[dict[str, Any]]:
        """Return every dialog as plain data; its window is the custom UI with the handle `ui`."""
        return [
            {
                "handle": dialog.handle,
                "title": dialog.title,
                "text": dialog.text,
                "style": _STYLES[dialog.style][0],
                "centred": dialog.is_centred,
                "title_colors": dialog.title_colors,
                "dialog_colors": dialog.dialog_colors,
                "ui": dialog.ui.handle,
                "result": dialog.result,
                "input": dialog.input,
            }
            for dialog in self
        ]

    def _clicked(self, dialog: Dialog, button: int) -> None:
        index = button - FIRST_BUTTON_ID
        if 0 <= index < len(dialog.buttons):  # a program may have turned the text into a button
            dialog.result = _RESULTS[dialog.buttons[index]]
            logger.info("dialog %d is answered with %s", dialog.handle, dialog.buttons[index])
            self._close_window(dialog)

    def _close_window(self, dialog: Dialog) -> None:
        if any(ui is dialog.ui for ui in self._uis):  # simxRemoveUI may have removed it already
            self._uis.remove(dialog.ui.handle)

    def _end_run(self) -> None:
        for dialog in self:
            self.end(dialog.handle)


def _make_ui(title: str, text: str, style: int, initial_text: str) -> CustomUI:
    enabled = c.sim_buttonproperty_enabled
    elements = [Element(TEXT_ID, c.sim_buttonproperty_label | enabled, text)]
    if style == c.sim_dlgstyle_input:
        elements.append(Element(INPUT_ID, c.sim_buttonproperty_editbox | enabled, initial_text))
    elements += [
        Element(FIRST_BUTTON_ID + number, c.sim_buttonproperty_button | enabled, name)
        for number, name in enumerate(_STYLES[style][1])
    ]
    return CustomUI(title, title, {element.id: element for element in elements})
