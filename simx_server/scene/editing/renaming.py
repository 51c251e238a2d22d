"""Giving an object of a scene another name, alias or annotation while it is there. A stop takes it back."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import Value
from simx_server.scene.names import alias_of
from simx_server.scene.registered import renamed

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

_NAME = re.compile(r"[^/@#*?\[\]{}]+(#\d+)?")
_ALIAS = re.compile(r"[^/@#*?\[\]{}]+")


def rename(sim: LiveScene, handle: int, name: str) -> None:
    """Give an object another name, and the alias that goes with it; what refers to it by name goes on doing so.

    Collections, collision and distance objects keep it, but a copy of it does not bring them along any more.
    Raises UnknownHandle, CommandError: no possible name, or another object has it.
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
    sim.model_edited()  # what keeps a copy keeps names
    sim.changed()


def set_alias(sim: LiveScene, handle: int, alias: str) -> None:
    """Several objects may have the same one. Raises UnknownHandle, CommandError: no possible alias."""
    item = sim.scene.get(handle)
    if not _ALIAS.fullmatch(alias):
        raise CommandError(f"{alias!r} is no alias for an object; it has none of / @ # * ? [ ] {{ }}")
    item.alias = alias
    sim.changed()


def annotate(sim: LiveScene, handle: int, kind: str, values: dict[str, Value]) -> None:
    """As if the scene's file said this of the object. Raises UnknownHandle."""
    scene = sim.scene
    item = scene.get(handle)
    note = {**item.annotations.get(kind, {}), **values}
    item.annotations = {**item.annotations, kind: note}
    notes = scene.annotations.objects
    scene.annotations = replace(scene.annotations, objects={**notes, item.name: dict(item.annotations)})
    sim.changed()
