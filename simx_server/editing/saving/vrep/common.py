"""Facts that all objects have, and their records."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.editing import object_flags
from simx_server.parts.custom_data import EXTENSION, HIDDEN, REFERENCES
from simx_server.scene.formats.vrep.decoding.common import (
    BASE_TAGS,
    CUSTOM_DATA_BLOCKS,
    MODEL_BASE,
    OBJECT_TYPE,
)
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list, text_bytes
from simx_server.scene.naming.names import alias_of
from simx_server.scene.objects import NOT_A_MODEL, ObjectKind
from simx_server.scene.poses.placing import moving_pose, object_pose
from simx_server.scene.poses.poses import Pose, compose, inverse

from .field import Field, Fields, Handle, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_ABILITIES = 0x3F3
"""Bits of Omp that the server knows: collidable, measurable, detectable by each kind of sensor, renderable."""

_FIRST_WITH_ALIASES = 25
FIRST_WITH_TAGGED_DATA = 23
"""Versions of the format in which all objects have an alias, and in which custom data have a text as tag."""


def local_pose(world: World, handle: int) -> Pose:
    """Return an object's pose relative to its parent; relative to a joint's moving frame."""
    sim = world.simulation
    item = sim.scene.objects[handle]
    pose = object_pose(sim, item)
    if item.parent == -1:
        return pose
    return compose(inverse(moving_pose(sim, sim.scene.objects[item.parent])), pose)


def put_pose(records: ObjectRecords, pose: Pose, _writing: Writing) -> None:
    position, turn = pose
    records.common.put_numbers("Cfq", *turn, *position)


def _names(world: World, handle: int) -> tuple[str, str]:
    item = world.simulation.scene.objects[handle]
    return item.name, item.alias


def _put_names(records: ObjectRecords, names: tuple[str, str], writing: Writing) -> None:
    name, alias = names
    records.common.put_text("Nme", name)
    is_usual = alias == alias_of(name)
    if records.common.has("Ali") or not is_usual or writing.serialization >= _FIRST_WITH_ALIASES:
        records.common.put_text("Ali", alias)


def _abilities(world: World, handle: int) -> int | None:
    kind = world.simulation.scene.objects[handle].kind
    has_any = kind in (ObjectKind.SHAPE, ObjectKind.DUMMY)
    return object_flags.special_flags(world, handle) if has_any else None


def _put_abilities(records: ObjectRecords, bits: int, _writing: Writing) -> None:
    records.common.put_bits("Omp", _ABILITIES, bits)


def _put_model(records: ObjectRecords, bits: int, _writing: Writing) -> None:
    is_base = not bits & NOT_A_MODEL
    for tag in [tag for tag in BASE_TAGS if records.common.has(tag)] or ["Va2"]:
        records.common.put_bits(tag, MODEL_BASE, MODEL_BASE * is_base)
    records.common.put_numbers("Mpo", bits)


def _sibling(world: World, handle: int) -> int | None:
    return world.simulation.scene.objects[handle].annotations.get("object", {}).get("sibling")  # type: ignore[return-value]


def _sizes(world: World, handle: int) -> tuple[float, ...] | None:
    note = world.simulation.scene.objects[handle].annotations.get("object", {})
    factor = float(note.get("size_factor", 1.0))
    text = str(note.get("size_values", "1,1,1"))
    return (factor, *map(float, text.split(",")))


def _put_sizes(records: ObjectRecords, sizes: tuple[float, ...], _writing: Writing) -> None:
    records.common.put_numbers("Sfa", sizes[0])
    records.common.put_numbers("Sfb", *sizes[1:])


def _extension(world: World, handle: int) -> str:
    return (world.custom_data.read(handle, EXTENSION) or b"").decode("utf-8", "surrogateescape")


def _data(world: World, handle: int) -> dict[str, bytes]:
    return {
        name: data
        for name in world.custom_data.names(handle)
        if not name.startswith((HIDDEN, "@tmp")) and (data := world.custom_data.read(handle, name))
    }


def _put_data(records: ObjectRecords, blocks: Mapping[str, bytes], writing: Writing) -> None:
    put_blocks(records.common, blocks, writing.serialization)


def put_blocks(records: RecordList, blocks: Mapping[str, bytes], serialization: int) -> None:
    """Replace the custom data of scripts."""
    tags = [tag for tag in ("Cda", "Cod") if records.has(tag)]
    for tag in tags or ["Cda" if serialization >= FIRST_WITH_TAGGED_DATA else "Cod"]:
        found = parse_list("custom data", records.raw(tag) or b"", serialization)
        replace_blocks(found, blocks, is_tagged=tag == "Cda")
        if list(found):
            records.put(tag, bytes(found) + END)
        else:
            records.remove(tag)


def replace_blocks(found: RecordList, blocks: Mapping[str, bytes], *, is_tagged: bool) -> None:
    """Replace the blocks of scripts in a list; data of plug-ins, which have a number in place of a tag, stay."""
    if is_tagged:
        found.put("Cdt", *(_tagged_block(name, data) for name, data in blocks.items()))
    else:
        others = [each for each in found.each("Dat") if not _is_of_scripts(each)]
        found.put("Dat", *others, *([_old_blocks(blocks)] if blocks else ()))


def _tagged_block(name: str, data: bytes) -> bytes:
    """Return the payload of `Cdt`."""
    return text_bytes(name) + struct.pack("<i", len(data)) + data


def _old_blocks(blocks: Mapping[str, bytes]) -> bytes:
    """Return the payload of `Dat` with all blocks of scripts."""
    entries = b""
    for name, data in blocks.items():
        tag = name.encode("utf-8", "surrogateescape") + b"\0"
        entries += struct.pack("<2i", 8 + len(tag) + len(data), len(tag)) + tag + data
    return struct.pack("<2i", CUSTOM_DATA_BLOCKS, len(entries)) + entries


def _is_of_scripts(payload: bytes) -> bool:
    return payload[:4] == struct.pack("<i", CUSTOM_DATA_BLOCKS)


def _references(world: World, handle: int) -> dict[str, tuple[Handle, ...]]:
    found: dict[str, tuple[Handle, ...]] = {}
    for name in world.custom_data.names(handle):
        packed = world.custom_data.read(handle, name)
        if name.startswith(REFERENCES) and packed:
            handles = struct.unpack(f"<{len(packed) // 4}i", packed)
            found[name.removeprefix(REFERENCES)] = tuple(map(Handle, handles))
    return found


def _put_references(
    records: ObjectRecords, lists: Mapping[str, tuple[Handle, ...]], writing: Writing
) -> None:
    plain, tagged = list[bytes](), list[bytes]()
    for tag, handles in lists.items():
        numbers = [writing.number(each) for each in handles]
        count = struct.pack("<i", len(numbers))
        if tag:
            tagged.append(text_bytes(tag) + count + struct.pack(f"<{len(numbers)}i", *numbers))
        else:
            plain.append(count + b"".join(struct.pack("<3i", OBJECT_TYPE, each, 0) for each in numbers))
    records.common.put("Crh", *plain)
    records.common.put("Cr2", *tagged)


def _parameters(world: World, handle: int) -> dict[str, str]:
    return world.script_parameters.all(handle)


def put_parameters(records: RecordList, tag: str, values: Mapping[str, str]) -> None:
    """Write user parameters; those that are there already keep their units and flags."""
    found = parse_list("parameters", records.raw(tag) or b"", records.serialization)
    units = _units(found.raw("Par") or b"")
    payload = struct.pack("<i", len(values))
    for name, value in values.items():
        unit, flags = units.get(name, (b"\0\0\0\0", 0))
        payload += text_bytes(name) + unit + text_bytes(value) + struct.pack("<i", flags)
    found.put("Par", payload)
    records.put(tag, bytes(found) + END)


def _units(payload: bytes) -> dict[str, tuple[bytes, int]]:
    """Return for each parameter its unit, as a text with its length, and its flags.

    The file has been read before, so that all lengths fit, and a count below 0 is none.
    """
    found: dict[str, tuple[bytes, int]] = {}
    place = 4
    for _ in range(int.from_bytes(payload[:4], "little", signed=True)):
        texts = list[bytes]()
        for _ in range(3):
            end = place + 4 + int.from_bytes(payload[place : place + 4], "little")
            texts.append(payload[place:end])
            place = end
        flags = int.from_bytes(payload[place : place + 4], "little")
        found[texts[0][4:].decode("utf-8", "surrogateescape")] = texts[1], flags
        place += 4
    return found


def _put_parameters(records: ObjectRecords, values: Mapping[str, str], _writing: Writing) -> None:
    put_parameters(records.common, "Lsp", values)


COMMON: Fields = {
    "names": Field(_names, _put_names),
    "pose": Field(local_pose, put_pose),
    "layers": Field(
        lambda world, handle: world.object_settings.layers(handle),
        lambda records, value, _: records.common.put_numbers("Lar", value),
    ),
    "abilities": Field(_abilities, _put_abilities),
    "flags": Field(object_flags.flags, lambda records, value, _: records.common.put_numbers("Op2", value)),
    "model": Field(lambda world, handle: world.simulation.scene.model_property(handle), _put_model),
    "place among siblings": Field(
        _sibling, lambda records, value, _: records.common.put_numbers("Cor", -1 if value is None else value)
    ),
    "size factors": Field(_sizes, _put_sizes),
    "extension string": Field(_extension, lambda records, value, _: records.common.put_text("Rst", value)),
    "custom data": Field(_data, _put_data),
    "references": Field(_references, _put_references),
    "user parameters": Field(_parameters, _put_parameters),
}
