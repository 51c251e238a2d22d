"""Scripts' sensors look at the present state itself; it is what a copy of it would be."""

from __future__ import annotations

import numpy as np
import pytest
from handler_calls import World

from simx_client.protocol.constants import sim_modelproperty_not_detectable

SCENE = """
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 .1"/>
    <body name="wall" pos="2 0 0"><geom type="box" size=".1 3 1"/></body>
    <body name="ball" pos="1 0 .5"><freejoint/><geom size=".1"/></body>
    <body name="mount" pos="0 0 .5">
      <geom size=".05" pos="0 0 -.3"/>
      <body name="head"><joint name="turn" axis="0 0 1"/><geom size=".02" mass=".1"/>
        <site name="beam" euler="0 90 0"/></body>
    </body>
  </worldbody>
  <custom>
    <text name="simx:proximity:beam" data="range=5 explicit=true"/>
    <text name="simx:joint:turn" data="mode=passive"/>
  </custom>
</mujoco>
"""

ARRAYS = "geom_xpos", "geom_xmat", "xpos", "site_xpos", "site_xmat"


@pytest.fixture
def world() -> World:
    made = World(SCENE)
    made.run(1)
    return made


def test_the_present_state_follows_what_moves(world: World) -> None:
    instants, joint = world.parts.instants, world.handle("turn")
    for angle in (0.0, 0.3, 2.0):
        world.call("simxSetJointPosition", joint, angle)
        present, copy = instants.present(), instants.now()
        for name in ARRAYS:
            assert np.array_equal(getattr(present, name), getattr(copy, name)), name
        assert present.data is world.sim.data
    before = instants.now()
    world.call("simxSetJointPosition", joint, 1.0)
    assert not np.array_equal(instants.present().site_xmat, before.site_xmat)
    assert instants.present() is present


def test_the_present_state_is_that_of_an_edited_scene(world: World) -> None:
    instants = world.parts.instants
    before = instants.present()
    world.call("simxCopyPasteObjects", [world.handle("ball")])
    after = instants.present()
    assert len(after.geom_xpos) == len(before.geom_xpos) + 1
    assert after.data is world.sim.data


def test_a_sensor_that_is_handled_sees_what_is_detectable_now(world: World) -> None:
    sensor, proximity = world.handle("beam"), world.parts.proximity
    ball, wall = world.handle("ball"), world.handle("wall")

    def met() -> int | None:
        found = proximity.handle(sensor)
        present, copy = world.parts.instants.present(), world.parts.instants.now()
        assert np.array_equal(present.detectable(), copy.detectable())
        return None if found is None else found.handle

    assert met() == ball
    for transparent in (True, False):
        world.sim.model.geom_rgba[world.sim.model.body("ball").geomadr[0], 3] = 0.0 if transparent else 1.0
        world.sim.model_edited()
        assert met() == (wall if transparent else ball)
    world.call("simxSetModelProperty", ball, sim_modelproperty_not_detectable)
    assert met() == wall
