"""``simx past``: the last steps of a run in a shell."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from processes import PENDULUM, ServerProcess, server
from real_world import BLOCKING

import simx_client as v
from simx_client import Client
from simx_client import __main__ as program

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    """A server that keeps sixty seconds, with a run of ten steps and a call before the sixth."""
    scene = tmp_path_factory.mktemp("scene") / "lab.xml"
    scene.write_text(PENDULUM)
    with server(scene, "--history", 60) as process:
        with Client(f"127.0.0.1:{process.port}") as client:
            v.simxSynchronous(client.id, True)
            v.simxStartSimulation(client.id, BLOCKING)
            for step in range(10):
                if step == 5:
                    v.simxSetFloatSignal(client.id, "gain", 0.5, BLOCKING)
                v.simxSynchronousTrigger(client.id)
            client.simulation.pause()
        yield process


def run(lab: ServerProcess, capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = program.main(["past", *map(str, arguments), "--at", str(lab.port)])
    said = capsys.readouterr()
    return code, said.out, said.err


def test_the_last_calls_are_listed_with_their_steps(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(lab, capsys)
    assert code == 0
    assert out.startswith("kept: step 0 (0.00 s) to step 10 (0.50 s), ")
    assert "step 6 (0.30 s)" in out
    assert "simxSetFloatSignal(signalName='gain', signalValue=0.5)" in out


def test_a_step_shows_joints_signals_and_calls(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = run(lab, capsys, 6, "--json")
    step = json.loads(out)
    assert code == 0
    assert step["signals"] == {"gain": 0.5}
    assert "simxSetFloatSignal" in step["calls"][0]["call"]
    assert len(step["joints"]) == 1
    lines = run(lab, capsys, 6)[1]
    assert lines.startswith("step 6, 0.300 s\njoints: ")
    assert "signals: gain 0.5" in lines


def test_wrong_use_and_a_step_that_is_gone_are_refused(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(lab, capsys, "--go-on")[0] == 2
    assert run(lab, capsys, -3)[0] == 2
    code, _, err = run(lab, capsys, 99, "--go-on")
    assert code == 1
    assert "step 99 is not kept; kept are steps 0 to 10; choose one of them" in err


def test_a_viewer_may_neither_look_back_nor_go_on(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SIMX_ROLE", "viewer")
    code, _, err = run(lab, capsys, 6, "--go-on")
    assert code == 1
    assert "may only read" in err


def test_a_new_run_goes_on_from_a_step(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(lab, capsys, 4, "--go-on")
    assert (code, out) == (0, "a new run, paused at step 4, 0.200 s; start the simulation to go on\n")
    with Client(f"127.0.0.1:{lab.port}") as client:
        assert client.simulation.time == pytest.approx(0.2)
        assert client.simulation.state == "paused"
