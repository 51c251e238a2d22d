"""Physics that goes wrong, or takes too long, ends in a sentence; the server goes on."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
from handler_calls import World
from observing import observe

from simx_server.errors import CommandError
from simx_server.handlers.quantities.engine import find
from simx_server.joints.guards import watch
from simx_server.joints.native.loading import VARIABLE
from simx_server.limits import LimitReached, Limits
from simx_server.scene import physics_warnings
from simx_server.scene.formats.loader import SceneError
from simx_server.simulation.simulation import SimulationState

FALLING = """
<mujoco>
  <option timestep="{timestep}"/>
  <worldbody><body name="ball"><freejoint/><geom size="0.1" mass="1"/></body></worldbody>
</mujoco>
"""
MOTOR = """
<mujoco>
  <worldbody><body name="arm"><joint name="hinge"/><geom size="0.1" mass="1" pos="1 0 0"/></body></worldbody>
  <actuator><general name="drive" joint="hinge"/></actuator>
</mujoco>
"""


def falling(timestep: float = 0.002) -> World:
    return World(FALLING.format(timestep=timestep))


def count_steps(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many physics steps each call of MuJoCo makes from now on, all of them in Python."""
    monkeypatch.setenv(VARIABLE, "python")
    made: list[int] = []
    step = mujoco.mj_step

    def counted(model: mujoco.MjModel, data: mujoco.MjData, count: int = 1) -> None:
        made.append(count)
        step(model, data, count)

    monkeypatch.setattr(mujoco, "mj_step", counted)
    return made


# --- divergence -----------------------------------------------------------------------------------


@pytest.mark.parametrize("has_controller", [False, True], ids=["free", "with a controller"])
def test_what_diverges_is_noticed_within_the_simulation_step_and_told_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, has_controller: bool
) -> None:
    world = World(MOTOR) if has_controller else falling()
    if has_controller:
        world.call("simxSetJointTargetPosition", world.handle("hinge"), 0.5)
        world.call("simxSetObjectIntParameter", world.handle("hinge"), 2001, 1)
    world.sim.time_step = 10.0  # 5000 physics steps
    told: list[str] = []
    observe(world.sim, script_stopped=told.append)
    made = count_steps(monkeypatch)
    world.sim.start()
    world.sim.data.qvel[0] = math.nan
    with caplog.at_level(logging.WARNING):
        world.parts.step()
    assert world.sim.state is SimulationState.STOPPED
    assert sum(made) <= watch.MOST_AT_ONCE
    assert [record.levelname for record in caplog.records] == ["WARNING", "ERROR"]
    assert caplog.records[1].message == "the physics diverged at 0.000 s; the simulation is stopped"
    assert told == [f"{caplog.records[1].message}; {watch.DIVERGED.partition('; ')[2]}"]
    world.run(1)
    assert np.isfinite(world.sim.data.qpos).all()


def test_divergence_is_noticed_in_each_run(caplog: pytest.LogCaptureFixture) -> None:
    world = falling()
    for _ in range(3):
        world.sim.start()
        world.sim.data.qpos[0] = math.inf
        world.parts.step()
        assert not world.sim.is_running


def test_one_line_a_kind_and_none_in_a_file_of_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    physics_warnings.listen()
    model = mujoco.MjModel.from_xml_string(FALLING.format(timestep=0.002))
    model.body_mass[1] = math.nan
    for _ in range(2):
        caplog.clear()
        data = mujoco.MjData(model)
        with physics_warnings.OnceAKind():
            mujoco.mj_step(model, data, 50)
        assert [record.message[:33] for record in caplog.records] == [
            f"mujoco: Nan, Inf or huge value in {what}"[:33] for what in ("QACC", "QPOS")
        ]
        assert "QACC" in caplog.text
        assert "QPOS" in caplog.text
    caplog.clear()
    mujoco.mj_step(model, data, 5)
    assert len(caplog.records) > 2  # as many as without it
    assert not list(tmp_path.iterdir())


def test_an_error_of_mujocos_within_a_step_stops_the_run_with_its_text(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(VARIABLE, "python")
    world = falling()
    world.run(2)
    height = world.sim.data.qpos[2]

    def fails(*_: object) -> None:
        raise mujoco.FatalError("mj_stackAlloc:\nout of memory")

    with monkeypatch.context() as broken:
        broken.setattr(mujoco, "mj_step", fails)
        world.parts.step()
    assert not world.sim.is_running
    assert "MuJoCo cannot go on: mj_stackAlloc: out of memory at 0.100 s" in caplog.text
    assert "Traceback" not in caplog.text
    world.run(2)
    assert world.sim.data.qpos[2] == height


def test_a_scene_without_the_memory_for_its_contacts_is_stopped_and_can_be_started_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A real error within `mj_step`, that leaves MuJoCo's stack half used."""
    balls = "".join(
        f"<body name='b{i}' pos='0 {i * 0.15} {1 + i % 2}'><freejoint/><geom size='0.1'/></body>"
        for i in range(40)
    )
    world = World(
        f"<mujoco><size memory='40K'/><worldbody><geom type='plane' size='9 9 1'/>{balls}</worldbody></mujoco>"
    )
    for _ in range(2):
        caplog.clear()
        world.run(40)
        assert not world.sim.is_running
        assert "MuJoCo cannot go on" in caplog.text


# --- steps that last too long ---------------------------------------------------------------------


def test_a_scene_with_too_many_physics_steps_is_refused_and_the_present_one_stays(tmp_path: Path) -> None:
    world = falling()
    scene = world.sim.scene
    path = tmp_path / "tiny.xml"
    path.write_text(FALLING.format(timestep=1e-9))
    with pytest.raises(LimitReached, match=r"1e-09 s has 50000000; choose .* --limit substeps=N"):
        world.sim.load(path)
    assert world.sim.scene is scene
    path.write_text(FALLING.format(timestep=5e-324))
    with pytest.raises(LimitReached):
        world.sim.load(path)
    world.run(1)


def test_a_time_step_with_too_many_physics_steps_is_refused() -> None:
    world = falling(timestep=1e-4)
    with pytest.raises(LimitReached, match="at most 10000 physics steps"):
        world.call("simxSetFloatingParameter", 1, 10.0)
    assert world.sim.time_step == 0.05
    world.sim.limits = Limits(substeps=100_000)
    world.call("simxSetFloatingParameter", 1, 10.0)
    assert world.sim.substeps == 100_000


def test_a_scene_that_mujoco_cannot_simulate_is_refused_and_the_present_one_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = falling()
    scene = world.sim.scene
    path = tmp_path / "other.xml"
    path.write_text(MOTOR)

    def fails(*_: object) -> None:
        raise mujoco.FatalError("mj_stackAlloc: out of memory")

    with monkeypatch.context() as broken:
        broken.setattr(mujoco, "mj_forward", fails)
        with pytest.raises(CommandError, match="cannot be simulated: mj_stackAlloc"):
            world.sim.load(path)
    assert world.sim.scene is scene
    world.run(1)


def test_within_a_long_simulation_step_others_are_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "SERVES_AFTER", 0.0)
    monkeypatch.setattr(watch, "GLANCE", 0.0)
    world = falling(timestep=1e-4)
    world.sim.time_step = 0.2
    served: list[float] = []
    world.sim.interruptions.serve_others = lambda: served.append(world.sim.data.time)
    world.run(1)
    assert len(served) >= 2000 // watch.MOST_AT_ONCE - 1
    assert served == sorted(set(served))
    assert world.sim.data.time == pytest.approx(0.2)


def test_a_usual_simulation_step_serves_nobody() -> None:
    world = falling()
    served: list[bool] = []
    world.sim.interruptions.serve_others = lambda: served.append(True)
    world.run(3)
    assert not served


def test_a_simulation_step_that_never_ends_stops_the_run(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(watch, "LONGEST", 0.0)
    monkeypatch.setattr(watch, "SERVES_AFTER", 0.0)
    monkeypatch.setattr(watch, "GLANCE", 0.0)
    world = falling(timestep=1e-5)
    world.run(1)
    assert not world.sim.is_running
    assert "5000 physics steps, and not all were made within 0 s at 0.000 s" in caplog.text


def test_the_end_of_the_server_ends_a_long_simulation_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "CUT_AFTER", 0.0)
    monkeypatch.setattr(watch, "SERVES_AFTER", 0.0)
    monkeypatch.setattr(watch, "GLANCE", 0.0)
    world = falling(timestep=1e-4)
    world.sim.is_ending = True
    world.run(1)
    assert not world.sim.is_running


def test_a_slow_simulation_step_is_warned_of_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(watch, "WARNS_AFTER", 0.0)
    monkeypatch.setattr(watch, "TOO_LONG", 0.0)
    monkeypatch.setattr(watch, "SERVES_AFTER", 0.0)
    monkeypatch.setattr(watch, "GLANCE", 0.0)
    world = falling(timestep=1e-5)
    world.run(2)
    assert caplog.text.count("a simulation step of 0.05 s has 5000 physics steps") == 1


def test_steps_in_pieces_are_the_same_numbers() -> None:
    """For any duration of the pieces by the clock."""
    world = falling()
    world.sim.time_step = 1.0
    world.run(2)
    model = mujoco.MjModel.from_xml_string(FALLING.format(timestep=0.002))
    model.opt.integrator = world.sim.model.opt.integrator
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mj_step(model, data, 1000)
    assert data.qpos.tolist() == world.sim.data.qpos.tolist()


def test_a_recording_knows_between_which_physics_steps_others_were_served(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The clock says whether; where it may be does not depend on it."""
    monkeypatch.setattr(watch, "SERVES_AFTER", 0.0)
    world, told = falling(), []
    world.sim.interruptions.physics_point = lambda: told.append(("point", round(world.sim.data.time, 3)))
    world.sim.interruptions.serve_others = lambda: told.append(("serve", round(world.sim.data.time, 3)))
    world.run(1)
    assert told == [(what, time) for time in (0.016, 0.032, 0.048) for what in ("serve", "point")]


def test_solvers_make_no_endless_iterations(tmp_path: Path) -> None:
    world = falling()
    path = tmp_path / "endless.xml"
    path.write_text("<mujoco><option iterations='2000000000' tolerance='0' solver='PGS'/></mujoco>")
    with pytest.raises(SceneError, match="option iterations is 2000000000; at most 10000 are valid"):
        world.sim.load(path)
    with pytest.raises(CommandError, match="must not be above 10000"):
        set_parameter(38002, world, 2_000_000_000)


def set_parameter(number: int, world: World, value: float) -> None:
    put = find(number, is_integer=True).set
    assert put is not None
    put(world.parts, -1, value)


@pytest.mark.parametrize("has_controller", [False, True], ids=["free", "with a controller"])
def test_a_run_is_stopped_after_a_physics_step_that_worked_for_too_long(
    monkeypatch: pytest.MonkeyPatch, has_controller: bool
) -> None:
    world, told = World(MOTOR) if has_controller else falling(), []
    observe(world.sim, script_stopped=told.append)
    worked, clock = [0.0], [0.0]
    step = mujoco.mj_step

    def long_step(model: mujoco.MjModel, data: mujoco.MjData, count: int = 1) -> None:
        step(model, data, count)
        worked[0] += work * count
        clock[0] += 3.0 * count

    monkeypatch.setenv(VARIABLE, "python")
    monkeypatch.setattr(mujoco, "mj_step", long_step)
    monkeypatch.setattr(watch.time, "thread_time", lambda: worked[0])
    monkeypatch.setattr(watch.time, "perf_counter", lambda: clock[0])
    work = 0.5  # the process was stopped meanwhile
    world.run(1)
    assert world.sim.state is SimulationState.RUNNING
    work = 3.0
    world.parts.step()
    assert world.sim.state is SimulationState.STOPPED
    assert told[0].startswith("a physics step took 3.0 s of processor time at ")
    assert "--limit step_seconds=N" in told[0]
