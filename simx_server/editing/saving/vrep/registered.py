"""Entries beside the objects: collections, groups of inverse kinematics, collision and distance objects, old UIs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import ENTITY_PREFIX, Annotation
from simx_server.scene.formats.texts.graph_streams import plain_name
from simx_server.scene.formats.texts.values import read_steps
from simx_server.scene.formats.vrep.chunks import decoded
from simx_server.scene.formats.vrep.conversion.facts.registered import KINDS
from simx_server.scene.formats.vrep.conversion.unique_names import UniqueNames
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list
from simx_server.scene.formats.vrep.writing.top_level import TopRecord

from .field import NotInVrepFiles, Writing
from .ik_groups import IK_GROUP, ik_group, ik_numbers

if TYPE_CHECKING:
    from .baseline import Baseline
    from .facts import Facts

_GROUP, _UI = "GRP", "BBK"

ENTRIES = {
    _GROUP: ("collection", "Grn"),
    "COL": ("collision", "Nme"),
    "DST": ("distance", "Nme"),
    IK_GROUP: ("ik", "Nme"),
    "PPL": ("planning", "Nme"),
    "MPL": ("motion_planning", "Nme"),
    _UI: ("old_ui", "Bkn"),
}
"""Tags of entries: kind of annotation, and tag of the name."""

FIRST_COLLECTION = 2_000_000
"""First number of a collection in a file."""

_PAIRS = {"collision": "COL", "distance": "DST"}
_FIRST_PAIR = {"COL": 2_010_000, "DST": 2_020_000}
"""Tags of entries that measure two entities, and the first number of each kind in a file."""

_NUMBERS = {kind: number for number, kind in KINDS.items()}


def kept_entries(facts: Facts, baseline: Baseline, writing: Writing) -> list[TopRecord]:
    """Return all records of a file, without the entries that do not exist any more.

    Args:
        facts: those of the present world.
        baseline: the file.
        writing: the numbers of objects and collections.

    Raises:
        NotInVrepFiles: an entry has changed that is not a collection.
    """
    now, before = facts.saved.registered, baseline.facts.saved.registered
    renamed = _renamed(facts, baseline)
    unique, found = UniqueNames("{}#{}"), list[TopRecord]()
    numbers = ik_numbers(baseline.records, now, baseline.header.serialization)
    for tag, payload in baseline.records:
        if tag not in ENTRIES:
            found.append((tag, payload))
            continue
        kind, name_tag = ENTRIES[tag]
        name = _name(tag, parse_list(tag, payload, baseline.header.serialization).raw(name_tag) or b"")
        name = unique.take(name or "UI") if kind == "old_ui" else name
        old, new = before.get(kind, {}).get(name), now.get(kind, {}).get(name)
        if old is None or _is_same(old, new, renamed):
            found.append((tag, payload))
        elif new is not None and tag == _GROUP:
            found.append((tag, _collection(payload, name, new, facts, writing)))
        elif new is not None and tag == IK_GROUP:
            found.append((tag, ik_group(payload, name, new, facts, writing, numbers)))
        elif new is not None:
            raise NotInVrepFiles(f"the changed {kind.replace('_', ' ')} '{name}'")
    return found


def new_entries(
    facts: Facts,
    known: Mapping[str, Mapping[str, Annotation]],
    baselines: Iterable[Baseline],
    writing: Writing,
    kept: Iterable[TopRecord],
) -> list[TopRecord]:
    """Return the records of entries that the file has not.

    Args:
        facts: those of the present world.
        known: the entries that it has, by kind and name.
        baselines: all files from which objects come.
        writing: the numbers of objects and collections.
        kept: the records that the file keeps.

    Raises:
        NotInVrepFiles: one is of a kind that is not written.
    """
    found, baselines = list[TopRecord](), list(baselines)
    numbers = ik_numbers(kept, facts.saved.registered, writing.serialization)
    for kind, notes in facts.saved.registered.items():
        for name, note in notes.items():
            if name in known.get(kind, {}) or (kind == "ik" and not note):
                continue
            if kind == "ik":
                found.append((IK_GROUP, ik_group(b"", name, note, facts, writing, numbers)))
            elif kind == "collection":
                found.append((_GROUP, _collection(b"", name, note, facts, writing)))
            elif kind in _PAIRS:
                found.append((_PAIRS[kind], _pair(_PAIRS[kind], name, note, facts, writing)))
            elif kind == "old_ui" and (payload := _ui(name, note, baselines, facts, writing)):
                found.append((_UI, payload))
            else:
                raise NotInVrepFiles(f"the new {kind.replace('_', ' ')} '{name}'")
    return found


def number_collections(facts: Facts, known: Mapping[int, int]) -> dict[int, int]:
    """Return the numbers in the file of all collections, by handle: those that they have there, or new ones."""
    found, collections = dict(known), facts.world.collections
    free = max([FIRST_COLLECTION - 1, *known.values()]) + 1
    for name in facts.saved.registered.get("collection", {}):
        handle = collections.find(name)
        if handle is not None and handle not in found:
            found[handle] = free
            free += 1
    return found


def _name(tag: str, payload: bytes) -> str:
    text = decoded(payload[4:])
    if tag == _GROUP:
        return "_".join(text.replace(",", " ").split())
    return plain_name(text) if tag in ("COL", "DST") else text


def _renamed(facts: Facts, baseline: Baseline) -> dict[str, str]:
    """Return the names of objects of the file that have another one now: old to new."""
    found: dict[str, str] = {}
    for handle, name in facts.saved.names.items():
        origin = facts.world.origins.of(handle)
        if origin is not None and origin[0] is baseline.source:
            old = baseline.facts.saved.names[baseline.handles[origin[1]]]
            if old != name:
                found.setdefault(old, name)
    return found


def _is_same(old: Annotation, new: Annotation | None, renamed: Mapping[str, str]) -> bool:
    if new is None or old.keys() != new.keys():
        return False
    return all(new[key] == value or new[key] == _translated(value, renamed) for key, value in old.items())


def _translated(value: object, renamed: Mapping[str, str]) -> object:
    """Return a text that lists names, with new ones in place of the old ones."""
    if not isinstance(value, str) or not renamed:
        return value
    for sign in ";,":
        if sign in value:
            return sign.join(str(_translated(part, renamed)) for part in value.split(sign))
    start, colon, name = value.rpartition(":")
    return start + colon + renamed.get(name, name)


def _ui(
    name: str, note: Annotation, baselines: Iterable[Baseline], facts: Facts, writing: Writing
) -> bytes | None:
    """Return the payload of the old UI of a loaded model or of a copy; None where no file has it."""
    found = None
    numbers = [0]
    for baseline in baselines:
        version = baseline.header.serialization
        for payload in (payload for tag, payload in baseline.records if tag == _UI):
            records = parse_list(_UI, payload, version)
            numbers.append(int((records.numbers("Bkh") or [0])[0]))
            if decoded((records.raw("Bkn") or b"")[4:]) == name.partition("#")[0]:
                found = records
    if found is None:
        return None
    writing.new_uis.append(name)
    found.put_text("Bkn", name)
    found.put_numbers("Bkh", max(numbers) + len(writing.new_uis))
    handles = {each: number for number, each in facts.saved.names.items()}
    found.put_numbers("Aoi", writing.numbers.get(handles.get(str(note.get("object", "")), -1), -1))
    return bytes(found) + END


def _pair(tag: str, name: str, note: Annotation, facts: Facts, writing: Writing) -> bytes:
    """Return the payload of a new collision or distance object. Raises NotInVrepFiles."""
    if note.get("explicit", False):
        raise NotInVrepFiles(f"the explicit handling of '{name}'")
    records = RecordList(tag, writing.serialization)
    entities = (_entity(str(note.get(key, "all")), facts, writing) for key in ("entity1", "entity2"))
    # Beyond those of the file, which count from the first one.
    number = _FIRST_PAIR[tag] + 5000 + len(writing.new_pairs)
    writing.new_pairs.append(name)
    records.put_numbers("Inx", *entities, number)
    records.put_text("Nme", name)
    if tag == "DST":
        records.put_numbers("Trh", 0.0)
    return bytes(records) + END


def _entity(text: str, facts: Facts, writing: Writing) -> int:
    """Return the number of an entity that an annotation names; -1 for all objects. Raises NotInVrepFiles."""
    if text == "all":
        return -1
    collection = facts.world.collections.find(text.removeprefix(ENTITY_PREFIX))
    if text.startswith(ENTITY_PREFIX) and collection is not None:
        return writing.collections[collection]
    handles = {each: number for number, each in facts.saved.names.items()}
    if text not in handles:
        raise NotInVrepFiles(f"what is measured of '{text}'")
    return writing.numbers[handles[text]]


def _collection(payload: bytes, name: str, note: Annotation, facts: Facts, writing: Writing) -> bytes:
    """Return the payload of a collection. Raises NotInVrepFiles."""
    records = parse_list(_GROUP, payload, writing.serialization)
    handle = facts.world.collections.find(name)
    if handle is None:
        raise NotInVrepFiles(f"the collection '{name}'")
    if not payload:
        records.put_text("Grn", name)
        records.put_numbers("Gix", writing.collections[handle])
    records.put_bits("Par", 1, int(bool(note.get("overrides", False))))
    handles = {each: number for number, each in facts.saved.names.items()}
    members = list[bytes]()
    for taken_out, kind, named in read_steps(str(note.get("steps", ""))):
        member = RecordList("member", writing.serialization)
        number = writing.numbers.get(handles.get(named, -1), -1)
        member.put_numbers("Obj", number, -1)
        member.put_numbers("Gty", _NUMBERS["object" if kind == "objects" else kind])
        member.put_numbers("Var", int(not taken_out))
        members.append(bytes(member) + END)
    records.put("Asg", *members)
    return bytes(records) + END
