"""Light, colours, textures and normals of the 3-D view, against those that MuJoCo draws."""

from __future__ import annotations

from typing import Any, cast

import mujoco
import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

import viser
from browser_panels import browser

from simx_server.viewer.page.mirror import Copy
from simx_server.viewer.page.view.background import background
from simx_server.viewer.page.view.geoms import meshes_of
from simx_server.viewer.page.view.lights import Lights, lit
from simx_server.viewer.page.view.materials import look_of
from simx_server.viewer.page.view.tones import FULL, albedo, before_film, light, linear, screen

pytestmark = pytest.mark.slow

__all__ = ["browser"]


def copy_of(text: str) -> Copy:
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Copy(model, data)


def film(amounts: np.ndarray) -> np.ndarray:
    """three.js's ACESFilmicToneMapping, as its shader has it."""
    into = np.array([[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]])
    out = np.array(
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
    )
    x = amounts / 0.6 @ into.T
    y = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081)
    return np.clip(y @ out.T, 0.0, 1.0)


def test_a_lit_surface_has_the_colour_that_mujoco_draws() -> None:
    for rgb in ((0.5, 0.5, 0.5), (0.1, 0.32, 0.22), (0.6, 0.3, 0.2), (0.2, 0.25, 0.6), (0.8, 0.75, 0.7)):
        shown = screen(film(albedo(np.array(rgb)) * FULL))
        assert shown == pytest.approx(rgb, abs=0.05)
    grey = screen(film(albedo(np.full(3, 0.65)) * light(0.5)))
    assert grey == pytest.approx(np.full(3, 0.325), abs=0.03)
    white = screen(film(albedo(np.ones(3)) * FULL))
    assert 0.9 < white.min() <= white.max() < 1.0
    assert film(before_film(linear(np.full(3, 0.3)))) == pytest.approx(linear(np.full(3, 0.3)), abs=1e-6)


def test_light_grows_with_strength() -> None:
    strengths = [light(each / 10) for each in range(15)]
    assert strengths == sorted(strengths)
    assert light(1.0) == pytest.approx(FULL)


def test_the_light_is_that_of_the_cameras() -> None:
    found = lit(
        copy_of(
            """<visual><headlight ambient="0.4 0.4 0.4" diffuse="0 0 0"/></visual><worldbody>
            <light type="directional" dir="0 0 -2" diffuse="0.5 0.4 0.3"/><light active="false"/></worldbody>"""
        )
    )
    assert found.ambient == pytest.approx((0.4, 0.4, 0.4))
    (ray,) = found.rays
    assert ray.direction == (0.0, 0.0, -1.0)
    assert ray.color == pytest.approx((0.5, 0.4, 0.3))
    assert ray.casts_shadow


def test_the_strongest_light_that_casts_shadows_casts_them_or_else_the_steepest_which_is_tilted() -> None:
    lights = """<worldbody><light type="directional" dir="0 0 -1" diffuse="0.2 0.2 0.2" castshadow="false"/>
        <light type="directional" dir="0 1 -1" diffuse="0.3 0.3 0.3" castshadow="{0}"/>
        <light type="directional" dir="1 0 -1" diffuse="0.6 0.6 0.6" castshadow="{0}"/>
        <light type="directional" dir="1 0 -0.2" diffuse="0.9 0.9 0.9" castshadow="{0}"/></worldbody>"""
    casting = lit(copy_of(lights.format("true"))).rays
    assert [ray.casts_shadow for ray in casting] == [False, False, True, False, False]
    none = lit(copy_of(lights.format("false"))).rays
    assert [ray.casts_shadow for ray in none] == [True, False, False, False, False]
    assert casting[0].direction == (0.0, 0.0, -1.0)
    assert none[0].direction[2] < -0.8
    assert none[0].direction[0] > 0.3


def test_shadows_can_be_switched_off(browser: viser.ViserServer) -> None:
    lights = Lights(browser.scene, browser.gui)
    copy = copy_of("<worldbody><light type='directional' dir='0 0 -1'/></worldbody>")
    lights.update(copy)
    assert casters(browser) == ["/lights/0"]
    lights._shadows.value = False
    assert lights.is_stale
    lights.follow(copy)
    assert casters(browser) == []
    assert not lights.is_stale
    lights.toggle_shadows()
    lights.spare_shadows()
    lights.follow(copy)
    assert casters(browser) == ["/lights/0"], "chosen by a user"


def test_a_browser_that_draws_by_software_has_no_shadows_at_first(browser: viser.ViserServer) -> None:
    lights = Lights(browser.scene, browser.gui)
    lights.spare_shadows()
    lights.update(copy_of("<worldbody><light type='directional' dir='0 0 -1'/></worldbody>"))
    assert casters(browser) == []


def casters(browser: viser.ViserServer) -> list[str]:
    nodes = browser.scene._handle_from_node_name
    return [name for name, node in nodes.items() if getattr(node, "cast_shadow", False) is True]


def test_the_background_has_the_colours_of_the_skybox_above_the_horizon() -> None:
    sky = """<asset><texture type="skybox" builtin="gradient" rgb1="0 0 1" rgb2="1 0 0" width="32" height="192"/>
        </asset>"""
    image = background(copy_of(sky).model)
    assert image.shape[1:] == (2, 3)
    assert image[0, 0, 2] > image[-1, 0, 2] + 30, "more blue above"
    assert image[-1, 0, 2] == pytest.approx(128, abs=20), "the horizon is half way"
    assert background(copy_of("").model)[-1, 0].tolist() == [237, 242, 247]


def test_a_texture_of_a_cube_or_of_a_mesh_without_places_counts_with_its_mean_colour() -> None:
    model = copy_of(
        """<asset>
        <texture name="side" type="cube" builtin="flat" rgb1="0.8 0.4 0.2" rgb2="0.8 0.4 0.2" width="8" height="8"/>
        <material name="painted" texture="side"/></asset>
        <worldbody><geom type="sphere" size="1" material="painted"/></worldbody>"""
    ).model
    look = look_of(model, 0)
    assert look.texture is None
    assert look.rgba[:3] == pytest.approx((0.8, 0.4, 0.2), abs=0.01)


@pytest.mark.parametrize(("uniform", "size", "repeats"), [(0, 3, 2), (1, 3, 6), (0, 0, 40), (1, 0, 40)])
def test_textures_of_planes_repeat_as_in_mujoco(uniform: int, size: int, repeats: float) -> None:
    model = copy_of(
        f"""<asset><texture name="checks" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="8" height="8"/>
        <material name="paper" texture="checks" texrepeat="2 2" texuniform="{"true" if uniform else "false"}"/></asset>
        <worldbody><geom type="plane" size="{size} {size} 0.1" material="paper"/></worldbody>"""
    ).model
    (mesh,) = meshes_of(model, 0)
    uv = cast(Any, mesh.visual).uv
    assert (uv.max(axis=0) - uv.min(axis=0)).tolist() == [repeats, repeats]


def test_a_box_has_its_image_too() -> None:
    model = copy_of(
        """<asset><texture name="checks" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="8" height="8"/>
        <material name="paper" texture="checks" texrepeat="3 1"/></asset>
        <worldbody><geom type="box" size="1 2 0.1" material="paper"/></worldbody>"""
    ).model
    (mesh,) = meshes_of(model, 0)
    visual = cast(Any, mesh.visual)
    assert visual.uv.max(axis=0).tolist() == [3, 1]
    assert visual.material.baseColorTexture.size == (8, 8)


BENT = """<asset><mesh name="bent" inertia="shell" vertex="0 0 0  0 1 0  1 0 0  1 1 0  0 0 1  0 1 1"
    face="0 2 3  0 3 1  0 1 5  0 5 4" {normals}/></asset>
    <worldbody><geom type="mesh" mesh="bent"/></worldbody>"""


def test_a_mesh_keeps_the_normals_of_its_file_and_edges_that_a_file_without_normals_rounds() -> None:
    (sharp,) = meshes_of(copy_of(BENT.format(normals="")).model, 0)
    assert np.abs(sharp.vertex_normals).max(axis=1) == pytest.approx(1.0), "the edge of 90 degrees is sharp"
    grid = """<asset><mesh name="flat" inertia="shell" vertex="0 0 0  1 0 0  0 1 0  0 0 0.1  1 0 0.1  0 1 0.1"
        normal="0.3 0 1  0.3 0 1  0.3 0 1  0 0.3 -1  0 0.3 -1  0 0.3 -1" face="0 1 2  3 5 4"/></asset>
        <worldbody><geom type="mesh" mesh="flat"/></worldbody>"""
    copy = copy_of(grid)
    (own,) = meshes_of(copy.model, 0)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, copy.model.geom_quat[0])
    asked = np.array([[0.3, 0, 1], [0, 0.3, -1]]) / np.sqrt(1.09)
    given = {tuple(normal) for normal in np.round(own.vertex_normals, 3).tolist()}
    assert given == {tuple(normal) for normal in np.round(asked, 3).tolist()}
