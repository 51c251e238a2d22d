"""Collections: named groups of objects, from `simx:collection:NAME` annotations.

`objects=a,b` single objects, `tree=c` an object with all below it, `below=c` the same without the object itself,
`chain=tip` an object with all above it, `all=yes` everything, `without=d,e` what is left out again. Names are looked
up when the scene is loaded (where they must exist); what hangs on what is looked up anew at each use, as in V-REP.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError, UnknownHandle
from simx_server.scene.annotations import Annotation
from simx_server.scene.objects import Scene

if TYPE_CHECKING:
    from simx_server.simulation import Simulation

FIRST_HANDLE = 2_000_000
"""Collections are numbered from here, as in V-REP."""

ALL = -2
"""`sim_handle_all`."""

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

    def _present(self, scene: Scene, element: str) -> list[int]:
        return [handle for handle in self.elements[element] if handle in scene.objects]


class Collections:
    """All collections of the loaded scene."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._by_handle: dict[int, Collection] = {}
        sim.on_load.append(self._load)
        sim.on_close.append(self._by_handle.clear)

    def __contains__(self, handle: int) -> bool:
        return handle in self._by_handle

    def find(self, name: str) -> int | None:
        """The handle of a collection, or None."""
        return next((h for h, collection in self._by_handle.items() if collection.name == name), None)

    def names(self) -> list[str]:
        return [collection.name for collection in self._by_handle.values()]

    def members(self, handle: int) -> list[int]:
        """Handles of the objects that are in a collection now. Raises CommandError."""
        try:
            return self._by_handle[handle].members(self._sim.scene)
        except KeyError:
            known = ", ".join(f"{h} '{c.name}'" for h, c in self._by_handle.items()) or "none"
            raise CommandError(
                f"no collection with handle {handle}; collections of this scene: {known}"
            ) from None

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
        """The handle of the object or collection that an annotation names, `all` for all. Raises CommandError."""
        if name == "all":
            return ALL
        handle = self._sim.scene.by_name(name)
        handle = self.find(name) if handle is None else handle
        if handle is None:
            raise CommandError(f"no object or collection named '{name}' is left in the scene")
        return handle

    def _load(self) -> None:
        self._by_handle.clear()
        scene = self._sim.scene
        for name, note in scene.annotations.registered.get("collection", {}).items():
            self._by_handle[FIRST_HANDLE + len(self._by_handle)] = _read(scene, name, note)


def _read(scene: Scene, name: str, note: Annotation) -> Collection:
    def handles(listed: str) -> tuple[int, ...]:
        found = (scene.by_name(word) for word in filter(None, listed.split(",")))
        return tuple(handle for handle in found if handle is not None)

    elements = {kind: handles(str(note.get(kind, ""))) for kind in _ELEMENTS}
    return Collection(name, bool(note.get("all", False)), elements)
