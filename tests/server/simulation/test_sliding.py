"""What slides stays on its ground."""

from __future__ import annotations

import numpy as np
import pytest
from scenes_for_tests import world_of

BOX = """
<mujoco>
  <option timestep="0.005" cone="elliptic" impratio="10"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1" friction="{friction}" solref="0.005 1"/>
    <body name="box" pos="0 0 0.05">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.05" mass="1" friction="{friction}"/>
    </body>
  </worldbody>
  <custom><numeric name="simx:time_step" data="0.05"/></custom>
</mujoco>"""
GRAVITY = 9.81


@pytest.mark.parametrize("friction", [0.3, 1.0])
def test_a_box_slides_on_the_floor_without_hopping_until_friction_has_stopped_it(friction: float) -> None:
    world = world_of(BOX.format(friction=friction))
    simulation = world.simulation
    simulation.start()
    for _ in range(10):
        world.step()
    data = simulation.data
    height = data.qpos[2]
    data.qvel[0] = 2.0
    heights: list[float] = []
    speeds: list[float] = []
    for _ in range(20):
        world.step()
        heights.append(float(data.qpos[2]))
        speeds.append(float(data.qvel[0]))
    assert max(heights) - height < 1e-4
    stopping = 2.0 / (friction * GRAVITY)
    times = 0.05 * np.arange(1, 21)
    assert speeds == pytest.approx(np.maximum(0.0, 2.0 - friction * GRAVITY * times).tolist(), abs=0.1)
    assert data.qpos[0] == pytest.approx(0.5 * 2.0 * stopping, rel=0.05)
