"""Joints that a script lists, in any mode: inverse kinematics moves these alone, for the length of a call."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.poses.frames import get_pose, set_pose
from simx_server.scene.poses.poses import conjugate, multiply, rotation_vector

ARM = """
<mujoco model="arm"><compiler angle="degree"/><option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><geom name="foot" type="cylinder" size=".05 .05"/>
      <body name="link1" pos="0 0 .1"><joint name="j1" axis="0 0 1"/>
        <geom type="capsule" fromto="0 0 0 0 0 .1" size=".04"/>
        <body name="link2" pos="0 0 .1"><joint name="j2" axis="0 1 0" range="-120 120"/>
          <geom type="capsule" fromto="0 0 0 0 0 .3" size=".04"/>
          <body name="link3" pos="0 0 .3"><joint name="j3" axis="0 1 0" range="-150 150"/>
            <geom type="capsule" fromto="0 0 0 0 0 .3" size=".03"/>
            <body name="link4" pos="0 0 .3"><joint name="j4" axis="0 1 0" range="-120 120"/>
              <geom type="capsule" fromto="0 0 0 0 0 .05" size=".03"/>
              <body name="link5" pos="0 0 .08"><joint name="j5" axis="1 0 0" range="-120 120"/>
                <geom type="capsule" fromto="0 0 0 0 0 .05" size=".03"/>
                <body name="link6" pos="0 0 .05"><joint name="j6" axis="0 0 1" range="-170 170"/>
                  <geom type="box" size=".03 .02 .02"/><site name="tip" pos="0 0 .05"/>
    </body></body></body></body></body></body></body>
    <site name="goal"/><site name="loose" pos="0 0 1"/>
  </worldbody>
  <actuator>
    <position joint="j1" kp="50"/><position joint="j2" kp="50"/><position joint="j3" kp="50"/>
    <position joint="j4" kp="50"/><position joint="j5" kp="50"/><position joint="j6" kp="50"/>
  </actuator>
  <custom>
    <text name="simx:ik:arm" data="tip=tip target=goal base=base handling=explicit iterations=100"/>
    <text name="simx:ik:no_goal" data="tip=loose target=world"/>
  </custom>
</mujoco>
"""
BENT = (0.2, 0.5, 0.9, 0.6, 0.1, 0.0)
BEGIN = """
local js, g = {}, sim.getIkGroupHandle('arm')
for i = 1, 6 do js[i] = sim.getObjectHandle('j' .. i) end
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    world = ScriptWorld(tmp_path, ARM, owner="base")
    put(world, list(BENT))
    aim(world, (0.0, 0.05, -0.05))
    return world


def put(world: ScriptWorld, values: list[float]) -> None:
    for number, value in enumerate(values, 1):
        world.sim.joints.set_position(world.handle(f"j{number}"), value)


def aim(world: ScriptWorld, away: tuple[float, float, float]) -> None:
    """Put the goal beside the tip, turned alike."""
    world.sim.refresh()
    place, turn = get_pose(world.sim, world.handle("tip"))
    there = (place[0] + away[0], place[1] + away[1], place[2] + away[2])
    set_pose(world.sim, world.handle("goal"), -1, (there, turn))


def misses(world: ScriptWorld, values: list[float]) -> tuple[float, float]:
    """Metres and radians between tip and goal with the joints there."""
    put(world, values)
    world.sim.refresh()
    a, b = (get_pose(world.sim, world.handle(name)) for name in ("tip", "goal"))
    return math.dist(a[0], b[0]), math.hypot(*rotation_vector(multiply(conjugate(a[1]), b[1])))


REACHED = pytest.approx((0.0, 0.0), abs=2e-3)


def test_a_check_moves_joints_in_force_mode_and_leaves_the_scene_as_it_is(world: ScriptWorld) -> None:
    state = "sim.getJointMode(js[1]), sim.getJointPosition(js[1]), sim.getJointTargetPosition(js[1])"
    before = world.sim.data.qpos.copy()
    *first, result, values = world.lua(BEGIN + f"return {state}, sim.checkIkGroup(g, js)")
    assert np.array_equal(world.sim.data.qpos, before)
    assert world.lua(BEGIN + f"return {state}") == first
    assert first[0] == 5
    assert result == 1
    assert misses(world, values) == REACHED


def test_joints_that_are_not_listed_are_locked_in_any_mode(world: ScriptWorld) -> None:
    set_mode = "sim.setJointMode(js[2], sim.jointmode_ik, 0)"
    result, values = world.lua(BEGIN + set_mode + " return sim.checkIkGroup(g, {js[1], js[3], js[4], js[5]})")
    assert result == 2, "without the second joint the pose is out of reach"
    assert len(values) == 4
    chosen = [values[0], BENT[1], *values[1:], BENT[5]]
    assert 1e-3 < misses(world, chosen)[0] < 0.1


def test_values_are_in_the_order_of_the_list(world: ScriptWorld) -> None:
    forth, back = world.lua(
        BEGIN
        + "local back = {} for i = 6, 1, -1 do back[#back + 1] = js[i] end\n"
        + "return select(2, sim.checkIkGroup(g, js)), select(2, sim.checkIkGroup(g, back))"
    )[-2:]
    assert forth == back[::-1]


def test_a_turned_cyclic_joint_counts_from_its_position(world: ScriptWorld) -> None:
    world.sim.data.qpos[0] = BENT[0] + 4 * math.pi
    world.sim.changed()
    aim(world, (0.0, 0.02, 0.0))
    result, values, path = world.lua(
        BEGIN + "local r, v = sim.checkIkGroup(g, js) return r, v, sim.generateIkPath(g, js, 3)"
    )
    assert result == 1
    assert values[0] == pytest.approx(BENT[0], abs=0.2)
    assert path[0] == pytest.approx(BENT[0])


@pytest.mark.parametrize("group", ["'no_goal'", "'arm'"])
def test_a_group_without_target_or_joint_is_not_performed(world: ScriptWorld, group: str) -> None:
    joints = "js" if "goal" in group else "{}"
    result, values = world.lua(BEGIN + f"return sim.checkIkGroup(sim.getIkGroupHandle({group}), {joints})")
    assert result == 0
    assert values == pytest.approx(BENT if joints == "js" else [])


def test_a_path_and_a_search_move_joints_in_force_mode(world: ScriptWorld) -> None:
    path, found = world.lua(
        BEGIN + "return sim.generateIkPath(g, js, 5), sim.getConfigForTipPose(g, js, 0.65, 2000)"
    )
    assert path[:6] == pytest.approx(BENT, abs=1e-6)
    assert misses(world, path[-6:]) == REACHED
    put(world, list(BENT))
    assert misses(world, found) == REACHED


@pytest.mark.parametrize(("method", "iterations"), [(0, 20), (1, 100), (2, 900)])
def test_all_methods_bring_the_tip_to_its_target(world: ScriptWorld, method: int, iterations: int) -> None:
    result, values = world.lua(
        BEGIN + f"sim.setIkGroupProperties(g, {method}, {iterations}, 0.1) return sim.checkIkGroup(g, js)"
    )
    assert result == 1
    assert misses(world, values) == REACHED


def test_constraints_choose_what_the_tip_must_reach(world: ScriptWorld) -> None:
    goal = world.handle("goal")
    place, turn = get_pose(world.sim, goal)
    set_pose(world.sim, goal, -1, (place, multiply(turn, (0.0, 1.0, 0.0, 0.0))))
    result, values = world.lua(
        BEGIN + "sim.setIkElementProperties(g, sim.getObjectHandle('tip'), 7) return sim.checkIkGroup(g, js)"
    )
    assert result == 1
    distance, angle = misses(world, values)
    assert distance < 1e-3
    assert angle > 1.0


def test_the_jacobian_is_that_of_the_joints_of_the_last_check(world: ScriptWorld) -> None:
    world.fails(BEGIN + "return sim.getIkGroupMatrix(g, 0)", "no joint that inverse kinematics may move")
    full, size, some, less = world.lua(
        BEGIN
        + """
        sim.setObjectPosition(sim.getObjectHandle('goal'), sim.getObjectHandle('tip'), {0, 0, 0})
        sim.checkIkGroup(g, js)
        local full, size = sim.getIkGroupMatrix(g, 0)
        sim.checkIkGroup(g, {js[1], js[3]})
        return full, size, sim.getIkGroupMatrix(g, 0)
        """
    )
    assert (size, less) == ([6, 6], [2, 6])
    rows = np.array(full).reshape(6, 6)
    assert np.array(some).reshape(6, 2) == pytest.approx(rows[:, [0, 2]])
    x, y, _ = get_pose(world.sim, world.handle("tip"))[0]
    assert rows[:3, 0] == pytest.approx([-y, x, 0.0], abs=1e-9), "the first joint turns about the world's z"
