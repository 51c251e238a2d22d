"""The solver's work is foreseen: another solver is used, or the step is not started, as the state alone decides."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from handler_calls import World
from observing import observe

from simx_server.errors import CommandError
from simx_server.joints.guards import foresight
from simx_server.joints.guards.foresight import factor_work, has_much_work
from simx_server.limits import Limits
from simx_server.simulation.simulation import SimulationState

NEWTON, CG = int(mujoco.mjtSolver.mjSOL_NEWTON), int(mujoco.mjtSolver.mjSOL_CG)


def cubes(count: int, gap: float, columns: int = 10) -> str:
    bodies = "".join(
        f'<body name="b{n}" pos="{gap * (n % columns)} {gap * (n // columns)} 0.05">'
        '<freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>'
        for n in range(count)
    )
    return (
        '<mujoco><option timestep="0.01" integrator="implicitfast"/><worldbody>'
        f'<geom type="plane" size="5 5 0.1"/>{bodies}</worldbody></mujoco>'
    )


def at_first_half(xml: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_step1(model, data)
    return model, data


def multiplications(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Of a factorization from the last row to the first, in which every number that may be other than 0 is."""
    pattern = np.eye(model.ntree, dtype=bool)
    for one, other in model.geom_bodyid[data.contact.geom] - 1:  # each body but the world is a tree
        if one >= 0 and other >= 0:
            pattern[one, other] = pattern[other, one] = True
    work = 0.0
    for tree in reversed(range(model.ntree)):
        row = pattern[tree, : tree + 1]
        work += 6 * (6.0 * row.sum()) ** 2
        pattern[: tree + 1, : tree + 1] |= np.outer(row, row)
    return work


@pytest.mark.parametrize(("gap", "columns"), [(0.099, 5), (0.06, 4), (0.3, 5)])
def test_the_work_is_counted_exactly(gap: float, columns: int) -> None:
    model, data = at_first_half(cubes(23, gap, columns))
    assert mujoco.mj_isSparse(model)
    assert factor_work(model, data) == multiplications(model, data)


def test_shapes_that_lie_apart_have_little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(foresight, "MOST_WORK", 1e4)
    assert not has_much_work(*at_first_half(cubes(23, 0.3)))
    assert has_much_work(*at_first_half(cubes(23, 0.09)))


@pytest.fixture
def pile(monkeypatch: pytest.MonkeyPatch) -> World:
    """A small scene that counts as a large one."""
    monkeypatch.setattr(foresight, "FEWEST_DOFS", 60)
    monkeypatch.setattr(foresight, "MOST_WORK", 1e4)
    return World(cubes(23, 0.09))


def test_such_steps_are_solved_by_conjugate_gradients_and_the_scene_keeps_its_solver(
    pile: World, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    used: list[int] = []
    second_half = mujoco.mj_step2

    def step2(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        used.append(int(model.opt.solver))
        second_half(model, data)

    monkeypatch.setattr(mujoco, "mj_step2", step2)
    pile.sim.start()
    pile.parts.step()
    assert used == [CG] * 5
    assert pile.sim.model.opt.solver == NEWTON
    assert caplog.text.count("conjugate gradients solve such steps") == 1
    for number in range(23):
        pile.call("simxSetObjectPosition", pile.handle(f"b{number}"), -1, [0.3 * number, 0.0, 0.05])
    used.clear()
    pile.parts.step()
    assert used == [NEWTON] * 5


def test_steps_that_are_only_watched_are_the_same_bit_for_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    def run() -> bytes:
        world = World(cubes(23, 0.09))
        world.sim.start()
        for _ in range(5):
            world.parts.step()
        return world.sim.data.qpos.tobytes() + world.sim.data.qvel.tobytes()

    plain = run()
    monkeypatch.setattr(foresight, "FEWEST_DOFS", 60)
    assert run() == plain
    monkeypatch.setattr(foresight, "MOST_WORK", 1e4)
    assert run() != plain


def test_a_step_that_no_solver_makes_in_time_is_not_begun_and_not_tried_again_at_once(
    pile: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mujoco, "mj_step2", lambda *_: pytest.fail("the step was begun"))
    monkeypatch.setattr(foresight, "PER_SECOND", 1.0)
    pile.sim.limits, told = Limits(step_seconds=3), []
    observe(pile.sim, script_stopped=told.append)
    pile.sim.start()
    pile.parts.step()
    assert pile.sim.state is SimulationState.STOPPED
    assert "constraints would take about" in told[0]
    assert "--limit step_seconds=N" in told[0]
    with pytest.raises(
        CommandError, match="is not started, because nothing has changed since a physics step"
    ):
        pile.sim.start()
    pile.call("simxSetObjectPosition", pile.handle("b0"), -1, [0.0, 0.0, 2.0])
    pile.sim.start()
    assert pile.sim.state is SimulationState.RUNNING


def test_a_scene_in_which_everything_overlaps_is_loaded_without_a_long_step(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(foresight, "FEWEST_DOFS", 60)
    monkeypatch.setattr(foresight, "MOST_WORK", 1e4)
    monkeypatch.setattr(foresight, "PER_SECOND", 1.0)
    world = World(cubes(23, 0.09))
    assert "the forces in this state are not known" in caplog.text
    assert world.sim.model.opt.solver == NEWTON
    assert world.sim.data.ncon > 100
