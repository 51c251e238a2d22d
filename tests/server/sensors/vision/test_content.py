"""Views that frame the content of a scene: everything but its ground."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from simx_server.scene.cameras.image import CameraView, Viewpoint
from simx_server.sensors.vision.content import content_of, framed

SCENE = """
<mujoco>
  <worldbody>
    <geom name="floor" type="box" size="2.5 2.5 0.02" pos="0 0 -0.02"/>
    <geom type="sphere" size="9" group="3"/>
    <geom type="sphere" size="9" rgba="1 1 1 0"/>
    {things}
    <camera name="far" pos="0 -4 0.1" xyaxes="1 0 0 0 0 1"/>
    <camera name="near" pos="1 -0.3 0.1" xyaxes="1 0 0 0 0 1"/>
    <camera name="away" pos="0 -4 0.1" xyaxes="-1 0 0 0 0 1"/>
  </worldbody>
</mujoco>
"""
ROBOT = '<geom type="box" size="0.1 0.1 0.1" pos="1 0 0.1"/>'
FREE = CameraView(
    camera_id=-1,
    width=160,
    height=90,
    fovy_deg=30.0,
    near=0.01,
    far=100.0,
    viewpoint=Viewpoint((0.0, 0.0, 0.0), 15.0, 90.0, -45.0),
)


def scene(things: str = ROBOT) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(SCENE.format(things=things))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def seen_from(model: mujoco.MjModel, name: str) -> CameraView:
    number = model.camera(name).id
    return CameraView(camera_id=number, width=160, height=90, fovy_deg=45.0, near=0.01, far=100.0)


def test_the_content_is_what_is_seen_beside_the_ground() -> None:
    content = content_of(*scene())
    assert content is not None
    assert (content.low.tolist(), content.high.tolist()) == (
        pytest.approx([0.9, -0.1, 0]),
        pytest.approx([1.1, 0.1, 0.2]),
    )
    ground = content_of(*scene(""))
    assert ground is not None
    assert ground.high[0] == pytest.approx(2.5)


def test_a_view_in_which_the_content_is_small_comes_nearer_in_its_direction() -> None:
    model, data = scene()
    found = framed(model, data, seen_from(model, "far"), FREE)
    assert found is not None
    assert found.lookat == pytest.approx((1.0, 0.0, 0.1))
    assert (found.azimuth_deg, found.elevation_deg) == (pytest.approx(90.0), pytest.approx(0.0))
    eye, turn = found.pose()
    corner = (np.array((1.1, -0.1, 0.2)) - eye) @ turn
    assert 0.7 < -corner[1] / corner[2] / np.tan(np.radians(15.0)) < 1.0  # inside, near the upper border


def test_a_view_that_shows_the_content_is_kept() -> None:
    model, data = scene()
    assert framed(model, data, seen_from(model, "near"), FREE) is None


def test_a_view_that_sees_nothing_gives_way_to_the_free_camera() -> None:
    model, data = scene()
    found = framed(model, data, seen_from(model, "away"), FREE)
    assert found is not None
    assert (found.azimuth_deg, found.elevation_deg) == (pytest.approx(90.0), pytest.approx(-45.0))
    assert found.lookat == pytest.approx((1.0, 0.0, 0.1))


def test_a_view_that_shall_show_everything_does_so_from_as_near_as_possible() -> None:
    model, data = scene()
    found = framed(model, data, seen_from(model, "near"), FREE, whole=True)
    assert found is not None
    assert found.lookat == pytest.approx((1.0, 0.0, 0.1))
