"""Pictures of a run for people: snapshots and films, made with real OpenGL, and looked at again."""

from __future__ import annotations

import contextlib
import errno
import math
import re
import shlex
import sys
from collections.abc import Iterator
from concurrent.futures import Future
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from films import BLUE, GREEN, RED, SCENE, frames, middle
from processes import ROOT, running, server, spawn, wait_until
from real_world import BLOCKING, RealWorld, start_stepped, step

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.installing import extra_line
from simx_server.app.cli import make_parser
from simx_server.app.server import serve
from simx_server.errors import CommandError
from simx_server.outputs.filming import Film, Shot, film
from simx_server.outputs.filming import shot as shot_module
from simx_server.outputs.filming.film_file import FilmWriter
from simx_server.outputs.filming.shot import first_image
from simx_server.outputs.packages import NewFile, OutputError
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

pytestmark = [pytest.mark.slow, pytest.mark.gl]

av = pytest.importorskip("av", reason="needs the extra video")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "balls.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def place(scene: Path) -> Iterator[RealWorld]:
    opened = RealWorld(scene)
    yield opened
    opened.close()


def snapshot(scene: Path, **flags: str) -> np.ndarray:
    """(height, width, 3) RGB of what the flag writes."""
    path = scene.with_name("picture.png")
    assert serve(gather({"scene": str(scene), "snapshot": str(path), **flags}, {})) == DONE
    picture = cv2.imread(str(path))
    assert picture is not None
    return picture[..., ::-1]


def film_of(place: RealWorld, path: Path, camera: str | None = "eye", **chosen: Any) -> Film:
    shot = Shot(place.parts, camera, chosen.pop("size", None))
    return Film(place.simulation, path, shot, **chosen)


def advance(place: RealWorld, passes: int) -> None:
    """As the server does at --speed max, so a film may hold them."""
    wanted = place.simulation.step_count + passes
    assert wait_until(lambda: place.simulation.step_count >= wanted, 60.0, lambda: place.loop.turn(0.01))


class Slow:
    """A shot whose pictures are made when the test wants them."""

    name, size = "slow", (32, 32)

    def __init__(self) -> None:
        self.asked: list[Future[Any]] = []
        self.is_slow = False

    def ask(self) -> Future[Any]:
        picture: Future[Any] = Future()
        self.asked.append(picture)
        if not self.is_slow:
            self.make(picture)
        return picture

    @staticmethod
    def make(picture: Future[Any]) -> None:
        picture.set_result(np.full((32, 32, 3), 200, np.uint8))


# --- one picture ---------------------------------------------------------------------------------


@pytest.mark.parametrize("camera", ["eye", None])
def test_snapshot_is_the_right_way_up(scene: Path, camera: str | None) -> None:
    picture = snapshot(scene, size="160x120", **({"camera": camera} if camera else {}))
    assert picture.shape == (120, 160, 3)
    (red, across), (green, _) = middle(picture, RED), middle(picture, GREEN)
    assert red < 0.4 < 0.6 < green
    assert across == pytest.approx(0.5, abs=0.05)
    assert middle(picture, BLUE)[1] > 0.55  # the arm points along x, which is to the right


def test_overview_by_rays_is_that_by_opengl(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = snapshot(scene, size="80x60")
    monkeypatch.setenv("MUJOCO_GL", "disable")
    cast = snapshot(scene, size="80x60")
    for colour in (RED, GREEN, BLUE):
        assert middle(cast, colour) == pytest.approx(middle(drawn, colour), abs=0.03)


def test_overview_may_be_orthographic(scene: Path) -> None:
    scene.write_text(scene.read_text().replace("<global ", '<global orthographic="true" fovy="200" '))
    far = snapshot(scene, size="200x200")
    scene.write_text(scene.read_text().replace('fovy="200"', 'fovy="2"'))
    near = snapshot(scene, size="240x120")
    rows, _ = np.nonzero(near[..., RED].astype(int) > near[..., BLUE].astype(int) + 80)
    assert rows.max() - rows.min() + 1 == pytest.approx(0.4 / 2 * 120, abs=2)  # a diameter of 0.4 of 2 metres
    rows, _ = np.nonzero(far[..., RED].astype(int) > far[..., BLUE].astype(int) + 80)
    assert len(rows) <= 4


def test_overview_that_shows_nothing_is_told(scene: Path, caplog: pytest.LogCaptureFixture) -> None:
    scene.write_text(scene.read_text().replace("<visual>", '<visual><map znear="5" zfar="1"/>'))
    flags = {"scene": str(scene), "snapshot": str(scene.with_name("a.png"))}
    assert serve(gather(flags, {})) == FAILURE
    assert "the scene's overview cannot be pictured: clip planes near=5.0 far=1.0" in caplog.text


SMALL = """
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <geom name="floor" type="box" size="2.5 2.5 0.02" pos="0 0 -0.02" rgba="0 1 0 1"/>
    <body name="robot" pos="1 1 0.03"><geom name="robot" type="sphere" size="0.03" rgba="1 0 0 1"/></body>
    <camera name="DefaultCamera" pos="0 -5 3" xyaxes="{axes}"/>
  </worldbody>
  <custom><text name="simx:camera:DefaultCamera" data="view=yes"/></custom>
</mujoco>
"""


@pytest.mark.parametrize(
    "axes", ["1 0 0 0 0.5 0.87", "-1 0 0 0 0 1"], ids=["small in the view", "beside the view"]
)
def test_overview_is_near_what_stands_on_the_floor(scene: Path, axes: str) -> None:
    scene.write_text(SMALL.format(axes=axes))
    picture = snapshot(scene, size="64x48")
    assert middle(picture, RED) == pytest.approx((0.5, 0.5), abs=0.03)
    assert 250 < np.count_nonzero((picture[..., 0] > 200) & (picture[..., 1] < 50)) < 2500
    of_camera = snapshot(scene, size="64x48", camera="DefaultCamera")
    assert not ((of_camera[..., 0] > 200) & (of_camera[..., 1] < 50)).sum() > 20


def test_image_that_never_comes_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shot_module, "LONGEST_WAIT", 0.0)
    slow: Any = Slow()
    slow.is_slow = True
    with pytest.raises(CommandError, match="no picture of slow came within 0 s; simx-server --doctor tells"):
        first_image(slow)


def test_depth_sensor_gives_the_image_of_the_remote_api(scene: Path, place: RealWorld) -> None:
    picture = snapshot(scene, camera="deep")
    client = place.client()
    _, handle = v.simxGetObjectHandle(client, "deep", BLOCKING)
    _, (width, height), image = v.simxGetVisionSensorImage(client, handle, 0, BLOCKING)
    shown = np.array(image, np.int8).view(np.uint8).reshape(height, width, 3)
    assert (picture == shown[::-1]).all()
    assert len(np.unique(picture)) > 3


def test_snapshot_after_a_duration_is_of_that_simulated_second(scene: Path) -> None:
    text = scene.read_text().replace(
        "</mujoco>", "<custom><text name='simx:lua:arm' data=\"{}\"/></custom></mujoco>"
    )
    turn = "function sysCall_actuation() sim.setJointTargetVelocity(sim.getObject('/hinge'), -math.pi/2) end"
    scene.write_text(text.format(turn))
    before, after = (middle(snapshot(scene, camera="eye", **more), BLUE) for more in ({}, {"duration": "1"}))
    assert before[1] > 0.55
    assert after[1] == pytest.approx(0.5, abs=0.03)  # a quarter turn, so the arm points up
    assert after[0] < before[0] - 0.1


def test_wrong_camera_suggests_the_nearest_and_names_all(
    scene: Path, caplog: pytest.LogCaptureFixture
) -> None:
    flags = {"scene": str(scene), "snapshot": str(scene.with_name("a.png")), "camera": "eyes"}
    assert serve(gather(flags, {})) == FAILURE
    assert (
        "no object named 'eyes'; did you mean 'eye'?; the cameras of this scene are eye, deep" in caplog.text
    )


def test_what_is_no_camera_is_named_as_what_it_is(place: RealWorld) -> None:
    with pytest.raises(
        CommandError, match="'hinge' is a joint, but this command needs a camera or vision sensor"
    ):
        Shot(place.parts, "hinge")


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ({"video": "a.avi"}, r"flag --video: 'a.avi' cannot be used; valid: .* ends in \.mp4"),
        ({"snapshot": "a.jpg"}, r"flag --snapshot: 'a.jpg' cannot be used; valid: .* ends in \.png"),
        ({"video": "a.mp4", "size": "4x4"}, r"valid: WIDTHxHEIGHT, each from 16 to 4096"),
        ({"video": "a.mp4", "size": "640"}, r"valid: WIDTHxHEIGHT"),
        ({"video": "a.mp4", "fps": "0"}, r"valid: a number from 1 to 240"),
        ({"video": "a.mp4", "count": "2"}, r"flag --video: does not go together with --count"),
        ({"snapshot": "a.png", "video": "a.mp4"}, r"flag --snapshot: does not go together with --video"),
        (
            {"camera": "eye"},
            r"flag --camera: nothing is pictured; valid: with --snapshot, --video or --state-log",
        ),
    ],
)
def test_flags_that_cannot_be_used_say_what_is_valid(flags: dict[str, str], told: str) -> None:
    with pytest.raises(SettingError, match=told):
        gather(flags, {})


def test_command_lines_of_the_page_are_understood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.simxlog").touch()
    page = (ROOT / "docs" / "pictures-of-a-run.md").read_text(encoding="utf-8")
    lines = re.findall(r"^    simx-server (.+?)(?:   .*)?$", page, re.MULTILINE)
    assert len(lines) > 5
    for line in lines:
        gather(vars(make_parser().parse_args(shlex.split(line))), {})


# --- films ---------------------------------------------------------------------------------------


def test_film_has_a_frame_for_each_pass_and_shows_the_arm_move(place: RealWorld, tmp_path: Path) -> None:
    made = film_of(place, tmp_path / "a.mp4", size=(80, 60))
    sim = place.simulation
    sim.start()
    sim.joints.set_target_velocity(sim.scene.resolve("hinge"), -math.pi / 2)
    advance(place, 20)
    sim.stop()
    made.close()
    shown = frames(tmp_path / "a.mp4")
    assert len(shown) == 21  # the state before the first pass is the first
    assert shown[0].shape == (60, 80, 3)
    assert middle(shown[0], RED)[0] < middle(shown[0], GREEN)[0]
    across = [middle(frame, BLUE)[1] for frame in shown]
    assert across[0] > 0.55
    assert across[-1] == pytest.approx(0.5, abs=0.03)
    assert all(after < before + 0.01 for before, after in pairwise(across))
    assert made.behind == made.unseen == 0


def test_at_full_speed_passes_are_held_rather_than_frames_lost(
    place: RealWorld, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(film, "MOST_WAITING", 1)
    shot: Any = Slow()
    made = Film(place.simulation, tmp_path / "a.mp4", shot)
    shot.is_slow = True
    place.simulation.start()
    for _ in range(5):
        place.loop.turn()
    assert place.simulation.step_count == 0
    client = place.client()
    assert (
        v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == v.simx_return_ok
    )  # calls are answered meanwhile
    shot.is_slow = False
    shot.make(shot.asked[-1])
    advance(place, 10)
    made.close()
    assert (len(frames(tmp_path / "a.mp4")), made.behind) == (11, 0)


def test_stepped_clients_get_every_frame_too(place: RealWorld, tmp_path: Path) -> None:
    made = film_of(place, tmp_path / "a.mp4")
    client = place.client()
    start_stepped(client)
    step(client, 1.0)
    made.close()
    assert (len(frames(tmp_path / "a.mp4")), made.behind) == (21, 0)


def test_in_real_time_no_pass_waits_for_an_image(scene: Path, tmp_path: Path) -> None:
    place = RealWorld(scene, speed=1e9)  # as the wall clock has it, which is in a hurry
    shot: Any = Slow()
    made = Film(place.simulation, tmp_path / "a.mp4", shot)
    shot.is_slow = True
    place.simulation.start()
    advance(place, 30)
    assert len(shot.asked) == 1 + film.MOST_WAITING
    for picture in shot.asked[1:]:
        shot.make(picture)
    made.close()
    place.close()
    assert made.behind == 31 - film.MOST_WAITING
    assert len(frames(tmp_path / "a.mp4")) == 31


@pytest.mark.parametrize(("fps", "count"), [(None, 41), (10, 21), (50, 101)])
def test_a_second_of_the_film_is_a_second_of_the_simulation(
    fps: float | None, count: int, place: RealWorld, tmp_path: Path
) -> None:
    shot: Any = Slow()
    made = Film(place.simulation, tmp_path / "a.mp4", shot, fps)
    place.simulation.start()
    advance(place, 40)
    made.close()
    with av.open(str(tmp_path / "a.mp4")) as container:
        (stream,) = container.streams.video
        shown = list(container.decode(stream))
        assert len(shown) == count
        assert float(shown[-1].pts * stream.time_base) == pytest.approx(2.0)
        assert stream.average_rate == Fraction(fps or 20)
        assert stream.codec_context.name == "h264"
    assert len(shot.asked) == 1 + min(count, 41)  # a state that is shown twice is rendered once


def test_next_run_goes_on_in_the_same_film_and_a_pause_is_not_filmed(
    place: RealWorld, tmp_path: Path
) -> None:
    made = film_of(place, tmp_path / "a.mp4", camera="deep")
    sim = place.simulation
    for _ in range(2):
        sim.start()
        advance(place, 5)
        sim.pause()
        place.loop.turn(0.05)
        sim.start()
        advance(place, 5)
        sim.stop()
    made.close()
    shown = frames(tmp_path / "a.mp4")
    assert len(shown) == 22
    assert shown[0].shape == (26, 34, 3)  # H.264 wants even sides; the sensor has 33 x 25


def test_camera_that_is_removed_leaves_the_last_image_and_the_server(
    place: RealWorld, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = film_of(place, tmp_path / "a.mp4")
    client = place.client()
    start_stepped(client)
    step(client, 0.5)
    _, eye = v.simxGetObjectHandle(client, "eye", BLOCKING)
    assert v.simxRemoveObject(client, eye, BLOCKING) == v.simx_return_ok
    step(client, 0.5)
    assert v.simxStopSimulation(client, BLOCKING) == v.simx_return_ok  # brings it back
    start_stepped(client)
    step(client, 0.1)
    made.close()
    assert made.unseen == 10
    assert caplog.text.count("the film goes on with its last image: no object named 'eye'") == 1
    shown = frames(tmp_path / "a.mp4")
    assert len(shown) == 24
    assert middle(shown[20], RED)[0] < 0.5


def test_next_scene_without_a_usable_view_leaves_the_last_image_and_the_run(
    place: RealWorld, scene: Path, tmp_path: Path
) -> None:
    made = film_of(place, tmp_path / "a.mp4", camera=None, size=(32, 32))
    scene.write_text(scene.read_text().replace("<visual>", '<visual><map znear="5" zfar="1"/>'))
    place.simulation.load(scene)
    place.simulation.start()
    advance(place, 5)
    made.close()
    assert made.unseen == len(frames(tmp_path / "a.mp4")) == 6


def test_full_disk_ends_the_film_and_not_the_server(
    place: RealWorld, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    write, room = NewFile.write, 4000

    def write_what_fits(self: NewFile, data: bytes) -> int:
        nonlocal room
        room -= len(data)
        if room < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(self, data)

    monkeypatch.setattr(NewFile, "write", write_what_fits)
    made = film_of(place, tmp_path / "a.mp4")
    place.simulation.start()
    advance(place, 60)
    made.close()
    assert (
        "ends here: No space left on device; what is in it can be played, and the server goes on"
        in caplog.text
    )
    assert caplog.text.count("ERROR") == 1
    assert place.simulation.step_count == 60
    assert len(frames(tmp_path / "a.mp4")) > 5


def test_file_that_is_there_is_not_written_over(place: RealWorld, tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"a film")
    with pytest.raises(OutputError, match="exists already and is not written over; give another --video"):
        film_of(place, tmp_path / "a.mp4")
    with pytest.raises(
        OutputError, match="cannot be written: No such file or directory; give --video a file"
    ):
        FilmWriter(tmp_path / "gone" / "a.mp4", (32, 32), Fraction(25))


def test_without_the_package_a_film_prints_the_line_that_installs_it(
    scene: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    flags = {"scene": str(scene), "video": str(scene.with_name("a.mp4"))}
    assert serve(gather(flags, {})) == FAILURE
    assert f"--video needs the package av, which is not installed; {extra_line('video')}" in caplog.text
    assert not scene.with_name("a.mp4").exists()


def test_killed_server_leaves_a_film_that_plays(scene: Path) -> None:
    path = scene.with_name("a.mp4")
    with server(scene, "--start", "--speed", "max", "--video", path, "--size", "64x48") as process:
        assert wait_until(lambda: path.stat().st_size > 20_000, 60.0)
        process.kill()
    shown: list[np.ndarray] = []
    # The packet that was being written may be cut off: as in a player, the film ends before it.
    with av.open(str(path)) as container, contextlib.suppress(av.error.InvalidDataError):
        shown.extend(frame.to_ndarray(format="rgb24") for frame in container.decode(video=0))
    assert len(shown) > 20
    assert middle(shown[-1], RED)[0] < middle(shown[-1], GREEN)[0]


def test_film_of_a_server_that_was_told_to_end_is_whole(
    scene: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = scene.with_name("a.mp4")
    flags = (
        "--port",
        0,
        "--start",
        "--speed",
        "max",
        "--duration",
        "0.5",
        "--video",
        path,
        "--camera",
        "eye",
    )
    with running(spawn("-m", "simx_server", scene, *flags)) as process:
        assert process.wait(60) == DONE
    shown = frames(path)
    assert f"has {len(shown)} frames of eye" in capfd.readouterr().err
    assert shown[0].shape == (48, 64, 3)
