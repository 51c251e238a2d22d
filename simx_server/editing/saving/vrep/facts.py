"""All facts of a world that V-REP's files know of, in a form in which two worlds can be compared."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from simx_server.editing.saving.notes import noted
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.texts.graph_streams import USER, read_streams, write_streams
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.objects import ObjectKind
from simx_server.scene.saved import Saved

from .common import COMMON
from .field import Fields, Handle
from .kinds.clouds import CLOUDS
from .kinds.dummies import DUMMIES, FORCE_SENSORS
from .kinds.graphs import GRAPHS
from .kinds.joints import JOINTS
from .kinds.paths import PATHS
from .kinds.sensors import CAMERAS, LIGHTS, PROXIMITY_SENSORS, VISION_SENSORS
from .kinds.shapes import SHAPES

if TYPE_CHECKING:
    from simx_server.world.world import World

OF_KIND: Mapping[ObjectKind, Fields] = {
    ObjectKind.SHAPE: SHAPES,
    ObjectKind.JOINT: JOINTS,
    ObjectKind.DUMMY: DUMMIES,
    ObjectKind.FORCE_SENSOR: FORCE_SENSORS,
    ObjectKind.VISION_SENSOR: VISION_SENSORS,
    ObjectKind.PROXIMITY_SENSOR: PROXIMITY_SENSORS,
    ObjectKind.CAMERA: CAMERAS,
    ObjectKind.LIGHT: LIGHTS,
    ObjectKind.PATH: PATHS,
    ObjectKind.OCTREE: CLOUDS,
    ObjectKind.POINT_CLOUD: CLOUDS,
    ObjectKind.GRAPH: GRAPHS,
}

_ONLY_COMPARED = ("graph", "ros2")
"""Kinds of annotations whose facts are compared, and not written."""

_CLOSE = 1e-9
"""Difference of numbers below which they are equal: they differ in their last digits after an edit."""


@dataclass(frozen=True)
class Facts:
    """The facts of one world."""

    world: World
    saved: Saved
    of_objects: Mapping[int, Mapping[str, Any]]
    """Values of the fields by handle."""

    @classmethod
    def of(cls, world: World, handles: Iterable[int], *, is_model: bool) -> Facts:
        """Collect the facts of these objects."""
        sim = world.simulation
        sim.refresh()
        handles = list(handles)
        values = {handle: facts_of_object(world, handle) for handle in handles}
        return cls(world, noted(sim, sim.scene.spec.copy(), handles, is_model=is_model), values)

    def scripts(self, handle: int) -> Mapping[str, Annotation]:
        """Return the scripts of an object by kind: their texts and options."""
        return {kind: note for kind, note in self.saved.objects[handle].items() if kind in SCRIPT_NOTES}

    def notes(self, handle: int) -> Mapping[str, Annotation]:
        """Return the annotations that are compared, and not written."""
        notes = self.saved.objects[handle]
        return {
            kind: _lasting(note) for kind, note in notes.items() if kind in _ONLY_COMPARED and _lasting(note)
        }


def _lasting(note: Annotation) -> Annotation:
    """Return the keys that are compared: scripts and clients that give a graph its values add these streams again."""
    measured = [each for each in read_streams(str(note.get("streams", ""))) if each.measures != USER]
    rest = {
        key: value for key, value in note.items() if key not in ("streams", "curves") and value is not False
    }
    return {**rest, "streams": write_streams(measured)} if measured else rest


def fields_of(kind: ObjectKind) -> Fields:
    """Return all fields of a kind of object; those of the kind come first."""
    return {**OF_KIND.get(kind, {}), **COMMON}


def facts_of_object(world: World, handle: int) -> dict[str, Any]:
    """Return the values of all fields of an object."""
    kind = world.simulation.scene.objects[handle].kind
    return {name: field.get(world, handle) for name, field in fields_of(kind).items()}


def are_equal(one: Any, other: Any) -> bool:
    """Return whether two values are the same, numbers up to their last digits."""
    if isinstance(one, (float, int)) and isinstance(other, (float, int)):
        return math.isclose(one, other, rel_tol=_CLOSE, abs_tol=_CLOSE)
    if isinstance(one, tuple) and isinstance(other, tuple):
        first, second = cast("tuple[Any, ...]", one), cast("tuple[Any, ...]", other)
        return len(first) == len(second) and all(map(are_equal, first, second))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        known, found = cast("Mapping[Any, Any]", one), cast("Mapping[Any, Any]", other)
        return known.keys() == found.keys() and all(are_equal(known[key], found[key]) for key in known)
    return bool(one == other)


def numbered(value: Any, numbers: Mapping[int, int]) -> Any:
    """Return a value with the numbers of a file in place of handles; -1 for those that the file has not."""
    if isinstance(value, Handle):
        return Handle(numbers.get(value.number, -1))
    if isinstance(value, tuple):
        return tuple(numbered(each, numbers) for each in cast("tuple[Any, ...]", value))
    if isinstance(value, Mapping):
        return {key: numbered(each, numbers) for key, each in cast("Mapping[Any, Any]", value).items()}
    return value


def has_handles(value: Any) -> bool:
    """Return whether a value names other objects."""
    if isinstance(value, Handle):
        return value.number >= 0
    if isinstance(value, Mapping):
        return any(map(has_handles, cast("Mapping[Any, Any]", value).values()))
    return isinstance(value, tuple) and any(map(has_handles, cast("tuple[Any, ...]", value)))
