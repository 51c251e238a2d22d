"""Files of clients that crash MuJoCo, or ask for all memory or time: the server says so in a sentence and goes on."""

from __future__ import annotations

import dataclasses
import io
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

import pytest
from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_server.limits import Limits

pytestmark = pytest.mark.slow

REMOTE_ERROR = v.simx_return_remote_error_flag
CUBE = b"<mujoco><worldbody><body name='cube'><geom type='box' size='.1 .1 .1'/></body></worldbody></mujoco>"
MOST = ["load_memory=384M", "load_seconds=1", "load_wait=20"]
"""Less than by default, so the tests are quick."""

SOON = 0.3
"""Seconds of processor time where a file is refused for these; others need more to reach the limit of memory."""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealWorld]:
    folder = tmp_path_factory.mktemp("workspace")
    (folder / "start.xml").write_bytes(CUBE.replace(b"cube", b"start"))
    world = RealWorld(folder / "start.xml", workspace=folder)
    world.simulation.limits = Limits.of(MOST)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> Iterator[int]:
    client = world.client(timeout=30.0)  # a second of processor time may take several on busy cores
    yield client
    v.simxFinish(client)


@pytest.fixture
def soon(world: RealWorld) -> Iterator[None]:
    """The file is expected to take too much processor time."""
    world.simulation.limits = dataclasses.replace(Limits.of(MOST), load_seconds=SOON)
    yield
    world.simulation.limits = Limits.of(MOST)


@pytest.fixture
def put(world: RealWorld, tmp_path: Path, client: int):
    """Stores files by name, as a client does."""

    def put(**files: bytes) -> None:
        for name, data in files.items():
            name = name.replace("__", "/").replace("_dot_", ".")
            (tmp_path / "sent").write_bytes(data)
            assert v.simxTransferFile(client, str(tmp_path / "sent"), name, 5000, BLOCKING) == 0

    return put


def error_of(client: int) -> str:
    code, texts = v.simxGetLastErrors(client, BLOCKING)
    assert code == 0
    return "\n".join(texts)


def resident() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def refused(world: RealWorld, client: int, file: str, *, model: bool = False) -> str:
    """Load a file as a scene or a model; what the error says. Another client is served, the scene stays."""
    scene, before = world.simulation.scene, resident()
    if model:
        code, _ = v.simxLoadModel(client, file, 0, BLOCKING)
    else:
        code = v.simxLoadScene(client, file, 0, BLOCKING)
    said = error_of(client)
    assert code == REMOTE_ERROR, said
    assert world.simulation.scene is scene
    assert resident() - before < 64 << 20
    other = world.client()
    assert v.simxGetObjectHandle(other, "start", BLOCKING)[0] == 0
    v.simxFinish(other)
    return said


# --- circles --------------------------------------------------------------------------------------

ATTACH = b"""<mujoco><asset><model name="m" file="%s"/></asset>
<worldbody><body name="b"><attach model="m" body="b" prefix="x"/></body></worldbody></mujoco>"""
INCLUDE = b'<mujoco><include file="%s"/></mujoco>'


def test_a_file_that_names_itself_is_refused(world, client, put) -> None:
    put(self_dot_xml=ATTACH % b"self.xml")
    assert "'self.xml' names itself" in refused(world, client, "self.xml")
    put(self_dot_xml=INCLUDE % b"./self.xml")
    assert "'self.xml' names itself" in refused(world, client, "self.xml", model=True)


@pytest.mark.parametrize(("first", "second"), [(ATTACH, ATTACH), (INCLUDE, ATTACH), (ATTACH, INCLUDE)])
def test_a_circle_of_files_is_refused_by_the_names_of_them(world, client, put, first, second) -> None:
    put(
        a_dot_xml=first % b"sub/b.xml",
        sub__b_dot_xml=second % b"../sub/c.xml",
        sub__c_dot_xml=ATTACH % b"../a.xml",
    )
    assert "'a.xml' names 'b.xml' names 'c.xml' names 'a.xml'" in refused(world, client, "a.xml")


def test_a_circle_through_a_file_of_the_operators_is_refused(world, client, put) -> None:
    own = world.simulation.files.workspace / "own.xml"
    own.write_bytes(ATTACH % b"theirs.xml")
    put(theirs_dot_xml=ATTACH % b"own.xml")
    assert "'own.xml' names 'theirs.xml' names 'own.xml'" in refused(world, client, "own.xml")


def test_a_file_that_is_included_twice_is_no_circle(world, client, put) -> None:
    part = b'<mujoco><worldbody><body name="%s"><geom size="1"/></body></worldbody></mujoco>'
    put(one__part_dot_xml=part % b"p1", two__part_dot_xml=part % b"p2")
    put(both_dot_xml=b'<mujoco><include file="one/part.xml"/><include file="two/part.xml"/></mujoco>')
    assert v.simxLoadScene(client, "both.xml", 0, BLOCKING) == 0, error_of(client)
    assert handle_of(client, "p1") != handle_of(client, "p2")
    assert v.simxLoadScene(client, "start.xml", 0, BLOCKING) == 0


# --- what is too much -----------------------------------------------------------------------------


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    pixels = zlib.compress(bytes(1000))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def many(count: int, text: str) -> str:
    return "".join(text.format(i) for i in range(count))


TEXTURES = many(30, '<texture name="t{0}" type="2d" builtin="flat" width="4000" height="4000"/>')
FIELDS = many(30, '<hfield name="f{0}" nrow="4000" ncol="4000" size="1 1 1 1"/>')
DEFAULT = "<default class='d{0}'>"
LOOSE = "<body><freejoint/><geom size='1'/></body>"
CHAIN = "<body><joint/><geom size='.1'/>"
BOMBS = {
    "nuserdata": '<size nuserdata="2000000000"/>',
    "nuser_geom": '<size nuser_geom="200000000"/><worldbody><geom size="1"/></worldbody>',
    "memory": '<size memory="64G"/>',
    "njmax": '<size njmax="2000000000" nconmax="2000000000"/>',
    "textures": f"<asset>{TEXTURES}</asset>",
    "height fields": f"<asset>{FIELDS}</asset>",
    "contact sensor": '<worldbody><geom name="g" size="1"/></worldbody>'
    '<sensor><contact geom1="g" num="200000000"/></sensor>',
    "user sensor": '<sensor><user dim="2000000000"/></sensor>',
    "builtin mesh": '<asset><mesh name="m" builtin="sphere" params="14"/></asset>'
    '<worldbody><geom type="mesh" mesh="m"/></worldbody>',
    "deep bodies": f"<worldbody>{CHAIN * 30000}{'</body>' * 30000}</worldbody>",
    "deep defaults": f"<default>{many(20000, DEFAULT)}{'</default>' * 20001}",
    "many bodies": f"<worldbody>{LOOSE * 20000}</worldbody>",
    "overlaps": f"<worldbody>{LOOSE * 1500}</worldbody>",
    "flexcomp": '<worldbody><flexcomp name="f" type="grid" count="40 40 40" dim="3"/></worldbody>',
    "plugin": '<extension><plugin plugin="mujoco.nothing"/></extension>',
    "history": '<worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>'
    '<actuator><motor joint="j" nsample="2000000000" delay="1"/></actuator>',
}  # fmt: skip
ENDLESS = ("many bodies", "flexcomp")
"""Those that take long instead of memory."""


@pytest.mark.parametrize("bomb", BOMBS)
def test_a_short_text_that_asks_for_too_much_is_refused(world, client, put, bomb, request) -> None:
    if bomb in ENDLESS:
        request.getfixturevalue("soon")
    put(bomb_dot_xml=f"<mujoco>{BOMBS[bomb]}</mujoco>".encode())
    said = refused(world, client, "bomb.xml")
    assert "'bomb.xml'" in said
    assert "Traceback" not in said


def test_the_sentence_names_the_limit_its_value_and_the_flag(world, client, put) -> None:
    put(bomb_dot_xml=b'<mujoco><size nuserdata="2000000000"/></mujoco>')
    said = refused(world, client, "bomb.xml")
    assert "at most 384M bytes of memory" in said
    assert "--limit load_memory=N" in said
    put(bomb_dot_xml=b'<mujoco><size nkey="100000000"/></mujoco>')
    said = refused(world, client, "bomb.xml")
    assert "at most 1 seconds of processor time" in said
    assert "--limit load_seconds=N" in said


def test_replicas_across_files_are_refused(world, client, put, soon) -> None:
    inner = b"""<mujoco><worldbody><body name="b"><replicate count="300"><geom size="1"/></replicate></body></worldbody>
    </mujoco>"""
    outer = b"""<mujoco><asset><model name="m" file="%s"/></asset><worldbody><body name="b"><replicate count="300">
    <attach model="m" body="b" prefix="x"/></replicate></body></worldbody></mujoco>"""
    put(inner_dot_xml=inner, middle_dot_xml=outer % b"inner.xml", outer_dot_xml=outer % b"middle.xml")
    refused(world, client, "outer.xml")


def test_an_image_whose_header_promises_gigabytes_is_refused(world, client, put) -> None:
    put(huge_dot_png=png(40000, 20000))
    put(picture_dot_xml=b'<mujoco><asset><texture name="t" type="2d" file="huge.png"/></asset></mujoco>')
    refused(world, client, "picture.xml")


STL = bytes(80) + struct.pack("<I", 150_000_000)
OBJ_FACES = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 999999999 999999998 999999997\n" * 4
MSH = struct.pack("<4i", 500_000_000, 500_000_000, 500_000_000, 500_000_000)


@pytest.mark.parametrize(("name", "data"), [("m.stl", STL), ("m.obj", OBJ_FACES), ("m.msh", MSH)])
def test_a_mesh_that_promises_more_than_it_holds_is_refused(world, client, put, name, data) -> None:
    put(**{name.replace(".", "_dot_"): data})
    mesh, geom = f'<mesh name="m" file="{name}"/>', '<geom type="mesh" mesh="m"/>'
    put(mesh_dot_xml=f"<mujoco><asset>{mesh}</asset><worldbody>{geom}</worldbody></mujoco>".encode())
    refused(world, client, "mesh.xml")
    if name != "m.msh":
        assert v.simxLoadModel(client, name, 0, BLOCKING) == (REMOTE_ERROR, 0)


def test_a_deep_chain_of_links_is_refused(world, client, put, soon) -> None:
    links = many(9000, '<link name="l{0}"/>')
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(8999)
    )
    put(deep_dot_urdf=f'<robot name="r">{links}{joints}</robot>'.encode())
    refused(world, client, "deep.urdf")


def test_deeply_nested_elements_are_refused(world, client, put) -> None:
    put(deep_dot_xml=b"<mujoco>" + b"<a>" * 200_000 + b"</a>" * 200_000 + b"</mujoco>")
    refused(world, client, "deep.xml")


def test_entities_that_multiply_are_refused(world, client, put) -> None:
    entities = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 50}">' for i in range(1, 9))
    put(laughs_dot_xml=f'<!DOCTYPE m [<!ENTITY e0 "ha">{entities}]><mujoco model="&e8;"/>'.encode())
    refused(world, client, "laughs.xml")


def test_an_archive_that_unpacks_to_gigabytes_is_refused(world, client, put) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("scene.xml", CUBE)
        with archive.open("big.png", "w") as member:
            for _ in range(300):
                member.write(bytes(1 << 20))
    put(bomb_dot_zip=packed.getvalue())
    assert "unpacks to" in refused(world, client, "bomb.zip")


def test_a_file_of_custom_uis_that_takes_minutes_to_parse_is_refused(world, client, put, soon) -> None:
    put(slow_dot_toml=b"a." * 400_000 + b"b = 1")
    assert v.simxLoadUI(client, "slow.toml", 0, BLOCKING)[0] == REMOTE_ERROR
    assert "load_seconds" in error_of(client)


def test_models_together_do_not_get_past_the_limit(world, client, put) -> None:
    """Each alone is within it."""
    world.simulation.limits = Limits.of([*MOST, "load_memory=160M"])
    for number in range(1, 9):
        texture = (
            f'<texture name="t" type="2d" builtin="flat" width="2400" height="2400" rgb1=".{number} 0 0"/>'
        )
        text = (
            f"<mujoco><asset>{texture}</asset><worldbody><body><geom size='1'/></body></worldbody></mujoco>"
        )
        put(**{f"m{number}_dot_xml": text.encode()})
        code, _ = v.simxLoadModel(client, f"m{number}.xml", 0, BLOCKING)
        if code == REMOTE_ERROR:
            break
    world.simulation.limits = Limits.of(MOST)
    assert code == REMOTE_ERROR
    assert "load_memory" in error_of(client)
    assert number > 1
    assert v.simxLoadScene(client, "start.xml", 0, BLOCKING) == 0


# --- what is no file ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "scene",
    [
        INCLUDE % b"pipe",
        ATTACH % b"pipe",
        b'<mujoco><asset><mesh name="m" file="pipe"/></asset></mujoco>',
        b'<mujoco><asset><texture name="t" type="2d" file="pipe"/></asset></mujoco>',
        b'<mujoco><asset><hfield name="h" size="1 1 1 1" file="pipe"/></asset></mujoco>',
    ],
)
def test_a_pipe_is_refused_wherever_it_is_named(world, client, put, scene) -> None:
    pipe = world.simulation.files.workspace / "pipe"
    if not pipe.exists():
        os.mkfifo(pipe)
    put(names_dot_xml=scene)
    assert "'pipe' is a pipe, a device or a socket" in refused(world, client, "names.xml")


def test_a_pipe_is_neither_written_nor_erased_nor_loaded(world, client, put, tmp_path) -> None:
    pipe = world.simulation.files.workspace / "pipe.xml"
    os.mkfifo(pipe)
    (tmp_path / "sent").write_bytes(CUBE)
    assert v.simxTransferFile(client, str(tmp_path / "sent"), "pipe.xml", 5000, BLOCKING) == REMOTE_ERROR
    assert "is a pipe" in error_of(client)
    assert v.simxEraseFile(client, "pipe.xml", BLOCKING) == REMOTE_ERROR
    assert v.simxLoadScene(client, "pipe.xml", 0, BLOCKING) == REMOTE_ERROR
    assert v.simxLoadUI(client, "pipe.xml", 0, BLOCKING)[0] == REMOTE_ERROR
    assert pipe.is_fifo()
