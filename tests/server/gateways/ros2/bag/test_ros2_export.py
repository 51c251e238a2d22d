"""``simx export --rosbag``: a recording becomes a bag with images, which rosbags opens as ``ros2 bag`` does."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from real_world import BLOCKING, handle_of, start_stepped
from recordings import recorded, rewrite
from ros2_world import SCENE

import simx_client as v
from simx_client import __main__ as simx
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE, INCOMPLETE, USAGE
from simx_server.app.export.command import main
from simx_server.recording.log_file import MAGIC
from simx_server.recording.records import Kind, Record
from simx_server.service.warm_up import warm_up

pytest.importorskip("mcap", reason="needs mcap, of the extra log")
highlevel = pytest.importorskip("rosbags.highlevel", reason="needs rosbags, of the extra dev")

pytestmark = pytest.mark.gl

STEPS = 6
TIMEOUT = 120.0
"""Seconds until the first image, which software draws, is made."""


class Recording(NamedTuple):
    """A recorded run, and what its client saw after the last step."""

    path: Path
    image: np.ndarray[Any, Any]
    """Rows from the top."""

    depth: np.ndarray[Any, Any]
    """Metres, rows from the top."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("recorded")
    scene, file = folder / "scene.xml", folder / "run.simxlog"
    scene.write_text(SCENE, encoding="utf-8")
    with recorded(scene, file) as place:
        cid = place.client(timeout=TIMEOUT)
        warming = warm_up(place.parts)
        assert warming is not None
        warming.result(TIMEOUT)
        start_stepped(cid)
        elbow, eye = (handle_of(cid, name) for name in ("elbow", "eye"))
        v.simxSetJointTargetPosition(cid, elbow, 0.8, BLOCKING)
        for _ in range(STEPS):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
        code, size, pixels = v.simxGetVisionSensorImage(cid, eye, 0, BLOCKING)
        assert code == v.simx_return_ok
        depth = v.simxGetVisionSensorDepthBuffer(cid, eye, BLOCKING)[2]
        _, near = v.simxGetObjectFloatParameter(cid, eye, v.sim_visionfloatparam_near_clipping, BLOCKING)
        _, far = v.simxGetObjectFloatParameter(cid, eye, v.sim_visionfloatparam_far_clipping, BLOCKING)
    width, height = size
    image = np.array(pixels, np.int16).astype(np.uint8).reshape(height, width, 3)[::-1]
    shares = np.array(depth, np.float32).reshape(height, width)[::-1]
    metres = np.where(shares < 1, near + shares * (far - near), np.inf)
    return Recording(file, image, metres)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    try:
        code = main([*map(str, words)])
    except SystemExit as end:
        code = int(end.code or 0)
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def messages(path: Path) -> Iterator[tuple[str, int, Any]]:
    """Topic, time and message of each, by the definitions in the file."""
    with highlevel.AnyReader([path]) as reader:
        for connection, time, data in reader.messages():
            yield connection.topic, time, reader.deserialize(data, connection.msgtype)


def test_a_recording_becomes_a_bag_with_the_images_that_its_client_saw(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "bag"
    code, shown, _ = run(capsys, recording.path, "--rosbag", out)
    assert code == DONE
    found = list(messages(out))
    assert f"has {len(found)} messages on {len({each[0] for each in found})} topics" in shown
    clocks = [each.clock.sec + each.clock.nanosec * 1e-9 for topic, _, each in found if topic == "/clock"]
    assert clocks == pytest.approx([0.05 * step for step in range(1, STEPS + 1)])
    times = [time for topic, time, _ in found if topic == "/clock"]
    assert [time - times[0] for time in times] == [50_000_000 * step for step in range(STEPS)]
    images = [each for topic, _, each in found if topic == "/eye/image_raw"]
    assert len(images) == STEPS
    last = images[-1]
    assert (last.encoding, last.header.frame_id) == ("rgb8", "eye_optical_frame")
    assert np.array_equal(last.data.reshape(recording.image.shape), recording.image)
    assert len(np.unique(recording.image.reshape(-1, 3), axis=0)) > 2
    depth = [each for topic, _, each in found if topic == "/eye/depth/image_raw"][-1]
    assert depth.encoding == "32FC1"
    seen = depth.data.view("<f4").reshape(recording.depth.shape)
    assert np.array_equal(np.isfinite(seen), np.isfinite(recording.depth))
    assert seen[np.isfinite(seen)] == pytest.approx(recording.depth[np.isfinite(seen)], abs=1e-4)
    info = [each for topic, _, each in found if topic == "/eye/camera_info"][-1]
    assert (info.width, info.height) == recording.image.shape[1::-1]
    assert info.header.stamp == last.header.stamp
    topics = {topic for topic, _, _ in found}
    assert {"/joint_states", "/tf", "/tf_static"} < topics
    assert "/eye/points" not in topics  # depth image and camera info have the same


def test_without_images_nothing_is_rendered_and_one_file_is_enough(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    out = tmp_path / "run.mcap"
    assert run(capsys, recording.path, "--rosbag", out, "--no-images")[0] == DONE
    assert [each.name for each in tmp_path.iterdir()] == ["run.mcap"]
    topics = [topic for topic, _, _ in messages(out)]
    assert topics.count("/joint_states") == STEPS
    assert not any(topic.startswith("/eye") for topic in topics)


def test_a_replay_that_differs_or_ends_early_has_its_own_exit_code(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def export(path: Path, name: str) -> tuple[int, str, str]:
        return run(capsys, path, "--rosbag", tmp_path / name, "--no-images")

    other = tmp_path / "other.simxlog"
    other.write_bytes(recording.path.read_bytes())

    def change_step_3(records: list[Record]) -> list[Record]:
        [each for each in records if each[0] == Kind.PASS][2][1] = bytes(8)
        return records

    rewrite(other, change_step_3)
    code, _, said = export(other, "differs")
    assert (code, "the replay differs in pass 3" in said) == (DIVERGED, True)
    assert sum(topic == "/clock" for topic, _, _ in messages(tmp_path / "differs")) == 3
    other.write_bytes(recording.path.read_bytes())
    rewrite(other, list)  # in several blocks: a short run may have one
    other.write_bytes(other.read_bytes()[:-3])
    code, shown, said = export(other, "cut")
    assert code == INCOMPLETE
    assert "the recording is not complete" in said
    assert "messages on" in shown


def test_what_cannot_be_used_is_named(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, said = run(capsys, recording.path)
    assert (code, "no output; valid: --rosbag DIR" in said) == (USAGE, True)
    code, _, said = run(capsys, recording.path, "--rosbag", tmp_path / "a" / "b", "--no-images")
    assert (code, "cannot be made: No such file or directory" in said) == (FAILURE, True)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "something").touch()
    code, _, said = run(capsys, recording.path, "--rosbag", tmp_path / "full", "--no-images")
    assert (code, "is not empty" in said) == (FAILURE, True)
    (tmp_path / "no.simxlog").write_bytes(MAGIC)
    code, _, said = run(capsys, tmp_path / "no.simxlog", "--rosbag", tmp_path / "out")
    assert (code, "holds nothing" in said) == (FAILURE, True)
    assert not (tmp_path / "out").exists()


def test_simx_has_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        simx.main(["export", "--help"])
    assert "export" in capsys.readouterr().out
