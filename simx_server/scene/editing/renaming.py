"""Change the name, alias or annotation of an object in a loaded scene. The stop undoes it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Value
from simx_server.scene.naming.names import alias_of
from simx_server.scene.registered import renamed

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_NAME = re.compile(r"[^/@#*?\[\]{}]+(#\d+)?")
_NOT_IN_ALIAS = re.compile(r"[/@#*?\[\]{}]")


def rename(sim: LiveScene, handle: int, name: str) -> None:
    """Change an object's name, and the alias that goes with it; references by name stay valid.

    Collections, collision and distance objects keep the object, but a copy of it does not include them any more.
    Raises UnknownHandle, CommandError: invalid name, or another object has it.
    """
    scene = sim.scene
    item = scene.get(handle)
    if not _NAME.fullmatch(name):
        raise CommandError(
            f"{name!r} is no name for an object; it has none of / @ * ? [ ] {{ }}, and # before a number"
        )
    other = scene.by_name(name)
    if other == handle:
        return
    if other is not None:
        raise CommandError(f"another object, with handle {other}, is named '{name}'; names are there once")
    names = {item.name: name}
    notes = scene.annotations.objects
    scene.annotations = replace(
        scene.annotations,
        objects={names.get(owner, owner): renamed(note, names) for owner, note in notes.items()},
    )
    item.name, item.alias = name, alias_of(name)
    for each in scene.objects.values():
        each.annotations = scene.annotations.objects.get(each.name, {})
    scene.reindex()
    sim.model_edited()  # parts with a copy of the model keep names
    sim.changed()


def set_alias(sim: LiveScene, handle: int, alias: str) -> None:
    """Set an object's alias, which other objects may share. Characters that no alias has become _, as in
    CoppeliaSim. Raises UnknownHandle.
    """
    item = sim.scene.get(handle)
    item.alias = _NOT_IN_ALIAS.sub("_", alias) or "_"
    sim.changed()


def annotate(sim: LiveScene, handle: int, kind: str, values: dict[str, Value]) -> None:
    """Add an annotation to the object as if it were in the scene's file. Raises UnknownHandle."""
    _replace_note(sim, handle, kind, {**sim.scene.get(handle).annotations.get(kind, {}), **values})


def scale_annotation(
    sim: LiveScene, handle: int, kind: str, powers: Mapping[str, int], factor: float
) -> None:
    """Multiply numbers of an object's annotation, where it has them, by powers of a factor. Raises UnknownHandle."""
    note = sim.scene.get(handle).annotations.get(kind, {})
    scaled = {key: float(note[key]) * factor**power for key, power in powers.items() if key in note}
    if scaled:
        annotate(sim, handle, kind, dict(scaled))


def drop_key(sim: LiveScene, handle: int, kind: str, key: str) -> None:
    """Remove a key of an annotation; do nothing without one. Raises UnknownHandle."""
    note = sim.scene.get(handle).annotations.get(kind, {})
    if key in note:
        _replace_note(sim, handle, kind, {each: value for each, value in note.items() if each != key})


def _replace_note(sim: LiveScene, handle: int, kind: str, note: dict[str, Value]) -> None:
    scene = sim.scene
    item = scene.get(handle)
    item.annotations = {**item.annotations, kind: note}
    notes = scene.annotations.objects
    scene.annotations = replace(scene.annotations, objects={**notes, item.name: dict(item.annotations)})
    sim.changed()
