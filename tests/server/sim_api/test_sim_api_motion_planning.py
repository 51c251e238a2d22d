"""Motion planning of V-REP 3: what scripts find with the tasks of a scene, and that the way is free."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><geom type="cylinder" size=".05 .25" pos="0 0 .2"/>
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-150 150"/>
          <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
          <body name="hand" pos=".4 0 0"><joint name="wrist" axis="0 0 1" range="-170 170"/>
            <geom size=".02" mass=".1"/><site name="tip" pos=".05 0 0"/></body>
        </body>
      </body>
    </body>
    <site name="target" pos=".5 .5 .5"/>
    <body name="post" pos=".62 0 .5"><geom type="box" size=".04 .04 .3"/></body>
  </worldbody>
  <custom>
    <text name="simx:collection:robot" data="tree=base"/>
    <text name="simx:ik:reach" data="tip=tip target=target constraints=x,y,gamma handling=explicit"/>
    <text name="simx:motion_planning:plan" data="joints=shoulder,elbow,wrist ik=reach robot=collection:robot
      obstacles=post weights=1,1,0.5{more}"/>
  </custom>
</mujoco>
"""
"""The straight way of the arm from one side to the other leads through the post."""

BEGIN = """
local plan = simGetMotionPlanningHandle('plan')
local left, right = {-0.8, 0.1, 0}, {0.8, -0.1, 0}
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE.format(more=""), owner="base")


def rows(values: list[float], count: int) -> list[list[float]]:
    return [values[place : place + count] for place in range(0, len(values), count)]


def put(world: ScriptWorld, state: list[float]) -> None:
    for name, value in zip(("shoulder", "elbow", "wrist"), state, strict=True):
        world.sim.joints.set_position(world.handle(name), value)
    world.sim.refresh()


def meets(world: ScriptWorld, state: list[float]) -> bool:
    put(world, state)
    robot, post = world.parts.collections.named("robot"), world.sim.scene.resolve("post")
    return bool(world.parts.meters.collisions.check(robot, post))


def tip(world: ScriptWorld, state: list[float]) -> list[float]:
    put(world, state)
    return world.call("simxGetObjectPosition", world.handle("tip"), -1)


def check(world: ScriptWorld, told: Any, step: float) -> list[list[float]]:
    """The states of a path, whose five tables must agree."""
    path, lengths, positions, quaternions, tip_lengths = told
    states = rows(path, 3)
    assert len(states) == len(lengths) == len(tip_lengths) == len(positions) / 3 == len(quaternions) / 4
    for number, (a, b) in enumerate(pairwise(states), 1):
        assert lengths[number] == pytest.approx(math.hypot(b[0] - a[0], b[1] - a[1], 0.5 * (b[2] - a[2])))
        assert lengths[number] <= step
    assert lengths[0] == tip_lengths[0] == 0
    for number in (0, len(states) // 2, -1):
        assert tip(world, states[number]) == pytest.approx(rows(positions, 3)[number], abs=1e-9)
    return states


def test_a_path_leads_around_the_obstacle_and_is_simplified(world: ScriptWorld) -> None:
    before = world.sim.data.qpos.copy()
    *found, shorter = world.lua(
        BEGIN
        + """
        local a, b, c, d, e = simFindMpPath(plan, left, right, 16, 0.1, 20000)
        return a, b, c, d, e, {simSimplifyMpPath(plan, a, 16, 0.1, 1, 1000)}
        """
    )
    assert np.array_equal(world.sim.data.qpos, before)
    for told in (found, shorter):
        states = check(world, told, 0.1)
        assert (states[0], states[-1]) == ([-0.8, 0.1, 0.0], [0.8, -0.1, 0.0])
        assert not any(meets(world, state) for state in states)
    assert sum(shorter[1]) <= sum(found[1]) + 1e-9
    assert meets(world, [0.0, 0.0, 0.0])


def test_options_leave_the_obstacles_out_and_no_way_is_nil(world: ScriptWorld) -> None:
    free, blocked = world.lua(
        BEGIN
        + """
        return #simFindMpPath(plan, left, right, 32, 0.1, 5000),
            simFindMpPath(plan, left, {0, 0, 0}, 0, 0.1, 200) or 'nil'
        """
    )
    assert (free > 6, blocked) == (True, "nil")


def test_a_clearance_keeps_the_robot_away(tmp_path: Path) -> None:
    near = "local n = simGetMpConfigTransition(plan, {-0.3, 0, 0}, {-0.2, 0, 0}, 0, nil, 0.01, 0.05) return n ~= nil"
    assert ScriptWorld(tmp_path, SCENE.format(more=""), owner="base").lua(BEGIN + near) == [True]
    kept = ScriptWorld(tmp_path, SCENE.format(more=" clearance=0.1"), owner="base")
    assert kept.lua(BEGIN + near) == [False]


def test_a_configuration_for_a_pose_is_found_and_the_nearest_to_a_reference(world: ScriptWorld) -> None:
    pose = "{0.3, 0.5, 0.5, 0, 0, 0.7071068, 0.7071068}"
    count, one, near, none = world.lua(
        BEGIN
        + f"""
        local count, one = simGetMpConfigForTipPose(plan, 0, 0.5, 100, {pose}, 3000)
        local _, near = simGetMpConfigForTipPose(plan, 0, 0.5, 60, {pose}, 3000, {{1, -1, 1}})
        return count, one, near, (simGetMpConfigForTipPose(plan, 0, 0.5, 5, {{9, 0, 0.5, 0, 0, 0, 1}}, 200))
        """
    )
    assert (count, none) == (1, 0)
    for state in (one, near):
        assert tip(world, state)[:2] == pytest.approx([0.3, 0.5], abs=1e-3)
    assert near[1] < 0


def test_the_tip_moves_on_a_straight_line(world: ScriptWorld) -> None:
    (*told, blocked) = world.lua(
        BEGIN
        + """
        local p = {0.4, -0.5, 0.5, 0, 0, 0, 1}
        local a, b, c, d, e = simFindIkPath(plan, {-1.5, 1.2, 0.3}, p, 0, 0.02)
        return a, b, c, d, e, simFindIkPath(plan, left, {0.62, 0, 0.5, 0, 0, 0, 1}, 0, 0.02) or 'nil'
        """
    )
    check(world, told, 1.0)
    places = np.array(rows(told[2], 3))
    assert blocked == "nil"
    assert places[-1] == pytest.approx([0.4, -0.5, 0.5], abs=1e-3)
    assert max(told[4]) < 0.025
    along = (places - places[0]) @ (places[-1] - places[0]) / np.sum((places[-1] - places[0]) ** 2)
    assert np.allclose(places, places[0] + along[:, np.newaxis] * (places[-1] - places[0]), atol=2e-3)


def test_a_transition_is_even_or_leads_the_tip_through_poses(world: ScriptWorld) -> None:
    even, through, blocked = world.lua(
        BEGIN
        + """
        local p = {0.4, -0.5, 0.5, 0, 0, 0, 1}
        local from, wrist = {-1.5, 1.2, 0.3}, sim.getObjectHandle('wrist')
        local line = simFindIkPath(plan, from, p, 0, 0.02)
        local to = {line[#line - 2], line[#line - 1], line[#line]}
        return {simGetMpConfigTransition(plan, from, to, 0, nil, 0.05, 0.05)},
            {simGetMpConfigTransition(plan, from, to, 512 + 256, nil, 0.02, 0.05)},
            simGetMpConfigTransition(plan, left, right, 0, {wrist, 0}, 0.05, 0.05) or 'nil'
        """
    )
    assert blocked == "nil"
    states = np.array(check(world, even, 0.0501))
    steps = np.diff(states, axis=0)
    assert np.allclose(steps, steps[0], atol=1e-6)
    places = np.array(rows(through[2], 3))
    check(world, through, 0.1)
    along = (places - places[0]) @ (places[-1] - places[0]) / np.sum((places[-1] - places[0]) ** 2)
    assert np.allclose(places, places[0] + along[:, np.newaxis] * (places[-1] - places[0]), atol=5e-3)


def test_behaviours_make_joints_move_less_readily(tmp_path: Path) -> None:
    scene = SCENE.format(more="").replace("x,y,gamma", "x,y")
    usual, *others = ScriptWorld(tmp_path, scene, owner="base").lua(
        BEGIN
        + """
        local wrist, elbow, shoulder = sim.getObjectHandle('wrist'), sim.getObjectHandle('elbow'),
            sim.getObjectHandle('shoulder')
        local from, to, results = {-1.5, 1.2, 0.3}, {-1.1, 0.5, 0.8}, {}
        for _, select in ipairs({{}, {wrist, 7}, {1, wrist, 7}, {shoulder, 7, elbow, 7}, {wrist, 0}}) do
            table.insert(results, (simGetMpConfigTransition(plan, from, to, 512 + 48, select, 0.01, 0.05)) or {})
        end
        return table.unpack(results)
        """
    )

    def bend(told: list[float]) -> float:
        """How far the wrist leaves its even way."""
        wrist = np.array(told[2::3])
        return float(np.max(np.abs(wrist - np.linspace(0.3, 0.8, len(wrist)))))

    seldom, counted, often, even = others
    assert counted == seldom
    assert bend(seldom) < 0.2 * bend(usual) < 0.2 * bend(often)
    assert bend(even) == pytest.approx(0.0, abs=1e-9)


def test_mistakes_are_told(world: ScriptWorld) -> None:
    world.fails("simGetMotionPlanningHandle('other')", "no motion planning task named 'other'.*plan")
    world.fails(
        "simFindMpPath(5, {}, {}, 0, 0.1)", "no motion planning task with handle 5; there are 2080000 'plan'"
    )
    world.fails(BEGIN + "simFindMpPath(plan, left, {1}, 0, 0.1)", "has 3 numbers, not 1")
    world.fails(BEGIN + "simSimplifyMpPath(plan, {1, 2}, 0, 0.1)", "are not rows of 3")
    transition = (
        "simGetMpConfigTransition(plan, left, right, 512, {sim.getObjectHandle('wrist'), 8}, 0.1, 0.1)"
    )
    world.fails(BEGIN + transition, "a joint's behaviour is from 0 to 7, not 8")


def test_a_task_without_its_joint_is_none(world: ScriptWorld) -> None:
    world.call("simxRemoveObject", world.handle("post"))
    world.fails(BEGIN + "simFindMpPath(plan, left, right, 0, 0.1)", "names 'post', which is no object")
