"""Ways around obstacles: what scripts plan with simOMPL, and that what is found is free."""

from __future__ import annotations

import math
import shutil
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import world_of
from sim_api_calls import ScriptWorld

from simx_server.files.library import find_scene
from simx_server.kinematics import Element
from simx_server.kinematics.chain import make_arms
from simx_server.kinematics.planning import dubins
from simx_server.kinematics.planning.paths import Failure, Planner, interpolate
from simx_server.kinematics.planning.space import Space
from simx_server.kinematics.planning.tasks import MARGIN
from simx_server.kinematics.planning.validity import of_joints
from simx_server.scene.poses.frames import get_position

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="base"><geom type="cylinder" size=".05 .25" pos="0 0 .25"/>
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-150 150"/>
          <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/><site name="tip" pos=".4 0 0"/>
        </body>
      </body>
    </body>
    <body name="post" pos=".62 0 .5"><geom type="box" size=".04 .04 .3"/></body>
    <body name="cart" pos="-1 0 .1"><freejoint/><geom type="box" size=".1 .06 .05"/></body>
    <body name="token" pos="-1 1.5 .1"><geom type="box" size=".1 .06 .05"/></body>
    <body name="wall" pos="-1 .5 .1"><geom type="box" size=".5 .02 .1"/></body>
  </worldbody>
  <custom>
    <text name="simx:collection:robot" data="tree=base"/>
  </custom>
</mujoco>
"""
"""The straight way of the arm from one side to the other leads through the post."""

ARM_TASK = """
local js = {sim.getObjectHandle('shoulder'), sim.getObjectHandle('elbow')}
local robot = sim.getCollectionHandle('robot')
local task = simOMPL.createTask('reach')
simOMPL.setAlgorithm(task, simOMPL.Algorithm.RRTConnect)
local spaces = {}
for i, j in ipairs(js) do
    spaces[i] = simOMPL.createStateSpace('j' .. i, simOMPL.StateSpaceType.joint_position, j, {-2.9}, {2.9}, 1)
end
simOMPL.setStateSpace(task, spaces)
simOMPL.setCollisionPairs(task, {robot, sim.handle_all})
simOMPL.setStartState(task, {-0.8, 0.1})
simOMPL.setGoalState(task, {0.8, -0.1})
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="base")


def states(path: list[float], count: int) -> list[list[float]]:
    return [path[start : start + count] for start in range(0, len(path), count)]


def meets(world: ScriptWorld, names: tuple[str, str], values: list[float]) -> bool:
    for name, value in zip(names, values, strict=True):
        world.sim.joints.set_position(world.sim.scene.resolve(name), value)
    robot, post = world.parts.collections.named("robot"), world.sim.scene.resolve("post")
    return bool(world.parts.meters.collisions.check(robot, post))


def test_the_way_leads_around_the_obstacle_at_fine_resolution(world: ScriptWorld) -> None:
    before = world.sim.data.qpos.copy()
    found, path, count = world.lua(
        ARM_TASK
        + "local found, path = simOMPL.compute(task, 10, 1, 200) return found, path, simOMPL.getPathStateCount(task)"
    )
    assert np.array_equal(world.sim.data.qpos, before)
    assert found is True
    assert count >= 200
    listed = states(path, 2)
    assert listed[0] == [-0.8, 0.1]
    assert listed[-1] == [0.8, -0.1]
    names = ("shoulder", "elbow")
    assert meets(world, names, [0.0, 0.0])
    for a, b in pairwise(listed):
        for share in (0.0, 0.25, 0.5, 0.75):
            state = [x + share * (y - x) for x, y in zip(a, b, strict=True)]
            assert not meets(world, names, state)


def test_equal_runs_find_the_same_path(world: ScriptWorld) -> None:
    paths: list[Any] = []
    for _ in range(2):
        paths.append(world.lua(ARM_TASK + "return simOMPL.compute(task, 10)"))
        world.sim.stop()
        world.sim.start()
    assert paths[0] == paths[1]


def test_a_goal_within_the_obstacle_is_no_goal(world: ScriptWorld) -> None:
    assert world.lua(
        ARM_TASK
        + "simOMPL.setGoalState(task, {0, 0}) "
        + "return simOMPL.setup(task), simOMPL.solve(task, 1), simOMPL.isStateValid(task, {0, 0})"
    ) == [False, False, False]
    assert world.lua(
        ARM_TASK
        + "simOMPL.setGoalState(task, {0, 0}) simOMPL.addGoalState(task, {0.8, 0}) "
        + "return simOMPL.setup(task), simOMPL.solve(task, 10)"
    ) == [True, True]


def test_a_plan_ends_in_time_when_there_is_no_way(world: ScriptWorld) -> None:
    sealed = (
        ARM_TASK
        + """
simOMPL.setStateValidityCallback(task, function(state) return math.abs(state[1]) > 0.2 end)
return simOMPL.compute(task, 0.3)
"""
    )
    assert world.lua(sealed) == [False, []]


def test_planning_longer_than_a_scripts_limit_does_not_end_the_script(world: ScriptWorld) -> None:
    world.parts.scripts.time_limit = 0.2
    world.sim.stop()
    world.sim.start()
    sealed = (
        ARM_TASK
        + """
simOMPL.setStateValidationCallback(task, function(state) return state[1] < 0.2 or state[1] > 0.7 end)
local found = simOMPL.solve(task, 0.6)
return found, #simOMPL.getPath(task)
"""
    )
    assert world.lua(sealed) == [False, 0]
    assert world.lua("return 1") == [1]


def test_a_plan_asks_between_two_slow_checks_whether_it_may_go_on_and_ends_when_not() -> None:
    space = Space(np.zeros(1), np.ones(1), np.ones(1), np.zeros(1, bool), resolution=0.01)
    checks = asked = 0

    def is_valid(state: np.ndarray) -> bool:
        nonlocal checks
        checks += 1
        end = time.monotonic() + 0.01
        while time.monotonic() < end:
            pass
        return abs(state[0] - 0.5) > 0.2

    def may_go_on() -> bool:
        nonlocal asked
        asked += 1
        return asked < 10

    planner = Planner(space, is_valid, np.random.default_rng(1), may_go_on)
    assert planner.plan(np.array([0.0]), [np.array([1.0])], 100.0) == Failure.TIME
    assert (asked, checks) == (10, 9)


def test_others_are_served_while_a_plan_is_made(world: ScriptWorld) -> None:
    served: list[int] = []
    world.sim.interruptions.serve_others = lambda: served.append(1)
    world.lua(ARM_TASK + "simOMPL.solve(task, 10)")
    assert served


@pytest.mark.parametrize("name", ["cart", "token"])
def test_something_that_moves_in_the_plane_goes_round_the_wall(world: ScriptWorld, name: str) -> None:
    found, path = world.lua(
        f"""
local it = sim.getObjectHandle('{name}')
local task = simOMPL.createTask('drive')
local space = simOMPL.createStateSpace('2d', simOMPL.StateSpaceType.pose2d, it, {{-2, -1.5}}, {{0, 2.5}}, 1)
simOMPL.setStateSpace(task, {{space}})
simOMPL.setCollisionPairs(task, {{it, sim.getObjectHandle('wall')}})
simOMPL.setStartState(task, {{-1, 0, 0}})
simOMPL.setGoalState(task, {{-1, 1, 1.5}})
local found, path = simOMPL.compute(task, 10, 1, 100)
simOMPL.writeState(task, simOMPL.getPathState(task, simOMPL.getPathStateCount(task) - 1))
return found, path
"""
    )
    assert found is True
    listed = states(path, 3)
    # The wall is 1 m wide about x = -1: whoever crosses its line does so beside it.
    assert all(abs(x + 1) > 0.5 for x, y, _ in listed if abs(y - 0.5) < 0.03)
    place = get_position(world.sim, world.sim.scene.resolve(name))
    assert place[:2] == pytest.approx([-1, 1])


@pytest.mark.parametrize("name", ["cart", "token"])
def test_something_that_flies_goes_over_the_wall_and_turns(world: ScriptWorld, name: str) -> None:
    found, path, last = world.lua(
        f"""
local it = sim.getObjectHandle('{name}')
local task = simOMPL.createTask('fly')
local space = simOMPL.createStateSpace('6d', simOMPL.StateSpaceType.pose3d, it, {{-1.4, -0.5, 0}}, {{-0.6, 1.5, 1}}, 1)
simOMPL.setStateSpace(task, {{space}})
simOMPL.setCollisionPairs(task, {{it, sim.getObjectHandle('wall')}})
simOMPL.setStartState(task, {{-1, 0, 0.1, 0, 0, 0, 1}})
simOMPL.setGoalState(task, {{-1, 1, 0.1, 0, 0, -0.7071068, -0.7071068}})
local found, path = simOMPL.compute(task, 20, 1, 50)
simOMPL.writeState(task, simOMPL.getPathState(task, simOMPL.getPathStateCount(task) - 1))
return found, path, simOMPL.readState(task)
"""
    )
    listed = states(path, 7)
    assert found is True
    assert listed[0] == pytest.approx([-1, 0, 0.1, 0, 0, 0, 1])
    assert listed[-1] == pytest.approx([-1, 1, 0.1, 0, 0, -0.7071068, -0.7071068], abs=1e-6)
    assert last == pytest.approx([-1, 1, 0.1, 0, 0, 0.7071068, 0.7071068], abs=1e-6)
    assert max(state[2] for state in listed) > 0.2
    for a, b in pairwise(listed):
        assert np.linalg.norm(a[3:]) == pytest.approx(1)
        assert abs(np.dot(a[3:], b[3:])) > 0.9  # no state turns far from the one before


def test_the_flat_names_of_old_plan_too(world: ScriptWorld) -> None:
    found, path, count, first, reverse, limits, there, exact, back = world.lua("""
local js = {simGetObjectHandle('shoulder'), simGetObjectHandle('elbow')}
local task, spaces = simExtOMPL_createTask('reach'), {}
for i, j in ipairs(js) do
    local kind = sim_ompl_statespacetype_joint_position
    spaces[i] = simExtOMPL_createStateSpace('j' .. i, kind, j, {-2.9}, {2.9}, 1)
end
simExtOMPL_setVerboseLevel(task, 0)
simExtOMPL_setStateSpace(task, spaces)
simExtOMPL_setAlgorithm(task, sim_ompl_algorithm_RRTConnect)
simExtOMPL_setCollisionPairs(task, {simGetCollectionHandle('robot'), sim_handle_all})
simExtOMPL_setStateValidityCheckingResolution(task, 0.001)
simExtOMPL_setStateValidityCallback(task, function() return false end)
simExtOMPL_setStateValidationCallback(task, function() return true end)
simExtOMPL_setStartState(task, {-0.8, 0.1})
simExtOMPL_setGoalState(task, {0.8, -0.1})
simExtOMPL_addGoalState(task, {0.9, -0.1})
assert(simExtOMPL_setup(task) and simExtOMPL_solve(task, 10))
simExtOMPL_simplifyPath(task, 0.2)
simExtOMPL_interpolatePath(task, 20)
simExtOMPL_printTaskInfo(task)
local path = simExtOMPL_getPath(task)
local limits = {simExtOMPL_isStateWithinBounds(task, {3, 0}), simExtOMPL_isStateValid(task, {0, 0})}
simExtOMPL_writeState(task, {0.5, 0.2})
local back = simExtOMPL_readState(task)
local far = simExtOMPL_stateDistance(task, {0, 0}, {3, 4})
local exact = {simExtOMPL_hasExactSolution(task), simExtOMPL_hasApproximateSolution(task), far}
local count, first = simExtOMPL_getPathStateCount(task), simExtOMPL_getPathState(task, 0)
local reverse = simExtOMPL_getReversedPath(task, path)
local found, there = simExtOMPL_compute(task, 10, -1, 20)
for _, space in ipairs(spaces) do simExtOMPL_destroyStateSpace(space) end
simExtOMPL_destroyTask(task)
return found, path, count, first, reverse, limits, #there, exact, back
""")
    assert found is True
    assert count == len(path) / 2 >= 20
    assert first == path[:2] == [-0.8, 0.1]
    assert reverse[:2] == path[-2:]
    assert limits == [False, False]
    assert there >= 40
    assert exact == [True, False, pytest.approx(5)]
    assert back == pytest.approx([0.5, 0.2])


def test_a_task_can_be_asked_step_by_step(world: ScriptWorld) -> None:
    count, ends, far, inside, state = world.lua(
        ARM_TASK
        + """
simOMPL.setVerboseLevel(task, 1)
simOMPL.setStateValidityCheckingResolution(task, 0.0005)
simOMPL.solve(task, 10)
simOMPL.simplifyPath(task, 0.2)
simOMPL.interpolatePath(task, 0)
simOMPL.printTaskInfo(task)
local back = simOMPL.getReversedPath(task, simOMPL.getPath(task))
local ends = {simOMPL.hasExactSolution(task), simOMPL.hasApproximateSolution(task), back[1], back[2]}
return simOMPL.getPathStateCount(task), ends, simOMPL.stateDistance(task, {0, 0}, {0.3, 0.4}),
    simOMPL.isStateWithinBounds(task, {2, 2}), simOMPL.readState(task)
"""
    )
    assert count > 300
    assert ends == [True, False, pytest.approx(0.8), pytest.approx(-0.1)]
    assert (far, inside, state) == (pytest.approx(0.5), True, [0, 0])


CAR_TASK = """
local cart, wall = sim.getObjectHandle('cart'), sim.getObjectHandle('wall')
local task = simOMPL.createTask('park')
local space = simOMPL.createStateSpace('car', simOMPL.StateSpaceType.dubins, cart, {{-2.5, -1}}, {{0.5, 2}}, 1)
simOMPL.setStateSpace(task, {{space}})
simOMPL.setDubinsParams(space, 0.3, {})
simOMPL.setCollisionPairs(task, {{cart, wall}})
simOMPL.setStartState(task, {{-1, 0, 0}})
"""


def test_a_car_drives_around_the_wall_in_curves_of_its_radius(world: ScriptWorld) -> None:
    found, path = world.lua(
        CAR_TASK.format("false")
        + "simOMPL.setGoalState(task, {-1, 1, math.pi}) return simOMPL.compute(task, 20, -1, 400)"
    )
    assert found is True
    listed = np.array(states(path, 3))
    assert np.allclose(listed[[0, -1]], [[-1, 0, 0], [-1, 1, math.pi]])
    assert np.all(np.abs(listed[:, :2] - [-1, 0.5]) <= [1.5, 1.5])
    blocked = (np.abs(listed[:, 0] + 1) < 0.5) & (np.abs(listed[:, 1] - 0.5) < 0.02)
    assert not blocked.any()
    moved, turned = np.diff(listed[:, :2], axis=0), np.diff(np.unwrap(listed[:, 2]))
    lengths = np.linalg.norm(moved, axis=1)
    assert np.all(np.abs(turned) <= lengths / 0.3 * 1.01 + 1e-9)
    middle = np.unwrap(listed[:, 2])[:-1] + turned / 2
    ahead = np.stack([np.cos(middle), np.sin(middle)], axis=1)
    assert np.allclose(moved, ahead * lengths[:, np.newaxis], atol=1e-4), "it never slides sideways"


def test_a_symmetric_car_backs_up_and_others_take_the_long_way(world: ScriptWorld) -> None:
    distance = "return simOMPL.stateDistance(task, {-1, 0, 0}, {-1.5, 0, 0})"
    assert world.lua(CAR_TASK.format("true") + distance) == [pytest.approx(0.5)]
    (around,) = world.lua(CAR_TASK.format("false") + distance)
    assert around > 2 * math.pi * 0.3


def test_all_curves_of_cars_lead_to_their_ends_at_full_speed() -> None:
    random = np.random.default_rng(1)
    low, high = np.array([-2, -2, -4]), np.array([2, 2, 4])
    starts, ends = random.uniform(low, high, (2, 200, 3))
    found = dubins.lengths(starts, ends, 0.7)
    for start, end, length in zip(starts, ends, found, strict=True):
        curve = dubins.Curve(start, end, 0.7)
        assert curve.length == pytest.approx(length)
        steps = np.diff([curve.at(share) for share in np.linspace(0, 1, 50)], axis=0)
        assert np.all(np.hypot(steps[:, 0], steps[:, 1]) <= length / 49 + 1e-9)
        assert np.all(np.hypot(steps[:, 0], steps[:, 1]) >= 0.9 * length / 49)
        head, tail = dubins.Curve(start, curve.at(0.3), 0.7), dubins.Curve(curve.at(0.3), end, 0.7)
        assert head.length + tail.length == pytest.approx(length, abs=1e-5), (
            "parts of a shortest way are shortest"
        )


def test_mistakes_are_told(world: ScriptWorld) -> None:
    world.fails("simOMPL.solve(7)", "no planning task 7")
    world.fails("local t = simOMPL.createTask('t') simOMPL.solve(t)", "no state space")
    world.fails(ARM_TASK + "simOMPL.setStartState(task, {1})", "2 numbers, not 1")
    world.fails(ARM_TASK + "simOMPL.setCollisionPairs(task, {robot})", "two by two")
    world.fails(ARM_TASK + "simOMPL.setAlgorithm(task, 3)", "no algorithm")
    world.fails(ARM_TASK + "simOMPL.compute(task, 10, -1, 1e9)", "up to 10000 states")
    world.fails(
        ARM_TASK + "simOMPL.createStateSpace('s', 30005, js[1], {-1e300}, {1e300})", "bounds are at most"
    )
    world.fails(
        "simOMPL.createStateSpace('s', 30007, sim.getObjectHandle('cart'), {}, {})",
        "no kind of state space that is there",
    )
    joint = "simExtOMPL_createStateSpace('j1', simOMPL.StateSpaceType.joint_position, js[1], {-1}, {1}, 1)"
    for call in (
        "simOMPL.setDubinsParams(spaces[1], 1, true)",
        f"simExtOMPL_setDubinsParams({joint}, 1, true)",
    ):
        world.fails(ARM_TASK + call, "'j1' is no dubins space")


def test_a_path_keeps_its_corners_when_it_is_made_even() -> None:
    flat = np.zeros(2)
    space = Space(flat - 5, flat + 5, flat + 1, flat.astype(bool))
    corners = [np.array(each, dtype=float) for each in ((0, 0), (1, 0), (1, 3))]
    even = interpolate(space, corners, 41)
    assert len(even) == 41
    assert all(any(np.allclose(state, corner) for state in even) for corner in corners)
    steps = [np.linalg.norm(b - a) for a, b in pairwise(even)]
    assert max(steps) < 1.2 * min(steps)


def test_angles_go_the_short_way_and_shortening_keeps_the_ends() -> None:
    space = Space(np.array([-math.pi]), np.array([math.pi]), np.ones(1), np.array([True]))
    planner = Planner(space, lambda _: True, np.random.default_rng(0))
    path = planner.plan(np.array([3.0]), [np.array([-3.0])], 1.0)
    assert not isinstance(path, Failure)
    even = interpolate(space, path, 10)
    assert all(abs(math.remainder(state[0] - math.pi, 2 * math.pi)) < 0.15 for state in even)


def test_the_tutorials_robot_reaches_around_a_post(tmp_path: Path) -> None:
    xml = find_scene("ur5_rg2_kinect").read_text(encoding="utf-8")
    post = '<worldbody><body name="post" pos="0.37 -0.3 0.35"><geom type="box" size=".05 .05 .35"/></body></worldbody>'
    shutil.copytree(find_scene("ur5_rg2_kinect").parent / "parts", tmp_path / "parts")
    (tmp_path / "scene.xml").write_text(xml.replace("</mujoco>", post + "</mujoco>"), encoding="utf-8")
    world = world_of(tmp_path / "scene.xml", workspace=tmp_path)
    sim = world.simulation
    scene = sim.scene
    tip, base = scene.resolve("UR5_ikTip"), scene.resolve("UR5")
    joints, _ = make_arms(sim, [Element(tip, scene.resolve("UR5_ikTarget"), base)], lambda _: True)
    robot = [handle for handle in (base, *scene.descendants(base)) if scene.objects[handle].kind == 0]
    is_free = of_joints(world, joints, [(handle, -2) for handle in robot])
    space = Space(np.full(6, -math.pi), np.full(6, math.pi), np.ones(6), np.zeros(6, bool))
    is_clear = of_joints(world, joints, [(handle, -2) for handle in robot], MARGIN)
    planner = Planner(space, is_free, np.random.default_rng(3), is_clear=is_clear)
    start, goal = np.radians([60, -70, 30, 0, -90, 0]), np.radians([-40, -70, 30, 0, -90, 0])
    between = [start + (goal - start) * share for share in np.linspace(0, 1, 100)]
    assert is_free(start)
    assert is_free(goal)
    assert not all(is_free(state) for state in between)
    path = planner.plan(start, [goal], 20.0)
    assert not isinstance(path, Failure)
    path = planner.shorten(path, 10.0, 800)
    assert all(is_free(state) for state in interpolate(space, path, 1500))
