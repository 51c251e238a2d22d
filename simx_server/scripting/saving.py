"""Scripts as annotations, from which the same scripts are found when the file is loaded."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES

from .script import Order, Script, ScriptKind, Traversal

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

_NOTES = {kind: note for note, kind in SCRIPT_NOTES.items()}


def save_script(saved: Saved, script: Script, sim: Simulation) -> None:
    """Annotate the home of a script, if that is saved, with the script and its text.

    Raises:
        ScriptError: its file cannot be read.
    """
    is_main = script.kind == ScriptKind.MAIN
    if saved.is_model if is_main else script.home not in saved.names:
        return
    text = script.source(sim)
    note = _note(script, text.decode("utf-8", "replace"))
    if is_main:
        saved.main_script = note
    else:
        saved.put(script.home, _NOTES[script.kind.name.lower()], **note)
    is_clients_file = script.text is None and sim.files.client_files.holds(script.path(sim), text)
    saved.has_code_of_client |= script.of_client or is_clients_file


def _note(script: Script, text: str) -> Annotation:
    note: Annotation = {"text": text, "language": script.language}
    if script.kind != ScriptKind.MAIN:
        note |= {
            "threaded": script.threaded,
            "enabled": script.enabled if script.interpreter is not None else script.starts_enabled,
            "joint_bases": script.joint_bases,
            "full_results": script.full_results,
        }
        if script.order != Order.NORMAL:
            note["order"] = script.order.name.lower()
        if script.traversal != Traversal.REVERSE:
            note["traversal"] = script.traversal.name.lower()
    return note | {"stops_at_errors": script.stops_at_errors}
