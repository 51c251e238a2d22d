"""An edited model is drawn with the meshes and textures that OpenGL has already, if it has no others."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from both_renderers import opengl_name
from camera_world import FRONT

from simx_server.sensors.opengl import renderer as opengl
from simx_server.sensors.opengl.renderer import OpenGLRenderer

pytestmark = [pytest.mark.slow, pytest.mark.gl]

__all__ = ["opengl_name"]

SCENE = """
<mujoco>
  <asset>
    <texture name="red" type="2d" builtin="flat" rgb1="1 0 0" rgb2="1 0 0" width="4" height="4"/>
    <texture name="blue" type="2d" builtin="flat" rgb1="0 0 1" rgb2="0 0 1" width="4" height="4"/>
    <texture name="checks" type="2d" builtin="checker" rgb1="1 1 0" rgb2="0 1 1" width="8" height="8"/>
    <material name="shown" texture="red"/><material name="other" texture="blue"/>
    <mesh name="wedge" vertex="-1 -1 -1  1 -1 -1  -1 1 -1  0 0 2"/>
  </asset>
  <worldbody>
    <light pos="0 -3 3" dir="0 1 -1"/>
    <camera name="eye" pos="0 -4 1" xyaxes="1 0 0 0 0.2 1" resolution="64 48"/>
    <body name="wedge"><geom name="wedge" type="mesh" mesh="wedge" material="shown"/></body>
  </worldbody>
</mujoco>
"""


def edited(change: Any = None) -> mujoco.MjModel:
    spec: Any = mujoco.MjSpec.from_string(SCENE)
    if change is not None:
        change(spec)
    return spec.compile()


def add_box(spec: Any) -> None:
    spec.worldbody.add_body(pos=[1, 0, 0]).add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.3] * 3)


def remove_wedge(spec: Any) -> None:
    spec.delete(spec.body("wedge"))


def show_checks(spec: Any) -> None:
    spec.material("shown").textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "checks"


def stretch(spec: Any) -> None:
    spec.mesh("wedge").scale = [1, 1, 0.5]


def paint(spec: Any) -> None:
    spec.texture("red").rgb1 = [0, 1, 0]


def add_mesh(spec: Any) -> None:
    spec.add_mesh(name="more", uservert=[0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1])


def shown(renderer: OpenGLRenderer, model: mujoco.MjModel) -> bytes:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = renderer.render(data, FRONT, rgb=True, depth=True)
    assert found.rgb is not None
    assert found.depth is not None
    return found.rgb.tobytes() + found.depth.tobytes()


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[mujoco.MjModel]:
    """Models for which contexts were made."""
    models: list[mujoco.MjModel] = []
    real = opengl.drawing_of

    def counted(model: mujoco.MjModel, **options: Any) -> Any:
        models.append(model)
        return real(model, **options)

    monkeypatch.setattr(opengl, "drawing_of", counted)
    return models


@pytest.mark.parametrize("change", [add_box, remove_wedge, show_checks], ids=lambda each: each.__name__)
def test_an_edit_without_new_meshes_keeps_the_drawing(
    change: Any, made: list[mujoco.MjModel], opengl_name: str
) -> None:
    renderer, model = OpenGLRenderer(edited(), opengl_name), edited(change)
    renderer.turn_to(model)
    assert len(made) == 1
    kept = shown(renderer, model)
    renderer.close()
    fresh = OpenGLRenderer(model, opengl_name)
    assert kept == shown(fresh, model)
    fresh.close()


@pytest.mark.parametrize("change", [stretch, paint, add_mesh], ids=lambda each: each.__name__)
def test_other_meshes_and_images_are_another_drawing(
    change: Any, made: list[mujoco.MjModel], opengl_name: str
) -> None:
    renderer, model = OpenGLRenderer(edited(), opengl_name), edited(change)
    renderer.turn_to(model)
    assert len(made) == 2
    turned = shown(renderer, model)
    renderer.close()
    fresh = OpenGLRenderer(model, opengl_name)
    assert turned == shown(fresh, model)
    fresh.close()


def test_a_texture_that_a_material_gets_later_is_shown(opengl_name: str) -> None:
    model, wanted = edited(), edited(show_checks)
    renderer = OpenGLRenderer(model, opengl_name)
    before = shown(renderer, model)
    model.mat_texid[:] = wanted.mat_texid
    after = shown(renderer, model)
    renderer.close()
    fresh = OpenGLRenderer(wanted, opengl_name)
    assert after == shown(fresh, wanted) != before
    fresh.close()


def test_the_meshes_are_compared_not_only_counted() -> None:
    one, other = edited(), edited(stretch)
    assert len(one.mesh_vert) == len(other.mesh_vert)
    assert not np.array_equal(one.mesh_vert, other.mesh_vert)
    assert opengl.have_one_drawing(one, edited(add_box))
    assert not opengl.have_one_drawing(one, other)
