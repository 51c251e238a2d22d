"""Collections: named groups of objects, from `simx:collection:NAME` annotations.

`objects=a,b` single objects, `tree=c` an object with all below it, `below=c` the same without the object itself,
`chain=tip` an object with all above it, `all=yes` everything, `without=d,e` exceptions; `steps=+all,-tree:c` the same
in any order; `overrides=yes` for objects that are measured and detected whatever they are declared. Names are resolved
when the scene or model is loaded (where they must exist); the tree is searched at each use, as in V-REP. A script can
create more collections, and change any of them: until the stop, if it did so while running.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError, UnknownHandle
from simx_server.simulation.part import Part

from .formats.annotations import ENTITY_PREFIX, Annotation
from .formats.texts.values import read_steps, write_steps
from .objects import Scene
from .registered import Registry
from .saved import listed

if TYPE_CHECKING:
    from .live import LiveScene
    from .saved import Saved

FIRST_HANDLE = 2_000_000
"""First handle of collections, as in V-REP."""

FIRST_MADE = 2_005_000
"""First handle of collections that scripts make."""

ALL = -2
"""`sim_handle_all`."""

GONE = 0
"""Handle that replaces one of a named object that does not exist (any more); no object has it."""

_STEP_ELEMENTS = {"object": "objects"}
_STEP_WORDS = {element: word for word, element in _STEP_ELEMENTS.items()}
"""Kinds of steps whose element has another name."""

_ELEMENTS = ("objects", "tree", "below", "chain", "without")


Step = tuple[str, int, bool]
"""Kind of element, handle, whether it is taken out. Beside the kinds of annotations there are `all`, which takes no
handle, and `above`, a chain without the object itself."""


@dataclass(frozen=True)
class Collection:
    """The definition of a collection: handles per kind of element."""

    name: str
    everything: bool
    elements: dict[str, tuple[int, ...]]
    steps: tuple[Step, ...] = ()
    """Steps that add and remove objects after that, in their order."""
    overrides: bool = False
    """Its objects are measured and detected whatever they are declared to be."""

    def members(self, scene: Scene) -> list[int]:
        """Return the handles of the objects that it contains now, in scene order."""
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
        found = _after(found, self.steps, scene)
        return [handle for handle in scene.objects if handle in found]

    def is_alive(self, scene: Scene) -> bool:
        """Return False when none of its elements exists any more: V-REP then removes it."""
        named = [handle for part in _ELEMENTS if part != "without" for handle in self.elements[part]]
        named += [handle for kind, handle, taken_out in self.steps if kind != "all" and not taken_out]
        everything = self.everything or any(
            kind == "all" for kind, _, taken_out in self.steps if not taken_out
        )
        return everything or not named or any(handle in scene.objects for handle in named)

    def _present(self, scene: Scene, element: str) -> list[int]:
        return [handle for handle in self.elements[element] if handle in scene.objects]


@dataclass(frozen=True)
class EditedCollection:
    """A collection that a script created or changed: steps that add or remove objects, in their order."""

    name: str
    origin: Collection | None = None
    """The collection before the first step."""
    steps: tuple[Step, ...] = ()
    overrides: bool = False

    def members(self, scene: Scene) -> list[int]:
        """Return the handles of the objects that it contains now, in scene order."""
        found: set[int] = set() if self.origin is None else set(self.origin.members(scene))
        found = _after(found, self.steps, scene)
        return [handle for handle in scene.objects if handle in found]


class Collections(Part):
    """All collections of the scene: those of its file, and those of the models loaded since."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._registry = Registry(
            sim,
            "collection",
            FIRST_HANDLE,
            lambda name, note: _read(sim.scene, name, note),
            lambda collection: collection.is_alive(sim.scene),
        )

        self._edited: dict[int, EditedCollection | None] = {}
        """Edited collections by handle; None: removed."""
        self._before_run = self._edited
        self._made = 0

    def run_started(self) -> None:
        self._remember()

    def run_stopped(self) -> None:
        self._restore()

    def scene_changed(self) -> None:
        self._forget()

    def remember(self) -> object:
        return self._edited, self._made

    def recall(self, memory: Any) -> None:
        self._edited, self._made = memory

    def __contains__(self, handle: int) -> bool:
        return self._find(handle) is not None

    def find(self, name: str) -> int | None:
        """Return the handle of a collection, or None."""
        return next((handle for handle, known in self._all().items() if known == name), None)

    def saving(self, saved: Saved) -> None:
        present = {handle: self._get(handle) for handle in self._all()}
        notes = {each.name: _note(saved, each) for each in present.values()}
        saved.registered["collection"] = {name: note for name, note in notes.items() if note is not None}

    def saved_name(self, saved: Saved, entity: int) -> str | None:
        """Return what an annotation of a saved object names an entity; None when it is not saved."""
        if entity == ALL:
            return "all"
        if (name := saved.name(entity)) is not None:
            return name
        found = self._find(entity)
        known = found is not None and _note(saved, found) is not None
        return f"{ENTITY_PREFIX}{found.name}" if found is not None and known else None

    def registered_names(self) -> Mapping[str, list[str]]:
        return {"collection": self.names()}

    def names(self) -> list[str]:
        """Return the names of the collections that the scene registers."""
        return [name for name, _ in self._registry.all().values()]

    def handles(self) -> list[int]:
        """Return the handles of all collections."""
        return list(self._all())

    def name(self, handle: int) -> str:
        """Return the name of a collection. Raises CommandError."""
        return self._get(handle).name

    def overrides(self, handle: int) -> bool:
        """Return whether this is a collection whose objects are measured and detected whatever they are declared."""
        collection = self._find(handle)
        return collection is not None and collection.overrides

    def rename(self, handle: int, name: str) -> None:
        """Give a collection another name. Raises CommandError for a name that is taken."""
        collection = self._get(handle)
        if not name or self.find(name) not in (None, handle):
            raise CommandError(f"'{name}' cannot name this collection; give one that no other collection has")
        origin = collection if isinstance(collection, Collection) else collection.origin
        steps = () if isinstance(collection, Collection) else collection.steps
        renamed = EditedCollection(name, origin, steps, collection.overrides)
        self._edited = {**self._edited, handle: renamed}

    def create(self, name: str, *, overrides: bool = False) -> int:
        """Create an empty collection and return its handle. Raises CommandError for a name that is taken."""
        if not name or self.find(name) is not None:
            raise CommandError(f"'{name}' cannot name another collection; give one that no collection has")
        made = sum(each is not None for each in self._edited.values())
        self._sim.limits.check("collections", made + 1, "destroy some")
        handle = FIRST_MADE + self._made
        self._made += 1
        self._edited = {**self._edited, handle: EditedCollection(name, overrides=overrides)}
        return handle

    def change(self, handle: int, kind: str, item: int, *, taken_out: bool) -> None:
        """Add objects or remove them: kind as in `EditedCollection`. Raises CommandError."""
        collection = self._get(handle)
        if kind != "all":
            self._sim.scene.get(item)
        if isinstance(collection, Collection):
            collection = EditedCollection(collection.name, collection, overrides=collection.overrides)
        changed = replace(collection, steps=(*collection.steps, (kind, item, taken_out)))
        self._edited = {**self._edited, handle: changed}

    def empty(self, handle: int) -> None:
        """Remove all objects from a collection. Raises CommandError."""
        earlier = self._get(handle)
        emptied = EditedCollection(earlier.name, overrides=earlier.overrides)
        self._edited = {**self._edited, handle: emptied}

    def remove(self, handle: int) -> None:
        """Remove a collection. Raises CommandError."""
        self._get(handle)
        self._edited = {**self._edited, handle: None}

    def members(self, handle: int) -> list[int]:
        """Return the handles of the objects that a collection contains now. Raises CommandError."""
        return self._get(handle).members(self._sim.scene)

    def entity(self, handle: int) -> list[int]:
        """Return the objects of an entity: an object, a collection, or all (`sim_handle_all`). Raises CommandError."""
        scene = self._sim.scene
        if handle == ALL:
            return list(scene.objects)
        if handle in scene.objects:
            return [handle]
        if handle >= FIRST_HANDLE:
            return self.members(handle)
        raise UnknownHandle(handle, scene.objects)

    def named(self, name: str) -> int:
        """Return the handle of the object or collection in an annotation: ALL for `all`, GONE for a missing one."""
        if name == "all":
            return ALL
        if name.startswith(ENTITY_PREFIX):
            return self.find(name.removeprefix(ENTITY_PREFIX)) or GONE
        return self._sim.scene.by_name(name) or self.find(name) or GONE

    def _find(self, handle: int) -> Collection | EditedCollection | None:
        return self._edited[handle] if handle in self._edited else self._registry.get(handle)

    def _get(self, handle: int) -> Collection | EditedCollection:
        collection = self._find(handle)
        if collection is None:
            known = ", ".join(f"{h} '{name}'" for h, name in self._all().items()) or "none"
            raise CommandError(f"no collection with handle {handle}; collections of this scene: {known}")
        return collection

    def _all(self) -> dict[int, str]:
        """Return the names of all existing collections by handle."""
        registered = {handle: name for handle, (name, _) in self._registry.all().items()}
        edited = {handle: each.name for handle, each in self._edited.items() if each is not None}
        return {h: name for h, name in (registered | edited).items() if self._edited.get(h, name) is not None}

    def _remember(self) -> None:
        self._before_run = self._edited

    def _restore(self) -> None:
        self._edited = self._before_run

    def _forget(self) -> None:
        self._registry.forget()
        self._edited = self._before_run = {}
        self._made = 0


def _after(found: set[int], steps: tuple[Step, ...], scene: Scene) -> set[int]:
    """Return what a set of objects becomes by some steps."""
    for kind, handle, taken_out in steps:
        elements = {each: (handle,) if each == kind else () for each in _ELEMENTS}
        if kind == "above":
            elements["chain"] = (handle,)
            elements["without"] = (handle,)
        some = Collection("", kind == "all", elements).members(scene)
        found = found.difference(some) if taken_out else found.union(some)
    return found


def _note(saved: Saved, collection: Collection | EditedCollection) -> Annotation | None:
    """Return the annotation of a collection with its saved objects; None where a model has no part of it."""
    named = [
        (taken_out, _STEP_WORDS.get(kind, kind), saved.name(handle) or "")
        for kind, handle, taken_out in _steps(collection)
        if kind == "all" or handle in saved.names
    ]
    if saved.is_model and not any(name for _, _, name in named):
        return None
    listed(name for _, _, name in named)
    steps: Annotation = {"steps": write_steps(named)} if named else {}
    return {"all": False, "overrides": collection.overrides} | steps


def _steps(collection: Collection | EditedCollection) -> tuple[Step, ...]:
    """Return all that a collection consists of, as steps."""
    if isinstance(collection, EditedCollection):
        return (*(() if collection.origin is None else _steps(collection.origin)), *collection.steps)
    first: list[Step] = [("all", 0, False)] if collection.everything else []
    for kind in _ELEMENTS:
        is_exception = kind == "without"
        first += [
            ("objects" if is_exception else kind, each, is_exception) for each in collection.elements[kind]
        ]
    return (*first, *collection.steps)


def _read(scene: Scene, name: str, note: Annotation) -> Collection:
    def handles(listed: str) -> tuple[int, ...]:
        return tuple(scene.by_name(word) or GONE for word in filter(None, listed.split(",")))

    elements = {kind: handles(str(note.get(kind, ""))) for kind in _ELEMENTS}
    steps = tuple(
        (_STEP_ELEMENTS.get(kind, kind), scene.by_name(named) or GONE, taken_out)
        for taken_out, kind, named in read_steps(str(note.get("steps", "")))
    )
    overrides = bool(note.get("overrides", False))
    return Collection(name, bool(note.get("all", False)), elements, steps, overrides)
