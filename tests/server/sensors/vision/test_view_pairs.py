"""Images of colours and of codes of one place: the same as apart, from one drawing."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pytest
from both_renderers import make_renderer, opengl_name
from camera_world import FRONT, SCENE, load

from simx_server.scene.cameras.image import CameraView
from simx_server.sensors.opengl import renderer as opengl
from simx_server.sensors.opengl.renderer import OpenGLRenderer
from simx_server.sensors.rendering.shared_cameras import CameraPlaces, ViewPairs

__all__ = ["make_renderer", "opengl_name"]

WHITE = (1.0, 1.0, 1.0)
CODED = dataclasses.replace(FRONT, codes=tuple(range(1, 300)), background=WHITE)


def test_the_other_view_is_expected_after_both_were_requested_for_one_version() -> None:
    pairs = ViewPairs()
    assert [pairs.requested(view, 0, 1) for view in (FRONT, CODED)] == [None, None]
    other = pairs.requested(FRONT, 0, 2)
    assert other is not None
    assert other.view is CODED
    assert pairs.requested(CODED, 0, 2) is None
    assert getattr(pairs.requested(CODED, 0, 3), "view", None) is FRONT, "in the other order too"


def test_a_view_that_was_not_requested_is_not_expected_again() -> None:
    pairs = ViewPairs()
    for version, views in enumerate(((FRONT, CODED), (FRONT,))):
        for view in views:
            pairs.requested(view, 0, version)
    assert pairs.requested(FRONT, 0, 3) is None


def test_views_of_other_places_are_no_pair() -> None:
    pairs = ViewPairs()
    for other in (dataclasses.replace(CODED, far=5.0), dataclasses.replace(CODED, only=frozenset((1,)))):
        for version in range(3):
            assert pairs.requested(FRONT, 0, version) is None
            assert pairs.requested(other, 1, version) is None


@pytest.mark.parametrize(("distance", "camera"), [(1e-7, 0), (1e-5, 1)])
def test_cameras_that_differ_by_rounding_are_at_one_place(distance: float, camera: int) -> None:
    eyes = f'<camera name="one"/><camera name="other" pos="0 0 {distance}"/>'
    model, data = load(f"<mujoco><worldbody>{eyes}<geom size='1'/></worldbody></mujoco>")
    view = dataclasses.replace(FRONT, camera_id=1)
    assert CameraPlaces().by_first(model, data, view).camera_id == camera


def differing_pixels(renderer, data: mujoco.MjData, view: CameraView, coded: CameraView) -> list[int]:
    """Return how many pixels differ from images drawn apart: colours, depth, codes, depth of the codes."""
    found: list[int] = []
    for together, on_its_own in zip(renderer.render_both(data, view, coded), (view, coded), strict=True):
        apart = renderer.render(data, on_its_own, rgb=True, depth=True)
        assert np.unique(apart.rgb).size > 1
        found.append(int(np.any(together.rgb != apart.rgb, axis=2).sum()))
        found.append(int((together.depth != apart.depth).sum()))
    return found


GEOMS = {
    "opaque": "",
    "see-through": '<geom type="box" size="0.2 0.1 0.2" pos="0.1 -0.5 0" rgba="1 1 0 0.4"/>',
    "a plane from behind": '<geom type="plane" size="1 1 0.1" pos="0 1 -0.4" euler="180 0 0"/>',
    "a plane": '<geom type="plane" size="3 3 0.1" pos="0 0 -0.6"/>',
    "within each other": '<geom type="box" size="0.1 0.1 0.1" pos="0.4 0 -0.3" rgba="1 1 0 1"/>',
    "more than can be numbered": "".join(
        f'<geom size="0.02" pos="{column / 10 - 1} 0 {row / 10 - 0.8}"/>'
        for column in range(20)
        for row in range(14)
    ),
}


@pytest.mark.gl
@pytest.mark.parametrize("geoms", GEOMS.values(), ids=GEOMS.keys())
def test_images_drawn_together_are_those_drawn_apart(make_renderer, geoms: str) -> None:
    model, data = load(SCENE.replace("<camera", geoms + "<camera", 1))
    renderer = make_renderer(model)
    assert differing_pixels(renderer, data, FRONT, CODED) == [0, 0, 0, 0]
    # The wall lies on the far plane.
    near = dataclasses.replace(FRONT, far=4.0), dataclasses.replace(CODED, far=4.0)
    assert differing_pixels(renderer, data, *near) == [0, 0, 0, 0]
    few = (frozenset((0, 2)),) * 2
    chosen = (dataclasses.replace(view, only=only) for view, only in zip((FRONT, CODED), few, strict=True))
    assert differing_pixels(renderer, data, *chosen) == [0, 0, 0, 0]


@pytest.mark.gl
def test_large_images_in_parts_are_numbered_too(opengl_name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opengl, "PART", 160 * 33)
    model, data = load(SCENE)
    renderer = OpenGLRenderer(model, opengl_name)
    try:
        assert differing_pixels(renderer, data, FRONT, CODED) == [0, 0, 0, 0]
    finally:
        renderer.close()


@pytest.mark.gl
def test_opaque_geoms_are_drawn_once_for_both(opengl_name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model, data = load(SCENE)
    renderer = OpenGLRenderer(model, opengl_name)
    try:
        drawn: list[int] = []
        draw = mujoco.mjr_render
        monkeypatch.setattr(mujoco, "mjr_render", lambda *arguments: (drawn.append(1), draw(*arguments)))
        renderer.render_both(data, FRONT, CODED)
        assert len(drawn) == 1
    finally:
        renderer.close()
