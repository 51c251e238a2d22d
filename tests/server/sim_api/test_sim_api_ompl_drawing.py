"""Functions of simOMPL and simIK that CoppeliaSim wrote in Lua and its own scenes call."""

from __future__ import annotations

from itertools import pairwise

import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.errors import CommandError

__all__ = ["world"]

TASK = """
local h = sim.getObjectHandle('cube')
local task = simOMPL.createTask('task')
simOMPL.setStateSpace(task, {simOMPL.createStateSpace('s', simOMPL.StateSpaceType.%s, h, {-9, -9}, {9, 9}, 1)})
"""


def test_a_path_of_positions_is_drawn_as_a_line_and_removed(world: ScriptWorld) -> None:
    code = (
        TASK % "pose2d"
        + "local drawn = simOMPL.drawPath(task, {0, 0, 1, 2, 0, 1, 2, 3, 1}, 4, {0, 1, 0}, 0) "
    )
    (handles,) = world.lua(code + "return drawn")
    ((drawing, items),) = world.parts.drawings.shown()
    assert (handles, items) == ([drawing.handle], [(0, 0, 0, 2, 0, 0), (2, 0, 0, 2, 3, 0)])
    world.lua(code + "simOMPL.removeDrawingObjects(task, drawn)")
    assert len(world.parts.drawings.shown()) == 1


def test_the_states_of_a_search_are_given_and_drawn(world: ScriptWorld) -> None:
    code = (
        TASK % "position2d"
        + """
    assert(#simOMPL.getPlannerData(task) == 0 and #simOMPL.drawPlannerData(task, 0.1, 2, {1, 0, 0}) == 0)
    simOMPL.setStateValidationCallback(task, function(s) return math.abs(s[1]) > 0.1 or s[2] > 5 end)
    simOMPL.setVerboseLevel(task, 1)
    simOMPL.setStartState(task, {-3, 0}) simOMPL.setGoalState(task, {3, 0})
    assert(simOMPL.solve(task, 10))
    local drawn = simOMPL.drawPlannerData(task, 0.1, 2, {1, 0, 0}, {0, 1, 0}, {0, 0, 1})
    return drawn, {simOMPL.getPlannerData(task)}, simOMPL.getPath(task), simOMPL.hasSolution(task)
    """
    )
    drawn, (states, tags, more, edges, lengths, starts, goals), path, is_solved = world.lua(code)
    assert is_solved
    points = [tuple(states[at : at + 2]) for at in range(0, len(states), 2)]
    joined = set(zip(edges[::2], edges[1::2], strict=True))
    assert tags == more == [0] * len(points)
    assert len(lengths) == len(joined) >= len(points) - 1
    assert ([points[at] for at in starts], [points[at] for at in goals]) == ([(-3, 0)], [(3, 0)])
    found = [points.index(tuple(path[at : at + 2])) for at in range(0, len(path), 2)]
    assert all(edge in joined for edge in pairwise(found))
    shown = {drawing.handle: items for drawing, items in world.parts.drawings.shown()}
    assert [len(shown[each]) for each in drawn] == [len(joined), len(points) - 2, 1, 1]
    assert any("states were reached" in line for line in world.parts.status_bar.messages)


def test_alternate_configurations_are_whole_turns_away_within_the_intervals(world: ScriptWorld) -> None:
    code = """
    local env = simIK.createEnvironment()
    local one = simIK.createJoint(env, simIK.jointtype_revolute)
    local other = simIK.createJoint(env, simIK.jointtype_revolute)
    simIK.setJointInterval(env, one, false, {-2 * math.pi, 4 * math.pi})
    simIK.setJointInterval(env, other, true, {-math.pi, 2 * math.pi})
    local twin = simIK.duplicateEnvironment(env)
    simIK.setJointPosition(env, one, 1)
    return simIK.getAlternateConfigs(twin, {one, other}, {1, 2}), simIK.getJointPosition(twin, one),
        #simIK.getAlternateConfigs(env, {one}, {1}, {-20}, {40})
    """
    found, position, count = world.lua(code)
    assert found == pytest.approx([1 - 6.283185307, 2, 1, 2])
    assert (position, count) == (0, 7)
    world.fails("simIK.duplicateEnvironment(99)", "environment")


@pytest.mark.parametrize(
    ("interval", "reason"),
    [
        ("{-1e15}, {2e15}", "more than 10000"),
        ("{1e308}, {1e308}", "finite numbers"),
    ],
)
def test_alternate_configurations_without_end_are_refused(
    world: ScriptWorld, interval: str, reason: str
) -> None:
    code = f"""
    local env = simIK.createEnvironment()
    local joint = simIK.createJoint(env, simIK.jointtype_revolute)
    return simIK.getAlternateConfigs(env, {{joint}}, {{1}}, {interval})
    """
    with pytest.raises(CommandError, match=reason):
        world.lua(code)


def test_names_of_older_versions_are_there(world: ScriptWorld) -> None:
    code = """
    local env = simIK.createEnvironment()
    local base, tip, target = simIK.createDummy(env), simIK.createDummy(env), simIK.createDummy(env)
    local joint = simIK.createJoint(env, simIK.jointtype_revolute)
    simIK.setObjectParent(env, joint, base) simIK.setObjectParent(env, tip, joint)
    simIK.setLinkedDummy(env, tip, target)
    local group = simIK.createIkGroup(env)
    local element = simIK.addIkElement(env, group, tip)
    simIK.setIkGroupFlags(env, group, 1)
    simIK.setIkElementFlags(env, group, element, 0)
    return simIK.getIkGroupFlags(env, group), simIK.getElementFlags(env, group, element),
        simIK.getIkElementFlags(env, group, element)
    """
    assert world.lua(code) == [1, 0, 0]
    world.lua(
        "local p = simROS2.advertise('/a', 'std_msgs/msg/Bool') simROS2.shutdownPublisher(p) "
        "simROS2.shutdownSubscriber(simROS2.subscribe('/a', 'std_msgs/msg/Bool', function() end))"
    )
    assert world.value("sim.transformImage('abcdef', {2, 1}, 2)") == "defabc"
