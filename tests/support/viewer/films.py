"""A small scene that is filmed, and films read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

av = pytest.importorskip("av", reason="needs the extra video")

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <statistic center="0 0 0.5" extent="1"/>
  <visual>
    <headlight ambient="0.6 0.6 0.6" diffuse="0.4 0.4 0.4" specular="0 0 0"/>
    <global azimuth="90" elevation="0"/>
  </visual>
  <worldbody>
    <geom name="red" type="sphere" size="0.2" pos="0 0 0.8" rgba="1 0 0 1"/>
    <geom name="green" type="sphere" size="0.2" pos="0 0 0.2" rgba="0 1 0 1"/>
    <body name="arm" pos="0 -0.5 0.5">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="0 0 1 1"/>
    </body>
    <camera name="eye" pos="0 -2 0.5" xyaxes="1 0 0 0 0 1" fovy="50" resolution="64 48"/>
    <camera name="deep" pos="0 -2 0.5" xyaxes="1 0 0 0 0 1" fovy="50" resolution="33 25" output="depth"/>
  </worldbody>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
</mujoco>
"""


RED, GREEN, BLUE = range(3)


def middle(pixels: np.ndarray, colour: int) -> tuple[float, float]:
    """Mean row and column of what has mostly this colour, each 0..1 from the top left."""
    others = np.delete(pixels.astype(int), colour, axis=2).max(axis=2)
    rows, columns = np.nonzero(pixels[..., colour] > others + 80)
    assert len(rows), "nothing has this colour"
    return rows.mean() / len(pixels), columns.mean() / len(pixels[0])


def frames(path: Path) -> list[np.ndarray]:
    """Of a film, RGB."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
