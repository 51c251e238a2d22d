"""Scripts as annotations: read when a file is loaded, and written when it is saved."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.objects import ObjectKind, SceneObject

from .script import LUA, PYTHON, Order, Script, ScriptKind, Traversal

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

KINDS = {kind: ScriptKind[script_type.upper()] for kind, script_type in SCRIPT_NOTES.items()}
"""Kind of annotation to kind of script."""

_NOTES = {kind: note for note, kind in KINDS.items()}


def read_script(
    note: Annotation,
    kind: ScriptKind,
    handle: int,
    name: str,
    home: SceneObject | None,
    *,
    is_of_client: bool,
) -> Script:
    """Return the script of an annotation.

    Args:
        note: the annotation.
        kind: of the script.
        handle: of the script.
        name: of its object, or ``main``: its file is called so, if it has none.
        home: the object with the annotation; None: it is the scene's.
        is_of_client: a client sent the scene.
    """
    is_object = home is not None and home.kind == ObjectKind.SCRIPT
    text, file = note.get("text"), str(note.get("file", ""))
    language = str(note.get("language", PYTHON if file.endswith(".py") else LUA))
    middle = "" if kind == ScriptKind.CHILD else f".{kind.name.lower()}"
    suffix = ".py" if language == PYTHON else ".lua"
    return Script(
        handle=handle,
        kind=kind,
        owner=-1 if home is None else home.parent if is_object else home.handle,
        place=home.handle if home is not None and is_object else -1,
        file=file or f"{name}{'' if name == 'main' else middle}{suffix}",
        text=None if text is None else str(text),
        folder=Path(str(note["folder"])) if "folder" in note else None,
        of_client=bool(note.get("of_client", is_of_client)),
        language=language,
        threaded=bool(note.get("threaded", False)),
        enabled=bool(note.get("enabled", True)),
        starts_enabled=bool(note.get("enabled", True)),
        joint_bases=bool(note.get("joint_bases", False)),
        full_results=bool(note.get("full_results", language == PYTHON)),
        stops_at_errors=bool(note.get("stops_at_errors", True)),
        order=Order[str(note.get("order", "normal")).upper()],
        traversal=Traversal[str(note.get("traversal", "reverse")).upper()],
    )


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
        saved.put(script.home, _NOTES[script.kind], **note)
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
