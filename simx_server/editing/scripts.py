"""Scripts that scripts make and change: new ones, their texts, another start.

Such a text may come from anywhere, from a client's signal too, so the operator must have allowed code of clients.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scripting.script import LUA, PYTHON, ScriptKind

from .creating import add

if TYPE_CHECKING:
    import mujoco

    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_NOTES = {kind: note for note, kind in SCRIPT_NOTES.items()}

LANGUAGES = (LUA, PYTHON)


def require_permission(world: World) -> None:
    """Raise CommandError unless scripts may run code of clients."""
    if not world.scripts.allows_code:
        raise CommandError(
            "scripts make and change no scripts, since their texts may come from clients; start the server with "
            "--allow-code if they shall"
        )


def create_script(world: World, kind: int, text: str, language: str) -> int:
    """Add a script object at the top of the tree, with a script; return the object's handle.

    Raises:
        CommandError: not allowed, or no such kind or language.
    """
    require_permission(world)
    chosen = checked_kind(kind)
    if language not in LANGUAGES:
        raise CommandError(f"a script's language is {' or '.join(LANGUAGES)}, not '{language[:40]}'")

    def build(spec: mujoco.MjSpec, name: str) -> None:
        spec.worldbody.add_site(name=name, group=5)

    notes: dict[str, Annotation] = {
        "object": {"type": "script"},
        _NOTES[chosen.name.lower()]: _note(text, language),
    }
    return add(world, "script", "site", build, notes)


def checked_kind(kind: int) -> ScriptKind:
    """Return the kind of a new script. Raises CommandError."""
    if kind not in (ScriptKind.CHILD, ScriptKind.CUSTOMIZATION):
        raise CommandError(
            f"a new script is of type {int(ScriptKind.CHILD)} child or {int(ScriptKind.CUSTOMIZATION)} customization, "
            f"not {kind}"
        )
    return ScriptKind(kind)


def set_text(world: World, script: Script, text: str) -> None:
    """Give a script another text, with which it starts the next time. Raises CommandError: not allowed."""
    require_permission(world)
    script.text, script.of_client = text, True
    scene = world.simulation.scene
    if script.kind == ScriptKind.MAIN:
        note = scene.annotations.main_script
        scene.annotations = replace(
            scene.annotations, main_script={**(note or {}), **_note(text, script.language)}
        )
        return
    _annotate(world, script.home, script.kind, {**_note(text, script.language)})


def attach(world: World, script: int, handle: int) -> None:
    """Give a loose script to an object, where it starts as far as it runs now; it keeps its own handle.

    Raises:
        UnknownHandle, CommandError: not allowed, no loose script, or the object has a script of this kind.
    """
    require_permission(world)
    item = world.simulation.scene.get(handle)
    loose = world.scripts.loose.get(script)
    if loose is None:
        raise CommandError(f"script {script} was not made by sim.addScript, or it has an object already")
    if world.scripts.of(handle, loose.kind) is not None:
        raise CommandError(f"'{item.name}' has a {loose.kind.text} already")
    del world.scripts.loose[script]
    _annotate(world, handle, loose.kind, _note(loose.text, LUA))
    world.scripts.adopt(handle, loose.kind, script)


def _annotate(world: World, handle: int, kind: ScriptKind, note: Annotation) -> None:
    scene = world.simulation.scene
    item = scene.get(handle)
    key = _NOTES[kind.name.lower()]
    item.annotations = {**item.annotations, key: {**item.annotations.get(key, {}), **note}}
    notes = {**scene.annotations.objects, item.name: dict(item.annotations)}
    scene.annotations = replace(scene.annotations, objects=notes)


def _note(text: str, language: str) -> dict[str, Any]:
    return {"text": text, "language": language, "of_client": True}
