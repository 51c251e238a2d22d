"""All that programs show to people, as one part of the world.

The server does not have a window. The state is kept and logged. `UserInterface.describe` returns it to clients in the
forms of the three APIs, `UserInterface.view` to the web viewer in the one form of `Window.view`.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.scene.trial.kinds import UI
from simx_server.service.calls.background import Steps, at_once
from simx_server.simulation.part import Part

from .consoles import Consoles
from .custom_ui_files import UIFileError, find_ui_file, read_ui_file
from .custom_uis import CustomUI, CustomUIs
from .dialogs import Dialogs
from .labels import plain_label
from .menu import ModuleMenu
from .old_uis import OldUIs
from .views import Views
from .xml_windows.windows import XmlWindows

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.trial.trials import Trials
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

CUSTOM, XML = "custom", "xml"
"""The APIs by which windows are operated: functions of the add-on differ, and their handles are counted separately."""


class UserInterface(Part):
    """All shown elements of one simulation. Use on the physics thread only; the status bar is a separate part."""

    def __init__(self, sim: Simulation, status_bar: StatusBar, trials: Trials) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self._trials = trials
        self.consoles = Consoles(sim)
        self.custom_uis = CustomUIs(sim)
        self.old_uis = OldUIs(sim, self.custom_uis)
        self.dialogs = Dialogs(sim, self.custom_uis)
        self.windows = XmlWindows(sim)
        self.views = Views(sim)
        self.menu = ModuleMenu(sim)
        self.mouse = (0, 0, 0)
        """x and y in pixels and the pressed buttons as bits, last reported by a web viewer; parameters 22, 23, 31."""

    def scene_changed(self) -> None:
        self.consoles.scene_changed()
        self.custom_uis.scene_changed()
        self.old_uis.forget()
        self.windows.scene_changed()
        self.views.scene_changed()
        self.menu.scene_changed()

    def run_stopped(self) -> None:
        self.consoles.run_stopped()
        self.dialogs.run_stopped()
        self.views.run_stopped()

    def scene_loaded(self) -> None:
        self._load_annotated()

    def model_changed(self, twins: Twins | None) -> None:
        self.old_uis.update()

    def registered_names(self) -> Mapping[str, list[str]]:
        return {"old_ui": self.old_uis.names(), "ui": [ui.name for ui in self.custom_uis]}

    def load(self, file: str) -> Steps[list[int]]:
        """Load the custom UIs of a file and return their handles in the file's order.

        Raises:
            CommandError: no such file, an error in it, or too many UIs.
        """
        return self.custom_uis.add(*(yield from self._read(find_ui_file(self._sim, file))))

    def _read(self, path: Path, *, is_short: bool = False) -> Steps[list[CustomUI]]:
        """Return the UIs of a file; a client's file goes through a trial first. Raises CommandError."""
        sources = self._sim.files.sources
        if not self._trials.concern(path, sources):
            return read_ui_file(path)
        tried = yield from self._trials.tried(UI, path, path.name, sources, is_short=is_short)
        return read_ui_file(path, None if tried.contents is None else tried.contents.read(path))

    def describe(self) -> dict[str, Any]:
        """Return the whole state for clients as plain data, ready for JSON."""
        self.windows.forget_the_gone()
        return {
            "status_bar": self._status_bar.messages,
            "consoles": self.consoles.describe(),
            "dialogs": [each.describe() for each in self.dialogs],
            "custom_uis": [each.describe() for each in self.custom_uis],
            "windows": [each.view() for each in self.windows],
        }

    def view(self) -> dict[str, Any]:
        """Return the whole state for the web viewer: all windows have one form, dialogs have a question."""
        self.windows.forget_the_gone()
        asked = {each.ui.handle: plain_label(each.text) for each in self.dialogs if each.is_open}
        old = [{**each.view(), "api": CUSTOM, "question": asked.get(each.handle)} for each in self.custom_uis]
        return {
            "status_bar": self._status_bar.messages,
            "consoles": self.consoles.describe(),
            "windows": [
                *old,
                *({**each.view(), "api": XML, "question": _question(each)} for each in self.windows),
            ],
            "views": self.views.view(),
            "menu": self.menu.view(),
        }

    def _load_annotated(self) -> None:
        """Load the UIs that the scene requests with ``simx:ui:NAME``; an invalid one is skipped."""
        for name, note in self._sim.scene.annotations.registered.get("ui", {}).items():
            try:
                file = find_ui_file(self._sim, str(note.get("file", "")))
                self.custom_uis.add(_choose(name, at_once(self._read(file, is_short=True))))
            except CommandError as problem:
                logger.warning("the scene's UI '%s' is not there: %s", name, problem)
                if isinstance(problem, LimitReached):
                    break  # the others would take as long, while clients wait


def _question(window: object) -> str | None:
    """Return what a window asks that opens above the scene; None for others."""
    from .contents.text_editors import TextEditor  # with it a reader of XML, which few servers need

    return "edit the text" if isinstance(window, TextEditor) and window.is_modal else None


def _choose(name: str, uis: list[CustomUI]) -> CustomUI:
    """Return the UI with this name; a file's only UI gets the name."""
    if len(uis) == 1:
        uis[0].name = name
        return uis[0]
    for ui in uis:
        if ui.name == name:
            return ui
    raise UIFileError(
        f"its file has no UI of that name; it has: {', '.join(ui.name for ui in uis) or 'none'}"
    )
