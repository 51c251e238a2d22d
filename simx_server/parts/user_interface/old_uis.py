"""The custom UIs that a scene's file holds, as V-REP 3 saved them: one per annotation `simx:old_ui:NAME`.

They belong to the scene, or to the object that the annotation names: a loaded model brings them along, a copy of the
object has a copy, and a removed object takes its UI with it.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.formats.texts.old_uis import UI_TEXT

from .custom_ui_files import read_ui_text
from .custom_uis import CustomUIs

if TYPE_CHECKING:
    from simx_server.scene.formats.annotations import Annotation
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)


class OldUIs:
    """The annotated UIs of the present scene. Physics thread only."""

    def __init__(self, sim: Simulation, uis: CustomUIs) -> None:
        self._sim = sim
        self._uis = uis
        self._made: dict[str, tuple[Annotation, int | None]] = {}
        """Annotation and handle of each UI by name; no handle where it could not be made."""

    def forget(self) -> None:
        """Forget the UIs of a scene that is gone; `CustomUIs` removes them."""
        self._made.clear()

    def update(self) -> None:
        """Make the UIs of new annotations, and remove those whose annotation or object is gone."""
        present = self._present()
        for name, (note, handle) in list(self._made.items()):
            if present.get(name) is not note:
                del self._made[name]
                if handle is not None and handle in self._handles():
                    self._uis.remove(handle)
        for name, note in present.items():
            if name not in self._made:
                self._made[name] = note, self._make(name, note)

    def names(self) -> list[str]:
        """Return the names of those that exist and were not removed by a program."""
        handles = self._handles()
        return [name for name, (_, handle) in self._made.items() if handle in handles]

    def owner(self, handle: int) -> int:
        """Return the object with which a UI is associated, -1 for none."""
        for note, made in self._made.values():
            if made == handle and "object" in note:
                found = self._sim.scene.by_name(str(note["object"]))
                return -1 if found is None else found
        return -1

    def _present(self) -> dict[str, Annotation]:
        scene = self._sim.scene
        notes = scene.annotations.registered.get(UI_TEXT, {})
        return {
            name: note
            for name, note in notes.items()
            if "object" not in note or scene.by_name(str(note["object"])) is not None
        }

    def _make(self, name: str, note: Annotation) -> int | None:
        try:
            return self._uis.add(read_ui_text(name, str(note["text"])))[0]
        except CommandError as problem:
            logger.warning("the scene's UI '%s' is not there: %s", name, problem)
            return None

    def _handles(self) -> set[int]:
        return {ui.handle for ui in self._uis}
