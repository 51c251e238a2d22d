"""Files of clients that mean no good: well-formed trees and headers with one thing or another turned hostile.

`bundle` makes a handful of files of any bytes: MJCF, URDF, meshes, textures and height fields that name each other.
Random text is seldom a scene, so elements, attributes and fields of headers are altered, not bytes alone. `Sender` is a
whole server in this thread, a client that transfers and loads such files, and one that minds its own business.
"""

# ruff: noqa: E501 - long lines are lists of values and elements

from __future__ import annotations

import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import simx_client as v

from .calls import Victim
from .scenes import MORE, URDF, VALUES

BLOCKING = v.simx_opmode_blocking

MAIN, PART, ROBOT = "main.xml", "part.xml", "robot.urdf"
MESHES = ("shape.stl", "shape.obj", "shape.msh")
IMAGES = ("image.png", "field.bin")
NAMES = (MAIN, PART, ROBOT, *MESHES, *IMAGES)

HUGE = (
    "100000000",
    "2147483647",
    "4294967295",
    "65536",
    "40000",
    "1e9",
    "1e300",
    "-1",
    "0",
    "nan",
    "3000000 1 1",
    "300 300 300",
)
"""Numbers for counts and sizes."""

BOMBS = (
    '<size nkey="100000000"/>', '<size nuserdata="100000000"/>', '<size memory="900G"/>', '<size nuser_geom="50000000"/>',
    '<size njmax="100000000"/>', '<size nconmax="100000000"/>',
    '<option timestep="1e-300"/>', '<option iterations="100000000"/>', '<compiler boundmass="1e308"/>',
    '<include file="main.xml"/>', '<include file="part.xml"/>', '<include file="robot.urdf"/>',
    '<asset><model name="m1" file="main.xml"/></asset>', '<asset><model name="m2" file="part.xml"/></asset>',
    '<asset><mesh name="k1" file="shape.stl"/></asset>', '<asset><mesh name="k2" file="shape.obj"/></asset>',
    '<asset><mesh name="k3" file="shape.msh"/></asset>', '<asset><mesh name="k4" builtin="supersphere" params="20000 1 1"/></asset>',
    '<asset><mesh name="k5" builtin="sphere" params="12"/></asset>', '<asset><texture name="x1" file="image.png" type="2d"/></asset>',
    '<asset><texture name="x2" type="cube" file="image.png"/></asset>', '<asset><texture name="x3" builtin="flat" width="8000" height="8000"/></asset>',
    '<asset><hfield name="h1" file="image.png" size="1 1 1 1"/></asset>', '<asset><hfield name="h2" file="field.bin" size="1 1 1 1"/></asset>',
    '<asset><hfield name="h3" nrow="7000" ncol="7000" size="1 1 1 1"/></asset>',
    '<worldbody><geom type="mesh" mesh="k1"/></worldbody>', '<worldbody><geom type="mesh" mesh="k2"/></worldbody>',
    '<worldbody><geom type="mesh" mesh="k3"/></worldbody>', '<worldbody><geom type="hfield" hfield="h1"/></worldbody>',
    '<worldbody><attach model="m1" body="a" prefix="p"/></worldbody>', '<worldbody><attach model="m2" body="a" prefix="q"/></worldbody>',
    '<worldbody><attach model="m1" prefix="s"/></worldbody>',
    '<worldbody><replicate count="3000" offset="1 0 0"><body><freejoint/><geom size=".1"/></body></replicate></worldbody>',
    '<worldbody><body><composite type="cable" count="5000 1 1" size="1"><geom size=".01"/></composite></body></worldbody>',
    '<worldbody><flexcomp name="f" type="grid" count="60 60 60" radius=".01" mass="1"/></worldbody>',
    '<worldbody><camera name="eye2" resolution="30000 30000"/></worldbody>', '<sensor><contact num="100000000" geom1="g"/></sensor>',
    '<sensor><user dim="100000000"/></sensor>', '<sensor><contact num="5" data="found force" reduce="none"/></sensor>',
    '<keyframe><key name="k" qpos="1 2 3"/></keyframe>', '<extension><plugin plugin="mujoco.sdf.torus"/></extension>',
    '<extension><plugin plugin="no.such"/></extension>', '<custom><numeric name="n" size="100000000"/></custom>',
    '<custom><text name="simx:model:base" data="file=part.xml"/></custom>', '<custom><text name="simx:copy:base" data="count=100000"/></custom>',
    '<deformable><flex name="f2" dim="2" vertex="0 0 0 1 0 0 0 1 0" element="0 1 99" body="world"/></deformable>',
    '<deformable><skin name="s" vertex="0 0 0 1 0 0 0 1 0" face="0 1 77"/></deformable>',
)  # fmt: skip
"""Elements that ask for much, or for each other's file."""


def bundle(data: bytes) -> dict[str, bytes]:
    """Name to content of some files, out of any bytes; `MAIN` or `ROBOT` is what to load."""
    source = random.Random(data)
    files: dict[str, bytes] = {}
    for name in (MAIN, PART):
        files[name] = _tree(source, source.choice((MORE, MORE, _SMALL)))
    files[ROBOT] = _robot(source)
    files |= {name: make(source) for name, make in _BINARIES.items() if source.random() < 0.7}
    return files


def to_load(data: bytes) -> str:
    """Which of them a client loads."""
    return (MAIN, MAIN, PART, ROBOT)[zlib.crc32(data) % 4]


_SMALL = (
    '<mujoco><worldbody><body name="a"><freejoint/><geom name="g" size=".1"/></body></worldbody></mujoco>'
)


def _tree(source: random.Random, text: str) -> bytes:
    root = ElementTree.fromstring(text)
    for _ in range(source.choice((1, 1, 2, 3, 6))):
        source.choice(_CHANGES)(source, root)
    if source.random() < 0.02:
        return (b"<mujoco><worldbody>" + b"<body>" * source.choice((200, 5000))) + b"</worldbody></mujoco>"
    return ElementTree.tostring(root).replace(b"\0", b"")


def _some(source: random.Random, root: ElementTree.Element) -> ElementTree.Element:
    return source.choice(list(root.iter()))


def _add_bomb(source: random.Random, root: ElementTree.Element) -> None:
    bomb = ElementTree.fromstring(source.choice(BOMBS))
    place = next((part for part in root if part.tag == bomb.tag), None)
    if place is None or bomb.tag in ("include", "size"):
        root.append(bomb)
    else:
        place.extend(list(bomb))


def _alter(source: random.Random, root: ElementTree.Element) -> None:
    element = _some(source, root)
    names = [*element.attrib, "count", "size", "name", "file", "nrow", "width"]
    element.set(
        source.choice(names),
        source.choice((*HUGE, *HUGE, *NAMES, *VALUES)).encode("utf-8", "replace").decode(),
    )


def _double(source: random.Random, root: ElementTree.Element) -> None:
    parent, child = _some(source, root), _some(source, root)
    if sum(1 for _ in root.iter()) < 2000 and parent not in set(child.iter()):
        parent.append(child)


def _delete(source: random.Random, root: ElementTree.Element) -> None:
    parent = _some(source, root)
    if len(parent):
        parent.remove(source.choice(list(parent)))


def _replicate(source: random.Random, root: ElementTree.Element) -> None:
    parent = _some(source, root)
    inner = list(parent)
    wrapped = ElementTree.SubElement(parent, "replicate", count=source.choice(("2", "50", "999", *HUGE)))
    for child in inner:
        parent.remove(child)
        wrapped.append(child)


def _rename(source: random.Random, root: ElementTree.Element) -> None:
    _some(source, root).tag = _some(source, ElementTree.fromstring(f"<a>{source.choice(BOMBS)}</a>")).tag


_CHANGES: tuple[Callable[[random.Random, ElementTree.Element], None], ...] = (
    _add_bomb, _add_bomb, _add_bomb, _alter, _alter, _double, _delete, _replicate, _rename,
)  # fmt: skip


def _robot(source: random.Random) -> bytes:
    if source.random() < 0.2:  # a chain, which may close
        length = source.choice((3, 100, 3000))
        links = "".join(f'<link name="l{n}"/>' for n in range(length))
        closes = source.random() < 0.3
        joints = "".join(
            f'<joint name="j{n}" type="{source.choice(("fixed", "revolute", "floating"))}"><parent link="l{n}"/>'
            f'<child link="l{(n + 1) % length}"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
            for n in range(length if closes else length - 1)
        )
        return f'<robot name="r">{links}{joints}</robot>'.encode()
    root = ElementTree.fromstring(URDF)
    for _ in range(source.choice((0, 1, 2, 4))):
        source.choice((_alter, _double, _delete))(source, root)
    if source.random() < 0.5:
        name = source.choice(
            (*NAMES, "package://p/shape.stl", "package://../x.stl", "file:///dev/zero", "model://m/a.obj")
        )
        geometry = ElementTree.SubElement(_some(source, root), "geometry")
        ElementTree.SubElement(geometry, "mesh", filename=name, scale=source.choice(("1 1 1", "1e300 0 nan")))
    return ElementTree.tostring(root)


def _number(source: random.Random, right: int) -> int:
    return source.choice((right, right, right, 0, 1, 40_000, 65_535, 1 << 31, (1 << 32) - 1))


def _flipped(source: random.Random, data: bytes) -> bytes:
    """Sometimes cut, or with a byte changed."""
    if source.random() < 0.3:
        data = data[: source.randrange(len(data) + 1)]
    if data and source.random() < 0.3:
        at = source.randrange(len(data))
        data = data[:at] + source.randbytes(1) + data[at + 1 :]
    return data


def _png(source: random.Random) -> bytes:
    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        )

    bits, colour = source.choice(((8, 2), (8, 0), (16, 6), (8, 3), (1, 0)))
    head = struct.pack(">IIBBBBB", _number(source, 4), _number(source, 4), bits, colour, 0, 0, 0)
    rows = zlib.compress(bytes(source.choice((4 * 13, 100_000))))
    return _flipped(
        source, b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    )


_CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def _stl(source: random.Random) -> bytes:
    faces = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in _CORNERS[corner]), 0) for face in _FACES
    )
    return _flipped(source, bytes(80) + struct.pack("<I", _number(source, len(_FACES))) + faces)


def _obj(source: random.Random) -> bytes:
    corners = "".join(f"v {x} {y} {source.choice((z, z, z, 'nan', 1e300))}\n" for x, y, z in _CORNERS)
    faces = "".join(
        f"f {a + 1} {b + 1} {source.choice((c + 1, c + 1, -1, 0, 2**31, 99))}\n" for a, b, c in _FACES
    )
    return _flipped(source, (corners + faces * source.choice((1, 1, 300))).encode())


def _msh(source: random.Random) -> bytes:
    counts = (_number(source, 4), _number(source, 0), _number(source, 0), _number(source, 4))
    corners = b"".join(struct.pack("<3f", *corner) for corner in _CORNERS)
    faces = b"".join(struct.pack("<3i", *face) for face in _FACES)
    return _flipped(source, struct.pack("<4I", *counts) + corners + faces)


def _field(source: random.Random) -> bytes:
    return _flipped(source, struct.pack("<2I9f", _number(source, 3), _number(source, 3), *range(9)))


_BINARIES: dict[str, Callable[[random.Random], bytes]] = {
    "shape.stl": _stl, "shape.obj": _obj, "shape.msh": _msh, "image.png": _png, "field.bin": _field,
}  # fmt: skip


class Sender:
    """A server that is sent such files; whatever they are, it lives, and the other client is answered."""

    def __init__(self, folder: Path) -> None:
        self._victim = Victim(folder)
        self._sent = folder / "sent"
        self._sent.mkdir()
        self._client = self._victim.world.client()
        self.loaded = 0

    def one(self, data: bytes) -> None:
        """One case: some files are transferred, and one of them is loaded as a scene or as a model."""
        for name, content in bundle(data).items():
            (self._sent / name).write_bytes(content)
            code = v.simxTransferFile(self._client, str(self._sent / name), name, 0, BLOCKING)
            assert code == v.simx_return_ok, (name, v.simxGetLastErrors(self._client, BLOCKING))
        if len(data) % 2:
            code, _ = v.simxLoadModel(self._client, to_load(data), 0, BLOCKING)
        else:
            code = v.simxLoadScene(self._client, to_load(data), 0, BLOCKING)
        if code == v.simx_return_ok:
            self.loaded += 1
            v.simxStartSimulation(self._client, BLOCKING)
            self._victim.world.loop.turn()
        _, errors = v.simxGetLastErrors(self._client, BLOCKING)
        assert code == v.simx_return_ok or errors, "no sentence"
        assert not any("internal error" in error for error in errors), errors
        self._victim.check(data)
        self._victim.begin()

    def close(self) -> None:
        self._victim.close()
