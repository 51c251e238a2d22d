"""Point clouds of depth images, and scans of vision sensors with one row, by the geometry of a wall."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from ros2_contents import Contents, in_frame

pytestmark = pytest.mark.gl

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="wall" type="box" pos="3.1 0.4 1" size="0.1 0.4 5"/>
    <body name="post" pos="0 0 1">
      <geom type="sphere" size="0.01" pos="-1 0 0"/>
      <camera name="eye" pos="0 0 0" xyaxes="0 -1 0 0 0 1" resolution="64 48" fovy="60" output="depth"/>
      <camera name="row" pos="0 0 0" xyaxes="0 -1 0 0 0 1" resolution="81 1" fovy="1" output="depth"/>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def contents(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Contents]:
    path = tmp_path_factory.mktemp("clouds") / "scene.xml"
    path.write_text(SCENE, encoding="utf-8")
    opened = Contents(path)
    yield opened
    opened.close()


def test_points_lie_on_the_wall_in_the_optical_frame(contents: Contents) -> None:
    message = contents.message("/eye/points")
    assert (message["width"], message["height"]) == (64, 48)
    assert [(field["name"], field["offset"]) for field in message["fields"]] == [("x", 0), ("y", 4), ("z", 8)]
    assert message["point_step"] * message["width"] == message["row_step"]
    points = message["data"].view("<f4").reshape(48, 64, 3)
    pose = in_frame(contents.transforms(), message["header"]["frame_id"], "world")
    found = ~np.isnan(points[..., 0])
    assert not message["is_dense"]
    assert found[:, 22:31].all()  # the wall is on the left
    assert not found[:, 34:].any()
    world = points[found] @ pose[:3, :3].T + pose[:3, 3]
    assert world[:, 0] == pytest.approx(3, abs=0.02)
    assert -0.1 < world[:, 1].min() < 0.1
    assert world[:, 1].max() < 0.85 + 0.05
    assert points[0, 25, 1] < 0 < points[-1, 25, 1]  # y points down
    assert points[0, 25, 0] < 0


def test_a_sensor_of_one_row_is_a_laser_scanner(contents: Contents) -> None:
    scan = contents.message("/row/scan")
    assert len(scan["ranges"]) == 81
    assert scan["angle_min"] == -scan["angle_max"]
    angles = scan["angle_min"] + scan["angle_increment"] * np.arange(81)
    hits = np.isfinite(scan["ranges"])
    assert not hits[angles < -0.01].any()  # the wall is on the left, at positive angles
    inside = (angles > 0.01) & (angles < 0.25)
    if inside.any():
        assert scan["ranges"][inside] == pytest.approx(3 / np.cos(angles[inside]), rel=0.01)
    pose = in_frame(contents.transforms(), scan["header"]["frame_id"], "world")
    assert pose[:3, :3] == pytest.approx(np.eye(3), abs=1e-6)
    assert scan["range_max"] >= scan["range_min"]
    assert math.isfinite(scan["range_max"])
    assert "/eye/scan" not in contents.topics()
