"""The values that checks read of a world: contacts of sleeping bodies too; objects that are gone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from simx_server.app.server import open_world
from simx_server.grading.checks.expression import parse
from simx_server.grading.checks.sight import WorldSight
from simx_server.settings.settings import Settings
from simx_server.world.world import World

SCENE = """
<mujoco>
  <option timestep="0.002"><flag sleep="enable"/></option>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="box" pos="0 0 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    (tmp_path / "scene.xml").write_text(SCENE)
    with ExitStack() as stack:
        yield open_world(Settings(scene=str(tmp_path / "scene.xml")), stack)


def is_true(sight: WorldSight) -> Callable[[str], object]:
    return lambda text: parse(text).evaluate(sight)


def test_a_box_that_sleeps_touches_the_floor_and_has_touched_it_once(world: World) -> None:
    sight = WorldSight(world)
    true = is_true(sight)
    world.simulation.start()
    for _ in range(40):
        world.step()
        sight.look()
        assert true('collisions("box", "floor") <= 1')
    assert np.all(world.simulation.data.tree_asleep >= 0)
    assert true('touches("box", "floor") and collisions("box", "floor") == 1')


def test_an_object_that_is_gone_touches_nothing_and_no_comparison_holds(world: World) -> None:
    sight = WorldSight(world)
    sight.look()
    true = is_true(sight)
    assert true('not touches("gone", "floor")')
    assert not true('touches("gone", "floor")')
    assert not true('z("gone") < 1 or z("gone") >= 1 or z("gone") != 1')
