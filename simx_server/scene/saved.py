"""The scene or model that is being saved: its spec and its annotations, to which each part of the world adds its state.

`Part.saving` gets it. A part reads its annotations again when the file is loaded.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import field
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .formats.annotations import GRAMMAR, PASSING, Annotation, Annotations, Value
from .formats.texts.scripts import SCRIPT_NOTES

if TYPE_CHECKING:
    import mujoco

    from .objects import Scene

_REBUILT = {*SCRIPT_NOTES, *PASSING}
"""Kinds of annotations that are not taken over: scripts write theirs, and the others have made what is there."""


@dataclass
class Saved:
    """The content of a file. All names are those of the objects in the scene."""

    spec: mujoco.MjSpec
    """Its elements have their names in the scene's model."""
    names: Mapping[int, str]
    """Handles of the saved objects, rising, with their names."""
    objects: dict[int, dict[str, Annotation]]
    registered: dict[str, dict[str, Annotation]]
    is_model: bool
    settings: Annotation = field(default_factory=dict[str, Value])
    """Of the whole scene; a model has none."""
    data: Annotation = field(default_factory=dict[str, Value])
    ros2: Annotation = field(default_factory=dict[str, Value])
    main_script: Annotation | None = None
    time_step: float | None = None
    has_code_of_client: bool = False
    """Whether a client sent one of its scripts."""

    @classmethod
    def of(cls, scene: Scene, spec: mujoco.MjSpec, handles: Iterable[int], *, is_model: bool) -> Saved:
        """Return the annotations that objects have now, from their file or from later changes."""
        items = [scene.objects[handle] for handle in sorted(handles)]
        notes = scene.annotations
        found = cls(
            spec=spec,
            names={item.handle: item.name for item in items},
            objects={
                item.handle: {
                    kind: dict(note) for kind, note in item.annotations.items() if kind not in _REBUILT
                }
                for item in items
            },
            registered=deepcopy({kind: dict(each) for kind, each in notes.registered.items()}),
            is_model=is_model,
        )
        if not is_model:
            found.settings, found.ros2 = dict(notes.scene), dict(notes.ros2)
        return found

    def put(self, handle: int, kind: str, /, **values: Value | None) -> None:
        """Set keys of an object's annotation; None removes a key."""
        note = self.objects[handle].setdefault(kind, {})
        for key, value in values.items():
            if value is None:
                note.pop(key, None)
            else:
                note[key] = value
        if not note:
            del self.objects[handle][kind]

    def drop(self, handle: int, kind: str) -> None:
        """Remove an object's annotation."""
        self.objects[handle].pop(kind, None)

    def name(self, handle: int) -> str | None:
        """Return the name of a saved object; None for any other handle."""
        return self.names.get(handle)

    def annotations(self) -> Annotations:
        """Return all annotations, for the file."""
        return Annotations(
            objects={self.names[handle]: _in_order(notes) for handle, notes in self.objects.items() if notes},
            registered=self.registered,
            main_script=self.main_script,
            data=self.data,
            scene={} if self.is_model else self.settings,
            ros2=self.ros2,
            time_step=self.time_step,
        )


def _in_order(notes: Mapping[str, Annotation]) -> dict[str, Annotation]:
    """Return the annotations of an object, and their keys, in the order of the grammar."""
    kinds = [*SCRIPT_NOTES, *GRAMMAR]
    places = {kind: list(GRAMMAR.get(kind, ())) for kind in notes}
    return {
        kind: dict(
            sorted(
                notes[kind].items(),
                key=lambda item, keys=places[kind]: keys.index(item[0]) if item[0] in keys else -1,
            )
        )
        for kind in sorted(notes, key=kinds.index)
    }


def listed(names: Iterable[str], separator: str = ",") -> str:
    """Return names as the value of an annotation's key.

    Raises:
        CommandError: a name contains the separator.
    """
    found = list(names)
    if bad := [name for name in found if separator in name]:
        raise CommandError(
            f"'{bad[0]}' belongs to a list of names, which '{separator}' separates; rename it without '{separator}' "
            "before saving"
        )
    return separator.join(found)


def numbers_text(values: Iterable[float]) -> str:
    """Return numbers as the value of an annotation's key."""
    return ",".join(repr(float(value)).removesuffix(".0") for value in values)
