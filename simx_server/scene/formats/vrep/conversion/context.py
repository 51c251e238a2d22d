"""A conversion in progress: the file, the spec that grows, names, notes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import mujoco
import numpy as np

from simx_server.scene.formats.annotations import ENTITY_PREFIX, PREFIX
from simx_server.scene.formats.texts.values import encode, encode_key
from simx_server.scene.formats.vrep.objects import Collection, VrepFile, VrepObject
from simx_server.scene.formats.vrep.report import Report

Part = TypeVar("Part")

_LARGEST_SINGLE = 3e38


@dataclass
class Conversion:
    """State that the modules of this folder share."""

    file: VrepFile
    spec: mujoco.MjSpec
    report: Report
    names: Mapping[int, str]
    """Handle to the name of the object in the scene: unique, without spaces; the element has it too."""
    notes: dict[tuple[str, str], dict[str, str]] = field(
        default_factory=dict[tuple[str, str], dict[str, str]]
    )

    parts: dict[type, Any] = field(default_factory=dict[type, Any])
    """Objects that single modules keep while they convert, by class."""

    def part(self, kind: type[Part], make: Callable[[], Part]) -> Part:
        """Return what a module keeps, made on first use."""
        if kind not in self.parts:
            self.parts[kind] = make()
        return self.parts[kind]

    def name(self, item: VrepObject) -> str:
        """Return the name of an object in the scene."""
        return self.names[item.handle]

    def entity(self, number: int) -> str | None:
        """Return what an annotation names an entity: an object, a collection, or `all` for -1; None when it is gone."""
        if number == -1:
            return "all"
        collections = [each for each in self.file.collections if each.id == number]
        collection = f"{ENTITY_PREFIX}{collection_name(collections[0])}" if collections else None
        return self.names.get(number, collection)

    def annotate(self, kind: str, name: str, /, **values: object) -> None:
        """Add keys to the annotation `simx:KIND:NAME`; None leaves a key out, True is yes. Any text may be a key."""
        said = {key: _text(value) for key, value in values.items() if value is not None}
        if said:  # MuJoCo takes no empty text
            self.notes.setdefault((kind, name), {}).update(said)

    def write_notes(self) -> None:
        """Write the annotations into the spec; called once, at the end."""
        for (kind, name), note in self.notes.items():
            data = " ".join(f"{encode_key(key)}={encode(value)}" for key, value in note.items())
            self.spec.add_text(name=f"{PREFIX}{kind}:{name}", data=data)


def collection_name(collection: Collection) -> str:
    """Return the name under which a collection is registered: without what separates words of annotations."""
    return "_".join(collection.name.replace(",", " ").split()) or f"collection_{collection.id}"


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return _shortest(value) if isinstance(value, float) else str(value)


def _shortest(value: float) -> str:
    """Return the shortest text of a number; of one that a file has in single precision, 0.7 and not 0.699999988."""
    single = np.float32(value) if abs(value) < _LARGEST_SINGLE else np.float32(0)
    return str(single) if float(single) == value else repr(value)
