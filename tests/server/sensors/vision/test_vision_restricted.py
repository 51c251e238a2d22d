"""Vision sensors that see one object or collection only, and sensors without colours, depth or statistics."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from camera_world import FRONT, SCENE, load, pixel_of
from handler_calls import QuickPainter, World, floats
from real_world import render_with
from sim_api_calls import ScriptWorld

from simx_client.protocol import constants as c
from simx_server.errors import CommandError

__all__ = ["make_renderer", "opengl_name"]

ENTITY = c.sim_visionintparam_entity_to_render
RED, GREEN, WALL = 0, 1, 2


def test_view_of_some_geoms_shows_nothing_else(make_renderer) -> None:
    model, data = load(SCENE)
    view = dataclasses.replace(FRONT, only=frozenset({GREEN}), background=(0.0, 0.0, 1.0))
    picture = make_renderer(model).render(data, view, rgb=True, depth=True)
    green, red = pixel_of(view, 0.4, -0.3, 1.9), pixel_of(view, -0.4, 0.3, 1.9)
    assert picture.rgb[green][1] > 60
    assert tuple(picture.rgb[red]) == (0, 0, 255)
    assert picture.depth[red] == 1.0
    assert picture.depth[green] == pytest.approx((1.9 - 0.1) / 9.9, abs=1e-3)
    nothing = make_renderer(model).render(
        data, dataclasses.replace(view, only=frozenset()), rgb=True, depth=True
    )
    assert np.all(nothing.depth == 1.0)


ROOM = """
<mujoco>
  <worldbody>
    <body name="head" pos="0 0 1"><camera name="eye" resolution="4 2" {output}/><geom size="0.01"/></body>
    <body name="ball" pos="0 0 0"><geom size="0.1"/><geom size="0.1" pos="1 0 0"/></body>
    <body name="cube" pos="0 1 0"><geom type="box" size="0.1 0.1 0.1"/></body>
  </worldbody>
  <custom>
    <text name="simx:collection:both" data="objects=ball,cube"/>
    <text name="simx:collection:cube" data="objects=ball"/>
    <text name="simx:vision:eye" data="{note}"/>
  </custom>
</mujoco>
"""


def room(note: str, output: str = "") -> World:
    world = World(ROOM.format(note=note, output=output))
    world.run()
    return world


def seen(world: World) -> frozenset[int] | None:
    """The geoms that the next image shows."""
    world.call("simxGetVisionSensorImage", world.handle("eye"), 0)
    return world.painter.views[-1].only


def test_entity_of_the_file_is_all_that_a_sensor_sees() -> None:
    assert seen(room("near=0.1")) is None
    assert seen(room("entity=ball")) == {1, 2}
    assert seen(room("entity=both")) == {1, 2, 3}
    assert seen(room("entity=cube")) == {3}
    assert seen(room("entity=collection:cube")) == {1, 2}


def test_entity_changes_by_parameter_and_ends_with_the_object() -> None:
    world = room("entity=ball")
    eye, cube = world.handle("eye"), world.handle("cube")
    assert world.call("simxGetObjectIntParameter", eye, ENTITY) == world.handle("ball")
    world.call("simxSetObjectIntParameter", eye, ENTITY, cube)
    assert seen(world) == {3}
    with pytest.raises(CommandError):
        world.call("simxSetObjectIntParameter", eye, ENTITY, 4711)
    world.call("simxRemoveObject", cube)
    assert world.call("simxGetObjectIntParameter", eye, ENTITY) == -1
    assert seen(world) is None


def test_script_checks_a_sensor_with_an_entity(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, ROOM.format(note="entity=ball", output=""), "head")
    render_with(world, painter := QuickPainter())
    world.lua("sim.checkVisionSensor(sim.getObjectHandle('eye'), sim.getObjectHandle('cube'))")
    assert painter.views[-1].only == {3}
    world.lua("sim.checkVisionSensorEx(sim.getObjectHandle('eye'), sim.handle_all, true)")
    assert painter.views[-1].only is None


def test_sensor_without_colours_is_black_and_one_without_depth_sees_nothing_near() -> None:
    world = room("rgb=no")
    eye = world.handle("eye")
    assert world.call("simxGetVisionSensorImage", eye, 0)[1] == bytes(24)
    assert world.painter.views == []  # nothing had to be rendered
    assert floats(world.call("simxGetVisionSensorDepthBuffer", eye)[1])[0] == 0.0
    world = room("depth=no")
    eye = world.handle("eye")
    assert world.call("simxGetVisionSensorImage", eye, 0)[1] == bytes(range(24))
    assert floats(world.call("simxGetVisionSensorDepthBuffer", eye)[1]) == [1.0] * 8
    packet = world.call("simxReadVisionSensor", eye)[1][0]
    assert packet[4::5] == [1.0, 1.0, 1.0]
    assert packet[6] > 0


def test_sensor_without_statistics_has_an_empty_first_packet_and_still_detects() -> None:
    world = room("statistics=no")
    assert world.call("simxReadVisionSensor", world.handle("eye")) == (False, [[]])
    world = room("statistics=no detect_above=0.01")
    assert world.call("simxReadVisionSensor", world.handle("eye")) == (True, [[]])


def test_own_background_of_a_sensor_replaces_the_scene_s() -> None:
    world = room("background=0.2,0.4,0.6")
    world.call("simxGetVisionSensorImage", world.handle("eye"), 0)
    assert world.painter.views[-1].background == (0.2, 0.4, 0.6)
    explicit = room("background=0.2,0.4,0.6 explicit=yes")
    assert explicit.call("simxGetVisionSensorImage", explicit.handle("eye"), 0)[1][:3] == bytes(
        (51, 102, 153)
    )
