"""Start, stop, scenes, status bar and the simulator's parameters."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import pytest
from handler_calls import World

from simx_server.errors import CommandError
from simx_server.parts.status_bar import KEPT
from simx_server.service.clock import Pacer
from simx_server.simulation.simulation import SimulationState

TINY = '<mujoco><worldbody><body name="thing"><geom size="1"/></body></worldbody></mujoco>'


@pytest.fixture
def world(tmp_path: Path) -> World:
    folder = tmp_path / "workspace"
    folder.mkdir()
    (folder / "tiny.xml").write_text(TINY, encoding="utf-8")
    (tmp_path / "outside.xml").write_text(TINY, encoding="utf-8")
    return World(workspace=folder)


def test_start_pause_resume_stop(world: World) -> None:
    world.call("simxPauseSimulation")
    assert world.sim.state is SimulationState.STOPPED
    for command, state in (
        ("simxStartSimulation", SimulationState.RUNNING),
        ("simxStartSimulation", SimulationState.RUNNING),
        ("simxPauseSimulation", SimulationState.PAUSED),
        ("simxStartSimulation", SimulationState.RUNNING),
        ("simxStopSimulation", SimulationState.STOPPED),
        ("simxStopSimulation", SimulationState.STOPPED),
    ):
        world.call(command)
        assert world.sim.state is state
    assert world.call("simxGetIntegerParameter", 29) == 1  # a stop while stopped is none


def test_scene_is_loaded_from_the_workspace_while_stopped(world: World) -> None:
    world.call("simxLoadScene", "tiny.xml", 0)
    assert world.handle("thing") == 1
    world.call("simxLoadScene", "tiny.ttt", 0)
    assert world.call("simxGetStringParameter", 13).endswith("tiny.xml")
    world.run()
    for name, *arguments in (("simxLoadScene", "tiny.xml", 0), ("simxCloseScene",)):
        with pytest.raises(CommandError, match="stop it first"):
            world.call(name, *arguments)
    world.call("simxStopSimulation")
    world.call("simxCloseScene")
    assert world.handle("ResizableFloor_5_25")
    assert world.sim.scene.by_name("thing") is None


def test_shipped_scene_is_found_by_name(world: World) -> None:
    world.call("simxLoadScene", "ur5_rg2_kinect", 0)
    assert world.handle("UR5") > 0


def test_scene_outside_the_workspace_or_missing_or_on_the_client_is_refused(
    world: World, tmp_path: Path
) -> None:
    for path in (str(tmp_path / "outside.xml"), "../outside.xml"):
        with pytest.raises(CommandError, match=r"workspace|no scene"):
            world.call("simxLoadScene", path, 0)
    with pytest.raises(CommandError, match="shipped scenes"):
        world.call("simxLoadScene", "nowhere.ttt", 0)
    with pytest.raises(CommandError, match="has not sent"):
        world.call("simxLoadScene", "tiny.xml", 1)


def test_status_bar_keeps_the_newest_and_logs(world: World, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "simx_server.parts.status_bar"):
        world.call("simxAddStatusbarMessage", "Hello \u4f60\nworld\x1b[0m")
    assert caplog.messages == ["Hello \u4f60 world [0m"]
    assert world.parts.status_bar.messages[-1] == "Hello \u4f60\nworld\x1b[0m"
    for number in range(KEPT + 5):
        world.parts.status_bar.add(str(number))
    assert len(world.parts.status_bar.messages) == KEPT
    assert world.parts.status_bar.messages[-1] == str(KEPT + 4)


def test_time_step_is_set_while_stopped_and_left_alone_while_running(world: World) -> None:
    assert world.call("simxGetFloatingParameter", 1) == 0.05
    world.call("simxSetFloatingParameter", 1, 0.009999999776482582)
    assert world.call("simxGetFloatingParameter", 1) == 0.01
    world.run()
    world.call("simxSetFloatParam", 1, 0.05)
    assert world.call("simxGetFloatParam", 1) == 0.01
    world.call("simxStopSimulation")
    with pytest.raises(CommandError):
        world.call("simxSetFloatingParameter", 1, -1.0)


def test_gravity_is_read_set_and_acts(world: World) -> None:
    world.call("simxLoadScene", "tiny.xml", 0)
    assert world.call("simxGetArrayParameter", 0) == pytest.approx([0, 0, -9.81])
    world.call("simxSetArrayParameter", 0, [0.0, 0.0, 1.0])
    assert world.call("simxGetArrayParameter", 0) == [0, 0, 1]
    assert world.sim.model.opt.gravity[2] == 1


def test_window_switches_read_off_and_stay_off(world: World) -> None:
    for number in (0, 1, 12, 16):
        world.call("simxSetBooleanParameter", number, False)
        assert world.call("simxGetBooleanParameter", number) is False
        with pytest.raises(CommandError, match="window"):
            world.call("simxSetBooleanParameter", number, True)
    assert world.call("simxGetBoolParam", 34) is True
    with pytest.raises(CommandError):
        world.call("simxSetBoolParam", 34, False)


def test_real_time_switch_changes_the_pace_while_stopped(world: World) -> None:
    pace = Pacer(1.0)
    world.parts.parameters.pace = pace
    assert world.call("simxGetBooleanParameter", 25) is True
    world.call("simxSetBooleanParameter", 25, False)
    assert math.isinf(pace.speed)
    world.run()
    world.call("simxSetBooleanParameter", 25, True)
    assert world.call("simxGetBooleanParameter", 25) is False


def test_waiting_for_trigger_is_what_the_engine_says(world: World) -> None:
    assert world.call("simxGetBooleanParameter", 45) is False
    world.parts.parameters.is_waiting_for_trigger = lambda: True
    assert world.call("simxGetBooleanParameter", 45) is True


def test_unknown_parameter_lists_the_known_ones(world: World) -> None:
    for kind in ("Boolean", "Integer", "Floating", "String", "Array"):
        with pytest.raises(CommandError, match=r"cannot be read; those that can: \d"):
            world.call(f"simxGet{kind}Parameter", 4711)
    for kind, value in (("Boolean", True), ("Integer", 1), ("Floating", 1.0), ("Array", [0.0, 0.0, 0.0])):
        with pytest.raises(CommandError, match=r"cannot be set; those that can: \d"):
            world.call(f"simxSet{kind}Parameter", 4711, value)


def test_random_parameters_are_numbers_that_repeat_in_the_next_server(world: World) -> None:
    assert 0 <= world.call("simxGetFloatingParameter", 0) <= 1
    alpha, beta, gamma = world.call("simxGetArrayParameter", 6)
    assert max(abs(alpha), abs(gamma)) <= math.pi
    assert abs(beta) <= math.pi / 2
    other = World()
    other.call("simxGetFloatingParameter", 0)
    assert other.call("simxGetArrayParameter", 6) == [alpha, beta, gamma]


def test_version_engine_and_platform_are_told(world: World) -> None:
    assert world.call("simxGetIntegerParameter", 1) == 30602
    assert world.call("simxGetInt32Param", 8) == 4
    with pytest.raises(CommandError, match="MuJoCo"):
        world.call("simxSetIntegerParameter", 8, 2)
    before = world.call("simxGetIntegerParameter", 20)
    world.call("simxCloseScene")
    assert world.call("simxGetIntegerParameter", 20) == before + 1
