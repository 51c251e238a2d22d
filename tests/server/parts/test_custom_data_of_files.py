"""Custom data, extension strings and size factors that a scene's file brings along."""

from __future__ import annotations

import base64
import struct
from pathlib import Path

import pytest
from handler_calls import World
from scripted_world import evaluate, scripted

from simx_server.editing.copying import Kept, copy_objects
from simx_server.parts.custom_data import EXTENSION, REFERENCES, SCENE

pytest.importorskip("lupa")

BLOCK = b"\x00\x01 any bytes \xff"
NOTES = (
    f'<text name="simx:data:base" data="CONF={base64.b64encode(BLOCK).decode()} with%20space=AAAA"/>'
    '<text name="simx:data:world" data="SCENE=QUJD"/>'
    '<text name="simx:object:base" data="size_factor=2.5 extension=name@plugin%20%7Btext%7D"/>'
)


SCENE_FILE = "<mujoco><worldbody>{}</worldbody><custom>{}</custom></mujoco>"


def handle(world: World, name: str) -> int:
    found = world.sim.scene.by_name(name)
    assert found is not None
    return found


def test_scripts_read_the_blocks_of_the_file() -> None:
    world = scripted(
        {"lua:customization:base": "b = sim.readCustomDataBlock(sim.handle_self, 'CONF')"}, custom=NOTES
    )
    code = (
        "return b, sim.readCustomDataBlockTags(sim.handle_self), sim.readCustomStringData(sim.handle_scene, 'SCENE'),"
        " sim.getObjectSizeFactor(sim.handle_self), sim.getExtensionString(sim.handle_self, -1, 'name@plugin')"
    )
    assert evaluate(world, code, kind=6) == [BLOCK, [b"CONF", b"with space"], b"ABC", 2.5, b"text"]


def test_an_object_without_blocks_has_none() -> None:
    world = scripted({}, custom=NOTES)
    assert world.parts.custom_data.names(handle(world, "plain")) == []


def test_what_a_script_writes_stays_instead() -> None:
    world = scripted({}, custom=NOTES)
    data, base = world.parts.custom_data, handle(world, "base")
    data.write(base, "CONF", b"")
    data.write(base, "new", b"n")
    assert data.names(base) == ["with space", EXTENSION, "new"]


def test_a_copy_has_the_blocks_of_its_original() -> None:
    world = scripted({}, custom=NOTES)
    data = world.parts.custom_data
    (untouched,) = copy_objects(world.parts, [handle(world, "base")])
    assert data.read(untouched, "CONF") == BLOCK
    data.write(handle(world, "base"), "CONF", b"changed")
    (changed,) = copy_objects(world.parts, [handle(world, "base")])
    assert data.read(changed, "CONF") == b"changed"


def test_a_loaded_model_brings_its_blocks(tmp_path: Path) -> None:
    notes = '<text name="simx:data:part" data="CONF=QUJD"/><text name="simx:data:world" data="SCENE=AAAA"/>'
    (tmp_path / "model.xml").write_text(SCENE_FILE.format('<body name="part"><geom size="1"/></body>', notes))
    world = World(SCENE_FILE.format('<body name="base"><geom size="1"/></body>', NOTES), workspace=tmp_path)
    loaded = world.call("simxLoadModel", str(tmp_path / "model.xml"), 0)
    assert world.parts.custom_data.read(loaded, "CONF") == b"ABC"
    assert world.parts.custom_data.read(SCENE, "SCENE") == b"ABC", (
        "a model does not change the scene's own data"
    )


def test_references_of_a_loaded_model_mean_its_own_objects(tmp_path: Path) -> None:
    notes = '<text name="simx:references:base" data="ik.tip=base,gone"/>'
    model = SCENE_FILE.format('<body name="base"><geom size="1"/></body>', notes)
    (tmp_path / "model.xml").write_text(model)
    world = World(model, workspace=tmp_path)
    loaded = world.call("simxLoadModel", str(tmp_path / "model.xml"), 0)
    for base in (handle(world, "base"), loaded):
        assert world.parts.custom_data.read(base, f"{REFERENCES}ik.tip") == struct.pack("<2i", base, -1)
    (copy,) = copy_objects(world.parts, [loaded], Kept(references=False))
    assert world.parts.custom_data.names(copy) == []


def test_another_scene_has_its_own_blocks() -> None:
    world = scripted({}, custom=NOTES)
    assert world.parts.custom_data.read(SCENE, "SCENE") == b"ABC"
    world.call("simxCloseScene")
    assert world.parts.custom_data.read(SCENE, "SCENE") is None
