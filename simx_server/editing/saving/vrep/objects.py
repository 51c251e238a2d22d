"""The records of the saved objects: those of their files with what has changed, and those of new objects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_server.scene.formats.vrep.writing.leaves import change_leaves
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import RecordList
from simx_server.scene.objects import ObjectKind

from .baseline import Baseline
from .common import put_parameters
from .facts import Facts, are_equal, fields_of, has_handles, numbered
from .field import NotInVrepFiles, Writing

if TYPE_CHECKING:
    from simx_server.scene.objects import SceneObject

TAGS = {
    ObjectKind.SHAPE: "SHP",
    ObjectKind.JOINT: "JNT",
    ObjectKind.DUMMY: "DMY",
    ObjectKind.FORCE_SENSOR: "FSE",
    ObjectKind.VISION_SENSOR: "RSN",
    ObjectKind.PROXIMITY_SENSOR: "SNR",
    ObjectKind.PATH: "PAT",
    ObjectKind.CAMERA: "CMA",
    ObjectKind.LIGHT: "LGT",
    ObjectKind.OCTREE: "OCT",
    ObjectKind.POINT_CLOUD: "PTC",
}
"""Kinds of new objects that are written, and their tags."""

PARAMETERS = "user parameters"


@dataclass(frozen=True)
class Origin:
    """Where an object comes from."""

    baseline: Baseline
    number: int
    """Its handle in that file."""
    is_first: bool
    """The file is the one that is written again, and the object has its number still."""
    starts: Mapping[str, int]
    """Where the meshes of the file start in the pools of the new one, by the tag with which leaves refer to them."""
    textures: Mapping[int, int]
    """Numbers of textures in that file, and in the new one."""

    @property
    def payload(self) -> tuple[str, bytes]:
        """Return the tag and the payload of its record."""
        return self.baseline.objects[self.number]


def records_of(facts: Facts, item: SceneObject, origin: Origin | None, writing: Writing) -> ObjectRecords:
    """Return the records of an object. Raises NotInVrepFiles."""
    try:
        if origin is None:
            return _new(facts, item, writing)
        return _changed(facts, item, origin, writing)
    except NotInVrepFiles as problem:
        raise NotInVrepFiles(f"{problem} of '{item.name}'") from None


def _changed(facts: Facts, item: SceneObject, origin: Origin, writing: Writing) -> ObjectRecords:
    before, baseline = origin.baseline.facts, origin.baseline
    handle = baseline.handles[origin.number]
    tag, payload = origin.payload
    records = ObjectRecords.parse(tag, payload, baseline.header.serialization)
    ids = (writing.numbers[item.handle], writing.numbers.get(item.parent, -1))
    if ids != records.handles:
        records.common.put_numbers("Ids", *ids)
    if not origin.is_first and tag == "SHP":
        _renumber_meshes(records.own, origin)
    if facts.notes(item.handle) != before.notes(handle):
        kinds = facts.notes(item.handle).keys() | before.notes(handle).keys()
        raise NotInVrepFiles(f"what has changed in '{', '.join(sorted(kinds))}'")
    values, old = facts.of_objects[item.handle], before.of_objects[handle]
    for name, field in fields_of(item.kind).items():
        value = values[name]
        is_same = are_equal(numbered(value, writing.all_numbers), numbered(old[name], baseline.numbers))
        if is_same and (origin.is_first or not has_handles(value)):
            continue
        if field.concerns is not None and not field.concerns(values, old):
            continue
        if name == PARAMETERS and _put_script_parameters(writing, item.handle, value):
            continue
        if value is not None or name == "place among siblings":
            field.put(records, value, writing)
    return records


def _put_script_parameters(writing: Writing, handle: int, values: Any) -> bool:
    """Write user parameters into the script that has them in old files; return whether there is one."""
    for script in writing.scripts.get(handle, ()):
        if script.has("Prm"):
            put_parameters(script, "Prm", values)
            return True
    return False


def _renumber_meshes(own: RecordList, origin: Origin) -> None:
    """Let the leaves of a shape of another file refer to their meshes and textures in the new one."""

    def renumber(_number: int, _wrapper: RecordList, leaf: RecordList) -> None:
        for tag, start in origin.starts.items():
            payload = leaf.raw(tag)
            place = -1 if payload is None else int.from_bytes(payload[:4], "little", signed=True)
            if place >= 0:  # the reader has checked all of them but the edges, which it does not use
                leaf.put(tag, (place + start).to_bytes(4, "little"))
        if leaf.has("Toj"):
            with leaf.child("Toj") as use:
                texture = use.numbers("Tob")
                if texture is not None:
                    use.put_numbers("Tob", origin.textures.get(int(texture[0]), -1), None, None, None)

    change_leaves(own, renumber)


def _new(facts: Facts, item: SceneObject, writing: Writing) -> ObjectRecords:
    tag = TAGS.get(item.kind)
    if tag is None or item.element == "tendon":
        raise NotInVrepFiles(f"a new {item.kind.text}: the object")
    if facts.notes(item.handle):
        raise NotInVrepFiles("settings")
    records = ObjectRecords.new(tag, writing.serialization)
    records.common.put_numbers("Ids", writing.numbers[item.handle], writing.numbers.get(item.parent, -1))
    for name, field in fields_of(item.kind).items():
        value = facts.of_objects[item.handle][name]
        is_usual = (
            value is None or value in ({}, "") or (field.is_usual is not None and field.is_usual(value))
        )
        if not is_usual and field.of_new:
            field.put(records, value, writing)
    return records
