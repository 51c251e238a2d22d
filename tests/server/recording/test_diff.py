"""``simx diff``: the first step in which two recordings differ, what differs, and the call before it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from processes import PENDULUM
from real_world import BLOCKING, handle_of, start_stepped
from recordings import recorded, rewrite

import simx_client as v
from simx_client import __main__ as simx
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_server.recording.records import Kind, Record


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.xml"
    path.write_text(PENDULUM)
    return path


def record(scene: Path, to: Path, *, kicks: dict[int, float], steps: int = 6) -> Path:
    """Record a stepped run in which a client puts the joint somewhere before some of the steps."""
    with recorded(scene, to) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        start_stepped(client)
        for step in range(1, steps + 1):
            if step in kicks:
                v.simxSetJointPosition(client, hinge, kicks[step], BLOCKING)
            v.simxSynchronousTrigger(client)
            v.simxGetPingTime(client)
    return to


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    code = simx.main(["diff", *map(str, words)])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def test_the_first_step_that_differs_is_named_with_the_object_and_the_call(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={2: 0.5, 4: 0.25})
    other = record(scene, tmp_path / "other.simxlog", kicks={2: 0.5, 4: 0.125})
    code, shown, _ = run(capsys, one, other)
    assert code == DIVERGED
    assert "different from step 4, 0.200 s after the start of its run: positions (qpos)" in shown
    assert "hinge: joint position differs by 0.1" in shown
    assert "clients did something else before this step" in shown
    assert ", 0.25)" in shown
    assert ", 0.125)" in shown
    code, shown, _ = run(capsys, one, other, "--json")
    told = json.loads(shown)
    assert (code, told["step"], told["call_step"]) == (DIVERGED, 4, 4)
    (position,) = (
        each for each in told["objects"] if (each["object"], each["quantity"]) == ("hinge", "joint position")
    )
    assert position["one"][0] - position["other"][0] == pytest.approx(0.125, abs=0.02)


def test_equal_runs_are_equal(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={3: 0.5})
    other = record(scene, tmp_path / "other.simxlog", kicks={3: 0.5})
    code, shown, _ = run(capsys, one, other)
    assert (code, shown) == (
        DONE,
        "equal: all 6 simulation steps have the same positions and velocities\n",
    )


def test_a_recording_that_ends_before_the_other_is_named(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={}, steps=6)
    other = record(scene, tmp_path / "other.simxlog", kicks={}, steps=4)
    code, shown, _ = run(capsys, one, other)
    assert (code, shown.splitlines()[0]) == (DIVERGED, f"equal in 4 simulation steps; then '{other}' ends")


def test_a_recording_that_does_not_replay_here_is_compared_without_names(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={})
    other = record(scene, tmp_path / "other.simxlog", kicks={})

    def change_step_3(records: list[Record]) -> list[Record]:
        steps = [each for each in records if each[0] == Kind.PASS]
        steps[2][1] = bytes(8)
        return records

    rewrite(other, change_step_3)
    code, _, problem = run(capsys, one, other)
    assert code == FAILURE
    assert "a recording does not replay here: in pass 3" in problem
    assert "compare with --no-replay" in problem
    code, shown, _ = run(capsys, one, other, "--no-replay")
    assert code == DIVERGED
    assert shown.splitlines()[:2] == [
        "different from step 3: positions (qpos), velocities (qvel)",
        "clients did the same in both up to there",
    ]


def test_what_is_no_recording_or_has_no_step_is_told(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={})
    code, _, problem = run(capsys, one, scene)
    assert code == FAILURE
    assert f"'{scene}' is no recording" in problem
    empty = tmp_path / "empty.simxlog"
    with recorded(scene, empty):
        pass
    code, _, problem = run(capsys, one, empty)
    assert code == FAILURE
    assert f"'{empty}' has no simulation step to compare" in problem


def test_a_recorded_scene_is_found_again_without_the_file(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = record(scene, tmp_path / "one.simxlog", kicks={})
    other = record(scene, tmp_path / "other.simxlog", kicks={1: 1.0})
    scene.unlink()
    code, shown, _ = run(capsys, one, other)
    assert code == DIVERGED
    assert "hinge" in shown
