"""Start, pause, stop, load and close (the reference's 3.2)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from conforming import BLOCKING, OK, ONESHOT, REMOTE_ERROR, SCENE, of

import simx_client as v
from simx_server.simulation.simulation import SimulationState


@of("simxStartSimulation")
def test_start_starts_resumes_and_may_be_repeated(world: Any, cid: int, simx: Any) -> None:
    assert simx(cid, BLOCKING) == OK
    assert world.simulation.state is SimulationState.RUNNING
    assert simx(cid, BLOCKING) == OK
    v.simxPauseSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == OK
    assert world.simulation.state is SimulationState.RUNNING


@of("simxPauseSimulation")
def test_pause_holds_time_and_is_success_when_nothing_runs(world: Any, cid: int, simx: Any) -> None:
    assert simx(cid, BLOCKING) == OK
    assert world.simulation.state is SimulationState.STOPPED
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == OK
    passes = world.simulation.step_count
    v.simxGetPingTime(cid)
    assert world.simulation.step_count == passes


@of("simxStopSimulation")
def test_stop_gives_back_the_state_of_the_start_at_once(world: Any, cid: int, simx: Any, handle: Any) -> None:
    falling, elbow, lid = handle("falling"), handle("elbow"), handle("lid")
    assert simx(cid, BLOCKING) == OK, "already stopped"
    v.simxStartSimulation(cid, BLOCKING)
    v.simxSetJointTargetPosition(cid, elbow, 1.0, BLOCKING)
    v.simxSetObjectParent(cid, lid, handle("target"), True, BLOCKING)
    v.simxSetObjectPosition(cid, lid, -1, [0, 0, 9], BLOCKING)
    for _ in range(10):
        world.loop.turn()
    assert v.simxGetObjectPosition(cid, falling, -1, BLOCKING)[1][2] < 50
    assert simx(cid, BLOCKING) == OK
    assert v.simxGetObjectPosition(cid, falling, -1, BLOCKING) == (OK, [2.0, 1.0, 50.0])
    assert v.simxGetJointPosition(cid, elbow, BLOCKING) == (OK, 0.0)
    assert v.simxGetObjectParent(cid, lid, BLOCKING) == (OK, handle("crate"))
    assert v.simxGetObjectPosition(cid, lid, -1, BLOCKING)[1] == pytest.approx([-2, -3, 0.65], abs=1e-6)
    assert v.simxGetLastCmdTime(cid) == 0
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state)[1] & 1 == 0


@of("simxStopSimulation")
def test_only_the_stop_of_a_run_counts_as_a_request_and_ends_stepped_mode(
    world: Any, cid: int, simx: Any
) -> None:
    def requests() -> int:
        return v.simxGetIntegerParameter(cid, v.sim_intparam_stop_request_counter, BLOCKING)[1]

    before = requests()
    v.simxSynchronous(cid, True)
    assert simx(cid, BLOCKING) == OK
    assert requests() == before, "it was stopped already"
    v.simxStartSimulation(cid, BLOCKING)
    assert v.simxSynchronousTrigger(cid) == OK, "stepped mode is still on"
    assert simx(cid, BLOCKING) == OK
    assert requests() == before + 1
    v.simxStartSimulation(cid, BLOCKING)
    assert v.simxSynchronousTrigger(cid) == REMOTE_ERROR


@of("simxPauseSimulation")
def test_pause_leaves_stepped_mode_on(world: Any, cid: int, simx: Any) -> None:
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == OK
    v.simxStartSimulation(cid, BLOCKING)
    for _ in range(3):
        world.loop.turn()
    assert world.simulation.step_count == 0
    assert v.simxSynchronousTrigger(cid) == OK


@of("simxLoadScene")
def test_a_scene_is_loaded_while_stopped_from_the_folders_the_server_opens(
    tmp_path: Path, cid: int, simx: Any
) -> None:
    other = "<mujoco><worldbody><body name='new'><geom size='1'/></body></worldbody></mujoco>"
    (tmp_path / "other.xml").write_text(other, encoding="utf-8")
    assert simx(cid, str(tmp_path / "other.xml"), 0, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "new", BLOCKING)[0] == OK
    assert v.simxGetObjectHandle(cid, "cube", BLOCKING) == (REMOTE_ERROR, 0)
    assert simx(cid, str(tmp_path / "missing.ttt"), 0, BLOCKING) == REMOTE_ERROR
    (tmp_path / "broken.xml").write_text("<mujoco><", encoding="utf-8")
    assert simx(cid, str(tmp_path / "broken.xml"), 0, BLOCKING) == REMOTE_ERROR
    assert v.simxGetObjectHandle(cid, "new", BLOCKING)[0] == OK, "the old scene stays"
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, str(tmp_path / "other.xml"), 0, BLOCKING) == REMOTE_ERROR
    v.simxPauseSimulation(cid, BLOCKING)
    assert simx(cid, str(tmp_path / "other.xml"), 0, BLOCKING) == REMOTE_ERROR, "paused is not stopped"


@of("simxLoadScene")
@pytest.mark.parametrize("options", [1, 0xFF])
def test_a_scene_file_of_the_client_is_transferred_first(
    tmp_path_factory: pytest.TempPathFactory, tmp_path: Path, cid: int, simx: Any, options: int
) -> None:
    mine = tmp_path_factory.mktemp("client") / "mine.xml"
    mine.write_text("<mujoco><worldbody><body name='mine'/></worldbody></mujoco>", encoding="utf-8")
    assert simx(cid, str(mine), options, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "mine", BLOCKING)[0] == OK
    assert list(tmp_path.rglob("REMOTE_API_TEMPFILE*")) == [], "the copy is erased again"
    rc = simx(cid, str(mine.with_name("missing.ttt")), options, BLOCKING)
    assert rc == v.simx_return_local_error_flag


@of("simxLoadScene")
def test_streams_survive_a_change_of_scene_and_then_give_8(
    world: Any, cid: int, simx: Any, handle: Any
) -> None:
    lid = handle("lid")
    v.simxGetObjectPosition(cid, lid, -1, v.simx_opmode_streaming)
    simx(cid, str(SCENE), 0, BLOCKING)
    world.loop.turn()
    v.simxCloseScene(cid, BLOCKING)
    v.simxStartSimulation(cid, BLOCKING)
    world.loop.turn()
    assert v.simxGetObjectPosition(cid, lid, -1, v.simx_opmode_buffer) == (REMOTE_ERROR, [0.0] * 3)


@of("simxCloseScene")
def test_closing_opens_the_default_scene_and_is_8_while_running(cid: int, simx: Any) -> None:
    v.simxStartSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == REMOTE_ERROR
    v.simxPauseSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == REMOTE_ERROR, "paused is not stopped"
    v.simxStopSimulation(cid, BLOCKING)
    assert simx(cid, BLOCKING) == OK
    for name in ("ResizableFloor_5_25", "DefaultCamera", "DefaultLightA"):
        assert v.simxGetObjectHandle(cid, name, BLOCKING)[0] == OK
    assert v.simxGetObjectHandle(cid, "lid", BLOCKING)[0] == REMOTE_ERROR


@of("simxLoadScene")
@pytest.mark.parametrize("options", [0, 1])
def test_an_empty_name_opens_the_default_scene(cid: int, simx: Any, options: int) -> None:
    assert simx(cid, "", options, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "ResizableFloor_5_25", BLOCKING)[0] == OK
    assert v.simxGetObjectHandle(cid, "lid", BLOCKING)[0] == REMOTE_ERROR


def test_start_pause_and_stop_are_different_commands(world: Any, cid: int) -> None:
    v.simxPauseCommunication(cid, True)
    for function in (v.simxStartSimulation, v.simxStopSimulation, v.simxStartSimulation):
        function(cid, ONESHOT)
    v.simxPauseCommunication(cid, False)
    world.loop.turn()
    assert world.simulation.state is SimulationState.STOPPED, "the second start took the place of the first"


def test_a_name_of_the_originals_format_means_the_same_stem_in_ours(tmp_path: Path, cid: int) -> None:
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><body name='r'/></worldbody></mujoco>", encoding="utf-8"
    )
    assert v.simxLoadScene(cid, str(tmp_path / "robot.ttt"), 0, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "r", BLOCKING)[0] == OK
