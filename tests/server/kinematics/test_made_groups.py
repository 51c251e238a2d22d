"""Groups of inverse kinematics that V-REP 3's scripts make and remove."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.geometry.frames import get_position

SCENE = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="base"><geom size="0.05"/>
    <body name="upper"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
      <body name="lower" pos="0.5 0 0"><joint name="elbow" axis="0 0 1" range="-40 150"/>
        <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/><site name="tip" pos="0.5 0 0"/></body></body>
  </body>
  <site name="goal" pos="0.6 0.4 0"/><site name="turned" euler="0 0 90"/>
</worldbody><custom>
  <text name="simx:joint:shoulder" data="mode=ik"/><text name="simx:joint:elbow" data="mode=ik"/>
  <text name="simx:ik:old" data="tip=tip target=goal constraints=x,y handling=explicit"/>
</custom></mujoco>
"""
BEGIN = """
local tip, goal = simGetObjectHandle('tip'), simGetObjectHandle('goal')
simSetJointPosition(simGetObjectHandle('elbow'), 0.5)
local function link() simSetLinkDummy(tip, goal) simSetDummyLinkType(tip, sim_dummy_linktype_ik_tip_target) end
local function group(options, numbers)
    simRemoveIkGroup(simGetIkGroupHandle('old'))
    local made = simCreateIkGroup(options, {sim_ik_damped_least_squares_method, 100}, numbers)
    return made
end
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="base")


def miss(world: ScriptWorld) -> float:
    world.sim.refresh()
    return math.dist(
        get_position(world.sim, world.handle("tip")), get_position(world.sim, world.handle("goal"))
    )


@pytest.mark.parametrize("order", ["link() add()", "add() link()"])
def test_a_made_group_brings_its_tip_to_the_linked_dummy(world: ScriptWorld, order: str) -> None:
    results = world.lua(
        BEGIN
        + f"""
        local made = group(32, {{0.05}})
        local nothing = simHandleIkGroup(made)
        local function add() return simCreateIkElement(made, 0, {{tip, -1, -1, 3}}, {{0.0001, 0.1, 1, 1}}) end
        {order}
        return nothing, simHandleIkGroup(made), simGetIkGroupHandle('IK_Group') == made, simGetExplicitHandling(made)
        """
    )
    assert results == [0, 1, True, 1]
    assert miss(world) < 0.001


def test_what_a_run_made_and_removed_is_undone_at_its_stop(world: ScriptWorld) -> None:
    world.sim.start()
    world.lua(BEGIN + "group(0) return 1")
    groups = world.parts.ik_groups
    assert groups.names() == []
    assert [group.name for group in groups._groups()] == ["IK_Group"]
    world.sim.stop()
    assert [group.name for group in groups._groups()] == ["old"]


def test_options_make_joints_stay_or_keep_a_distance_from_their_limits(world: ScriptWorld) -> None:
    stays, stayed, keeps, kept = world.lua(
        BEGIN
        + """
        link()
        simSetObjectPosition(goal, -1, {3, 0, 0})
        local elbow, out = simGetObjectHandle('elbow'), {}
        for number, options in ipairs({4, 2}) do
            local made = simCreateIkGroup(options, {0, 100}, {0, 1, 0.01, 0.3})
            simCreateIkElement(made, 0, {tip, -1, -1, 3})
            table.insert(out, simHandleIkGroup(made))
            table.insert(out, simGetJointPosition(elbow))
            simRemoveIkGroup(made)
            simSetObjectPosition(goal, -1, {0.3, 0, 0})
        end
        return unpack(out)
        """
    )
    assert (stays, keeps) == (2, 2)
    assert stayed == pytest.approx(0.5)
    assert kept == pytest.approx(math.radians(150) - 0.3)


def test_single_coordinates_count_along_another_object_s_axes(world: ScriptWorld) -> None:
    world.lua(
        BEGIN
        + """
        link()
        local made = group(32)
        simCreateIkElement(made, 0, {tip, -1, simGetObjectHandle('turned'), 1})
        simHandleIkGroup(made)
        return 1
        """
    )
    x, y, _ = get_position(world.sim, world.handle("tip"))
    assert y == pytest.approx(0.4, abs=1e-3), "x of the turned object is the world's y"
    assert x != pytest.approx(0.6, abs=1e-2)


def test_a_wrong_group_or_too_few_numbers_are_errors(world: ScriptWorld) -> None:
    world.fails("simRemoveIkGroup(7)", "no inverse kinematics group with handle 7")
    world.fails("simCreateIkElement(simCreateIkGroup(0), 0, {1, 2})", "an element has four numbers")
