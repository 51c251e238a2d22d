"""Start, pass, pause, stop: time, exact restore, repeatability, listeners, what may be done when."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from observing import observe
from scenes_for_tests import ARM, arm, run, world_of

from simx_server.errors import CommandError
from simx_server.joints.parameters import set_parameter
from simx_server.parts.communication.signals import Signals
from simx_server.scene.editing import editing
from simx_server.scene.editing.model_state import editable_arrays, get_state
from simx_server.scene.formats.loader import SceneError, load_text
from simx_server.scene.poses import frames
from simx_server.simulation.simulation import Simulation, SimulationState
from simx_server.world.world import World


def everything(sim: Simulation) -> dict[str, bytes | str]:
    """All that must be the same again after a stop."""
    found: dict[str, bytes | str] = {name: value.tobytes() for name, value in editable_arrays(sim.model)}
    found["state"] = get_state(sim.model, sim.data).tobytes()
    found["gravity"] = sim.model.opt.gravity.tobytes()
    found["parents"] = str({h: item.parent for h, item in sim.scene.objects.items()})
    found["joints"] = str({h: str(sim.joints.state(h)) for h in sim.scene.of_kind(1)})
    found["poses"] = str({h: frames.get_pose(sim, h) for h in sim.scene.objects})
    return found


def lively_run(world: World) -> list[object]:
    """Commands of every sort between passes; returns what was read."""
    sim = world.simulation
    resolve = sim.scene.resolve
    read: list[object] = []
    sim.start()
    sim.joints.set_target_position(resolve("shoulder"), 1.0)
    world.step()
    frames.set_position(sim, resolve("cube"), -1, [0.9, 0.1, 0.6])
    frames.set_orientation(sim, resolve("wall"), -1, [0.1, 0, 0.3])
    sim.joints.set_max_force(resolve("elbow"), 3)
    sim.joints.set_target_position(resolve("elbow"), -0.5)
    for _ in range(5):
        world.step()
        read += [sim.joints.force(resolve("elbow")), world.velocities.measure(resolve("tip"))]
    set_parameter(sim.joints, resolve("elbow"), 2000, 0)
    sim.model.opt.gravity[2] = -3
    editing.set_parent(sim, resolve("wall"), resolve("lower"), True)
    world.step()
    editing.remove_object(sim, resolve("hand"))
    dummy = editing.create_dummy(sim, 0.1)
    for _ in range(3):
        world.step()
    # Handles of what a run adds are not given again, so the name stands for the dummy here.
    read += [
        sim.scene.get(dummy).name,
        frames.get_pose(sim, resolve("tip")),
        frames.get_pose(sim, resolve("cube")),
        sim.time,
    ]
    read.append(get_state(sim.model, sim.data).tobytes())
    sim.stop()
    return read


def test_stop_restores_everything_bit_for_bit() -> None:
    world = arm()
    sim = world.simulation
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [0.1, 1, 0.2])
    before, scene, model, data = everything(sim), sim.scene, sim.model, sim.data
    lively_run(world)
    assert (sim.scene, sim.model, sim.data) == (scene, model, data)
    after = everything(sim)
    assert [name for name in before if before[name] != after[name]] == []


def test_same_calls_give_the_same_numbers_in_every_run() -> None:
    world = arm()
    first = lively_run(world)
    assert lively_run(world) == first
    assert lively_run(arm()) == first


def test_one_long_step_call_equals_many_short_ones() -> None:
    """A scene without position controllers is stepped in one call; asking for forces must not change its course."""
    scene = ARM.replace("control=position", "control=velocity")
    plain, asked = world_of(scene), world_of(scene)
    for world in (plain, asked):
        world.simulation.joints.set_target_velocity(world.simulation.scene.resolve("shoulder"), 0.7)
    run(plain, 1)
    asked.simulation.start()
    asked.simulation.joints.force(asked.simulation.scene.resolve("shoulder"))
    asked.step()
    run(plain, 5)
    run(asked, 5)
    assert np.array_equal(
        get_state(plain.simulation.model, plain.simulation.data),
        get_state(asked.simulation.model, asked.simulation.data),
    )


def test_time_counts_passes_and_is_zero_when_stopped() -> None:
    world = arm()
    sim = world.simulation
    run(world, 3)
    assert sim.time == 3 * 0.05
    assert sim.step_count == 3
    assert sim.data.time == pytest.approx(0.15)
    sim.pause()
    world.step()
    assert sim.time == 3 * 0.05
    sim.stop()
    assert sim.time == 0


def test_physics_step_becomes_a_whole_fraction_of_the_simulation_step() -> None:
    world = arm()
    sim = world.simulation
    for step, substeps in ((0.01, 5), (0.025, 12), (0.001, 1)):
        sim.time_step = step
        assert sim.substeps == substeps
        assert sim.model.opt.timestep == pytest.approx(step / substeps)
        run(world, 2)
        assert sim.data.time == pytest.approx(sim.time)
        with pytest.raises(CommandError, match="stop it first"):
            sim.time_step = 0.05
        sim.stop()
    with pytest.raises(CommandError, match="above 0"):
        sim.time_step = 0


EVENTS = (
    "run_starting", "run_started", "run_paused", "run_resumed", "run_ending", "run_stopping", "run_stopped",
    "scene_closing", "scene_changed", "scene_loaded", "step_finished",
)  # fmt: skip


def told_by(sim: Simulation) -> list[str]:
    """The names of all that happens from now on, in order."""
    told: list[str] = []
    events = {name: lambda name=name: told.append(name) for name in EVENTS}
    observe(sim, **events, model_changed=lambda twins: told.append("model_changed"))
    return told


def test_life_of_a_run_is_told_to_parts_in_order() -> None:
    world = arm()
    sim = world.simulation
    told = told_by(sim)
    sim.start()
    sim.start()
    world.step()
    sim.pause()
    sim.pause()
    sim.start()
    world.step()
    sim.stop()
    sim.stop()
    sim.close()
    assert told == [
        "run_starting", "run_started", "step_finished", "run_paused", "run_resumed", "step_finished",
        "run_ending", "run_stopping", "run_stopped", "scene_closing", "scene_changed", "scene_loaded", "model_changed",
    ]  # fmt: skip
    told.clear()
    sim.use(*load_text(ARM))
    assert told == ["scene_closing", "scene_changed", "scene_loaded", "model_changed"]


def test_the_stages_of_a_step_are_made_in_order_and_none_after_a_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[str] = []
    names = [name for name, _ in World.STEP]
    stages = tuple((name, lambda _, name=name: partial(made.append, name)) for name in names)
    monkeypatch.setattr(World, "STEP", stages)
    run(arm(), 1)
    assert made == names
    middle = len(names) // 2
    stopping = (names[middle], lambda world: world.simulation.stop)
    monkeypatch.setattr(World, "STEP", (*stages[:middle], stopping, *stages[middle + 1 :]))
    made.clear()
    run(arm(), 1)
    assert made == names[:middle]


def test_a_run_that_is_stopped_before_its_physics_makes_no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    first, *others = World.STEP
    stopping = (first[0], lambda world: world.simulation.stop)
    monkeypatch.setattr(World, "STEP", (stopping, *others))
    world = arm()
    sim = world.simulation
    run(world, 1)
    assert sim.state is SimulationState.STOPPED
    assert sim.time == 0


def test_every_change_is_a_new_version() -> None:
    world = arm()
    sim = world.simulation
    versions = [sim.version]
    for act in (
        sim.start,
        world.step,
        lambda: frames.set_position(sim, 1, -1, [0, 0, 1]),
        lambda: sim.joints.set_position(sim.scene.resolve("elbow"), 0.1),
        sim.stop,
        sim.close,
    ):
        act()
        versions.append(sim.version)
    assert versions == sorted(versions)
    assert len(set(versions[1:])) == len(versions) - 1


def test_scene_is_loaded_and_closed_only_while_stopped(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    world = world_of("<mujoco/>")
    sim = world.simulation
    sim.close()
    assert sim.scene.name == "default"
    run(world, 2)
    with pytest.raises(CommandError, match="only while the simulation is stopped"):
        sim.load(file)
    with pytest.raises(CommandError, match="only while the simulation is stopped"):
        sim.close()
    sim.stop()
    sim.load(file)
    assert sim.scene.name == "arm"
    with pytest.raises(SceneError):
        sim.load(tmp_path / "missing.xml")
    assert sim.scene.name == "arm"
    sim.close()
    assert sim.scene.name == "default"


def test_diverging_physics_stops_the_run_and_says_so(caplog: pytest.LogCaptureFixture) -> None:
    world = arm()
    sim = world.simulation
    run(world, 2)
    sim.data.qvel[:] = 1e12
    world.step()
    assert sim.state is SimulationState.STOPPED
    assert "the physics diverged at 0.100 s" in caplog.text
    assert np.all(np.isfinite(sim.data.qpos))
    run(world, 1)
    assert sim.time == sim.time_step


def test_engine_warnings_do_not_touch_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    world = arm()
    sim = world.simulation
    sim.start()
    sim.data.qvel[:] = math.inf
    world.step()
    assert list(tmp_path.iterdir()) == []


def test_signals_stay_until_cleared_or_until_their_owner_goes() -> None:
    signals = Signals(Simulation())
    signals.set_integer("grip", 1)
    signals.set_integer("mine", 2, owner="script")
    signals.set_float("speed", 0.5, owner="script")
    signals.append_string("log", b"a")
    signals.append_string("log", b"b")
    signals.set_float("speed", 0.7)  # taken over by a client
    signals.clear_owned("script")
    assert (signals.get_integer("grip"), signals.get_integer("mine"), signals.get_float("speed")) == (
        1,
        None,
        0.7,
    )
    assert signals.take_string("log") == b"ab"
    assert signals.get_string("log") is None
    signals.set_integer("other", 3)
    signals.clear_integer("grip")
    assert signals.integers == {"other": 3}
    signals.clear_integer("")
    assert signals.integers == {}
