"""``simx export --npz``, ``--lerobot``, ``--minari``: a recording becomes episodes with new images."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from real_world import BLOCKING, handle_of, start_stepped
from recordings import recorded

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE
from simx_server.app.export.command import main
from simx_server.service.warm_up import warm_up

pytestmark = pytest.mark.gl

STEPS = 5
TIMEOUT = 120.0
"""Seconds until the first image, which software draws, is made."""

SCENE = """
<mujoco model="reacher">
  <compiler angle="radian"/>
  <worldbody>
    <light name="lamp" directional="true" dir="0 0 -1" diffuse="0.7 0.7 0.7"/>
    <geom name="floor" type="plane" size="2 2 0.1" rgba="0.3 0.5 0.7 1"/>
    <body name="arm" pos="0 0 0.6">
      <joint name="hinge" axis="0 1 0" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="1 0.2 0.1 1"/>
    </body>
    <body name="cube" pos="0.5 0.4 0.05">
      <freejoint/>
      <geom type="box" size="0.05 0.05 0.05" rgba="0.2 0.8 0.3 1"/>
    </body>
    <camera name="eye" pos="0.2 -2 0.8" xyaxes="1 0 0 0 0.2 1" resolution="64 48"/>
  </worldbody>
  <actuator><velocity joint="hinge" kv="10"/></actuator>
</mujoco>
"""


class Recording(NamedTuple):
    """A recording, and what its client saw before each step of the last episode."""

    path: Path
    hinge: list[float]
    cube: list[list[float]]
    image: np.ndarray[Any, Any]
    """Before the first step, rows from the top."""


def mark(cid: int, value: int) -> None:
    v.simxSetIntegerSignal(cid, "demonstration", value, BLOCKING)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A success, a discarded episode and another success, each in a run with a step before it."""
    folder = tmp_path_factory.mktemp("recorded")
    scene, file = folder / "scene.xml", folder / "run.simxlog"
    scene.write_text(SCENE, encoding="utf-8")
    with recorded(scene, file) as place:
        cid = place.client(timeout=TIMEOUT)
        warming = warm_up(place.parts)
        assert warming is not None
        warming.result(TIMEOUT)
        hinge, cube, eye = (handle_of(cid, name) for name in ("hinge", "cube", "eye"))
        for number, end in enumerate((2, 3, 2)):
            start_stepped(cid)
            v.simxSynchronousTrigger(cid)
            mark(cid, 1)
            angles, places = [], []
            for step in range(STEPS):
                angles.append(v.simxGetJointPosition(cid, hinge, BLOCKING)[1])
                places.append(v.simxGetObjectPosition(cid, cube, -1, BLOCKING)[1])
                if not step:
                    code, (width, height), pixels = v.simxGetVisionSensorImage(cid, eye, 0, BLOCKING)
                    assert code == v.simx_return_ok
                v.simxSetJointTargetVelocity(cid, hinge, number + 0.5 * step, BLOCKING)
                v.simxSynchronousTrigger(cid)
            mark(cid, end)
            v.simxStopSimulation(cid, BLOCKING)
            v.simxGetPingTime(cid)
        image = np.array(pixels, np.int16).astype(np.uint8).reshape(height, width, 3)[::-1]
    return Recording(file, angles, places, image)


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    try:
        code = main([*map(str, words)])
    except SystemExit as end:
        code = int(end.code or 0)
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def test_episodes_have_what_the_client_saw_and_commanded(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, shown, _ = run(capsys, recording.path, "--npz", tmp_path / "demos", "--cameras", "eye")
    assert (code, shown) == (DONE, "episodes: 2 written, 1 left out\n")
    described = json.loads((tmp_path / "demos" / "dataset.json").read_text(encoding="utf-8"))
    assert described["observation"][:2] == ["hinge.position", "hinge.velocity"]
    assert described["action"] == ["hinge.target_velocity"]
    assert [each["is_success"] for each in described["episodes"]] == [True, True]
    with np.load(tmp_path / "demos" / described["episodes"][1]["file"]) as episode:
        assert episode["observation"].shape == (STEPS + 1, 9)
        assert episode["time"] == pytest.approx([0.05 * step for step in range(1, STEPS + 2)])
        assert episode["observation"][:-1, 0] == pytest.approx(recording.hinge, abs=1e-6)
        assert episode["observation"][:-1, 2:5] == pytest.approx(np.array(recording.cube), abs=1e-6)
        assert episode["action"][:, 0] == pytest.approx([2 + 0.5 * step for step in range(STEPS)])
        assert episode["image.eye"].shape == (STEPS + 1, 48, 64, 3)
        assert np.array_equal(episode["image.eye"][0], recording.image)


def test_images_have_another_size_and_another_light_and_the_replay_stays_equal(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pixels = {}
    for light in ("1", "0.3", "1,0,10"):
        folder = tmp_path / light
        words = ["--npz", folder, "--cameras", "eye:32x24", "overview:40x30", "--light", light]
        assert run(capsys, recording.path, *words)[0] == DONE
        with np.load(folder / "episode-000.npz") as episode:
            assert episode["image.overview"].shape == (STEPS + 1, 30, 40, 3)
            pixels[light] = episode["image.eye"].astype(float)
    assert pixels["1"].shape == (STEPS + 1, 24, 32, 3)
    assert pixels["0.3"].mean() < 0.6 * pixels["1"].mean()
    assert pixels["1,0,10"].mean() < 0.95 * pixels["1"].mean()  # the floor gets little of a low lamp


def test_without_marks_each_run_is_an_episode_and_chosen_numbers_are_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, file = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(SCENE, encoding="utf-8")
    with recorded(scene, file) as place:
        cid = place.client()
        for length in (2, 3):
            start_stepped(cid)
            for _ in range(length):
                v.simxSetIntegerSignal(cid, "grip", length, BLOCKING)
                v.simxSynchronousTrigger(cid)
            v.simxStopSimulation(cid, BLOCKING)
    words = ["--npz", tmp_path / "demos", "--observe", "cube.position", "--act", "grip.int_signal"]
    assert run(capsys, file, *words)[0] == DONE
    described = json.loads((tmp_path / "demos" / "dataset.json").read_text(encoding="utf-8"))
    assert described["observation"] == ["cube.position.x", "cube.position.y", "cube.position.z"]
    assert described["episodes"] == [
        {"file": f"episode-00{number}.npz", "steps": steps, "is_success": None}
        for number, steps in enumerate((2, 3))
    ]
    with np.load(tmp_path / "demos" / "episode-001.npz") as episode:
        assert episode["action"].tolist() == [[3.0]] * 3
    code, _, problem = run(capsys, file, "--npz", tmp_path / "others", "--successes")
    assert code == FAILURE
    assert "none that is marked as a success" in problem


@pytest.mark.parametrize(
    ("words", "code", "problem"),
    [
        (["--observe", "cube.colour"], FAILURE, "valid: position, quaternion"),
        (["--act", "nobody.position"], FAILURE, "nobody"),
        (["--cameras", "cyclops"], FAILURE, "the cameras of this scene are eye"),
        (["--cameras", "eye:0x9"], USAGE, "valid: NAME or NAME:WxH"),
        (["--light", "1,2"], USAGE, "valid: 0.5"),
    ],
)
def test_what_the_scene_does_not_have_is_named(
    words: list[str], code: int, problem: str, recording: Recording, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    found = run(capsys, recording.path, "--npz", tmp_path / "demos", *words)
    assert found[0] == code
    assert problem in found[2]


def test_a_folder_with_files_is_not_written_over(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "kept").write_text("mine", encoding="utf-8")
    code, _, problem = run(capsys, recording.path, "--npz", tmp_path)
    assert code == FAILURE
    assert "is not written over" in problem


def test_lerobot_gets_tables_statistics_and_films(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra datasets")
    av = pytest.importorskip("av", reason="needs av, of the extra datasets")
    out = tmp_path / "demos"
    assert run(capsys, recording.path, "--lerobot", out, "--cameras", "eye", "--task", "swing")[0] == DONE
    info = json.loads((out / "meta" / "info.json").read_text(encoding="utf-8"))
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", 20, 2)
    assert info["features"]["observation.state"]["names"] == ["hinge.position", "hinge.velocity"]
    assert info["features"]["observation.environment_state"]["shape"] == [7]
    rows = parquet.read_table(out / info["data_path"].format(chunk_index=0, file_index=0)).to_pydict()
    assert rows["index"] == list(range(2 * STEPS))
    assert rows["frame_index"] == 2 * list(range(STEPS))
    assert rows["timestamp"][:STEPS] == pytest.approx([0.05 * step for step in range(STEPS)])
    assert rows["action"][STEPS:] == pytest.approx([2 + 0.5 * step for step in range(STEPS)])
    assert [row[0] for row in rows["observation.state"][STEPS:]] == pytest.approx(recording.hinge, abs=1e-6)
    assert rows["next.success"] == 2 * [*[False] * (STEPS - 1), True]
    episodes = parquet.read_table(out / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    assert [each["dataset_from_index"] for each in episodes] == [0, STEPS]
    assert episodes[1]["tasks"] == ["swing"]
    assert episodes[1]["stats/action/max"] == pytest.approx([2 + 0.5 * (STEPS - 1)])
    tasks = parquet.read_table(out / "meta" / "tasks.parquet")
    assert tasks.to_pydict() == {"task_index": [0], "__index_level_0__": ["swing"]}
    statistics = json.loads((out / "meta" / "stats.json").read_text(encoding="utf-8"))
    assert statistics["index"]["mean"] == [pytest.approx(STEPS - 0.5)]
    assert statistics["index"]["std"] == [pytest.approx(np.std(range(2 * STEPS)))]
    assert np.shape(statistics["observation.images.eye"]["mean"]) == (3, 1, 1)
    key, place = "observation.images.eye", episodes[1]
    film = out / info["video_path"].format(
        video_key=key,
        chunk_index=place[f"videos/{key}/chunk_index"],
        file_index=place[f"videos/{key}/file_index"],
    )
    with av.open(str(film)) as container:
        frames = list(container.decode(video=0))
    assert [frame.time for frame in frames] == pytest.approx([0.05 * step for step in range(STEPS)])
    first = frames[0].to_ndarray(format="rgb24").astype(float)
    assert np.abs(first - recording.image).mean() < 12  # H.264 halves the resolution of colours


def test_minari_reads_what_was_written_for_it(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    minari = pytest.importorskip("minari", reason="needs minari, of the extra minari")
    assert run(capsys, recording.path, "--minari", tmp_path / "swing-v0", "--cameras", "eye:32x24")[0] == DONE
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    dataset = minari.load_dataset("swing-v0")
    assert (dataset.total_episodes, dataset.total_steps) == (2, 2 * STEPS)
    episode = dataset[1]
    assert episode.observations["state"][:-1, 0] == pytest.approx(recording.hinge, abs=1e-6)
    assert episode.observations["eye"].shape == (STEPS + 1, 24, 32, 3)
    assert episode.actions[:, 0] == pytest.approx([2 + 0.5 * step for step in range(STEPS)])
    assert episode.terminations.tolist() == [*[False] * (STEPS - 1), True]
