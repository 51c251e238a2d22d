"""Films, pictures and state logs that a replay makes: those that the run itself would have made."""

from __future__ import annotations

import logging
import math
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from films import BLUE, SCENE, frames, middle
from processes import wait_until
from real_world import BLOCKING, handle_of, start_stepped, step
from recordings import RecordedWorld, blocks, kinds, recorded, replay, rewrite
from state_logs import Logged, read

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.codec import decode_batch, encode
from simx_server.outputs.filming import film
from simx_server.outputs.filming.shot import Shot, first_image
from simx_server.recording.log_file import MAGIC, LogReader
from simx_server.recording.records import Kind, Record
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

pytestmark = [pytest.mark.slow, pytest.mark.gl]

SMALL = "64x48"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "balls.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    return tmp_path / "run.simxlog"


@pytest.fixture
def quarter_turn(scene: Path, recording: Path) -> Path:
    """A recording of one second in which the arm, that points along x, comes to point up."""
    with recorded(scene, recording) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        start_stepped(client)
        v.simxSetJointTargetVelocity(client, hinge, -math.pi / 2, BLOCKING)
        step(client, 1.0)
    return recording


def picture(path: Path) -> np.ndarray:
    """RGB."""
    pixels = cv2.imread(str(path))
    assert pixels is not None
    return pixels[..., ::-1]


def comparable(logged: Logged) -> dict[str, list[tuple[int, bytes]]]:
    """Messages of two files are of two classes."""
    return {
        topic: [(time, message.SerializeToString()) for time, message in messages]
        for topic, messages in logged.items()
    }


def live(place: RecordedWorld, other: Path) -> None:
    """Two runs of a scene and one of another, pauses and edits, messages and signals."""
    sim, client = place.simulation, place.client()

    def start() -> None:
        has_room = lambda: not sim.parts.holds_step()  # noqa: E731
        assert wait_until(has_room, 20.0)
        start_stepped(client)

    start()
    v.simxSetJointTargetVelocity(client, handle_of(client, "hinge"), -1.0, BLOCKING)
    v.simxSetFloatSignal(client, "speed", -1.0, BLOCKING)
    step(client, 0.3)
    v.simxPauseSimulation(client, BLOCKING)
    v.simxSetFloatSignal(client, "speed", 0.5, BLOCKING)
    v.simxStartSimulation(client, BLOCKING)
    code, (copy,) = v.simxCopyPasteObjects(client, [handle_of(client, "green")], BLOCKING)
    assert code == v.simx_return_ok
    v.simxSetObjectPosition(client, copy, -1, (-0.4, 0, 0.5), BLOCKING)
    step(client, 0.2)
    v.simxStopSimulation(client, BLOCKING)
    v.simxAddStatusbarMessage(client, "once more", BLOCKING)
    v.simxSetJointPosition(client, handle_of(client, "hinge"), 1.0, BLOCKING)
    start()
    step(client, 0.2)
    v.simxStopSimulation(client, BLOCKING)
    assert v.simxLoadScene(client, other.name, 0, BLOCKING) == v.simx_return_ok
    v.simxClearFloatSignal(client, "speed", BLOCKING)
    start()
    step(client, 0.25)


def test_replay_makes_the_film_and_the_log_that_the_run_made(
    scene: Path, recording: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.xml"
    other.write_text(scene.read_text().replace("0 0 0.8", "0.2 0 0.8"))
    made, again = ({"video": tmp_path / f"{n}.mp4", "state_log": tmp_path / f"{n}.mcap"} for n in "ab")
    with recorded(scene, recording) as place:
        place.add_outputs(**made, camera="eye", fps="30")
        live(place, other)
    assert replay(recording, **again, camera="eye", fps="30") == DONE
    ours, theirs = (read(files["state_log"]) for files in (again, made))
    assert {"/tf", "/joints", "/scene", "/simulation", "/signals/speed", "/log", "/camera/eye"} == set(theirs)
    assert {message.state for _, message in theirs["/simulation"]} == {"running", "paused", "stopped"}
    assert comparable(ours) == comparable(theirs)
    shown, expected = frames(again["video"]), frames(made["video"])
    assert len(expected) == 1 + 15 + 1 + 6 + 1 + 7
    assert len(shown) == len(expected)
    assert all((one == other).all() for one, other in zip(shown, expected, strict=True))


def test_replay_waits_for_images_so_no_frame_is_lost(
    quarter_turn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(film, "MOST_WAITING", 1)
    assert replay(quarter_turn, video=tmp_path / "a.mp4", size=SMALL) == DONE
    shown = frames(tmp_path / "a.mp4")
    assert len(shown) == 21
    assert "21 frames of overview, 1.05 s of simulated time; 0 of them repeat" in caplog.text
    across = [middle(frame, BLUE)[1] for frame in (shown[0], shown[-1])]
    assert across[0] > 0.55
    assert across[1] == pytest.approx(0.5, abs=0.03)


def test_snapshot_of_a_replay_is_of_that_second_or_of_the_end(
    scene: Path, recording: Path, tmp_path: Path
) -> None:
    tidy = "function sysCall_cleanup() sim.setJointPosition(sim.getObject('/hinge'), 1) end"
    scene.write_text(
        SCENE.replace("</mujoco>", f'<custom><text name="simx:lua:arm" data="{tidy}"/></custom></mujoco>')
    )
    with recorded(scene, recording) as place:
        client = place.client()
        start_stepped(client)
        v.simxSetJointTargetVelocity(client, handle_of(client, "hinge"), -math.pi / 2, BLOCKING)
        shot = Shot(place.parts, "eye", (160, 120))
        seen = [first_image(shot)]
        for _ in range(20):
            v.simxSynchronousTrigger(client)
            seen.append(first_image(shot))
    for second, passes in (("0.01", 1), ("0.5", 10), ("0.51", 11), ("1", 20), (None, 20)):
        flags = {"camera": "eye", "size": "160x120"} | ({"duration": second} if second else {})
        assert replay(recording, snapshot=tmp_path / "a.png", **flags) == DONE
        shown = picture(tmp_path / "a.png")
        assert [(shown == each).all() for each in seen].index(True) == passes


def test_snapshot_counts_all_runs_and_says_when_there_is_less(
    scene: Path, recording: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with recorded(scene, recording) as place:
        client = place.client()
        hinge = handle_of(client, "hinge")
        for angle in (0.0, -math.pi / 2):
            v.simxSetJointPosition(client, hinge, angle, BLOCKING)
            start_stepped(client)
            step(client, 0.2)
            v.simxStopSimulation(client, BLOCKING)
    path, flags = tmp_path / "a.png", {"camera": "eye", "size": "160x120"}
    for second, is_up in (("0.2", False), ("0.3", True)):
        assert replay(recording, snapshot=path, duration=second, **flags) == DONE
        assert (middle(picture(path), BLUE)[1] < 0.55) == is_up
    path.unlink()
    assert replay(recording, snapshot=path, duration="0.5", **flags) == FAILURE
    assert "there are only 0.4 s of simulated time, so there is no picture of 0.5 s" in caplog.messages[-1]
    assert not path.exists()


def test_recording_that_was_cut_off_is_imaged_as_far_as_it_goes(
    quarter_turn: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = blocks(list(LogReader(quarter_turn)))
    quarter_turn.write_bytes(MAGIC + b"".join(made[: len(made) // 2]))
    passes = kinds(quarter_turn).count(Kind.PASS)
    assert 5 < passes < 15
    assert replay(quarter_turn, video=tmp_path / "a.mp4", size=SMALL) == DONE
    assert len(frames(tmp_path / "a.mp4")) == passes + 1
    assert replay(quarter_turn, snapshot=tmp_path / "a.png", size=SMALL) == DONE
    assert middle(picture(tmp_path / "a.png"), BLUE)[1] > 0.5


def test_replay_that_differs_leaves_what_came_before(quarter_turn: Path, tmp_path: Path) -> None:
    def change(records: list[Record]) -> list[Record]:
        passes = 0
        for record in records:
            passes += record[0] == Kind.PASS
            if record[0] == Kind.BATCH and passes == 8:
                batch = decode_batch(record[3])
                stronger = batch.calls[0]._replace(command="simxSetFloatSignal", arguments=["other", 1.0])
                record[3] = encode(batch._replace(calls=[stronger, *batch.calls]))
        return records

    rewrite(quarter_turn, change)
    files = {"video": tmp_path / "a.mp4", "state_log": tmp_path / "a.mcap"}
    assert replay(quarter_turn, **files, size=SMALL) == DIVERGED
    shown = frames(files["video"])
    assert len(shown) == 21  # signals are compared after every 20th pass
    assert middle(shown[-1], BLUE)[1] == pytest.approx(0.5, abs=0.03)
    logged = read(files["state_log"])
    assert logged["/simulation"][-1][1].pass_count == 20
    assert "/signals/other" in logged
    assert replay(quarter_turn, snapshot=tmp_path / "a.png") == DIVERGED
    assert not (tmp_path / "a.png").exists()


LOOKING = """
<custom><text name="simx:lua:arm" data="
    function sysCall_actuation()
        local hinge, eye = sim.getObject('/hinge'), sim.getObject('/eye')
        sim.setJointTargetVelocity(hinge, -1)
        local _, packet = sim.checkVisionSensor(eye, sim.handle_all)
        sim.setFloatSignal('seen', packet[14])
    end"/></custom></mujoco>"""


def test_images_of_a_film_take_nothing_from_those_of_scripts(
    scene: Path, recording: Path, tmp_path: Path
) -> None:
    scene.write_text(SCENE.replace("</mujoco>", LOOKING))
    with recorded(scene, recording, limit=("pictures=1",)) as place:
        client = place.client()
        start_stepped(client)
        step(client, 1.0)
        assert place.parts.signals.floats["seen"] > 0.001
    assert replay(recording, video=tmp_path / "a.mp4", size=SMALL) == DONE


def test_state_log_of_an_old_recording_begins_now(quarter_turn: Path, tmp_path: Path) -> None:
    began = next(iter(LogReader(quarter_turn)))[1]["began"]

    def make_old(records: list[Record]) -> list[Record]:
        del records[0][1]["began"]
        return records

    rewrite(quarter_turn, make_old)
    assert replay(quarter_turn, state_log=tmp_path / "a.mcap") == DONE
    times = [time for time, _ in read(tmp_path / "a.mcap")["/tf"]]
    assert times[0] > began
    assert times[-1] - times[0] == 1_000_000_000


@pytest.mark.parametrize("began", [-1, 1 << 63, True])
def test_recording_that_began_at_no_time_is_told(
    began: int, quarter_turn: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def change(records: list[Record]) -> list[Record]:
        records[0][1]["began"] = began
        return records

    rewrite(quarter_turn, change)
    assert replay(quarter_turn) == FAILURE
    assert "the recording's header cannot be used: it began at no time" in caplog.messages[-1]


def test_what_cannot_be_made_is_told_before_anything_is_replayed(
    quarter_turn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    films = {"video": tmp_path / "a.mp4"}
    assert replay(quarter_turn, **films, camera="eyes") == FAILURE
    assert "no object named 'eyes'; did you mean 'eye'?" in caplog.messages[-1]
    (tmp_path / "a.mp4").write_bytes(b"a film")
    assert replay(quarter_turn, **films) == FAILURE
    assert "exists already and is not written over; give another --video" in caplog.messages[-1]
    monkeypatch.setitem(sys.modules, "av", None)
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    assert replay(quarter_turn, video=tmp_path / "b.mp4") == FAILURE
    assert caplog.messages[-1].endswith(f"is not installed; {extra_line('video')}")
    assert replay(quarter_turn, state_log=tmp_path / "b.mcap") == FAILURE
    assert caplog.messages[-1].endswith(f"is not installed; {extra_line('log')}")


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ({"scene": "a.xml"}, "flag --replay: a recording brings its scene"),
        ({"count": "2"}, "flag --replay: .* valid: no SCENE, --record or --count beside it"),
        ({"snapshot": "a.png"}, "flag --snapshot: does not go together with --video; valid: one of both"),
    ],
)
def test_flags_that_make_no_sense_beside_a_filmed_replay_are_refused(
    flags: dict[str, str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.simxlog").touch()
    with pytest.raises(SettingError, match=told):
        gather({"replay": "run.simxlog", "video": "a.mp4", **flags}, {})
