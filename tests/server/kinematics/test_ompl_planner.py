"""The planners of OMPL by their names: what they find, the same from a seed, and what is said without them."""

from __future__ import annotations

import math
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import NoRendering
from sim_api_calls import ScriptWorld

from simx_server.app.building import build_world
from simx_server.app.server import open_world
from simx_server.errors import CommandError, StartError
from simx_server.kinematics.planning import ompl_planner
from simx_server.kinematics.planning.ompl_planner import ALGORITHMS, OmplPlanner
from simx_server.kinematics.planning.paths import Failure
from simx_server.kinematics.planning.space import Car, Space
from simx_server.kinematics.searching import Searching
from simx_server.scene.formats.loader import load_text
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import Settings

needs_ompl = pytest.mark.skipif(not ompl_planner.is_available(), reason="the extra 'ompl' is not installed")

ARM = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base">
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-3 3"/>
        <geom type="capsule" fromto=".1 0 0 .4 0 0" size=".03"/>
        <body name="lower" pos=".4 0 0"><joint name="elbow" axis="0 0 1" range="-2.5 2.5"/>
          <geom type="capsule" fromto=".05 0 0 .4 0 0" size=".03"/></body>
      </body>
    </body>
    <body name="post" pos=".62 0 .5"><geom type="box" size=".04 .04 .3"/></body>
  </worldbody>
  <custom><text name="simx:collection:arm" data="tree=base"/></custom>
</mujoco>
"""
"""The straight way of the arm from one side to the other leads through the post."""

START, GOAL = [-0.8, 0.1], [0.8, -0.1]


def space(low: float, high: float, count: int, *, endless: bool = False, cars: tuple[Car, ...] = ()) -> Space:
    return Space(
        np.full(count, low),
        np.full(count, high),
        np.ones(count),
        np.full(count, endless),
        resolution=0.05,
        cars=cars,
    )


def find(name: str, where: Space, ends: Any, seed: int = 0, checks: int = 20_000, blocked: Any = None) -> Any:
    """A path between states around a ball of radius 1 at the origin."""
    is_blocked = blocked or (lambda state: np.linalg.norm(state) < 1.0)
    planner = OmplPlanner(name, where, lambda state: not is_blocked(state), np.random.default_rng(seed))
    start, *goals = (np.array(each, float) for each in ends)
    return planner.plan(start, goals, 60.0, checks=checks)


@needs_ompl
@pytest.mark.parametrize("name", ALGORITHMS)
def test_each_algorithm_finds_a_path_around_an_obstacle_and_the_same_from_a_seed(name: str) -> None:
    ends = ([-2, -2, 0], [2, 2, 0])
    checks = 40_000 if name == "FMT" else 3_000
    paths = [find(name, space(-3, 3, 3), ends, seed, checks) for seed in (0, 0, 5)]
    for path in paths:
        assert path[0].tolist() == [-2, -2, 0]
        assert path[-1].tolist() == [2, 2, 0]
        lines = (a + share * (b - a) for a, b in pairwise(path) for share in np.linspace(0, 1, 50))
        assert min(map(np.linalg.norm, lines)) > 0.97
    assert np.array_equal(np.array(paths[0]), np.array(paths[1]))
    assert len(paths[0]) != len(paths[2]) or not np.array_equal(np.array(paths[0]), np.array(paths[2]))


@needs_ompl
def test_the_graph_of_a_search_has_its_start_and_its_edges() -> None:
    planner = OmplPlanner(
        "RRT", space(-3, 3, 2), lambda state: bool(abs(state[0]) > 0.5), np.random.default_rng(0)
    )
    planner.plan(np.array([-2.0, 0.0]), [np.array([2.0, 0.0])], 20, checks=500)
    graph = planner.graph
    assert [graph.states[at].tolist() for at in graph.starts] == [[-2, 0]]
    assert len(graph.edges) >= len(graph.states) - 1 > 5
    assert all(0 <= end < len(graph.states) for edge in graph.edges for end in edge)


@needs_ompl
def test_an_angle_without_an_end_goes_the_short_way() -> None:
    path = find(
        "RRTConnect", space(-math.pi, math.pi, 1, endless=True), ([3.0], [-3.0]), blocked=lambda _: False
    )
    assert path[-1] == pytest.approx(2 * math.pi - 3.0)
    assert np.ptp(np.array(path)) < 3.0


@needs_ompl
def test_a_car_drives_around_an_obstacle() -> None:
    where = space(-3, 3, 3, cars=(Car(slice(0, 3), 0.3, True),))
    path = find(
        "RRTConnect", where, ([-2, 0, 0], [2, 0, 0]), blocked=lambda state: math.hypot(*state[:2]) < 1
    )
    assert len(path) >= 3
    states = [where.line(a, b).at(share) for a, b in pairwise(path) for share in np.linspace(0, 1, 100)]
    assert min(math.hypot(*state[:2]) for state in states) > 0.97


@needs_ompl
def test_a_pose_in_space_is_planned() -> None:
    where = Space(
        np.array([-3.0] * 3 + [-1.0] * 4),
        np.array([3.0] * 3 + [1.0] * 4),
        np.ones(7),
        np.zeros(7, bool),
        resolution=0.05,
        quaternions=(slice(3, 7),),
    )
    ends = ([-2, 0, 0, 0, 0, 0, 1], [2, 0, 0, 1, 0, 0, 0])
    path = find("RRTConnect", where, ends, blocked=lambda state: np.linalg.norm(state[:3]) < 1.0)
    assert path[-1] == pytest.approx(ends[1])


@needs_ompl
def test_a_search_without_a_way_ends_after_counted_checks() -> None:
    counted = [0]

    def is_blocked(state: np.ndarray) -> bool:
        counted[0] += 1
        return abs(state[0]) < 0.5

    for name in ALGORITHMS:
        counted[0] = 0
        found = find(name, space(-3, 3, 2), ([-2, 0], [2, 0]), checks=500, blocked=is_blocked)
        assert found is Failure.TIME
        assert counted[0] < 2000, name


@needs_ompl
def test_blocked_ends_are_told_apart() -> None:
    where = space(-3, 3, 2)
    assert find("RRT", where, ([0, 0], [2, 0])) is Failure.START
    assert find("RRT", where, ([2, 0], [0, 0])) is Failure.GOAL


@needs_ompl
def test_an_error_of_a_check_reaches_the_caller() -> None:
    def fails(_state: np.ndarray) -> bool:
        raise CommandError("the script has an error")

    with pytest.raises(CommandError, match="the script has an error"):
        find("RRTConnect", space(-3, 3, 2), ([-2, 0], [2, 0]), blocked=fails)


@needs_ompl
def test_the_add_on_of_pyrep_plans_with_it_when_asked() -> None:
    def path(name: str, *, uses_ompl: bool) -> list[float]:
        world = build_world(NoRendering(), searching=Searching(0, uses_ompl))  # type: ignore[arg-type]
        world.simulation.use(*load_text(ARM))
        joints = [world.simulation.scene.resolve(each) for each in ("shoulder", "elbow")]
        for handle, value in zip(joints, START, strict=True):
            world.simulation.joints.set_position(handle, value)
        ints: Any = [world.collections.find("arm"), 0, 1, *joints]
        return world.scripts.add_ons["PyRep"].call("getNonlinearPath", ints, GOAL, [name], b"")[1]

    own, first = path("BKPIECE1", uses_ompl=False), path("BKPIECE1", uses_ompl=True)
    assert len(first) >= 600
    assert first[-2:] == pytest.approx(GOAL)
    assert first == path("BKPIECE1", uses_ompl=True)
    assert first != own
    assert path("SBL", uses_ompl=False) == own
    with pytest.raises(
        CommandError, match="SBL cannot be used from the Python module of OMPL; these can: BITstar"
    ):
        path("SBL", uses_ompl=True)


@needs_ompl
def test_a_task_of_a_script_plans_with_the_algorithm_that_it_sets(tmp_path: Path) -> None:
    world = ScriptWorld(tmp_path, ARM, owner="base")
    object.__setattr__(world.parts, "searching", Searching(0, uses_ompl=True))
    plan = """
        local joints = {sim.getObjectHandle('shoulder'), sim.getObjectHandle('elbow')}
        local task, spaces = simOMPL.createTask('reach'), {}
        for i, joint in ipairs(joints) do
            spaces[i] = simOMPL.createStateSpace('', simOMPL.StateSpaceType.joint_position, joint, {-2.5}, {2.5})
        end
        simOMPL.setStateSpace(task, spaces)
        simOMPL.setAlgorithm(task, simOMPL.Algorithm.NAME)
        simOMPL.setCollisionPairs(task, {sim.getCollectionHandle('arm'), sim.handle_all})
        simOMPL.setStartState(task, {-0.8, 0.1})
        simOMPL.setGoalState(task, {0.8, -0.1})
        return simOMPL.compute(task, 10, -1, 100)
    """
    found, path = world.lua(plan.replace("NAME", "LBKPIECE1"))
    assert found is True
    assert len(path) >= 200
    assert path[-2:] == pytest.approx(GOAL)
    world.fails(plan.replace("NAME", "PRM"), "PRM cannot be used from the Python module of OMPL")


def test_without_the_library_the_message_has_the_line_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ompl_planner, "is_available", lambda: False)
    with pytest.raises(CommandError, match=r"install with: .* install .*ompl>=2"):
        find("RRT", space(-3, 3, 2), ([-2, 0], [2, 0]))
    with ExitStack() as stack, pytest.raises(StartError, match="--planner ompl needs OMPL"):
        open_world(Settings(planner="ompl"), stack)


def test_seed_and_planner_come_from_flags_and_variables() -> None:
    settings = gather({"seed": "7"}, {"SIMX_PLANNER": "ompl"})
    assert (settings.seed, settings.planner) == (7, "ompl")
    assert (Settings().seed, Settings().planner) == (0, "own")
    with pytest.raises(SettingError, match="valid: own"):
        gather({"planner": "omp"}, {})
    with pytest.raises(SettingError, match="a whole number from 0 to"):
        gather({"seed": "-1"}, {})
