"""V-REP's own files that mean no good: good ones whose records, numbers and bytes were altered.

`file_of` makes a file of any bytes: the first ones choose a good file, one of those that the tests' own writer makes
of each version, or a sample where there are some; the others choose what is altered. Records are altered as a tree,
so that lengths stay right and the fault is found as deep as possible; the bytes too, and the compressed file.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from vrep_packing import header
from vrep_samples import ALL
from vrep_writer import PROGRAMS, VrepWriter

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.chunks import MARKERS
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.formats.vrep.objects import Shape, VrepFile
from simx_server.scene.formats.vrep.reading import OBJECTS, REST, read_file
from simx_server.scene.formats.vrep.records import RECORDS

from .codec import Bytes

LARGEST_SAMPLE = 60_000
"""Bytes of a sample; larger ones have the same records, and take longer."""

INTS = (0, 1, -1, 2, 255, 65535, 65536, 2**31 - 1, -(2**31), 10**9, 24, 100_000)
REALS = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e-308, 0.0, -1.0, 3e38)


@dataclass
class Node:
    """A record: payload, or the records in it; a marker has neither."""

    tag: bytes
    payload: bytearray = field(default_factory=bytearray)
    inside: list[Node] | None = None

    def bytes(self) -> bytes:
        """Return the record as it is written."""
        if self.tag in MARKERS:
            return self.tag
        data = bytes(self.payload) if self.inside is None else b"".join(each.bytes() for each in self.inside)
        return self.tag + struct.pack("<I", len(data)) + data

    def copy(self) -> Node:
        """Return an independent copy."""
        inside = None if self.inside is None else [each.copy() for each in self.inside]
        return Node(self.tag, bytearray(self.payload), inside)


def good_file(ser: int) -> bytes:
    """A file with everything that the writer knows."""
    writer = VrepWriter(ser)
    pixels = np.zeros((2, 3, 3))
    texture = writer.texture(pixels)
    base = writer.shape(
        "base", cuboid=(0.2, 0.2, 0.1), dynamic=True, respondable=True, model_base=True, friction=0.5,
        texture=texture, custom_data={"a": b"12345"}, acknowledgement="thanks",
    )  # fmt: skip
    motor = writer.joint("motor", parent=base, motor=True, control="position")
    triangle = (np.eye(3), np.array([[0, 1, 2]]))
    writer.shape("group", parent=motor, leaves=[{"mesh": triangle}, {"plane": (1, 1, 0), "texture": texture}])
    writer.shape("hills", heightfield=(1, 1, 1), heights=np.ones((3, 2)))
    tip = writer.dummy("tip", linked=5, link_type=5)
    writer.dummy("target", linked=tip, link_type=5)
    writer.force_sensor("pad", force=3.0)
    filters = [{"type": 1, "ints": [1], "reals": [2.0], "data": b"x"}]
    writer.vision_sensor("eye", filters=filters)
    writer.proximity_sensor("nose", volume="cone", entity=base)
    writer.camera("view")
    writer.light("lamp")
    writer.path("track", [(0, 0, 0), (1, 0, 0)], section=[(0.1, 0), (-0.1, 0)])
    writer.graph("plot", [("x", 1, base)])
    writer.mill("drill")
    writer.octree("cells", [(0.05, 0.05, 0.05), (-0.15, 0.05, 0.05)])
    writer.point_cloud("cloud", np.eye(3).tolist() * 3)
    writer.script("print(1)", base, parameters=[("a", "b", "c")])
    writer.script("sim.handleDynamics(0)")
    if ser == 25:
        writer.script("#python\nx = 1", base, as_object=True)
    group = writer.collection("all", [(base, 1, True)])
    writer.collision("crash", group)
    writer.distance("gap", base)
    writer.ik_group("ik", [{"tip": tip, "base": base}])
    writer.old_ui("panel", [{"id": 3, "label": "x"}], owner=base)
    writer.settings()
    writer.scene_data({"q": b"123"})
    writer.model_information((0, 0, 0), (1, 1, 1))
    return writer.bytes()


@cache
def bases() -> list[bytes]:
    """The good files."""
    small = [path for path in ALL if path.stat().st_size < LARGEST_SAMPLE]
    return [*(good_file(ser) for ser in PROGRAMS), *(path.read_bytes() for path in small)]


@cache
def tree_of(number: int) -> tuple[int, tuple[int, int, int], list[Node]]:
    """A good file's version, program, and records."""
    info, body = unpack(bases()[number])
    return info.serialization, info.program, _nodes(bytes(body), None)


def _nodes(data: bytes, names: list[str] | None) -> list[Node]:
    """Return the records in a payload; `names` are the lists of its sections, None at the top."""
    found: list[Node] = []
    place, section = 0, 0
    while place < len(data):
        tag = data[place : place + 3]
        if tag in MARKERS:
            found.append(Node(tag))
            place, section = place + 3, section + 1
            continue
        (length,) = struct.unpack_from("<I", data, place + 3)
        payload = data[place + 7 : place + 7 + length]
        place += 7 + length
        inner = _lists_in(tag.decode("latin-1"), names, section)
        found.append(Node(tag, bytearray(payload), _nodes(payload, inner) if inner else None))
    return found


def _lists_in(tag: str, names: list[str] | None, section: int) -> list[str]:
    """Return the lists of the sections of a record's payload, none if it is not a list."""
    if names is None:
        if tag in OBJECTS:
            return ["object", tag]
        return {"VIN": ["VIN"], "DMA": ["surface"], "TEX": ["TEX"], "SET": ["SET"]}.get(
            tag, [REST[tag][0]] if tag in REST else []
        )
    form = RECORDS[names[section]].get(tag, "") if section < len(names) else ""
    name = form.removeprefix("list ")
    return ["group", "leaf"] if name == "leaf" else [name] if form.startswith("list ") else []


def file_of(data: bytes) -> bytes:
    """Return a file made of any bytes."""
    source = Bytes(data)
    number, way = source.number(len(bases())), source.number(8)
    if way == 0:
        return _altered_bytes(bytearray(bases()[number]), source)
    ser, program, nodes = tree_of(number)
    top = [each.copy() for each in nodes]
    for _ in range(1 + source.number(3)):
        _alter(top, source)
    body = b"".join(each.bytes() for each in top)
    if way == 1:
        body = _altered_bytes(bytearray(body), source)
    return header(body, serialization=ser, program=program, compression=0, kind=source.number(3)) + body


def _altered_bytes(data: bytearray, source: Bytes) -> bytes:
    for _ in range(1 + source.number(4)):
        if not data:
            break
        at = int.from_bytes(source.take(3), "little") % len(data)
        match source.number(5):
            case 0:
                del data[at:]
            case 1:
                data[at : at + 1] = source.take(1)
            case 2:
                data[at : at + 4] = struct.pack("<q", INTS[source.number(len(INTS))])[:4]
            case 3:
                del data[at : at + 1 + source.number(8)]
            case _:
                data[at:at] = source.take(1 + source.number(8))
    return bytes(data)


def _alter(nodes: list[Node], source: Bytes) -> None:
    """Alter one record, somewhere in the tree."""
    at = int.from_bytes(source.take(2), "little") % max(1, len(nodes))
    node = nodes[at] if nodes else None
    if node is not None and node.inside and source.number(8):
        _alter(node.inside, source)
        return
    other = nodes[int.from_bytes(source.take(2), "little") % len(nodes)] if nodes else None
    if node is None or other is None:
        return
    match source.number(10):
        case 0:
            del nodes[at]
        case 1:
            nodes.insert(at, node.copy())
        case 2:
            node.tag = other.tag
        case 3:
            node.payload, node.inside = bytearray(other.payload), None
        case 4:
            nodes.append(Node(node.tag, inside=[node.copy() for _ in range(1 + source.number(3))]))
        case _ if node.inside is None:
            _alter_payload(node.payload, source)
        case _:
            node.inside.append(other.copy())


def _alter_payload(payload: bytearray, source: Bytes) -> None:
    """Alter what stands in a record."""
    match source.number(5):
        case 0:
            del payload[source.number(256) :]
        case 1:
            payload += source.take(source.number(9))
        case 2 if payload:
            place = int.from_bytes(source.take(2), "little") % len(payload)
            payload[place : place + 1] = source.take(1)
        case 3:
            place = source.number(16) * 4
            payload[place : place + 4] = struct.pack("<q", INTS[source.number(len(INTS))])[:4]
        case _:
            real, place = REALS[source.number(len(REALS))], source.number(16) * 4
            if source.number(2):
                payload[place : place + 8] = struct.pack("<d", real)
            else:
                payload[place : place + 4] = np.float32(np.clip(real, -3e38, 3e38)).tobytes()


class Reader:
    """The function that runs one case, and counts."""

    def __init__(self) -> None:
        self.read = 0
        """Files that were read in spite of all."""

    def one(self, data: bytes) -> None:
        """One case: the file is refused with a sentence, or what is read is sound."""
        try:
            file = read_file(file_of(data), "hostile.ttt")
        except SceneError as error:
            assert len(str(error)) > len("'hostile.ttt' cannot be read: "), "no sentence"  # noqa: PT017 - no test
            return
        self.read += 1
        _check(file)


def _check(file: VrepFile) -> None:
    """Check what the conversion builds on."""
    for handle, item in file.objects.items():
        assert handle == item.handle >= 0
        assert item.parent == -1 or item.parent in file.objects
        assert all(map(math.isfinite, item.pose[0]))
        assert math.isclose(math.hypot(*item.pose[1]), 1.0, abs_tol=1e-6)
        for leaf in item.leaves if isinstance(item, Shape) else ():
            assert np.isfinite(leaf.vertices).all()
            assert not leaf.triangles.size or 0 <= leaf.triangles.min() <= leaf.triangles.max() < len(
                leaf.vertices
            )
    assert all(script.owner == -1 or script.owner in file.objects for script in file.scripts)
    assert 0 < file.settings.time_step <= 10
