"""Overlapping shapes part at a walking pace, for any contacts of the scene."""

from __future__ import annotations

import numpy as np
import pytest
from scenes_for_tests import world_of

from simx_server.joints.stepping.separation import FASTEST

BLOCKS = """
<mujoco>
  <option timestep="{timestep}" cone="{cone}" gravity="0 0 {gravity}"/>
  <default><geom solref="0.005 1"/></default>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="one" pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <body name="other" pos="{x} 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
  </worldbody>
</mujoco>"""


def fastest(x: float, timestep: float = 0.005, cone: str = "elliptic") -> float:
    """The greatest speed, m/s, of two blocks of 0.2 m whose middles are `x` apart, within a second."""
    world = world_of(BLOCKS.format(x=x, timestep=timestep, cone=cone, gravity=-9.81))
    sim = world.simulation
    sim.start()
    found = 0.0
    for _ in range(20):
        world.step()
        found = max(found, float(np.abs(sim.data.qvel[[0, 1, 2, 6, 7, 8]]).max()))
    assert abs(sim.data.qpos[7] - sim.data.qpos[0]) > 0.195
    return found


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
@pytest.mark.parametrize("timestep", [0.005, 0.002])
def test_blocks_within_each_other_part_at_a_metre_per_second_at_most(timestep: float, cone: str) -> None:
    assert 0.1 < fastest(0.05, timestep, cone) <= 1.05 * FASTEST


def test_a_shape_that_is_put_into_another_one_during_a_run_does_not_explode() -> None:
    world = world_of(BLOCKS.format(x=1.0, timestep=0.005, cone="elliptic", gravity=0))
    sim = world.simulation
    sim.start()
    world.step()
    sim.data.qpos[7:10] = (0.06, 0, 0.1)
    sim.changed()
    for _ in range(20):
        world.step()
        assert np.abs(sim.data.qvel).max() <= 1.05 * FASTEST


def test_a_fast_ball_bounces_as_before() -> None:
    """Only overlaps are limited: a hard impact gives back its speed."""
    world = world_of(
        """
<mujoco>
  <option timestep="0.001" gravity="0 0 0"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1" solref="-20000 -1" priority="1"/>
    <body pos="0 0 0.5"><freejoint/><geom size="0.1" mass="1"/></body>
  </worldbody>
</mujoco>"""
    )
    sim = world.simulation
    sim.start()
    sim.data.qvel[2] = -8
    for _ in range(4):
        world.step()
    assert sim.data.qvel[2] > 5
