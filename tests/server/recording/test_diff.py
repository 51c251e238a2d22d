"""``simx diff``: the first step in which two recordings differ, what differs, and the call before it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from processes import PENDULUM
from real_world import BLOCKING, start_stepped
from recordings import recorded, rewrite

import simx_client as v
from simx_client import __main__ as simx
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_server.gateways.zmq.peer import with_number
from simx_server.gateways.zmq2.messages import call_of
from simx_server.gateways.zmq2.tags import packer
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
        hinge = v.simxGetObjects(client, v.sim_object_joint_type, BLOCKING)[1][0]
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


def test_an_object_that_one_scene_lacks_is_named_once(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.xml"
    other.write_text(PENDULUM.replace('"hinge"', '"elbow"'))
    code, shown, _ = run(
        capsys,
        record(scene, tmp_path / "one.simxlog", kicks={1: 0.5}),
        record(other, tmp_path / "other.simxlog", kicks={}),
    )
    assert code == DIVERGED
    assert shown.count("hinge: only in the first recording") == 1
    assert shown.count("elbow: only in the second recording") == 1


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


def test_calls_that_differ_only_in_bytes_or_far_behind_are_told_apart(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def signalled(to: Path, signal: bytes, number: int) -> Path:
        with recorded(scene, to) as place:
            client = place.client()
            hinge = v.simxGetObjects(client, v.sim_object_joint_type, BLOCKING)[1][0]
            start_stepped(client)
            for _ in range(12):
                v.simxSetIntegerSignal(client, "many", 1, BLOCKING)
            v.simxSetStringSignal(client, "text", 300 * b"a" + signal, BLOCKING)
            v.simxSetFloatSignal(client, "behind", float(number), BLOCKING)
            for _ in range(12):
                v.simxSetIntegerSignal(client, "many", 1, BLOCKING)
            v.simxSetJointPosition(client, hinge, 0.1 * number, BLOCKING)
            v.simxSynchronousTrigger(client)
            v.simxGetPingTime(client)
        return to

    one = signalled(tmp_path / "one.simxlog", b"x", 1)
    other = signalled(tmp_path / "other.simxlog", b"y", 2)
    code, shown, _ = run(capsys, one, other, "--no-replay")
    assert code == DIVERGED
    told = [line for line in shown.splitlines() if line.startswith(("  " + str(one), "  " + str(other)))]
    assert [line.partition(": ")[2].count("simxSetStringSignal") for line in told] == [1, 1]
    assert [line.partition(": ")[2].split("; ")[0].partition(" called ")[2][:19] for line in told] == [
        "simxSetStringSignal",
        "simxSetStringSignal",
    ]


def test_the_calls_of_api_2_are_named_and_the_names_of_its_clients_do_not_count(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def with_calls(to: Path, name: str, place: float) -> Path:
        def insert(records: list[Record]) -> list[Record]:
            first = next(at for at, each in enumerate(records) if each[0] == Kind.PASS)
            records[first][1] = bytes(8) if place else records[first][1]
            joined = [int(Kind.JOINED_ZMQ), -1, 9, f"zmq2/{name}", f"api2-{name}", 23001]
            calls = [("getObject", ["/hinge"]), ("setFloatProperty", [3, "jointPosition", place])]
            messages = [with_number(1, packer()(call_of(None, *call))) for call in calls]
            records[first:first] = [joined, *([int(Kind.BATCH), -1, 9, each] for each in messages)]
            return records

        rewrite(record(scene, to, kicks={}), insert)
        return to

    one = with_calls(tmp_path / "one.simxlog", "1a2b", 0.0)
    other = with_calls(tmp_path / "other.simxlog", "3c4d", 0.5)
    code, shown, _ = run(capsys, one, other, "--no-replay")
    assert code == DIVERGED
    assert shown.splitlines()[1:] == [
        "clients did something else before this step",
        f"  {one}: 'api2-1a2b' called setFloatProperty(3, 'jointPosition', 0.0)",
        f"  {other}: 'api2-3c4d' called setFloatProperty(3, 'jointPosition', 0.5)",
    ]
