"""The records of the saved objects: those of their files with what has changed, and those of new objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from simx_server.scene.formats.vrep.writing.leaves import change_leaves
from simx_server.scene.formats.vrep.writing.meshes import POOLS, MeshPools
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list
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
    ObjectKind.GRAPH: "GRH",
}
"""Kinds of new objects that are written, and their tags."""

PARAMETERS = "user parameters"


class Brought:
    """Meshes and textures of another file, which come into the new one as leaves need them."""

    def __init__(self, baseline: Baseline, writing: Writing) -> None:
        """Bring nothing yet. Raises SceneError: the file is damaged."""
        assert writing.pools is not None  # formats without pools are not written
        version = baseline.header.serialization
        pools = next((payload for tag, payload in baseline.records if tag == "VIN"), END)
        self._writing, self._pools = writing, writing.pools
        self._other = MeshPools(parse_list("VIN", pools, version))
        textures = [parse_list("TEX", payload, version) for tag, payload in baseline.records if tag == "TEX"]
        self._textures = {int((each.numbers("Ipa") or [0])[0]): each for each in textures}
        self._meshes: dict[tuple[str, int], int] = {}
        self._numbers: dict[int, int] = {}

    def mesh(self, tag: str, place: int) -> int:
        """Return the place of a part of a mesh in the new file.

        Args:
            tag: with which leaves refer to it.
            place: its place in the other file.
        """
        if (tag, place) not in self._meshes:
            self._meshes[tag, place] = self._pools.bring(self._other, tag, place)
        return self._meshes[tag, place]

    def texture(self, number: int) -> int:
        """Return the number of a texture in the new file, -1 if the other one has none with this number."""
        if number in self._textures and number not in self._numbers:
            texture = self._textures[number]
            self._numbers[number] = self._writing.take_texture_number()
            texture.put_numbers("Ipa", self._numbers[number], None, None)
            self._writing.brought_textures.append(bytes(texture) + END)
        return self._numbers.get(number, -1)


@dataclass(frozen=True)
class Origin:
    """Where an object comes from."""

    baseline: Baseline
    number: int
    """Its handle in that file."""
    is_first: bool
    """The file is the one that is written again, and the object has its number still."""
    brought: Brought | None
    """Its meshes and textures; None: the new file has all of them where they were."""

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
    if origin.brought is not None and tag == "SHP":
        _renumber_meshes(records.own, origin.brought)
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


def _renumber_meshes(own: RecordList, brought: Brought) -> None:
    """Let the leaves of a shape of another file refer to their meshes and textures in the new one."""

    def renumber(_number: int, _wrapper: RecordList, leaf: RecordList) -> None:
        for tag in POOLS:
            payload = leaf.raw(tag)
            if payload is not None:
                place = int.from_bytes(payload[:4], "little", signed=True)
                leaf.put(tag, brought.mesh(tag, place).to_bytes(4, "little", signed=True))
        if leaf.has("Toj"):
            with leaf.child("Toj") as use:
                texture = use.numbers("Tob")
                if texture is not None:
                    use.put_numbers("Tob", brought.texture(int(texture[0])), None, None, None)

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
