"""The compiled crew: threads that make the physics of several worlds, with the results of one world after the other."""

from __future__ import annotations

import gc
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import ARM, world_of

from simx_server.joints.native import loading
from simx_server.world.world import World

if loading.crew_form().module is None:
    pytest.skip(f"no compiled crews: {loading.crew_form().reason}", allow_module_level=True)

from simx_server.joints.native import _crew as compiled

COUNT = 5


def started(steps: int = 1) -> World:
    world = world_of(ARM)
    world.simulation.start()
    for _ in range(steps):
        world.step()
    return world


def course(world: World, reads: list[Any] | None = None, writes: list[Any] | None = None) -> Any:
    simulation, joints = world.simulation, world.simulation.joints
    block = world.velocities.copies.block
    assert block is not None
    step = joints.controllers.stepper.compiled
    assert step is not None
    made = compiled.Course(
        step, simulation.substeps, joints.controllers.stepper.own_flags, False, simulation.time_step,
        writes or [], [], reads or [], np.zeros((0, 7)), block,
    )  # fmt: skip
    newest = joints.measured.newest
    assert newest is not None
    made.begin(np.concatenate(newest), world.velocities.newest, False, False)
    return made


def state(world: World) -> tuple[bytes, ...]:
    data = world.simulation.data
    return tuple(each.tobytes() for each in (data.qpos, data.qvel, data.ctrl, data.xpos, data.qacc_warmstart))


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_a_step_of_all_is_that_of_each(threads: int) -> None:
    together, alone = (
        [started(number + 1) for number in range(COUNT)],
        [started(number + 1) for number in range(COUNT)],
    )
    crew = compiled.Crew(COUNT, threads)
    for place, world in enumerate(together):
        crew.put(place, course(world))
    rows, some = np.zeros((COUNT, 1)), np.array([0, 2, 3])
    for number in range(30):
        places = some if number % 3 == 0 else np.arange(COUNT)
        assert crew.step(places, rows, rows, 1) == []
        for place in places:
            alone[place].step()
    assert [state(world) for world in together] == [state(world) for world in alone]
    crew.close()
    assert crew.workers == 0
    assert crew.step(some, rows, rows, 1) == []  # by this thread alone


def test_physics_is_made_while_python_does_something_else() -> None:
    together, alone = [started() for _ in range(COUNT)], [started() for _ in range(COUNT)]
    crew = compiled.Crew(COUNT, 3)
    flags = 8 | together[0].simulation.joints.controllers.stepper.own_flags
    for place, world in enumerate(together):
        crew.put(place, course(world))
    for _ in range(10):
        found: list[int] = []
        for place in range(COUNT):
            crew.submit(place, flags)
            if (made := crew.next(1)) >= 0:
                found.append(made)
        while (made := crew.next(-1)) >= 0:
            found.append(made)
        assert sorted(found) == list(range(COUNT))
        for world in alone:
            world.step()
    assert [state(world) for world in together] == [state(world) for world in alone]


def test_a_restart_goes_back_to_what_was_captured() -> None:
    world = started()
    made = course(world)
    crew = compiled.Crew(1, 1)
    crew.put(0, made)
    one, rows = np.zeros(1, np.intp), np.zeros((1, 1))
    assert crew.restart(one, rows, rows) == [0]  # nothing is captured
    assert made.outcome == compiled.REFUSED
    made.capture()
    trajectories = []
    for _ in range(2):
        assert crew.restart(one, rows, rows) == []
        states = []
        for _ in range(5):
            assert crew.step(one, rows, rows, 2) == []
            states.append(state(world))
        trajectories.append(states)
    assert trajectories[0] == trajectories[1]
    assert (made.steps, made.all_steps, made.restarts) == (10, 20, 2)


def test_what_does_not_fit_the_model_is_refused() -> None:
    world = started()
    crew = compiled.Crew(2, 2)
    rows, none = np.zeros((2, 1)), (0, 0, 0, 0, 0.0, 0.0, 0.0)
    for kind in (compiled.POSITION, compiled.RATE, compiled.BODY_POSITION, compiled.VELOCITY, 99):
        with pytest.raises(IndexError, match="operation 0 has an index out of the model"):
            course(world, reads=[(kind, 10_000, *none)])
    for kind in (compiled.TARGET, compiled.COMMAND, compiled.FORCE, compiled.PLACE, -1):
        with pytest.raises(IndexError, match="operation 0 has an index out of the model"):
            course(world, writes=[(kind, 10_000, *none)])
    crew.put(0, course(world, reads=[(compiled.POSITION, 0, *none)] * 3))
    for places, values in ((np.array([0]), rows), (np.array([1]), np.zeros((2, 3))), (np.array([5]), rows)):
        with pytest.raises(ValueError, match="places are numbers that rise"):
            crew.step(places, values, values, 1)
    with pytest.raises(ValueError, match="a row of numbers for each place"):
        crew.step(np.array([0]), np.zeros(3), rows, 1)
    with pytest.raises(ValueError, match="this place has no course"):
        crew.submit(1, 0)
    with pytest.raises(ValueError, match="at least one place and one thread"):
        compiled.Crew(1, 0)
    with pytest.raises(TypeError, match="physics steps are needed"):
        compiled.Course(None, 1, 0, False, 0.1, [], [], [], np.zeros((0, 7)), np.zeros(1))  # type: ignore[arg-type]


def test_warnings_of_mujoco_come_in_the_log_as_without_a_crew(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "full.xml"
    boxes = "".join(f"<body pos='0 0 {z}'><freejoint/><geom size='0.1'/></body>" for z in range(1, 8))
    path.write_text(
        f"<mujoco><size memory='30K'/><worldbody><geom type='plane' size='1 1 1'/>{boxes}</worldbody></mujoco>"
    )
    logged: list[list[str]] = []
    for _ in range(2):
        caplog.clear()
        world = world_of(path)
        world.simulation.start()
        world.step()
        for joint in range(world.simulation.model.njnt):
            world.simulation.data.joint(joint).qpos[:3] = 0.01 * joint, 0.0, 0.05  # all of them in one place
        if logged:
            crew, full, rows = compiled.Crew(1, 1), course(world), np.zeros((1, 1))
            crew.put(0, full)
            assert crew.step(np.zeros(1, np.intp), rows, rows, 1) == []
            world.physics.finish(lambda: False, full.warnings)
        else:
            world.step()
        logged.append([record.getMessage() for record in caplog.records if "mujoco" in record.getMessage()])
    assert "Insufficient arena memory" in logged[0][0]
    assert logged[0] == logged[1]


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="needs /proc")
def test_a_crew_that_is_forgotten_ends_its_threads() -> None:
    before = len(os.listdir("/proc/self/task"))
    crew = compiled.Crew(1, 4)
    crew.put(0, course(started()))
    rows = np.zeros((1, 1))
    crew.step(np.zeros(1, np.intp), rows, rows, 1)
    assert crew.workers == 3
    assert len(os.listdir("/proc/self/task")) == before + 3
    del crew
    gc.collect()
    assert len(os.listdir("/proc/self/task")) == before
