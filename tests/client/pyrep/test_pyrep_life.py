"""The life of a simulation below PyRep: launch, steps, stop, shutdown, again; several at once; failures."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from c_program import CProgram, Out, ffi
from processes import ROOT
from recordings import replay

from simx_client.errors import ConnectionFailed
from simx_client.protocol.cli.exit_codes import DONE
from simx_client.pyrep.library import Library
from simx_client.pyrep.worlds import ARGUMENTS, NoSimulation

SCENE = ROOT / "tests" / "conformance" / "scene.xml"


@pytest.fixture
def program() -> Iterator[CProgram]:
    with CProgram(SCENE) as launched:
        yield launched


def test_a_step_advances_a_running_simulation_by_its_time_step(program: CProgram) -> None:
    lib = program.lib
    lib.simExtStep(True)
    assert lib.simGetSimulationTime() == 0.0
    lib.simStartSimulation()
    for _ in range(3):
        lib.simExtStep(True)
    assert lib.simGetSimulationTime() == pytest.approx(3 * lib.simGetSimulationTimeStep(), rel=1e-6)


def test_a_step_of_the_window_alone_does_not_advance_time(program: CProgram) -> None:
    program.run(1)
    before = program.lib.simGetSimulationTime()
    program.lib.simExtStep(False)
    assert program.lib.simGetSimulationTime() == before > 0.0


def test_a_stop_restores_the_start_and_steps_after_it_do_nothing(program: CProgram) -> None:
    cube = program.handle("falling")
    height = program.done("simGetObjectPosition", cube, -1, Out("float[3]"))[2]
    program.run(10)
    assert program.done("simGetObjectPosition", cube, -1, Out("float[3]"))[2] < height - 0.01
    program.lib.simStopSimulation()
    for _ in range(5):
        program.lib.simExtStep(True)
    assert program.done("simGetObjectPosition", cube, -1, Out("float[3]"))[2] == height


def test_every_run_waits_for_steps_of_the_program(program: CProgram) -> None:
    for _ in range(2):
        program.run(2)
        assert program.lib.simGetSimulationTime() == pytest.approx(
            2 * program.lib.simGetSimulationTimeStep(), rel=1e-6
        )
        program.lib.simStopSimulation()


def test_a_paused_simulation_does_not_step(program: CProgram) -> None:
    program.run(1)
    program.done("simPauseSimulation")
    before = program.lib.simGetSimulationTime()
    program.lib.simExtStep(True)
    assert program.lib.simGetSimulationTime() == before


def test_a_program_launches_again_after_a_shutdown() -> None:
    for _ in range(2):
        with CProgram(SCENE) as program:
            program.run(1)


def test_an_empty_text_or_a_folder_opens_an_empty_scene(tmp_path: Path) -> None:
    for scene in ("", tmp_path):
        with CProgram(scene) as program:
            assert program.lib.simGetObjectHandle(b"DefaultCamera") > 0


def test_a_scene_that_cannot_be_opened_is_told_to_the_thread_that_waits(tmp_path: Path) -> None:
    (tmp_path / "broken.ttt").write_bytes(b"no scene")
    with pytest.raises(ConnectionFailed, match="broken"):
        CProgram(tmp_path / "broken.ttt")


def test_the_exit_request_is_seen_until_the_end_and_after_it() -> None:
    program = CProgram(SCENE)
    assert program.lib.simExtGetExitRequest() == 0
    program.lib.simQuitSimulator(True)
    assert program.lib.simExtGetExitRequest() == 1
    program.shutdown()
    assert program.lib.simExtGetExitRequest() == 1


def test_programs_of_several_threads_have_a_simulation_each() -> None:
    times: dict[int, float] = {}
    all_have_run = threading.Barrier(3)

    def drive(steps: int) -> None:
        with CProgram(SCENE) as program:
            program.run(steps)
            all_have_run.wait(60)
            times[steps] = program.lib.simGetSimulationTime() / program.lib.simGetSimulationTimeStep()

    threads = [threading.Thread(target=drive, args=(steps,)) for steps in (1, 2, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert times == pytest.approx({1: 1, 2: 2, 3: 3}, rel=1e-5)


def test_a_thread_that_a_program_starts_uses_its_simulation(program: CProgram) -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.append(program.handle("cube")))
    thread.start()
    thread.join()
    assert found == [program.handle("cube")]


def test_a_second_launch_of_a_thread_is_refused_and_the_first_goes_on(program: CProgram) -> None:
    other = program.lib
    opener = threading.Thread(target=other.simExtLaunchUIThread, args=(b"", 0, b"", b""), daemon=True)
    opener.start()
    opener.join()
    with pytest.raises(NoSimulation, match="shut it down first"):
        other.simExtCanInitSimThread()
    assert program.handle("cube")


def test_a_call_without_a_simulation_fails_and_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert Library().simGetObjectType(1) == -1
    assert "simGetObjectType: no simulation is open; launch one first" in capsys.readouterr().err


def test_a_failure_is_a_code_and_one_line(program: CProgram, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):
        assert program.lib.simGetObjectType(12345) == -1
    assert capsys.readouterr().err.count("simGetObjectType: no object with handle 12345") == 1


def test_a_look_for_something_that_may_be_missing_is_silent(
    program: CProgram, capsys: pytest.CaptureFixture[str]
) -> None:
    assert program.lib.simGetObjectHandle(b"nobody") == -1
    assert program.lib.simGetObjectName(12345) == ffi.NULL
    assert program.lib.simGetObjectParent(program.handle("robot")) == -1
    assert capsys.readouterr().err == ""


def test_a_function_that_the_library_lacks_is_an_attribute_error(program: CProgram) -> None:
    with pytest.raises(AttributeError, match="simDoesNotExist"):
        program.lib.simDoesNotExist(1)


def test_how_much_is_printed_may_be_set_before_the_launch() -> None:
    assert Library().simSetStringParameter(121, b"none") == 1
    assert Library().simSetStringParameter(1, b"x") == -1


def test_more_flags_of_the_server_come_from_the_environment(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Relative paths start in the program's working folder, which PyRep leaves while it launches."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(ARGUMENTS, "--record run.simx")
    with CProgram(SCENE) as program:
        program.run(3)
        program.done("simSetJointTargetVelocity", program.handle("shoulder"), 1.0)
        program.lib.simExtStep(True)
    assert (tmp_path / "run.simx").stat().st_size > 0
    assert Path.cwd() == tmp_path


def test_a_recording_of_a_program_replays_bit_for_bit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    record = tmp_path / "run.simx"
    monkeypatch.setenv(ARGUMENTS, f"--record '{record}'")
    with CProgram(SCENE) as program:
        program.done("simSetJointTargetVelocity", program.handle("shoulder"), 1.0)
        program.run(20)
        made, copies = ffi.new("int[]", [program.handle("cube")]), 1
        program.done("simCopyPasteObjects", made, copies, 0)
        program.done("simSetStringSignal", b"bytes", b"\0\1\xff", 3)
        program.lib.simExtStep(True)
    assert replay(record, allow_code=True) == DONE
