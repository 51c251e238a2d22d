"""Pictures: what is where and how far, the same in both renderers."""

import dataclasses
import gc
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from camera_world import FRONT, SCENE, load, pixel_of
from numpy.typing import NDArray

from simx_server.scene.cameras.image import (
    CameraImage,
    CameraView,
    RenderError,
    depth_as_grey,
    fovy_from_perspective_angle,
    grey,
    perspective_angle_from_fovy,
)
from simx_server.sensors.opengl import renderer as opengl
from simx_server.sensors.opengl.renderer import OpenGLRenderer
from simx_server.sensors.opengl.roundness import may_be_coarse, round_geoms
from simx_server.sensors.ray_casting.renderer import RaycastRenderer

pytestmark = pytest.mark.slow

__all__ = ["make_renderer", "opengl_name"]

ONE_GREY_LEVEL = 1 / 255


class Drawn(NamedTuple):
    """An image with both channels."""

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


def both(picture: CameraImage) -> Drawn:
    """Return both channels of an image."""
    assert picture.rgb is not None
    assert picture.depth is not None
    return Drawn(picture.rgb, picture.depth)


def image_of(make_renderer, xml: str = SCENE, view: CameraView = FRONT) -> Drawn:
    model, data = load(xml)
    return both(make_renderer(model).render(data, view, rgb=True, depth=True))


# What a picture shows


def test_rows_come_bottom_first_and_left_is_left(make_renderer) -> None:
    picture = image_of(make_renderer)
    assert picture.rgb.shape == (120, 160, 3)
    assert picture.rgb.dtype == np.uint8
    assert picture.rgb.flags.c_contiguous
    red = picture.rgb[pixel_of(FRONT, -0.4, 0.3, 2.0)]
    green = picture.rgb[pixel_of(FRONT, 0.4, -0.3, 1.9)]
    assert red[0] > 150 > 50 > red[1]
    assert green[1] > 150 > 50 > green[0]
    assert pixel_of(FRONT, -0.4, 0.3, 2.0)[0] > 60  # above the middle: a late row
    assert pixel_of(FRONT, -0.4, 0.3, 2.0)[1] < 80


@pytest.mark.parametrize("orthographic_size", [None, 3.0])
def test_an_image_of_several_parts_is_that_of_one(
    make_renderer, orthographic_size: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    view = dataclasses.replace(FRONT, orthographic_size=orthographic_size, background=(1.0, 0.0, 0.0))
    whole = image_of(make_renderer, view=view)
    monkeypatch.setattr(opengl, "PART", 160 * 33)
    model, data = load(SCENE)
    renderer = make_renderer(model)
    parts: list[CameraImage] = []
    cut = renderer.render(
        data, view, True, True, lambda: parts.append(renderer.render(data, FRONT, True, False))
    )
    if isinstance(renderer, OpenGLRenderer):
        assert len(parts) == 3
    different = (cut.rgb.astype(int) - whole.rgb).max(axis=2, initial=0) > 2
    assert different.mean() < 0.01  # pixels on edges
    assert np.median(np.abs(cut.depth - whole.depth)) < 1e-6
    assert (np.abs(cut.depth - whole.depth) > ONE_GREY_LEVEL).mean() < 0.01


def test_depth_is_linear_along_the_view_axis(make_renderer) -> None:
    picture = image_of(make_renderer)
    assert picture.depth.shape == (120, 160)
    assert picture.depth.dtype == np.float32
    metres = FRONT.near + picture.depth * (FRONT.far - FRONT.near)
    assert metres[pixel_of(FRONT, -0.4, 0.3, 1.9)] == pytest.approx(1.9, abs=0.01)  # the ball's nearest point
    assert metres[pixel_of(FRONT, 0.4, -0.3, 1.9)] == pytest.approx(1.9, abs=1e-3)
    # A wall square to the axis has one depth all over, however slanting the ray.
    for corner in ((0, 0), (0, 159), (119, 0), (119, 159)):
        assert metres[corner] == pytest.approx(4.0, abs=1e-3)


@pytest.mark.parametrize("orthographic_size", [None, 3.0])
@pytest.mark.parametrize("euler", ["0 0 0", "20 5 0", "-10 62 0"])
def test_depth_of_a_plane_is_as_much_farther_as_half_its_slope(
    make_renderer, euler: str, orthographic_size: float | None
) -> None:
    xml = f"""
    <mujoco><worldbody>
      <geom type="plane" size="0 0 0.1" pos="0 0 -1" euler="{euler}"/>
      <camera name="eye" pos="0 0 1"/>
    </worldbody></mujoco>
    """
    model, data = load(xml)
    view = dataclasses.replace(FRONT, near=0.01, far=6.0, orthographic_size=orthographic_size)
    renderer = make_renderer(model)
    renderer.turn_to(model)
    depth = renderer.render(data, view, rgb=False, depth=True).depth
    half_width, half_height = view.half_extent()
    x = half_width * ((np.arange(view.width) + 0.5) * 2 / view.width - 1)[np.newaxis, :]
    y = half_height * ((np.arange(view.height) + 0.5) * 2 / view.height - 1)[:, np.newaxis]
    normal = data.geom_xmat[0].reshape(3, 3)[:, 2]
    if orthographic_size is None:
        exact = 2.0 * normal[2] / (normal[2] - x * normal[0] - y * normal[1])
        window = view.far / (view.far - view.near) * (1.0 - view.near / exact)
    else:
        exact = 2.0 + (x * normal[0] + y * normal[1]) / normal[2]
        window = (exact - view.near) / (view.far - view.near)
    slopes = [np.abs(np.diff(window, axis=axis)).max() for axis in (0, 1)]  # the same everywhere on a plane
    window = np.minimum(window + 0.5 * max(slopes), 1.0)
    if orthographic_size is None:
        expected = view.far * view.near / (view.far - window * (view.far - view.near))
    else:
        expected = view.near + window * (view.far - view.near)
    expected[(exact < view.near) | (exact > view.far)] = view.far
    metres = view.near + depth * (view.far - view.near)
    assert np.abs(metres - expected).max() < 1e-4


@pytest.mark.gl
@pytest.mark.parametrize(("below", "colour"), [(0.25, "wall"), (0.75, "floor")])
def test_the_polygon_offset_moves_the_line_where_a_floor_meets_a_wall_by_half_a_pixel(
    opengl_name: str, below: float, colour: str
) -> None:
    pixel = 2 * FRONT.half_extent()[1] / FRONT.height
    # The line is `below` pixels above the middle of the pixels of row 39.
    distance = 1.0 / ((60 - 39.5 - below) * pixel)
    xml = f"""
    <mujoco><worldbody>
      <geom type="box" size="9 9 0.1" pos="0 0 -1.1" rgba="0 1 0 1"/>
      <geom type="box" size="9 0.1 9" pos="0 {distance + 0.1} 0" rgba="1 0 0 1"/>
      <camera name="eye" xyaxes="1 0 0 0 0 1"/>
    </worldbody></mujoco>
    """
    model, data = load(xml)
    renderer = OpenGLRenderer(model, opengl_name)
    try:
        rgb = both(renderer.render(data, FRONT, rgb=True, depth=True)).rgb
    finally:
        renderer.close()
    red, green, _ = rgb[39, 80].astype(int)
    assert (red > green) == (colour == "wall")
    assert rgb[40, 80, 0] > rgb[40, 80, 1]
    assert rgb[38, 80, 1] > rgb[38, 80, 0]


def test_beyond_the_far_plane_there_is_background_and_depth_one(make_renderer) -> None:
    near_only = dataclasses.replace(FRONT, far=3.0)
    picture = image_of(make_renderer, view=near_only)
    assert picture.depth[0, 0] == 1.0
    assert not picture.rgb[0, 0].any()
    assert picture.rgb[pixel_of(near_only, -0.4, 0.3, 2.0)].any()


def test_the_far_plane_cuts_a_surface_where_it_is(make_renderer) -> None:
    xml = """
    <mujoco><worldbody>
      <geom type="plane" size="5 5 0.1" pos="0 0 -0.2"/>
      <camera name="eye" xyaxes="1 0 0 0 0 1"/>
    </worldbody></mujoco>
    """
    view = dataclasses.replace(FRONT, height=240, far=1.0)
    picture = image_of(make_renderer, xml, view)
    row, column = pixel_of(view, 0.0, -0.2, 1.0)
    assert picture.depth[row - 2, column] < 1.0
    assert picture.rgb[row - 2, column].any()
    assert picture.depth[row + 2, column] == 1.0
    assert not picture.rgb[row + 2, column].any()


def test_a_background_colour_fills_what_nothing_is_seen_in(make_renderer) -> None:
    coloured = dataclasses.replace(FRONT, far=3.0, background=(0.2, 0.4, 1.0))
    picture = image_of(make_renderer, view=coloured)
    assert np.abs(picture.rgb[0, 0].astype(int) - (51, 102, 255)).max() <= 1
    model, data = load(SCENE)
    alone = make_renderer(model).render(data, coloured, rgb=True, depth=False)
    assert alone.depth is None
    assert alone.rgb is not None
    assert np.array_equal(alone.rgb, picture.rgb)


def test_what_is_nearer_than_the_near_plane_is_looked_through(make_renderer) -> None:
    beyond_the_balls = dataclasses.replace(FRONT, near=2.5)
    picture = image_of(make_renderer, view=beyond_the_balls)
    wall = (4.0 - 2.5) / (10.0 - 2.5)
    assert picture.depth[pixel_of(FRONT, -0.4, 0.3, 2.0)] == pytest.approx(wall, abs=1e-3)
    assert picture.depth[pixel_of(FRONT, 0.4, -0.3, 1.9)] == pytest.approx(wall, abs=1e-3)


def test_a_camera_inside_its_housing_sees_out(make_renderer) -> None:
    xml = SCENE.replace(
        '<site name="dummy"', '<geom type="sphere" size="0.3" pos="0 -2 0"/><site name="dummy"'
    )
    picture = image_of(make_renderer, xml)
    assert picture.depth[0, 0] == pytest.approx((4.0 - 0.1) / 9.9, abs=1e-3)


def test_collision_shapes_sites_and_invisible_geoms_are_not_seen(make_renderer) -> None:
    picture = image_of(make_renderer)
    assert picture.depth[60, 80] == pytest.approx((4.0 - 0.1) / 9.9, abs=1e-3)
    alone = make_renderer(load(SCENE)[0]).render(load(SCENE)[1], FRONT, rgb=False, depth=True)
    assert alone.rgb is None
    assert np.abs(alone.depth - picture.depth).max() < 1e-5


def test_a_see_through_geom_tints_by_its_opacity_and_has_depth(make_renderer) -> None:
    pane = '<geom type="box" size="0.2 0.01 0.2" rgba="1 0 0 0.5"/><site name="dummy"'
    solid, xml = (SCENE.replace('<site name="dummy"', text) for text in (pane.replace("0.5", "1"), pane))
    clear, tinted, opaque = (image_of(make_renderer, each) for each in (SCENE, xml, solid))
    assert np.array_equal(tinted.depth, opaque.depth)
    assert tinted.depth[60, 80] < clear.depth[60, 80]
    middle = (clear.rgb[60, 80].astype(float) + opaque.rgb[60, 80]) / 2
    assert tinted.rgb[60, 80] == pytest.approx(middle, abs=1)
    model, data = load(xml)
    alone = make_renderer(model).render(data, FRONT, rgb=False, depth=True)
    assert np.abs(alone.depth - opaque.depth).max() < 1e-5


PANES = """
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <geom type="box" size="9 0.01 9" pos="0 2 0" rgba="0 1 0 0.5"/>
    <geom type="box" size="9 0.01 9" pos="0 4 0" rgba="0 0 1 0.2"/>
    <camera name="eye" xyaxes="1 0 0 0 0 1"/>
  </worldbody>
</mujoco>
"""
THROUGH_PANES = [0.4 * 255, 0.5 * 255, 0.1 * 255]
"""Their colours over red."""


def test_what_is_see_through_lies_over_the_background_and_over_what_is_farther(make_renderer) -> None:
    view = dataclasses.replace(FRONT, background=(1.0, 0.0, 0.0))
    picture = image_of(make_renderer, PANES, view)
    assert picture.rgb[60, 80] == pytest.approx(THROUGH_PANES, abs=1)


@pytest.mark.gl
def test_what_memory_held_before_a_scene_changes_no_image(opengl_name: str) -> None:
    model, data = load(PANES)
    renderer = OpenGLRenderer(model, opengl_name)
    for geom in renderer._scene.geoms:
        geom.objtype, geom.objid, geom.segid, geom.category = mujoco.mjtObj.mjOBJ_GEOM, 0, 9, 9
    image = renderer.render(
        data, dataclasses.replace(FRONT, background=(1.0, 0.0, 0.0)), rgb=True, depth=False
    )
    renderer.close()
    assert image.rgb is not None
    assert image.rgb[60, 80] == pytest.approx(THROUGH_PANES, abs=1)


@pytest.mark.parametrize("size", [None, 2.0], ids=["perspective", "orthographic"])
def test_what_reaches_into_the_view_from_beside_is_seen(make_renderer, size: float | None) -> None:
    view = dataclasses.replace(FRONT, orthographic_size=size)
    half_width, half_height = (half * (1.0 if size else 2.0) for half in view.half_extent())
    for x, y in ((half_width, 0.0), (-half_width, 0.0), (0.0, half_height), (0.0, -half_height)):
        # The ball's centre lies outside by nearly its radius.
        x, y = x + math.copysign(0.3, x) * (x != 0), y + math.copysign(0.3, y) * (y != 0)
        xml = f"""
        <mujoco><worldbody>
          <geom type="sphere" size="0.4" pos="{x} 0 {y}"/>
          <camera name="front" pos="0 -2 0" xyaxes="1 0 0 0 0 1"/>
        </worldbody></mujoco>
        """
        seen = np.argwhere(image_of(make_renderer, xml, view).depth < 1.0)
        assert len(seen) > 20


def test_an_empty_world_is_background(make_renderer) -> None:
    picture = image_of(make_renderer, "<mujoco><worldbody><camera/></worldbody></mujoco>")
    assert not picture.rgb.any()
    assert np.all(picture.depth == 1.0)


def test_an_orthographic_view_measures_its_larger_side(make_renderer) -> None:
    view = dataclasses.replace(FRONT, orthographic_size=1.6, width=80, height=60)
    picture = image_of(make_renderer, view=view)
    metres = view.near + picture.depth * (view.far - view.near)
    assert metres[0, 0] == pytest.approx(4.0, abs=1e-3)
    # The box spans x 0.3 .. 0.5 of a picture 1.6 m wide: ten of 80 columns.
    row, _ = pixel_of(view, 0.4, -0.3, 1.9)
    assert np.flatnonzero(metres[row] < 3.0).tolist() == list(range(55, 65))
    assert metres[row, 60] == pytest.approx(1.9, abs=1e-3)


def test_a_colour_changed_in_the_model_shows(make_renderer) -> None:
    model, data = load(SCENE)
    renderer = make_renderer(model)
    where = pixel_of(FRONT, 0.4, -0.3, 1.9)
    assert renderer.render(data, FRONT, rgb=True, depth=False).rgb[where][2] < 50
    model.geom("green").rgba = (0, 0, 1, 1)
    assert renderer.render(data, FRONT, rgb=True, depth=False).rgb[where][2] > 150


LAMPS = """
<mujoco>
  <visual><headlight ambient="0 0 0" diffuse="0 0 0" specular="0 0 0"/></visual>
  <asset><material name="matt" specular="0" shininess="0"/></asset>
  <worldbody><geom type="box" size="2 2 0.1" material="matt"/><camera pos="0 0 3"/>{}</worldbody>
</mujoco>
"""


def brightness(make_renderer, lamp: str, count: int = 1) -> int:
    """The brightness of a white floor straight below."""
    model, data = load(LAMPS.format(f'<light {lamp} specular="0 0 0" castshadow="false"/>' * count))
    view = dataclasses.replace(FRONT, width=9, height=9)
    picture = make_renderer(model).render(data, view, rgb=True, depth=False)
    return int(picture.rgb[4, 4, 0])


def test_seven_lights_shine_beside_the_headlight(make_renderer) -> None:
    lamp = 'type="directional" dir="0 0 -1" diffuse="0.1 0.1 0.1"'
    assert brightness(make_renderer, lamp, 3) == pytest.approx(0.3 * 255, abs=2)
    assert brightness(make_renderer, lamp, 20) == pytest.approx(0.7 * 255, abs=2)


def test_a_spot_of_half_a_turn_shines_everywhere_and_weaker_with_distance(make_renderer) -> None:
    lamp = 'type="spot" cutoff="180" dir="0 0 1" pos="0 0 2.1" diffuse="1 1 1" attenuation="{}"'
    assert brightness(make_renderer, lamp.format("1 0 0")) == pytest.approx(255, abs=2)
    assert brightness(make_renderer, lamp.format("0.5 0 0.25")) == pytest.approx(255 / 1.5, abs=2)
    assert brightness(make_renderer, lamp.format("0 1 0")) == pytest.approx(255 / 2, abs=2)


def test_a_camera_that_is_not_in_the_model_is_an_error(make_renderer) -> None:
    with pytest.raises(RenderError, match=r"camera id 7 .* has 2"):
        image_of(make_renderer, view=dataclasses.replace(FRONT, camera_id=7))


@pytest.mark.gl
def test_both_renderers_see_the_same(opengl_name: str) -> None:
    xml = """
    <mujoco>
      <asset>
        <texture name="tiles" type="2d" builtin="checker" rgb1="0.9 0.8 0.7" rgb2="0.2 0.3 0.4" width="64" height="64"/>
        <material name="floor" texture="tiles" texrepeat="5 3" specular="0"/>
        <material name="paint" rgba="0.1 0.7 0.3 1" emission="0.2" specular="0"/>
        <mesh name="wedge" vertex="0 0 0  0.4 0 0  0 0.4 0  0 0 0.4"/>
      </asset>
      <worldbody>
        <light pos="0.5 0 3" dir="0 0 -1" specular="0 0 0"/>
        <light type="directional" dir="1 1 -1" diffuse="0.4 0.3 0.2" specular="0 0 0"/>
        <geom type="plane" size="2 2 0.1" material="floor"/>
        <geom type="sphere" size="0.2" pos="-0.6 0.3 0.2" material="paint"/>
        <geom type="capsule" size="0.1 0.2" pos="0.6 0.3 0.4" euler="40 30 0" rgba="0.2 0.2 0.9 1"/>
        <geom type="cylinder" size="0.15 0.2" pos="0 0.8 0.2" rgba="0.9 0.9 0.1 1"/>
        <geom type="ellipsoid" size="0.1 0.2 0.1" pos="0 -0.2 0.1" rgba="0.9 0.2 0.1 1"/>
        <geom type="mesh" mesh="wedge" pos="0.3 0 0.2" rgba="0.6 0.2 0.9 1"/>
        <camera name="eye" pos="0 -1.6 1.2" xyaxes="1 0 0 0 0.6 0.8"/>
      </worldbody>
      <visual><quality numslices="64" numstacks="48"/></visual>
    </mujoco>
    """
    model, data = load(xml)
    view = dataclasses.replace(FRONT, far=3.0)
    drawn = OpenGLRenderer(model, opengl_name)
    try:
        one = both(drawn.render(data, view, rgb=True, depth=True))
    finally:
        drawn.close()
    other = both(RaycastRenderer(model).render(data, view, rgb=True, depth=True))
    # Tessellated outlines differ from true ones by part of a pixel, so a few edge pixels may disagree.
    assert np.mean((one.depth < 1.0) != (other.depth < 1.0)) < 0.003
    apart = np.abs(one.depth - other.depth)
    assert np.median(apart) < 1e-4
    assert np.mean(apart > ONE_GREY_LEVEL) < 0.005
    colours_apart = np.abs(one.rgb.astype(int) - other.rgb).max(axis=2)
    assert np.median(colours_apart) <= 2
    assert np.mean(colours_apart > 12) < 0.08


TEXTURED = """
<mujoco>
  <asset>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="1 0 0" rgb2="0 1 0" width="64" height="384"/>
    <texture name="squares" type="2d" builtin="checker" rgb1="{0}" rgb2="0 0 0" width="64" height="64"/>
    <texture name="sides" type="cube" builtin="flat" mark="cross" rgb1="{0}" markrgb="1 1 1" width="64" height="384"/>
    <material name="floor" texture="squares" texrepeat="4 4"/>
    <material name="crate" texture="sides"/>
    <material name="dome" texture="sky"/>
  </asset>
  <worldbody>
    <light type="directional" dir="1 1 -1"/>
    <geom type="plane" size="2 2 0.1" material="floor"/>
    <geom type="box" size="0.2 0.2 0.2" pos="-0.4 0.3 0.2" material="crate"/>
    <geom type="box" size="0.2 0.2 0.2" pos="0.4 0.3 0.2" material="dome"/>
    <camera name="eye" pos="0 -1.6 1.2" xyaxes="1 0 0 0 0.6 0.8"/>
  </worldbody>
</mujoco>
"""


@pytest.mark.gl
def test_a_renderer_that_turns_to_another_model_draws_it_with_its_own_textures(opengl_name: str) -> None:
    blue, red = load(TEXTURED.format("0 0 1")), load(TEXTURED.format("1 0 0"))
    renderers = [OpenGLRenderer(red[0], opengl_name), OpenGLRenderer(blue[0], opengl_name)]
    try:
        fresh = both(renderers[0].render(red[1], FRONT, rgb=True, depth=True))
        before = both(renderers[1].render(blue[1], FRONT, rgb=True, depth=True))
        renderers[1].turn_to(red[0])
        turned = both(renderers[1].render(red[1], FRONT, rgb=True, depth=True))
    finally:
        for renderer in renderers:
            renderer.close()
    assert np.array_equal(turned.rgb, fresh.rgb)
    assert np.array_equal(turned.depth, fresh.depth)
    assert not np.array_equal(before.rgb, fresh.rgb)
    # Squares, a cross on a crate, and a sky's gradient used as a crate's: not one pixel's colour each.
    assert len(np.unique(fresh.rgb.reshape(-1, 3), axis=0)) > 100


@pytest.mark.gl
def test_a_driver_that_gives_no_display_lists_is_an_error(
    opengl_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, _ = load(SCENE)
    mesh = '<asset><mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset>'
    other, _ = load(SCENE.replace("</mujoco>", f"{mesh}</mujoco>"))
    renderer = OpenGLRenderer(model, opengl_name)
    monkeypatch.setattr("OpenGL.raw.GL.VERSION.GL_1_1.glGenLists", lambda _: 0)
    try:
        with pytest.raises(mujoco.FatalError, match="context is lost"):
            renderer.turn_to(other)
    finally:
        renderer.close()


@pytest.mark.gl
def test_what_is_left_of_a_failed_renderer_changes_no_image_of_another(
    opengl_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo's context deletes by numbers, in the OpenGL context that is current when Python frees it."""
    model, data = load(SCENE)
    with monkeypatch.context() as lost:
        lost.setattr("OpenGL.raw.GL.VERSION.GL_1_1.glGenLists", lambda _: 0)
        left: list[BaseException] = []
        try:
            OpenGLRenderer(model, opengl_name)
        except mujoco.FatalError as problem:
            left.append(problem)  # with the frames in which it was raised
    renderer = OpenGLRenderer(model, opengl_name)
    try:
        before = both(renderer.render(data, FRONT, rgb=True, depth=True))
        assert left.pop()
        gc.collect()
        after = both(renderer.render(data, FRONT, rgb=True, depth=True))
    finally:
        renderer.close()
    assert np.array_equal(before.rgb, after.rgb)


def row_of_cylinders(distance: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    stands = "".join(
        f'<geom type="cylinder" size="0.05 0.3" pos="{x / 5} {distance} 0" euler="20 {30 * x} 0"/>'
        for x in range(-6, 7)
    )
    return load(
        '<mujoco><visual><quality numslices="32" numstacks="16"/></visual><worldbody>'
        f'<light type="directional" dir="1 1 -1"/>{stands}<camera xyaxes="1 0 0 0 0 1"/></worldbody></mujoco>'
    )


@pytest.mark.gl
def test_round_things_far_away_look_the_same_with_fewer_corners(
    opengl_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, data = row_of_cylinders(distance=3.0)
    asked: list[bool] = []

    def render(may_be_coarse: Callable[..., bool]) -> Drawn:
        monkeypatch.setattr(opengl, "may_be_coarse", may_be_coarse)
        renderer = OpenGLRenderer(model, opengl_name)
        try:
            return both(renderer.render(data, FRONT, rgb=True, depth=True))
        finally:
            renderer.close()

    def asking(*arguments: Any) -> bool:
        asked.append(may_be_coarse(*arguments))
        return asked[-1]

    coarse, fine = render(asking), render(lambda *_: False)
    assert asked == [True]
    assert np.mean(coarse.depth < 1.0) > 0.02
    assert np.mean(np.abs(coarse.rgb.astype(int) - fine.rgb).max(axis=2) > 16) < 0.002
    assert np.mean(np.abs(coarse.depth - fine.depth) > 1e-3) < 0.002


@pytest.mark.gl
def test_round_things_are_drawn_coarsely_only_if_many_and_small_in_the_image() -> None:
    def is_coarse(distance: float, **view: float) -> bool:
        model, data = row_of_cylinders(distance)
        chosen = np.flatnonzero(round_geoms(model))
        return may_be_coarse(model, data, dataclasses.replace(FRONT, **view), chosen, 16)

    assert is_coarse(3.0)
    assert not is_coarse(3.0, width=640, height=480)
    assert not is_coarse(1.0)
    assert is_coarse(1.0, orthographic_size=2.0)
    assert not is_coarse(1.0, orthographic_size=0.5)
    model, data = row_of_cylinders(3.0)
    assert not may_be_coarse(model, data, FRONT, np.arange(3), 16)


def test_images_are_shared_so_they_cannot_be_written(make_renderer) -> None:
    picture = image_of(make_renderer)
    with pytest.raises(ValueError, match="read-only"):
        picture.rgb[0, 0] = 1
    with pytest.raises(ValueError, match="read-only"):
        picture.depth[0, 0] = 1


# Conversions


def test_a_perspective_angle_belongs_to_the_larger_side() -> None:
    # The tutorial's camera: 57 degrees at 640 x 480.
    assert fovy_from_perspective_angle(math.radians(57), 640, 480) == pytest.approx(44.31, abs=0.01)
    assert fovy_from_perspective_angle(math.radians(57), 480, 640) == pytest.approx(57)
    for size in ((640, 480), (480, 640), (64, 64)):
        there = fovy_from_perspective_angle(1.1, *size)
        assert perspective_angle_from_fovy(there, *size) == pytest.approx(1.1)


def test_grey_is_the_integer_mean() -> None:
    rgb = np.array([[[255, 255, 255], [0, 1, 1], [10, 20, 33]]], np.uint8)
    assert grey(rgb).tolist() == [[255, 0, 21]]


def test_depth_as_grey_is_dark_near_and_bright_far() -> None:
    shown = depth_as_grey(np.array([[0.0, 0.2, 1.0]], np.float32))
    assert shown.tolist() == [[[0, 0, 0], [51, 51, 51], [255, 255, 255]]]


@pytest.mark.parametrize(
    "wrong",
    [
        {"width": 0},
        {"height": 100_000},
        {"near": 0.0},
        {"far": 0.1},
        {"fovy_deg": 180.0},
        {"orthographic_size": 0.0},
        {"far": math.inf},
    ],
)
def test_a_view_no_camera_can_have_is_refused(wrong: dict) -> None:
    with pytest.raises(ValueError, match=r"give|between"):
        dataclasses.replace(FRONT, **wrong)
