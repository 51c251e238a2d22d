"""Decode the records that all objects have: names, pose, layers, properties, custom data."""

from __future__ import annotations

from collections.abc import Iterator

from simx_server.scene.formats.vrep.chunks import Chunks, Place
from simx_server.scene.formats.vrep.objects import UserParameter, VrepObject

from .numbers import quaternion_first

CUSTOM_DATA_BLOCKS = 356248756
"""Header of older custom data that scripts wrote; other headers belong to plug-ins."""
BASE_TAGS, MODEL_BASE = ("Va3", "Va2", "Var"), 1
"""Records of which the first one that an object has tells whether it is the base of a model, and their bit."""
MOST_BLOCKS = 10_000
MOST_PARAMETERS = 10_000
MOST_REFERENCES = 10_000
OBJECT_TYPE = 109
"""`sim_appobj_object_type`: a reference to an object of the scene, not to a collection and the like."""


def fill_common(item: VrepObject, chunks: Chunks) -> None:
    """Fill the fields of VrepObject from the records before NXT. Raises SceneError."""
    item.pose = quaternion_first(chunks, "Cfq")
    item.name = chunks.text("Nme")
    item.alias = chunks.text("Ali") if chunks.has("Ali") else None
    (item.layers,) = chunks.ints("Lar", item.layers)
    (item.properties,) = chunks.ints("Omp", item.properties)
    (item.model_properties,) = chunks.ints("Mpo", item.model_properties)
    flags = next((chunks.ints(tag)[0] for tag in BASE_TAGS if chunks.has(tag)), 0)
    item.is_model_base = bool(flags & MODEL_BASE)
    (item.flags,) = chunks.ints("Op2", item.flags)
    (order,) = chunks.ints("Cor", -1)
    item.order = order if order >= 0 else None
    (item.size_factor,) = chunks.reals("Sfa", item.size_factor)
    along_x, along_y, along_z = chunks.reals("Sfb", *item.size_values)
    item.size_values = along_x, along_y, along_z
    item.extension = chunks.text("Rst")
    item.acknowledgement = chunks.text("Ack")
    parameters = chunks.child("Lsp")
    if parameters is not None:
        item.parameters = user_parameters(parameters)
    item.references = references(chunks)
    for tag in ("Cod", "Cda"):  # the newer one last: it wins
        for data in chunks.each(tag):
            item.custom_data.update(custom_data(data))


def custom_data(chunks: Chunks) -> dict[str, bytes]:
    """Return custom data blocks by tag, of an object or the scene."""
    found: dict[str, bytes] = {}
    for start, end in chunks.all_places("Dat"):
        found.update(_older_blocks(chunks, start, end))
    for start, end in chunks.all_places("Cdt"):
        tag, place = chunks.text_at("Cdt", start, end)
        found[tag] = _sized(chunks, "Cdt", place, end)
        if len(found) > MOST_BLOCKS:
            raise chunks.error("Cdt", f"is one block too many: there may be {MOST_BLOCKS}")
    return found


def user_parameters(chunks: Chunks) -> list[UserParameter]:
    """Return name, unit and value of each user parameter, of an object or a script."""
    found: list[UserParameter] = []
    for place, end in chunks.all_places("Par"):
        (count,) = chunks.whole("Par", place, end, "i")
        if count > MOST_PARAMETERS:
            raise chunks.error("Par", f"has {count} parameters; there may be {MOST_PARAMETERS}")
        place += 4
        for _ in range(count):
            name, place = chunks.text_at("Par", place, end)
            unit, place = chunks.text_at("Par", place, end)
            value, place = chunks.text_at("Par", place, end)
            chunks.whole("Par", place, end, "i")
            place += 4
            found.append((name, unit, value))
    return found


def references(chunks: Chunks) -> dict[str, list[int]]:
    """Return the handles that scripts have stored with an object, by tag: '' before CoppeliaSim had tags."""
    found: dict[str, list[int]] = {}
    for place, end in chunks.all_places("Crh"):
        numbers = _counted(chunks, "Crh", place, end, 3)
        found[""] = [
            handle if kind == OBJECT_TYPE else -1
            for kind, handle in zip(numbers[::3], numbers[1::3], strict=True)
        ]
    for start, end in chunks.all_places("Cr2"):
        tag, place = chunks.text_at("Cr2", start, end)
        found[tag] = _counted(chunks, "Cr2", place, end, 1)
        if len(found) > MOST_REFERENCES:
            raise chunks.error("Cr2", f"is one tag too many: there may be {MOST_REFERENCES}")
    return found


def _counted(chunks: Chunks, tag: str, start: int, end: int, each: int) -> list[int]:
    (count,) = chunks.whole(tag, start, end, "i")
    if not 0 <= count <= MOST_REFERENCES:
        raise chunks.error(tag, f"has {count} references; there may be {MOST_REFERENCES}")
    return list(chunks.whole(tag, start + 4, end, f"{each * count}i"))


def _sized(chunks: Chunks, tag: str, start: int, end: int) -> bytes:
    (length,) = chunks.whole(tag, start, end, "i")
    if not 0 <= length <= end - start - 4:
        raise chunks.error(tag, f"has a block of {length} bytes where {end - start - 4} are left")
    return bytes(chunks.body.data[start + 4 : start + 4 + length])


def _older_blocks(chunks: Chunks, start: int, end: int) -> Iterator[tuple[str, bytes]]:
    """Yield tag and data of each entry: its length, the tag's length, the tag and a 0, the data."""
    header, _ = chunks.whole("Dat", start, end, "2i")
    if header != CUSTOM_DATA_BLOCKS:
        return
    block = _sized(chunks, "Dat", start + 4, end)
    place: Place = (0, len(block))
    count = 0
    while place[1] - place[0] >= 8:
        count += 1
        if count > MOST_BLOCKS:
            raise chunks.error("Dat", f"has one block too many: there may be {MOST_BLOCKS}")
        first = place[0]
        length, tag_length = (int.from_bytes(block[first + at : first + at + 4], "little") for at in (0, 4))
        if not 8 + tag_length <= length <= place[1] - first:
            raise chunks.error("Dat", f"has an entry of {length} bytes where {place[1] - first} are left")
        tag = block[first + 8 : first + 8 + tag_length].rstrip(b"\0").decode("utf-8", errors="replace")
        yield tag, block[first + 8 + tag_length : first + length]
        place = (first + length, place[1])
