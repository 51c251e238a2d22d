"""Start, pass, pause, stop: time, exact restore, repeatability, listeners, what may be done when."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import ARM, arm, run, simulation_of

from simx_server.errors import CommandError
from simx_server.parts.signals import Signals
from simx_server.scene.editing import editing
from simx_server.scene.formats.loader import SceneError
from simx_server.scene.geometry import frames
from simx_server.world.saved_state import editable_arrays, get_state
from simx_server.world.simulation import Simulation, SimulationState


def everything(sim: Simulation) -> dict[str, bytes | str]:
    """All that must be the same again after a stop."""
    found: dict[str, bytes | str] = {name: value.tobytes() for name, value in editable_arrays(sim.model)}
    found["state"] = get_state(sim.model, sim.data).tobytes()
    found["gravity"] = sim.model.opt.gravity.tobytes()
    found["parents"] = str({h: item.parent for h, item in sim.scene.objects.items()})
    found["joints"] = str({h: str(sim.joints.state(h)) for h in sim.scene.of_kind(1)})
    found["poses"] = str({h: frames.get_pose(sim, h) for h in sim.scene.objects})
    return found


def lively_run(sim: Simulation) -> list[object]:
    """Commands of every sort between passes; returns what was read."""
    resolve = sim.scene.resolve
    read: list[object] = []
    sim.start()
    sim.joints.set_target_position(resolve("shoulder"), 1.0)
    sim.advance()
    frames.set_position(sim, resolve("cube"), -1, [0.9, 0.1, 0.6])
    frames.set_orientation(sim, resolve("wall"), -1, [0.1, 0, 0.3])
    sim.joints.set_max_force(resolve("elbow"), 3)
    sim.joints.set_target_position(resolve("elbow"), -0.5)
    for _ in range(5):
        sim.advance()
        read += [sim.joints.force(resolve("elbow")), sim.measured_velocity(resolve("tip"))]
    sim.joints.set_parameter(resolve("elbow"), 2000, 0)
    sim.model.opt.gravity[2] = -3
    editing.set_parent(sim, resolve("wall"), resolve("lower"), True)
    sim.advance()
    editing.remove_object(sim, resolve("hand"))
    dummy = editing.create_dummy(sim, 0.1)
    for _ in range(3):
        sim.advance()
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
    sim = arm()
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [0.1, 1, 0.2])
    before, scene, model, data = everything(sim), sim.scene, sim.model, sim.data
    lively_run(sim)
    assert (sim.scene, sim.model, sim.data) == (scene, model, data)
    after = everything(sim)
    assert [name for name in before if before[name] != after[name]] == []


def test_same_calls_give_the_same_numbers_in_every_run() -> None:
    sim = arm()
    first = lively_run(sim)
    assert lively_run(sim) == first
    assert lively_run(arm()) == first


def test_one_long_step_call_equals_many_short_ones() -> None:
    """A scene without position controllers is stepped in one call; asking for forces must not change its course."""
    scene = ARM.replace("control=position", "control=velocity")
    plain, asked = simulation_of(scene), simulation_of(scene)
    for sim in (plain, asked):
        sim.joints.set_target_velocity(sim.scene.resolve("shoulder"), 0.7)
    run(plain, 1)
    asked.start()
    asked.joints.force(asked.scene.resolve("shoulder"))
    asked.advance()
    run(plain, 5)
    run(asked, 5)
    assert np.array_equal(get_state(plain.model, plain.data), get_state(asked.model, asked.data))


def test_time_counts_passes_and_is_zero_when_stopped() -> None:
    sim = arm()
    run(sim, 3)
    assert sim.time == 3 * 0.05
    assert sim.pass_count == 3
    assert sim.data.time == pytest.approx(0.15)
    sim.pause()
    sim.advance()
    assert sim.time == 3 * 0.05
    sim.stop()
    assert sim.time == 0


def test_physics_step_becomes_a_whole_fraction_of_the_pass() -> None:
    sim = arm()
    for step, substeps in ((0.01, 5), (0.025, 12), (0.001, 1)):
        sim.time_step = step
        assert sim.substeps == substeps
        assert sim.model.opt.timestep == pytest.approx(step / substeps)
        run(sim, 2)
        assert sim.data.time == pytest.approx(sim.time)
        with pytest.raises(CommandError, match="stop it first"):
            sim.time_step = 0.05
        sim.stop()
    with pytest.raises(CommandError, match="above 0"):
        sim.time_step = 0


def test_life_of_a_run_is_told_to_listeners_in_order() -> None:
    sim = arm()
    told: list[str] = []
    for name in (
        "on_start",
        "on_stop",
        "on_pause",
        "on_pass_begin",
        "on_sensing",
        "on_load",
        "on_close",
        "on_model_changed",
    ):
        getattr(sim, name).append(lambda name=name: told.append(name))
    sim.start()
    sim.start()
    sim.advance()
    sim.pause()
    sim.pause()
    sim.start()
    sim.advance()
    sim.stop()
    sim.stop()
    sim.close()
    assert told == ["on_start", "on_pass_begin", "on_sensing", "on_pause", "on_pass_begin", "on_sensing", "on_stop",
                    "on_close", "on_model_changed"]  # fmt: skip


def test_listener_that_stops_the_run_keeps_the_pass_from_happening() -> None:
    sim = arm()
    sim.on_pass_begin.append(sim.stop)
    run(sim, 1)
    assert sim.state is SimulationState.STOPPED
    assert sim.time == 0


def test_every_change_is_a_new_version() -> None:
    sim = arm()
    versions = [sim.version]
    for act in (
        sim.start,
        sim.advance,
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
    sim = Simulation()
    assert not sim.scene.objects
    run(sim, 2)
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
    assert not sim.scene.objects


def test_diverging_physics_stops_the_run_and_says_so(caplog: pytest.LogCaptureFixture) -> None:
    sim = arm()
    run(sim, 2)
    sim.data.qvel[:] = 1e12
    sim.advance()
    assert sim.state is SimulationState.STOPPED
    assert "the physics diverged at 0.100 s" in caplog.text
    assert np.all(np.isfinite(sim.data.qpos))
    run(sim, 1)
    assert sim.time == sim.time_step


def test_engine_warnings_do_not_touch_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    sim = arm()
    sim.start()
    sim.data.qvel[:] = math.inf
    sim.advance()
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
