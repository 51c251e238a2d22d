"""Searches of configurations from random starts: which starts are tried, how much work is done, and what repeats."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from sim_api_calls import ScriptWorld
from test_listed_joints import ARM, BEGIN, BENT, aim, put

from simx_server.kinematics import sampling
from simx_server.kinematics.planning.validity import as_pairs, of_joints
from simx_server.kinematics.sampling import Nearness
from simx_server.kinematics.scratch import Snapshot, Trials
from simx_server.kinematics.search import find_configs
from simx_server.kinematics.solver import Solution, Solver
from simx_server.scene.poses.frames import set_position


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    world = ScriptWorld(tmp_path, ARM, owner="base")
    put(world, list(BENT))
    aim(world, (0.0, 0.05, -0.05))
    return world


def call(arguments: str) -> str:
    return f"{BEGIN} return (sim.getConfigForTipPose(g, js, {arguments}))"


def find(world: ScriptWorld, arguments: str = "0.65, 1000") -> list[float] | None:
    return world.lua(call(arguments))[0]


class Looks:
    """Counts the states that are looked at, and the random starts."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.count = 0
        solve, sample = Solver.solve, Solver.sample

        def solved(solver: Solver, *arguments: Any) -> Solution:
            found = solve(solver, *arguments)
            self.count += found.looks
            return found

        def sampled(solver: Solver, *arguments: Any) -> tuple[np.ndarray, int, bool]:
            found = sample(solver, *arguments)
            self.count += found[1]
            return found

        monkeypatch.setattr(Solver, "solve", solved)
        monkeypatch.setattr(Solver, "sample", sampled)


def test_only_starts_whose_tip_is_near_the_target_are_tried(world: ScriptWorld) -> None:
    groups = world.parts.ik_groups
    group = groups.get(groups.find("arm"))
    joints, solver = groups.solver(group, [world.handle(f"j{number}") for number in range(1, 7)])
    goals, near = groups.goals(group), Nearness(0.3)
    tried = list[bool]()
    solve = solver.solve

    def noted(start: np.ndarray, *arguments: object) -> object:
        tried.append(near.includes(solver.tips(start), goals))
        return solve(start, *arguments)  # type: ignore[arg-type]

    solver.solve = noted  # type: ignore[method-assign, assignment]
    found = list(find_configs(solver, joints, goals, np.random.default_rng(0), seconds=0.5, near=near))
    assert found
    assert all(tried)


def test_a_threshold_that_no_start_meets_finds_nothing(world: ScriptWorld) -> None:
    assert find(world, "0.65, 1000") is not None
    assert find(world, "0.0, 100") is None


def test_the_metric_weights_the_differences(world: ScriptWorld) -> None:
    assert find(world, "0.0001, 1000, {0, 0, 0, 0}") is not None
    assert find(world, "0.3, 100, {0, 0, 0, 1000}") is None
    world.fails(call("0.65, 10, {1, 1, 1}"), "a metric is four numbers")


def test_starts_lie_in_the_given_ranges(world: ScriptWorld) -> None:
    low = ", ".join(str(value - 0.05) for value in BENT)
    found = find(world, f"9, 1000, nil, nil, nil, {{{low}}}, {{0.1, 0.1, 0.1, 0.1, 0.1, 0.1}}")
    assert found == pytest.approx(BENT, abs=0.3), "the solver finds the configuration beside these starts"


@pytest.mark.parametrize("threshold", ["0.65", "100"])
def test_a_search_for_a_pose_out_of_reach_ends_after_its_time_in_work(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch, threshold: str
) -> None:
    set_position(world.sim, world.handle("goal"), -1, [1.2, 0.0, 0.2])
    looks = Looks(monkeypatch)
    for _ in range(10):
        assert find(world, f"{threshold}, 10") is None
    # 10 ms are about 120 looks, or 600 random starts.
    assert 10 * 50 < looks.count < 10 * 700


def test_what_is_found_does_not_depend_on_the_clock(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    results = list[list[float] | None]()
    for pace in (0.0, 1e-4):
        world.parts.ik_groups.seed(0)
        ticks = count()
        monkeypatch.setattr(sampling, "monotonic", lambda pace=pace, ticks=ticks: pace * next(ticks))
        results += [find(world, "0.65, 10") for _ in range(8)]
    monkeypatch.undo()
    assert results[:8] == results[8:]
    assert {found is None for found in results} == {False, True}, "some searches end without a result"


def test_the_clock_ends_a_search_that_takes_many_times_as_long(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    ticks = count(step=100.0)
    monkeypatch.setattr(sampling, "monotonic", lambda: next(ticks))
    assert find(world, "0.65, 1000") is None


def test_equal_seeds_give_equal_configurations(world: ScriptWorld) -> None:
    first, same, other = (
        world.lua(f"simx.setSearchSeed({seed}) {call('0.65, 1000')}")[0] for seed in (7, 7, 8)
    )
    assert first is not None
    assert first == same != other
    world.fails("simx.setSearchSeed(-1)", "a seed is 0 or more, not -1")


def test_a_seed_holds_until_the_stop_or_for_all_later_runs(world: ScriptWorld) -> None:
    usual = find(world)
    world.lua("simx.setSearchSeed(5)")
    of_seed = find(world)

    def found_in_a_new_run() -> list[float] | None:
        world.sim.start()
        put(world, list(BENT))
        aim(world, (0.0, 0.05, -0.05))
        found = find(world)
        world.sim.stop()
        return found

    world.sim.stop()
    assert found_in_a_new_run() == usual != of_seed
    world.parts.ik_groups.seed(5)
    assert found_in_a_new_run() == of_seed
    assert found_in_a_new_run() == of_seed


def test_a_check_starts_where_the_scene_was_whatever_other_checks_have_tried(world: ScriptWorld) -> None:
    model, data, trials = world.sim.model, world.sim.data, Trials()
    one, other, positions = object(), object(), Snapshot(data)
    present = data.qpos.copy()
    trials.of(one, model, positions).qpos[:2] = 7.0, 8.0
    assert trials.of(one, model, positions).qpos[:2].tolist() == [7.0, 8.0]
    data.qpos[:] = 0.5  # the scene moves on
    assert trials.of(other, model, positions).qpos.tolist() == present.tolist()
    assert trials.of(one, model, positions).qpos.tolist() == present.tolist()
    newer = mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>")
    assert trials.of(one, newer, Snapshot(mujoco.MjData(newer))).qpos.size == 0


def test_checks_of_two_searches_at_once_do_not_disturb_each_other(world: ScriptWorld) -> None:
    groups, handles = world.parts.ik_groups, [world.handle(f"j{number}") for number in range(1, 7)]
    group = groups.get(groups.find("arm"))
    pairs = as_pairs([world.handle("link5"), world.handle("base")])
    all_joints, last = (groups.solver(group, some)[0] for some in (handles, handles[3:]))
    first, second = (of_joints(world.parts, joints, pairs) for joints in (all_joints, last))
    folded = np.array([0.0, 2.0, 2.6, -1.46, 0.0, 0.0])
    assert not first(folded)
    assert second(folded[3:]), "the other joints are where the scene has them"
    assert not first(folded)
