"""What users' views show and vision sensors do not: shapes that are not renderable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from handler_calls import World

from simx_client.protocol import constants as c
from simx_server.scene.cameras.image import CameraView, Renderer

__all__ = ["make_renderer", "opengl_name"]

SCENE = """
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <camera name="eye" pos="0 0 3" resolution="30 10"/>
    <body name="left" pos="-0.6 0 0"><geom type="box" size="0.2 0.2 0.2" rgba="1 0 0 1"/></body>
    <body name="middle"><geom type="box" size="0.2 0.2 0.2" rgba="0 1 0 1"/>
      <geom type="box" size="0.25 0.25 0.25" rgba="1 1 1 1" group="5"/></body>
    <body name="right" pos="0.6 0 0"><geom type="box" size="0.2 0.2 0.2" rgba="0 0 1 1"/></body>
  </worldbody>
  <custom>
    <text name="simx:shape:middle" data="renderable=no"/>
    <text name="simx:shape:right" data="renderable=no"/>
    <text name="simx:object:right" data="layers=0x0100"/>
  </custom>
</mujoco>
"""

VIEW = CameraView(camera_id=0, width=30, height=10, fovy_deg=30.0, near=0.1, far=10.0)


@pytest.fixture
def world() -> World:
    return World(SCENE)


def colours(renderer: Renderer, world: World, view: CameraView) -> list[list[int]]:
    """The colours of the three boxes."""
    data = mujoco.MjData(world.sim.model)
    mujoco.mj_forward(world.sim.model, data)
    image = renderer.render(data, view, rgb=True, depth=False).rgb
    assert image is not None
    return [np.asarray(image[5, column] > 128, int).tolist() for column in (11, 15, 19)]


@pytest.mark.gl
def test_users_see_what_is_not_renderable_unless_its_layers_hide_it(
    world: World, make_renderer: Callable[[mujoco.MjModel], Renderer]
) -> None:
    red, green, nothing = [1, 0, 0], [0, 1, 0], [0, 0, 0]
    renderer = make_renderer(world.sim.model)
    assert colours(renderer, world, VIEW) == [red, nothing, nothing]
    assert colours(renderer, world, replace(VIEW, is_users=True)) == [red, green, nothing]
    assert colours(renderer, world, VIEW) == [red, nothing, nothing]


@pytest.mark.gl
def test_users_do_not_see_what_is_on_a_hidden_layer_and_vision_sensors_do(
    world: World, make_renderer: Callable[[mujoco.MjModel], Renderer]
) -> None:
    red, green, nothing = [1, 0, 0], [0, 1, 0], [0, 0, 0]
    left, layers = world.handle("left"), c.sim_objintparam_visibility_layer
    world.call("simxSetObjectIntParameter", left, layers, 0x0100)
    renderer = make_renderer(world.sim.model)
    assert colours(renderer, world, VIEW) == [red, nothing, nothing]
    assert colours(renderer, world, replace(VIEW, is_users=True)) == [nothing, green, nothing]
    world.call("simxSetIntegerParameter", c.sim_intparam_visible_layers, 0x0100)
    assert colours(renderer, world, replace(VIEW, is_users=True)) == [red, nothing, [0, 0, 1]]
    assert colours(renderer, world, VIEW) == [red, nothing, nothing]


def test_layers_show_and_hide_what_is_not_renderable(world: World) -> None:
    layers = c.sim_objintparam_visibility_layer
    geom = world.sim.model.body("right").geomadr[0]
    groups = [int(world.sim.model.geom_group[geom])]
    for value in (0x0001, 0x0200):
        world.call("simxSetObjectIntParameter", world.handle("right"), layers, value)
        groups.append(int(world.sim.model.geom_group[geom]))
    assert groups == [5, 6, 5]


def test_a_model_that_is_not_visible_is_hidden_from_users_too(world: World) -> None:
    left = world.handle("left")
    geom = world.sim.model.body("left").geomadr[0]
    for bits, group in (
        (c.sim_modelproperty_not_renderable, 6),
        (c.sim_modelproperty_not_visible | c.sim_modelproperty_not_renderable, 5),
        (c.sim_modelproperty_not_visible, 5),
        (0, 0),
    ):
        world.call("simxSetModelProperty", left, bits)
        assert int(world.sim.model.geom_group[geom]) == group
