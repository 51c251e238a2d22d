"""Render mode 2: a picture whose pixels are the handles of what is seen, in both back ends and for every asker."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from camera_world import FRONT, SCENE, load, pixel_of
from handler_calls import World
from sim_api_calls import ScriptWorld

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.cameras.image import NO_CODE, CameraImage, CameraView

pytestmark = pytest.mark.slow

__all__ = ["make_renderer", "opengl_name"]

MODE = c.sim_visionintparam_render_mode
PANE = SCENE.replace(
    '<site name="dummy"',
    '<geom name="pane" type="box" size="0.2 0.01 0.2" rgba="1 0 0 0.5"/><site name="dummy"',
)
CODES = (3, 258, 0x030201, 9, 10, 70000)
"""Of the geoms red, green, wall, collision shape, invisible, pane: all three bytes are used."""


def codes_of(picture: CameraImage) -> np.ndarray:
    assert picture.rgb is not None
    return picture.rgb.astype(int) @ (1, 256, 65536)


def coded(view: CameraView = FRONT) -> CameraView:
    return dataclasses.replace(view, codes=CODES, background=(1.0, 1.0, 1.0))


def test_each_pixel_has_exactly_the_code_of_what_is_seen_there(make_renderer) -> None:
    model, data = load(PANE)
    renderer = make_renderer(model)
    codes = codes_of(renderer.render(data, coded(), rgb=True, depth=True))
    assert codes[pixel_of(FRONT, -0.4, 0.3, 2.0)] == 3
    assert codes[pixel_of(FRONT, 0.4, -0.3, 1.9)] == 258
    assert codes[0, 0] == 0x030201
    assert (
        codes[60, 80] == 70000
    )  # see-through, and solid here; neither what is hidden nor what is clear is seen
    assert set(np.unique(codes)) == {3, 258, 0x030201, 70000}
    # The outlines are those of the coloured picture.
    coloured = renderer.render(data, FRONT, rgb=True, depth=True)
    assert np.array_equal(codes != 0x030201, coloured.depth < 0.39)
    assert coloured.rgb[pixel_of(FRONT, -0.4, 0.3, 2.0)][0] > 150


def test_where_nothing_is_seen_the_code_is_white(make_renderer) -> None:
    model, data = load(PANE)
    codes = codes_of(
        make_renderer(model).render(data, dataclasses.replace(coded(), far=3.0), rgb=True, depth=False)
    )
    assert codes[0, 0] == NO_CODE
    assert codes[pixel_of(FRONT, -0.4, 0.3, 2.0)] == 3


def test_what_is_cut_by_the_near_plane_is_looked_through(make_renderer) -> None:
    model, data = load(PANE)
    beyond = dataclasses.replace(coded(), near=2.5)
    codes = codes_of(make_renderer(model).render(data, beyond, rgb=True, depth=False))
    assert np.all(codes == 0x030201)


WORLD = """
<mujoco>
  <statistic extent="1"/>
  <worldbody>
    <geom size="0.1" pos="0 0 9"/>
    <body name="ball"><geom size="0.2"/></body>
    <body name="box" pos="0 0 -1"><geom type="box" size="9 9 0.1"/><geom type="box" size="0.1 0.1 0.3"/></body>
    <camera name="eye" pos="0 0 2" resolution="4 2"/>
    <camera name="depth_eye" pos="0 0 3" resolution="4 2" output="depth"/>
    <camera name="sorter" pos="0 0 4" resolution="4 2"/>
    <camera name="asked" pos="0 0 5" resolution="4 2"/>
  </worldbody>
  <custom>
    <text name="simx:vision:sorter" data="render=handles"/>
    <text name="simx:vision:asked" data="render=handles explicit=yes"/>
  </custom>
</mujoco>
"""
RAMP = bytes(range(24))
"""What the painter of `handler_calls` makes of every view."""


@pytest.fixture
def world() -> World:
    world = World(WORLD)
    world.run()
    return world


def image(world: World, name: str) -> bytes:
    return world.call("simxGetVisionSensorImage", world.handle(name), 0)[1]


def mode(world: World, name: str) -> int:
    return world.call("simxGetObjectIntParameter", world.handle(name), MODE)


def set_mode(world: World, name: str, value: int) -> None:
    world.call("simxSetObjectIntParameter", world.handle(name), MODE, value)


@pytest.mark.gl
def test_the_mode_is_set_read_back_and_stays_when_the_simulation_stops(world: World) -> None:
    assert (mode(world, "eye"), mode(world, "sorter")) == (0, 2)
    image(world, "eye")
    assert world.painter.views[-1].codes is None
    set_mode(world, "eye", 2)
    image(world, "eye")
    view = world.painter.views[-1]
    ball, box = world.handle("ball"), world.handle("box")
    assert view.codes == (NO_CODE, ball, box, box)  # a geom of the world without a name is no object
    assert view.background == (1.0, 1.0, 1.0)
    # V-REP, too, put back the explicit handling only.
    world.call("simxStopSimulation")
    assert mode(world, "eye") == 2
    set_mode(world, "eye", 0)
    image(world, "eye")
    assert world.painter.views[-1].codes is None


@pytest.mark.gl
@pytest.mark.parametrize("number", [0, 1, 3, 5, 6, 7, 8])
def test_every_mode_but_2_is_kept_and_draws_colours(world: World, number: int) -> None:
    set_mode(world, "sorter", number)
    image(world, "sorter")
    assert mode(world, "sorter") == number
    assert world.painter.views[-1].codes is None
    told = [line for line in world.parts.status_bar.messages if "draws colours as mode 0" in line]
    assert len(told) == (number in (1, 3, 5, 6))  # V-REP's renderers of its own drew colours in the others


@pytest.mark.gl
def test_a_number_without_a_render_mode_is_refused(world: World) -> None:
    for wrong in (4, 9, -1):
        with pytest.raises(CommandError, match=f"{wrong} is not a render mode; those are 0 colours, 1 aux"):
            set_mode(world, "eye", wrong)
    assert mode(world, "eye") == 0


@pytest.mark.gl
def test_a_file_names_the_render_mode(world: World) -> None:
    assert mode(World(WORLD.replace("render=handles explicit=yes", "render=opengl3")), "asked") == 7


@pytest.mark.gl
def test_numbers_of_an_image_are_those_of_single_precision(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path)
    wanted = np.arange(256, dtype=np.float32) / np.float32(255)
    for first in (0, 96, 160):  # an image of `eye` has 96 bytes
        given = range(first, first + 96)
        numbers = world.lua(
            "local eye = sim.getObjectHandle('eye')\n"
            f"sim.setVisionSensorCharImage(eye, string.char({', '.join(map(str, given))}))\n"
            "return sim.getVisionSensorImage(eye)"
        )[0]
        assert numbers == wanted[first : first + 96].tolist()


@pytest.mark.gl
def test_a_sensor_that_shows_its_depth_shows_handles_when_told_to(world: World) -> None:
    grey = image(world, "depth_eye")
    set_mode(world, "depth_eye", 2)
    assert image(world, "depth_eye") == RAMP != grey
    assert world.painter.views[-1].codes is not None


@pytest.mark.gl
def test_background_is_white_when_nothing_is_drawn(world: World) -> None:
    assert image(world, "asked") == b"\xff" * 24


@pytest.mark.gl
def test_reading_the_sensor_lists_the_handles_it_sees_plus_a_half(world: World) -> None:
    seen = [7, 7, NO_CODE, 300, 5, 300, 7, NO_CODE]
    pixels = b"".join(code.to_bytes(3, "little") for code in seen)
    world.call("simxSetVisionSensorImage", world.handle("sorter"), pixels, 0)
    assert world.call("simxReadVisionSensor", world.handle("sorter")) == (False, [[5.5, 7.5, 300.5]])


@pytest.mark.gl
def test_scripts_set_the_mode_by_its_name(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path)
    eye, number = "local eye = sim.getObjectHandle('eye')\n", "eye, sim.visionintparam_render_mode"
    world.lua(f"{eye} sim.setObjectInt32Param({number}, sim.rendermode_colorcoded)")
    assert world.lua(f"{eye} return sim.getObjectInt32Param({number})") == [2]
    assert world.parts.vision.settings(world.handle("eye")).shows_handles
    world.lua(eye.replace("local ", ""))
    world.goes_on(f"sim.setObjectInt32Param({number}, sim.rendermode_povray)", "pov_ray, draws colours", 1)
    world.goes_on(f"sim.setObjectInt32Param({number}, 4)", "is not a render mode", 1)
