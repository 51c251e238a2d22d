"""Groups of inverse kinematics that V-REP 3's scripts make and remove."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.poses.frames import get_position

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


def test_the_kinematics_of_a_scene_are_written_for_the_external_library(
    world: ScriptWorld, tmp_path: Path
) -> None:
    world.lua(
        BEGIN + "link() simCreateIkElement(group(32), 0, {tip, -1, -1, 3}) return simExportIk('arm.ik')"
    )
    data = (tmp_path / "arm.ik").read_bytes()
    place = 0

    def take(form: str) -> tuple[Any, ...]:
        nonlocal place
        values = struct.unpack_from(f"<{form}", data, place)
        place += struct.calcsize(f"<{form}")
        return values

    def text() -> str:
        nonlocal place
        start, place = place, data.index(0, place) + 1
        return data[start : place - 1].decode()

    version, count = take("2i")
    objects: dict[str, tuple[Any, ...]] = {}
    for _ in range(count):
        ((kind,), pose, (handle, parent), name) = take("i"), take("7f"), take("2i"), text()
        objects[name] = (handle, parent, pose, take("i5fB5f2i2f" if kind == 1 else "2i"))
    assert (version, count) == (0, len(world.sim.scene.objects))
    elbow, tip, goal = (objects[name] for name in ("elbow", "tip", "goal"))
    assert elbow[1] == objects["upper"][0]
    assert elbow[2] == pytest.approx((1, 0, 0, 0, 0.5, 0, 0), abs=1e-6)
    assert elbow[3][:7] == (10, 0.0, 1.0, 0.0, 0.0, 0.0, 0)
    expected = (math.radians(-40), math.radians(190), 0.5, math.radians(10), 1.0)
    assert elbow[3][7:12] == pytest.approx(expected, abs=1e-6)
    assert elbow[3][12:] == (2, -1, 1.0, 0.0)
    assert (tip[3], goal[3]) == ((goal[0], 5), (tip[0], 5))
    assert (take("i"), take("i"), text()) == (
        (1,),
        (world.value("simGetIkGroupHandle('IK_Group')"),),
        "IK_Group",
    )
    assert take("2i4f2i") == pytest.approx((100, 0, 1.0, 0.0, 0.0, 0.1, 1, -1))
    assert take("2Bi") == (1 + 8 + 16 + 64, 0, 1)
    element = take("4i2fi2fB")
    assert element[:4] == (0, tip[0], -1, -1)
    assert element[4:] == pytest.approx((math.radians(0.1), 0.0005, 3, 1.0, 1.0, 1))
    assert place == len(data)


def test_groups_that_are_made_and_removed_again_leave_only_their_links(world: ScriptWorld) -> None:

    def made() -> int:
        memory: Any = world.parts.ik_groups.remember()
        return len(memory[2])

    before = made()
    code = """
    link()
    for i = 1, 300 do
        local made = simCreateIkGroup(0)
        simCreateIkElement(made, 0, {tip, -1, -1, sim_ik_x_constraint})
        simRemoveIkGroup(made)
    end
    simRemoveIkGroup(simGetIkGroupHandle('old'))
    return simGetLinkDummy(tip) == goal
    """
    assert world.lua(BEGIN + code) == [True]
    assert made() == before
