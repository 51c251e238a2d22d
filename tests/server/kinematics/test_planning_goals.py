"""Goals of simOMPL other than states, samplers, and spaces and projections of joints."""

from __future__ import annotations

import math

import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base">
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-170 170"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-150 150"/>
          <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/><site name="tip" pos=".4 0 0"/>
        </body>
      </body>
    </body>
    <body name="post" pos=".62 0 .5"><geom type="box" size=".04 .04 .3"/></body>
    <site name="target" pos=".3 .5 .5"/>
    <site name="far" pos="5 0 .5"/>
  </worldbody>
  <custom><text name="simx:collection:robot" data="tree=base"/></custom>
</mujoco>
"""

TASK = """
local joints = {sim.getObjectHandle('shoulder'), sim.getObjectHandle('elbow')}
local tip, target, far = sim.getObjectHandle('tip'), sim.getObjectHandle('target'), sim.getObjectHandle('far')
local task = simOMPL.createTask('reach')
simOMPL.setStateSpaceForJoints(task, joints)
simOMPL.setCollisionPairs(task, {sim.getCollectionHandle('robot'), sim.handle_all})
simOMPL.setStartState(task, {-0.8, 0.1})
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> ScriptWorld:
    return ScriptWorld(tmp_path_factory.mktemp("goals"), SCENE, owner="base")


def tip_at(shoulder: float, elbow: float) -> tuple[float, float]:
    return (
        0.4 * math.cos(shoulder) + 0.4 * math.cos(shoulder + elbow),
        0.4 * math.sin(shoulder) + 0.4 * math.sin(shoulder + elbow),
    )


def test_a_path_leads_the_tip_to_an_object_around_the_post(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoal(task, tip, target, 0.002, {1, 1, 1, 0})
    assert(simOMPL.setup(task) and simOMPL.solve(task, 20))
    return simOMPL.hasExactSolution(task), simOMPL.hasApproximateSolution(task), simOMPL.getGoalDistance(task),
        simOMPL.getPath(task), simOMPL.isStateValid(task, {0, 0})
    """
    exact, approximate, distance, path, through_the_post = world.lua(TASK + code)
    assert (exact, approximate, distance, through_the_post) == (True, False, 0, False)
    assert path[:2] == [-0.8, 0.1]
    assert math.dist(tip_at(*path[-2:]), (0.3, 0.5)) <= 0.002


def test_a_goal_out_of_reach_is_approached(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoal(task, tip, far, 0.01, {1, 0, 0, 0})
    simOMPL.setCollisionPairs(task, {})
    local solved = simOMPL.solve(task, 0.5)
    return solved, simOMPL.hasSolution(task), simOMPL.hasExactSolution(task), simOMPL.hasApproximateSolution(task),
        simOMPL.getGoalDistance(task), simOMPL.getPath(task)
    """
    *found, distance, path = world.lua(TASK + code)
    assert found == [True, True, False, True]
    assert distance == pytest.approx(5 - tip_at(*path[-2:])[0], abs=1e-6)
    assert distance < 4.25  # at best 4.2


def test_a_sampler_that_never_leaves_the_start_ends_with_the_time(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoal(task, tip, far, 0.01, {1, 0, 0, 0})
    local function same() return {-0.8, 0.1} end
    simOMPL.setValidStateSamplerCallback(task, same, same)
    return simOMPL.solve(task, 0.1), simOMPL.hasSolution(task)
    """
    assert world.lua(TASK + code) == [False, False]


def test_the_graph_of_a_search_goes_with_its_states(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoal(task, tip, far, 0.01, {1, 0, 0, 0})
    local function states() return #simOMPL.getPlannerData(task) end
    simOMPL.solve(task, 0.1)
    local after_search = states()
    simOMPL.setStartState(task, {0, 0})
    local has_failed = not simOMPL.solve(task, 0.1)
    local after_failure = states()
    simOMPL.setStartState(task, {-0.8, 0.1})
    simOMPL.solve(task, 0.1)
    simOMPL.setStateSpaceForJoints(task, {joints[1]})
    return after_search > 0, has_failed, after_failure, states(), simOMPL.drawPlannerData(task, 0.01, 1, {1, 0, 0})
    """
    assert world.lua(TASK + code) == [True, True, 0, 0, []]


def test_a_function_judges_the_goal(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoalCallback(task, function(s)
        return s[2] > 1 and s[1] > 1, math.max(1 - s[2], 0) + math.max(1 - s[1], 0)
    end)
    assert(simOMPL.getGoalDistance(task) == -1 and not simOMPL.hasSolution(task))
    assert(simOMPL.solve(task, 20) and simOMPL.hasExactSolution(task))
    return simOMPL.getPath(task)
    """
    (path,) = world.lua(TASK + code)
    assert min(path[-2:]) > 1
    wrong = TASK + "simOMPL.setGoalCallback(task, function(s) return false, {} end) simOMPL.solve(task, 1)"
    world.fails(wrong, "returns whether the state is a goal, and its distance")


def test_one_of_several_goal_states_is_reached(world: ScriptWorld) -> None:
    code = """
    simOMPL.setGoalStates(task, {{0, 0}, {-1, 0.5}}) assert(simOMPL.solve(task, 5))
    return simOMPL.getPath(task)
    """
    (path,) = world.lua(TASK + code)
    assert path[-2:] == [-1, 0.5]  # the other one is in the post


def test_samplers_give_the_states_to_grow_towards(world: ScriptWorld) -> None:
    code = """
    local far, near = 0, 0
    simOMPL.setValidStateSamplerCallback(task,
        function() far = far + 1 return {math.random() * 2 - 1, math.random() * 2 - 1} end,
        function(s, distance) near = near + 1 return {s[1] + distance * (math.random() - 0.5), s[2]} end)
    simOMPL.setGoalCallback(task, function(s) return far * near > 0 and s[1] < -0.9, s[1] end)
    assert(simOMPL.solve(task, 20))
    return far, near
    """
    assert min(world.lua(TASK + code)) > 0
    wrong = """
    simOMPL.setGoalState(task, {2, 1})
    simOMPL.setStateValidationCallback(task, function(s) return s[1] < 0 or s[1] > 1.9 or s[2] > 2 end)
    simOMPL.setValidStateSamplerCallback(task, function() return %s end) simOMPL.solve(task, 5)
    """
    world.fails(TASK + wrong % "{1, 2, 3}", "states of 2 numbers, not 3")
    world.fails(TASK + wrong % "7", "a table of numbers")


def test_spaces_of_joints_have_their_intervals(world: ScriptWorld) -> None:
    code = """
    local space = simOMPL.createStateSpaceForJoint('elbow', joints[2], 1, 2)
    local other = simOMPL.createTask('other')
    simOMPL.setStateSpace(other, {space})
    return simOMPL.getStateSpaceDimension(task), simOMPL.getStateSpaceDimension(other),
        simOMPL.enforceBounds(task, {-9, 0.5}), simOMPL.stateDistance(other, {0}, {1})
    """
    dimension, of_other, inside, distance = world.lua(TASK + code)
    assert (dimension, of_other, distance) == (2, 1, 2)
    assert inside == pytest.approx([math.radians(-170), 0.5])
    world.fails(TASK + "simOMPL.setStateSpaceForJoints(task, joints, {1})", "2 joints need as many flags")


def test_states_are_projected_by_default_or_by_a_function(world: ScriptWorld) -> None:
    code = """
    local states = {1, 2, 4, 6}
    local length = simOMPL.getProjectedPathLength(task, states)
    local before = {simOMPL.projectionSize(task), simOMPL.projectStates(task, states), length}
    simOMPL.setStateSpaceForJoints(task, joints, {0, 1})
    local one = {simOMPL.projectionSize(task), simOMPL.projectStates(task, states)}
    simOMPL.setProjectionEvaluationCallback(task, function(s) return {s[1] + s[2]} end, 1)
    return before, one, {simOMPL.projectionSize(task), simOMPL.projectStates(task, states)}
    """
    assert world.lua(TASK + code) == [[2, [1, 2, 4, 6], 5], [1, [2, 6]], [1, [3, 10]]]
    wrong = """
    simOMPL.setProjectionEvaluationCallback(task, function(s) return {1} end, 2)
    simOMPL.projectStates(task, {1, 2})
    """
    world.fails(TASK + wrong, "returns 2 numbers, not 1")
    world.fails(TASK + "simOMPL.projectStates(task, {1})", "2 numbers each; 1 are no multiple")


def test_the_names_of_old_set_goals_too(world: ScriptWorld) -> None:
    code = """
    local task = simExtOMPL_createTask('old')
    local joint = simGetObjectHandle('elbow')
    local kind = sim_ompl_statespacetype_joint_position
    simExtOMPL_setStateSpace(task, {simExtOMPL_createStateSpace('s', kind, joint, {-2}, {2}, 1)})
    simExtOMPL_setStartState(task, {0})
    simExtOMPL_setGoal(task, simGetObjectHandle('tip'), simGetObjectHandle('target'))
    simExtOMPL_setGoalStates(task, {{1}})
    function isGoal(s) return s[1] > 1, 1 - s[1] end
    simExtOMPL_setGoalCallback(task, sim_handle_self, 'isGoal')
    simExtOMPL_setValidStateSamplerCallback(task, function() return {math.random()} end)
    simExtOMPL_solve(task, 5)
    return simExtOMPL_hasSolution(task), simExtOMPL_getGoalDistance(task), #simExtOMPL_getPath(task) ==
        #simOMPL.getPath(task), simExtOMPL_drawPath(task, simExtOMPL_getPath(task), 1, {1, 0, 0}), simExtOMPL_missing
    """
    assert world.lua(code) == [True, 0, True, [], None]


def test_a_task_without_a_start_is_not_set_up(world: ScriptWorld) -> None:
    code = """
    simOMPL.setStateSpaceForJoints(task, joints)
    simOMPL.setGoal(task, tip, far, 0.1)
    return simOMPL.setup(task)
    """
    assert world.lua(TASK + code) == [False]


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        ("setGoal(task, tip, target, 0)", "above 0"),
        ("setGoal(task, tip, target, 1, {1, 2})", "4 factors"),
        ("setGoal(task, tip, 999999)", "999999"),
        ("setGoalStates(task, {})", "at least one"),
        ("setGoalStates(task, {{1}})", "2 numbers, not 1"),
    ],
)
def test_mistakes_in_goals_are_told(world: ScriptWorld, call: str, reason: str) -> None:
    world.fails(f"{TASK} simOMPL.{call}", reason)
