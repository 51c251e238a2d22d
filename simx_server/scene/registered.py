"""Entries that `<custom>` registers under separate names (collections, collision, distance, IK groups, UIs), by handle.

The scene's annotations define the entries: an edit passes them on, loading a model adds to them, and the stop restores
the old ones. An entry lives as long as its annotation and its objects exist.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Generic, TypeVar

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from .formats.annotations import ENTITY_PREFIX, FREE, WORLD, Annotation, Value
from .formats.annotations.ros2_keys import JOINT_LISTS, renamed_joints
from .formats.texts.graph_streams import renamed_streams
from .formats.texts.values import read_steps, write_steps

if TYPE_CHECKING:
    from .live import LiveScene

_T = TypeVar("_T")

LISTS = frozenset({"objects", "tree", "below", "chain", "without"})
"""Keys of a collection's annotation that name objects, with commas between them."""

_REFERENCES = ("parent", "master", "entity", "linked")
"""Keys of annotations that name another object."""

_OF_PLANNINGS = ("path", "start", "goal", "robot", "obstacles")
"""Keys of a path planning task that name an object or a collection."""

_OF_MOTIONS = ("robot", "obstacles", "own", "own_others")
"""Keys of a motion planning task that name an object or a collection."""

_REGISTERED_REFERENCES = LISTS | {
    *("entity1", "entity2", "after", "object", "joints", "ik"),
    *_OF_PLANNINGS,
    *_OF_MOTIONS,
}
"""The same keys of registered entries."""

_OF_TIPS = ("tip", "target", "base", "axes")
"""Keys of an IK group that name an object for each tip, with semicolons between them."""


@dataclass(frozen=True)
class _Entry(Generic[_T]):
    name: str
    note: Annotation
    """Annotation in the scene it was read from; another one with the same name is another entry."""
    item: _T


class Registry(Generic[_T]):
    """All entries of one kind. Handles count from `first_handle` and are not reused until another scene is loaded."""

    def __init__(
        self,
        sim: LiveScene,
        kind: str,
        first_handle: int,
        read: Callable[[str, Annotation], _T],
        is_alive: Callable[[_T], bool],
    ) -> None:
        self._sim = sim
        self._kind = kind
        self._first_handle = first_handle
        self._read = read
        self._is_alive = is_alive
        self._entries: dict[int, _Entry[_T]] = {}
        self._seen: object = None

    def get(self, handle: int) -> _T | None:
        """Return the entry that has this handle now, or None."""
        self._look()
        entry = self._entries.get(handle)
        return entry.item if entry is not None and self._is_there(entry) else None

    def __bool__(self) -> bool:
        """Return whether there was ever an entry in this scene."""
        self._look()
        return bool(self._entries)

    def all(self) -> dict[int, tuple[str, _T]]:
        """Return name and item of all present entries, by handle."""
        self._look()
        return {h: (each.name, each.item) for h, each in self._entries.items() if self._is_there(each)}

    def find(self, name: str) -> int | None:
        """Return the handle that a name has now, or None."""
        return next((handle for handle, (known, _) in self.all().items() if known == name), None)

    def handle_of(self, name: str, called: str) -> int:
        """Return the handle of a name from a client, with or without ``#``.

        Raises CommandError that lists the existing names; `called` is the word for such an entry.
        """
        handle = self.find(name.removesuffix("#"))
        if handle is not None:
            return handle
        known = ", ".join(name for name, _ in self.all().values()) or "none"
        raise CommandError(
            f"no {called} named '{name}'; those of this scene: {known}; "
            f"a scene registers one with a text simx:{self._kind}:NAME"
        )

    def _is_there(self, entry: _Entry[_T]) -> bool:
        present = self._sim.scene.annotations.registered.get(self._kind, {})
        return present.get(entry.name) is entry.note and self._is_alive(entry.item)

    def _look(self) -> None:
        """Read new annotations. An edit passes on the same annotations, so this costs one comparison."""
        registered = self._sim.scene.annotations.registered
        if registered is self._seen:
            return
        self._seen = registered
        known = {id(entry.note) for entry in self._entries.values()}
        for name, note in registered.get(self._kind, {}).items():
            if id(note) not in known:
                handle = self._first_handle + len(self._entries)
                self._entries[handle] = _Entry(name, note, self._read(name, note))

    def forget(self) -> None:
        """Reset for another scene: handles are counted from the first one again."""
        self._entries.clear()
        self._seen = None


def concerned(
    present: Mapping[str, Mapping[str, Annotation]], objects: Collection[str]
) -> dict[str, dict[str, Annotation]]:
    """Return the entries that copies of the objects with these names include, per kind and name.

    As in V-REP: a collection without all other objects, unless it is then empty; a collision or distance object
    when both its entities are copied, or one that is tested against all others; an IK group when all its objects are;
    an old custom UI when its object is.
    """
    found: dict[str, dict[str, Annotation]] = {"collection": {}, "collision": {}, "distance": {}}
    for name, registered in present.get("collection", {}).items():
        note = dict(registered)
        for key in LISTS & note.keys():
            note[key] = ",".join(word for word in str(note[key]).split(",") if word in objects)
        if "steps" in note:
            note["steps"] = _concerned_steps(str(note["steps"]), objects)
        if any(note.get(key) for key in (LISTS | {"steps"}) - {"without"}):
            found["collection"][name] = note
    entities = {*objects, *found["collection"], *(f"{ENTITY_PREFIX}{name}" for name in found["collection"])}
    for kind in ("collision", "distance"):
        for name, note in present.get(kind, {}).items():
            if note["entity1"] in entities and note.get("entity2", "all") in {*entities, "all"}:
                found[kind][name] = note
    known = {*objects, WORLD}
    found["ik"] = {
        name: note
        for name, note in present.get("ik", {}).items()
        if all(known.issuperset(str(note[key]).split(";")) for key in _OF_TIPS if key in note)
    }
    found["planning"] = {
        name: note
        for name, note in present.get("planning", {}).items()
        if all(note.get(key, "all") in {*entities, "all"} for key in _OF_PLANNINGS)
    }
    found["motion_planning"] = {
        name: note
        for name, note in present.get("motion_planning", {}).items()
        if note["ik"] in found["ik"]
        and all(joint in objects for joint in str(note["joints"]).split(","))
        and all(note.get(key, "all") in {*entities, "all"} for key in _OF_MOTIONS)
    }
    found["old_ui"] = {
        name: note for name, note in present.get("old_ui", {}).items() if note.get("object") in objects
    }
    return {kind: notes for kind, notes in found.items() if notes}


def _concerned_steps(value: str, objects: Collection[str]) -> str:
    """Return the steps of a collection that concern these objects; nothing when none adds any of them."""
    kept = [step for step in read_steps(value) if step[1] == "all" or step[2] in objects]
    adds = any(not taken_out and name in objects for taken_out, _, name in kept)
    is_of_all = any(kind == "all" for _, kind, _ in kept) and any(name in objects for _, _, name in kept)
    return write_steps(kept) if adds or is_of_all else ""


def renamed_registered(note: Annotation, names: Mapping[str, str]) -> Annotation:
    """Return a registered entry with its objects renamed."""

    def new(key: str, value: Value) -> Value:
        if key == "steps":
            steps = read_steps(str(value))
            return write_steps([(out, kind, names.get(name, name)) for out, kind, name in steps])
        separator = "," if key in _REGISTERED_REFERENCES else ";" if key in _OF_TIPS else None
        if separator is None:
            return value
        return separator.join(_renamed(word, names) for word in str(value).split(separator))

    return {key: new(key, value) for key, value in note.items()}


def renamed(notes: dict[str, Annotation], names: Mapping[str, str]) -> dict[str, Annotation]:
    """Return the annotations of one object with references to the added objects."""

    def new(kind: str, key: str, value: Value) -> Value:
        if (kind, key) == ("graph", "streams"):
            return renamed_streams(str(value), names)
        if kind == "ros2" and key in JOINT_LISTS:
            return renamed_joints(key, str(value), names)
        if kind == "references":
            return ",".join(_renamed(word, names) for word in str(value).split(","))
        return _renamed(str(value), names) if key in _REFERENCES and kind not in FREE else value

    return {kind: {key: new(kind, key, value) for key, value in note.items()} for kind, note in notes.items()}


def _renamed(name: str, names: Mapping[str, str]) -> str:
    """Return the new name of an object or collection."""
    plain = name.removeprefix(ENTITY_PREFIX)
    return name.removesuffix(plain) + names.get(plain, plain)
