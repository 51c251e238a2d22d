"""Copies of a model, and a second load of it, bring their groups of inverse kinematics and collections along."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.poses.frames import get_position

ARM = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="arm"><geom size="0.05"/>
    <site name="goal" pos="0.6 0.5 0"/>
    <body name="upper"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
      <body name="lower" pos="0.5 0 0"><joint name="elbow" axis="0 0 1" range="-40 150"/>
        <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/><site name="tip" pos="0.5 0 0"/></body></body>
  </body>
  {}
</worldbody>
<actuator><position joint="shoulder" kp="9"/><position joint="elbow" kp="9"/></actuator>
<custom>
  <text name="simx:model:arm" data="base=yes"/>
  <text name="simx:collection:arm_all" data="tree=arm"/>
  <text name="simx:ik:arm_ik" data="tip=tip target=goal base=arm constraints=x,y handling=explicit iterations=200"/>
  <text name="simx:ik:arm_free" data="tip=tip target=world base=arm handling=explicit"/>
</custom></mujoco>
"""
COPY = "sim.copyPasteObjects({sim.getObjectHandle('arm')}, 1)"
LOAD = "sim.loadModel('arm.xml')"


@pytest.fixture(params=["running", "stopped"])
def world(request: pytest.FixtureRequest, tmp_path: Path) -> ScriptWorld:
    (tmp_path / "arm.xml").write_text(ARM.format(""), encoding="utf-8")
    scene = ARM.format('<body name="owner" pos="0 0 5"><geom size="0.1"/></body>')
    world = ScriptWorld(tmp_path, scene, owner="owner", kind="customization")
    if request.param == "stopped":
        world.sim.stop()
    return world


@pytest.mark.parametrize("action", [COPY, LOAD])
def test_groups_and_collections_of_another_arm_have_its_number(world: ScriptWorld, action: str) -> None:
    world.lua(f"{action} {COPY}")
    groups = world.parts.ik_groups
    assert groups.names() == [f"arm_{name}{end}" for end in ("", "#0", "#1") for name in ("ik", "free")]
    for end in ("", "#0", "#1"):
        element = groups.get(groups.find(f"arm_ik{end}")).elements[0]
        names = [world.sim.scene.get(handle).name for handle in (element.tip, element.target, element.base)]
        assert names == [f"tip{end}", f"goal{end}", f"arm{end}"]
        assert groups.get(groups.find(f"arm_free{end}")).elements[0].target == -1
        members = world.value(f"sim.getCollectionObjects(sim.getCollectionHandle('arm_all{end}'))")
        assert {world.sim.scene.get(handle).name for handle in members} == {
            name + end for name in ("arm", "goal", "upper", "shoulder", "lower", "elbow", "tip")
        }


@pytest.mark.parametrize("action", [COPY, LOAD])
def test_each_group_solves_for_its_own_arm(world: ScriptWorld, action: str) -> None:
    world.lua(action)
    world.lua("sim.setObjectPosition(sim.getObjectHandle('arm#0'), -1, {3, 1, 0})")
    result, values = world.lua(
        """
        local js = {sim.getObjectHandle('shoulder#0'), sim.getObjectHandle('elbow#0')}
        sim.setJointPosition(js[2], 0.4)
        return sim.checkIkGroup(sim.getIkGroupHandle('arm_ik#0'), js)
        """
    )
    assert result == 1
    for name, value in zip(("shoulder#0", "elbow#0"), values, strict=True):
        world.sim.joints.set_position(world.handle(name), value)
    world.sim.refresh()
    tip, goal, other = (get_position(world.sim, world.handle(name)) for name in ("tip#0", "goal#0", "tip"))
    assert math.dist(tip, goal) < 1e-3
    assert other == pytest.approx((1.0, 0.0, 0.0))
