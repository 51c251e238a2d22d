"""Replays of runs whose scripts plan paths: the recording has the seed of the searches."""

from __future__ import annotations

from pathlib import Path

import pytest
from real_world import BLOCKING
from recordings import recorded, replay, rewrite

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE
from simx_server.recording.records import Kind, Record

pytestmark = pytest.mark.slow
pytest.importorskip("lupa")

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><geom size="0.02"/>
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-3 3"/>
        <geom type="capsule" fromto=".1 0 0 .4 0 0" size=".03" mass="1"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-2.5 2.5"/>
          <geom type="capsule" fromto=".05 0 0 .4 0 0" size=".03" mass="1"/></body>
      </body>
    </body>
    <body name="post" pos=".62 0 .5"><geom type="box" size=".04 .04 .3"/></body>
  </worldbody>
  <custom>
    <text name="simx:collection:arm" data="tree=base"/>
    <text name="simx:joint:shoulder" data="mode=passive"/>
    <text name="simx:joint:elbow" data="mode=passive"/>
    <text name="simx:script:base" data="file=plan.lua"/>
  </custom>
</mujoco>
"""

PLAN = """
function sysCall_init()
    joints = {sim.getObject('/shoulder'), sim.getObject('/elbow')}
    sim.setJointPosition(joints[1], -0.8)
end
function sysCall_actuation()
    local ints = {sim.getCollectionHandle('arm'), 0, 1, joints[1], joints[2]}
    local _, path = sim.callScriptFunction('getNonlinearPath@PyRep', 2, ints, {0.8, 0.1}, {'RRTConnect'}, '')
    for i = 1, 2 do sim.setJointPosition(joints[i], path[400 + i]) end
end
"""
"""The arm is put into the middle of a path around the post, in each step of another one."""


def test_planned_paths_are_replayed_from_the_recorded_seed(tmp_path: Path) -> None:
    scene, recording = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(SCENE)
    (tmp_path / "plan.lua").write_text(PLAN)
    with recorded(scene, recording, seed=7) as place:
        client = place.client()
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        for _ in range(3):
            v.simxSynchronousTrigger(client)
        assert place.parts.simulation.data.qpos.any()
    assert replay(recording) == DONE

    def with_another_seed(records: list[Record]) -> list[Record]:
        return [[Kind.HEADER, {**records[0][1], "seed": 8}], *records[1:]]

    rewrite(recording, with_another_seed)
    assert replay(recording) == DIVERGED
