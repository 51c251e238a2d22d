"""Collections: named groups of objects, from `simx:collection:NAME` annotations.

`objects=a,b` single objects, `tree=c` an object with all below it, `below=c` the same without the object itself,
`chain=tip` an object with all above it, `all=yes` everything, `without=d,e` what is left out again. Names are looked
up when the scene or model is loaded (where they must exist); what hangs on what is looked up anew at each use, as in
V-REP.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError, UnknownHandle
from simx_server.scene.annotations import Annotation
from simx_server.scene.objects import Scene
from simx_server.scene.registered import Registry

if TYPE_CHECKING:
    from simx_server.simulation import Simulation

FIRST_HANDLE = 2_000_000
"""Collections are numbered from here, as in V-REP."""

ALL = -2
"""`sim_handle_all`."""

GONE = 0
"""In place of the handle of what is named and not there (any more); no object has it."""

_ELEMENTS = ("objects", "tree", "below", "chain", "without")


@dataclass(frozen=True)
class Collection:
    """What a collection is made of: handles per kind of element."""

    name: str
    everything: bool
    elements: dict[str, tuple[int, ...]]

    def members(self, scene: Scene) -> list[int]:
        """Handles of the objects that are in it now, in scene order."""
        found: set[int] = set(scene.objects) if self.everything else set()
        for handle in self._present(scene, "objects"):
            found.add(handle)
        for handle in self._present(scene, "tree"):
            found.update((handle, *scene.descendants(handle)))
        for handle in self._present(scene, "below"):
            found.update(scene.descendants(handle))
        for handle in self._present(scene, "chain"):
            while handle != -1:
                found.add(handle)
                handle = scene.objects[handle].parent
        found.difference_update(self.elements["without"])
        return [handle for handle in scene.objects if handle in found]

    def is_alive(self, scene: Scene) -> bool:
        """False when nothing is left of what it was made of: then V-REP removes it."""
        parts = [element for element in _ELEMENTS if element != "without"]
        if self.everything or not any(self.elements[part] for part in parts):
            return True
        return any(self._present(scene, part) for part in parts)

    def _present(self, scene: Scene, element: str) -> list[int]:
        return [handle for handle in self.elements[element] if handle in scene.objects]


class Collections:
    """All collections of the scene: those of its file, and those of the models loaded since."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._registry = Registry(
            sim,
            "collection",
            FIRST_HANDLE,
            lambda name, note: _read(sim.scene, name, note),
            lambda collection: collection.is_alive(sim.scene),
        )

    def __contains__(self, handle: int) -> bool:
        return self._registry.get(handle) is not None

    def find(self, name: str) -> int | None:
        """The handle of a collection, or None."""
        return self._registry.find(name)

    def names(self) -> list[str]:
        return [name for name, _ in self._registry.all().values()]

    def members(self, handle: int) -> list[int]:
        """Handles of the objects that are in a collection now. Raises CommandError."""
        collection = self._registry.get(handle)
        if collection is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(f"no collection with handle {handle}; collections of this scene: {known}")
        return collection.members(self._sim.scene)

    def entity(self, handle: int) -> list[int]:
        """The objects an entity stands for: an object, a collection, or all (`sim_handle_all`). Raises CommandError."""
        scene = self._sim.scene
        if handle == ALL:
            return list(scene.objects)
        if handle in scene.objects:
            return [handle]
        if handle >= FIRST_HANDLE:
            return self.members(handle)
        raise UnknownHandle(handle, scene.objects)

    def named(self, name: str) -> int:
        """The handle of the object or collection that an annotation names: ALL for `all`, GONE if it is not there."""
        if name == "all":
            return ALL
        return self._sim.scene.by_name(name) or self.find(name) or GONE


def _read(scene: Scene, name: str, note: Annotation) -> Collection:
    def handles(listed: str) -> tuple[int, ...]:
        return tuple(scene.by_name(word) or GONE for word in filter(None, listed.split(",")))

    elements = {kind: handles(str(note.get(kind, ""))) for kind in _ELEMENTS}
    return Collection(name, bool(note.get("all", False)), elements)
