"""Path planning tasks of V-REP 3 in scripts: searches that write a way around a wall into a path object."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="host"><geom type="box" size=".1 .1 .1"/><site name="front" pos=".05 0 0"/></body>
    <body name="wall" pos="1 0 0"><geom type="box" size=".05 {width} .5"/></body>
    <body name="ghost" pos=".5 0 0"><geom type="box" size=".05 5 .5"/></body>
    <body name="seat" pos="0 0 1"><geom size=".01" contype="0" conaffinity="0"/><site name="way" pos="0 0 -.5"/></body>
    <site name="goal" pos="2 0 0" euler="0 0 1.5707963"/>
  </worldbody>
  <custom>
    <text name="simx:object:way" data="type=path"/>
    <text name="simx:planning:around" data="path=way start=front goal=goal robot=host obstacles=wall
      low=-1,{low},-1 high=3,1,1 type={type}"/>
  </custom>
</mujoco>
"""

H = "local h, task = sim.getObjectHandle, simGetPathPlanningHandle('around')\n"
POINTS = """
local points = {}
for i = 0, 50 do points[#points + 1] = sim.getPositionOnPath(h'way', i / 50) end
return points, sim.getOrientationOnPath(h'way', 1)[3]
"""


def make(folder: Path, kind: str = "xy", *, width: float = 0.5, low: float = -1) -> ScriptWorld:
    return ScriptWorld(folder, SCENE.format(type=kind, width=width, low=low), owner="host")


@pytest.mark.parametrize(("kind", "turn"), [("xy", 0), ("xyg", math.pi / 2)])
def test_a_search_finds_the_way_of_the_start_around_the_obstacles(
    tmp_path: Path, kind: str, turn: float
) -> None:
    world = make(tmp_path, kind)
    assert world.lua(H + "return simSearchPath(task, 30)") == [2]
    points, last = world.lua(H + POINTS)
    assert points[0] == pytest.approx([0.05, 0, 0], abs=1e-6)
    assert points[-1] == pytest.approx([2, 0, 0], abs=1e-6)
    assert last == pytest.approx(turn, abs=1e-6)
    assert all(abs(y) > 0.5 for x, y, _ in points if abs(x - 1) < 0.1)
    assert world.call("simxGetObjectPosition", world.handle("host"), -1) == pytest.approx([0, 0, 0])


def test_the_third_coordinate_is_searched_too(tmp_path: Path) -> None:
    world = make(tmp_path, "xyz", width=2)
    assert world.lua(H + "return simSearchPath(task, 30)") == [2]
    assert any(abs(z) > 0.55 for _, _, z in world.lua(H + POINTS)[0])


def test_a_search_goes_on_step_by_step_until_a_way_is_found(tmp_path: Path) -> None:
    world = make(tmp_path)
    (results,) = world.lua(
        H
        + """
        local search, results = simInitializePathSearch(task, 60, 0.03), {}
        repeat results[#results + 1] = simPerformPathSearchStep(search, false) until results[#results] ~= -2
        return results
        """
    )
    assert results == [-2] * (len(results) - 1) + [2]
    world.fails("simPerformPathSearchStep(1, false)", "no path search 1 is under way")


def test_a_search_without_a_way_fails_and_leaves_the_path(tmp_path: Path) -> None:
    world = make(tmp_path, width=5)
    assert world.lua(H + "return simSearchPath(task, 0.1), sim.getPathLength(h'way')") == [0, 0]
    (results,) = world.lua(
        H
        + """
        local search, results = simInitializePathSearch(task, 0.8, 0.02), {}
        repeat results[#results + 1] = simPerformPathSearchStep(search, false) until results[#results] ~= -2
        return results
        """
    )
    assert results[0] == -2
    assert results[-1] == 0


def test_a_search_can_be_ended(tmp_path: Path) -> None:
    world = make(tmp_path)
    assert world.lua(H + "return simPerformPathSearchStep(simInitializePathSearch(task, 5, 0.1), true)") == [
        0
    ]
    world.fails("simPerformPathSearchStep(1, false)", "no path search 1 is under way")
    world.fails(
        H + "for i = 1, 101 do simInitializePathSearch(task, 5, 0.1) end", "100 path searches are under way"
    )
    world.fails("simSearchPath(7, 1)", "no path planning task with handle 7; there are 2070000 'around'")
    world.fails("simGetPathPlanningHandle('along')", "around")


def test_a_start_in_an_obstacle_fails_at_once(tmp_path: Path) -> None:
    world = make(tmp_path)
    world.call("simxSetObjectPosition", world.handle("host"), -1, [1, 0, 0])
    assert world.lua(H + "return simPerformPathSearchStep(simInitializePathSearch(task, 5, 0.1), false)") == [
        0
    ]


def test_a_task_without_its_goal_is_none(tmp_path: Path) -> None:
    world = make(tmp_path)
    world.call("simxRemoveObject", world.handle("goal"))
    world.fails("simGetPathPlanningHandle('around')", "no path planning task named .around.")
