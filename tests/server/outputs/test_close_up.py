"""The near overview of small images: what it shows, when it stays and when it moves."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from simx_server.outputs.filming.close_up import CloseUp, viewpoint_of
from simx_server.scene.cameras.image import Viewpoint

SCENE = """
<mujoco>
  <statistic center="0 0 0" extent="10"/>
  <worldbody>
    <geom type="plane" size="10 10 0.1"/>
    <geom name="wall" type="box" size="5 0.1 1" pos="0 5 1"/>
    {moving}
    <camera name="DefaultCamera" pos="3 -4 0" xyaxes="0.8 0.6 0 0 0 1"/>
  </worldbody>
</mujoco>
"""
BALL = '<body name="ball" pos="1 2 0.5"><freejoint/><geom size="0.2"/></body>'
FREE = Viewpoint((0.0, 0.0, 0.0), 15.0, 90.0, -45.0)


def scene(moving: str = BALL) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(SCENE.format(moving=moving))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def moved(model: mujoco.MjModel, data: mujoco.MjData, x: float) -> None:
    data.qpos[0] = x
    mujoco.mj_forward(model, data)


def test_camera_is_near_what_moves_and_looks_in_the_same_direction() -> None:
    model, data = scene()
    near = CloseUp(model).viewpoint(data, FREE)
    assert near.lookat == pytest.approx((1.0, 2.0, 0.5))
    assert 0.5 < near.distance < 3.0
    assert (near.azimuth_deg, near.elevation_deg) == (90.0, -45.0)


def test_camera_stays_for_small_movements_and_jumps_after_larger_ones() -> None:
    model, data = scene()
    camera = CloseUp(model)
    first = camera.viewpoint(data, FREE)
    moved(model, data, 1.1)
    assert camera.viewpoint(data, FREE) == first
    moved(model, data, 3.0)
    assert camera.viewpoint(data, FREE).lookat == pytest.approx((3.0, 2.0, 0.5))


def test_camera_comes_nearer_again_when_things_are_together() -> None:
    two = BALL + BALL.replace('"ball" pos="1 2', '"other" pos="4 2')
    model, data = scene(two)
    camera = CloseUp(model)
    wide = camera.viewpoint(data, FREE).distance
    moved(model, data, 3.9)
    assert camera.viewpoint(data, FREE).distance < wide / 2


def test_whole_scene_is_shown_when_something_is_far_away_or_nothing_moves() -> None:
    model, data = scene()
    moved(model, data, -4000.0)
    other, still = scene("")
    assert CloseUp(other).viewpoint(still, FREE) is FREE
    falling = scene(BALL + BALL.replace('"ball" pos="1 2', '"other" pos="4 -300'))
    assert CloseUp(falling[0]).viewpoint(falling[1], FREE) is FREE
    data.qpos[0] = np.nan
    mujoco.mj_kinematics(model, data)
    assert CloseUp(model).viewpoint(data, FREE) is FREE


def test_direction_of_the_users_camera_is_kept() -> None:
    _, data = scene()
    view = viewpoint_of(data, 0)
    position, matrix = view.pose()
    assert position == pytest.approx((3.0, -4.0, 0.0))
    assert view.distance == pytest.approx(5.0)
    assert matrix == pytest.approx(data.cam_xmat[0].reshape(3, 3))
