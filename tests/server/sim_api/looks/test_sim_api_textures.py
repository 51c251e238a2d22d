"""Textures that scripts find, read, write and apply to shapes."""

from __future__ import annotations

from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest
from sim_api_calls import SCENE, ScriptWorld, world

__all__ = ["world"]

CHECKED = SCENE.replace(
    "<worldbody>",
    '<asset><texture name="checks" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="8" height="4"/>'
    '<material name="painted" texture="checks"/></asset><worldbody>'
    '<body name="board" pos="5 0 0"><geom type="box" size="1 1 1" material="painted"/></body>',
)


@pytest.fixture
def checked(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, CHECKED)


def drawn_texture(world: ScriptWorld, name: str) -> str:
    """The name of the texture that images show on a body's last geom; empty without one."""
    model = world.sim.model
    body = model.body(name)
    geom = int(body.geomadr[0] + body.geomnum[0] - 1)
    material = int(model.geom_matid[geom])
    texture = (
        int(model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)]) if material >= 0 else -1
    )
    return model.tex(texture).name if texture >= 0 else ""


def test_textures_have_numbers(checked: ScriptWorld) -> None:
    number, resolution = checked.lua("t = sim.getTextureId('checks') return sim.getTextureId('checks')")
    assert resolution == [8, 4]
    assert checked.lua("return sim.getShapeTextureId(sim.getObjectHandle('board'))") == [number]
    assert checked.lua("return sim.getShapeTextureId(sim.getObjectHandle('cube'))") == [-1]
    assert checked.lua("return sim.getTextureId('nothing')") == [-1]
    checked.fails("sim.readTexture(99, 0)", "no texture has the number 99")


def test_pixels_are_read_and_written(checked: ScriptWorld) -> None:
    (text,) = checked.lua("t = sim.getTextureId('checks') return sim.readTexture(t, 0)")
    before = np.frombuffer(text.encode("latin-1"), np.uint8).reshape(4, 8, 3)
    assert set(map(tuple, before.reshape(-1, 3).tolist())) == {(255, 0, 0), (0, 0, 255)}
    models = checked.sim.model_version
    checked.lua("for x = 0, 1 do sim.writeTexture(t, 0, string.char(1, 2, 3):rep(3), 2 * x, 0, 1, 3) end")
    assert checked.lua("return sim.readTexture(t, 0, 2, 2, 1, 1)") == ["\x01\x02\x03"]
    assert checked.sim.model_version == models, "many writings are one change of the model"
    checked.run(1)
    model = checked.sim.model
    after = model.tex_data[: 4 * 8 * 3].reshape(4, 8, 3)
    assert (after[:3, [0, 2]] == (1, 2, 3)).all()
    assert (after[3] == before[3]).all()
    checked.lua("sim.writeTexture(t, 4, string.rep('a', 8 * 4 * 3))")
    (text,) = checked.lua("return sim.readTexture(t, 0)")
    round_one = np.frombuffer(text.encode("latin-1"), np.uint8).reshape(4, 8, 3)
    assert (round_one[2, 4] == 97).all()
    assert (round_one[3, 7] == before[3, 7]).all()
    checked.lua("sim.writeTexture(t, 0, string.char(0, 100, 200), 0, 0, 1, 1)")
    checked.lua("sim.writeTexture(t, 0, string.char(100, 0, 0), 0, 0, 1, 1, 0.25)")
    assert checked.lua("return sim.readTexture(t, 0, 0, 0, 1, 1)") == ["K\x192"]  # 75, 25, 50
    checked.fails("sim.writeTexture(t, 0, 'abc', 0, 0, 0, 0, 2)", "from 0 to 1, not 2")
    checked.fails("sim.writeTexture(t, 0, 'abc')", "8 x 4 pixels have 96 bytes, not 3")
    checked.fails("sim.readTexture(t, 0, 7, 0, 2, 1)", "are not within 8 x 4")
    checked.sim.stop()
    assert (checked.sim.model.tex_data[: 4 * 8 * 3].reshape(4, 8, 3) == before).all()


def test_a_texture_is_applied_to_shapes_and_taken_away(checked: ScriptWorld) -> None:
    mass = checked.sim.model.body("cube").mass[0]
    checked.lua(
        "t = sim.getTextureId('checks') c = sim.getObjectHandle('cube') "
        "sim.setShapeTexture(c, t, sim.texturemap_cube, 2, {0.5, 0.5}, {0, 0, 0.1}, {0, 0, 1})"
    )
    assert drawn_texture(checked, "cube") == "checks"
    assert checked.value("sim.getShapeTextureId(c) == t")
    assert checked.sim.model.body("cube").mass[0] == pytest.approx(mass)
    places = np.array(checked.lua("return sim.getShapeViz(c, 0)")[0]["texture"]["coordinates"])
    assert np.ptp(places.reshape(-1, 2), axis=0).max() < 1
    geoms = checked.sim.model.body("cube").geomnum[0]
    checked.lua("sim.setShapeTexture(c, t, sim.texturemap_plane, 0, {1, 1})")
    assert checked.sim.model.body("cube").geomnum[0] == geoms
    assert (checked.sim.model.nmesh, checked.sim.model.nmat) == (1, 2), "nothing is left of the first one"
    checked.run(1)
    checked.lua("sim.setShapeTexture(c, -1, 0, 0, {1, 1})")
    assert drawn_texture(checked, "cube") == ""
    checked.fails("sim.setShapeTexture(c, t, 7, 0, {1, 1})", "7 is no mapping")
    checked.sim.stop()
    assert checked.sim.model.body("cube").geomnum[0] == 1


def test_shapes_with_a_texture_still_collide_and_rest(checked: ScriptWorld) -> None:
    checked.lua(
        "c = sim.getObjectHandle('cube') d = sim.getObjectHandle('cube#0') "
        "sim.setShapeTexture(c, sim.getTextureId('checks'), 0, 0, {1, 1}) sim.setObjectPosition(d, -1, {2.15, 0, 1})"
    )
    assert checked.lua("return sim.checkCollision(c, d)")[0] == 1
    checked.run(3)
    assert checked.lua("return sim.getObjectPosition(c, -1)")[0][0] < 2.0, "physics pushes it away"


def test_new_textures_are_made_with_a_plane(world: ScriptWorld) -> None:
    handle, number, resolution = world.lua(
        "h, t, r = sim.createTexture('', 2, {2, 1}, nil, nil, 0, {4, 2}) return h, t, r"
    )
    assert resolution == [4, 2]
    assert world.lua("return sim.getShapeTextureId(h), sim.getTextureId('texture')") == [
        number,
        number,
        [4, 2],
    ]
    assert world.sim.scene.get(handle).name == "Plane"
    assert world.lua("return sim.readTexture(t, 0)") == ["\xff" * 24]
    world.fails("sim.createTexture('', 0, {0, 1})", "sizes above 0")
    world.fails("sim.createTexture('', 0, nil, nil, nil, 0, {0, 1})", "a resolution is")


def test_an_image_file_becomes_a_texture(world: ScriptWorld, tmp_path: Path) -> None:
    pixels = np.zeros((6, 12, 3), np.uint8)
    pixels[5] = (0, 0, 255)
    cv2.imwrite(str(tmp_path / "flag.png"), pixels)
    _, number, resolution = world.lua("h, t, r = sim.createTexture('flag.png', 0) return h, t, r")
    assert resolution == [12, 6]
    assert world.lua("return (sim.getTextureId('flag'))") == [number]
    assert world.lua("return sim.readTexture(t, 0, 0, 0, 1, 1)") == ["\xff\x00\x00"], "red, at the bottom"
    assert world.lua("h, t, r = sim.createTexture('flag.png', 0, nil, nil, nil, 8) return r") == [[8, 8]]
    (tmp_path / "no.png").write_text("no image")
    world.fails("sim.createTexture('no.png', 0)", "not an image file")


def test_pixels_and_coordinates_are_applied_at_once(checked: ScriptWorld) -> None:
    checked.lua(
        "c = sim.getObjectHandle('cube') n = #sim.getShapeViz(c, 0).indices uv = {} "
        "for i = 1, 2 * n do uv[i] = (i % 2) / 2 end "
        "t = sim.applyTexture(c, uv, string.char(9, 8, 7, 0):rep(4), {2, 2}, 16 + 32 + 64)"
    )
    assert checked.value("sim.getShapeTextureId(c) == t")
    assert checked.lua("return sim.readTexture(t, 0)") == ["\x09\x08\x07" * 4]
    assert checked.lua("return sim.getShapeViz(c, 0)")[0]["texture"]["coordinates"][:4] == [0.5, 0, 0.5, 0]
    checked.fails("sim.applyTexture(c, {1, 2}, 'abc', {1, 1})", "numbers u and v of their corners; got 2")
    checked.fails("sim.applyTexture(c, uv, 'abc', {2, 1})", "2 x 1 pixels have 6 bytes, not 3")
