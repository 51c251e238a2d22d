"""Replays of runs whose scripts make and remove many shapes, which wait for the compile."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_world import BLOCKING
from recordings import recorded, replay

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE

pytestmark = pytest.mark.slow
pytest.importorskip("lupa")

SCENE = """
<mujoco>
  <option timestep="0.01"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="base"><geom size="0.02"/></body>
    <body name="ball" pos="0 0.5 0.3"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <custom><text name="simx:script:base" data="file=build.lua"/></custom>
</mujoco>
"""

BUILD = """
function sysCall_init()
    made, number = {}, 0
end
function sysCall_actuation()
    for i = 1, 3 do
        local shape = sim.createPureShape(i % 2, 8 + 16 * (i % 2), {0.1, 0.1, 0.1}, 0.2, nil)
        sim.setObjectPosition(shape, -1, {0.15 * i, 0.5, 0.15 + 0.1 * number})
        sim.setShapeColor(shape, nil, sim.colorcomponent_ambient_diffuse, {1, 0, 0})
        table.insert(made, shape)
    end
    number = number + 1
    if #made > 9 then
        for i = 1, 4 do sim.removeObject(table.remove(made, 2)) end
    end
    sim.setObjectPosition(made[1], -1, {0.15, 0.5 + 0.002 * number, 0.15})
end
"""
"""Static and falling shapes come and go; the first one is moved, and drags what lies on it."""


def test_shapes_that_come_and_go_are_replayed(tmp_path: Path) -> None:
    scene, recording = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(SCENE)
    (tmp_path / "build.lua").write_text(BUILD)
    with recorded(scene, recording) as place:
        client = place.client()
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        for _ in range(20):
            v.simxSynchronousTrigger(client)
        v.simxGetPingTime(client)
        assert place.parts.simulation.model.nbody > 9
    assert replay(recording) == DONE
