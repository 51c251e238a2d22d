"""The first image of a server: prepared when a program has its sensor, and no other call waits for a driver."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest
from both_renderers import opengl_name
from processes import START_TIMEOUT, read_line, running, server, spawn, wait_until
from real_world import RealWorld

import simx_client as vrep
from simx_client.connection.discovery import measure_servers
from simx_client.protocol.reports import Metrics
from simx_server.app import embedding
from simx_server.scene.cameras.image import CameraView
from simx_server.sensors.opengl import backend as gl_backend
from simx_server.sensors.opengl.early_probe import EarlyProbe, may_have_cameras
from simx_server.service.warm_up import WarmUp, wait_until_warm, warm_up

pytestmark = [pytest.mark.slow, pytest.mark.gl]

__all__ = ["opengl_name"]

TUTORIAL = "ur5_rg2_kinect"
SENSOR = "kinect_rgb"
ROOM = '<mujoco><worldbody>{}<geom name="box" type="box" size="1 1 1"/></worldbody></mujoco>'
EYE = '<camera name="eye" pos="0 0 3" resolution="16 16"/>'

HANGING = """
import sys, threading
from simx_server.app import server
from simx_server.sensors.rendering import current_renderer
from simx_server.settings.settings import Settings

def hang(name, give_up):
    threading.Event().wait()

current_renderer.CHOSEN_WITHIN = 0.1
sys.exit(server.serve(Settings(scene=sys.argv[1], ports=(0,)), hang))
"""
"""A server whose graphics driver never comes back."""


def metrics_of(port: int) -> Metrics:
    (found,), _ = measure_servers([f"tcp/127.0.0.1:{port}"])
    assert found.metrics is not None
    return found.metrics


def connect(port: int) -> int:
    client = vrep.simxStart("127.0.0.1", port, True, True, 5000, 5)
    assert client >= 0
    return client


@pytest.mark.skipif(sys.platform != "linux", reason="counts on the back end that Linux has")
@pytest.mark.parametrize("recording", [False, True])
def test_who_has_the_handle_of_a_camera_finds_its_images_prepared(
    opengl_name: str, tmp_path: Path, recording: bool
) -> None:
    """The first image then takes less than a fifth of a second of the server's processor time."""
    flags = ("--record", str(tmp_path / "run.simxlog")) if recording else ()
    with server(TUTORIAL, "--start", *flags) as fresh:
        client = connect(fresh.port)
        handle = vrep.simxGetObjectHandle(client, SENSOR, vrep.simx_opmode_blocking)[1]
        before = metrics_of(fresh.port)
        assert before["images"]["backend"] == opengl_name
        vrep.simxGetVisionSensorImage(client, handle, 0, vrep.simx_opmode_streaming)
        read = lambda: vrep.simxGetVisionSensorImage(client, handle, 0, vrep.simx_opmode_buffer)  # noqa: E731
        assert wait_until(lambda: read()[0] == vrep.simx_return_ok, START_TIMEOUT)
        after = metrics_of(fresh.port)
        assert after["process"]["processor_seconds"] - before["process"]["processor_seconds"] < 0.2
        vrep.simxFinish(client)


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RealWorld]:
    """A scene without cameras, whose server keeps warm."""
    for name, content in (("plain", ""), ("eyes", EYE + EYE.replace("eye", "other"))):
        (tmp_path / f"{name}.xml").write_text(ROOM.format(content))
    world = RealWorld(tmp_path / "plain.xml", workspace=tmp_path)
    world.simulation.parts.attach(WarmUp(world.parts, at_once=True))
    monkeypatch.setattr(gl_backend, "candidates", lambda: ())
    yield world
    world.close()


def test_a_server_without_cameras_makes_no_renderer(world: RealWorld) -> None:
    assert warm_up(world.parts) is None
    world.simulation.load(world.simulation.files.workspace / "plain.xml")
    assert not world.parts.rendering.is_begun


def test_before_the_first_client_a_server_says_how_it_makes_images_and_makes_no_renderer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "eyes.xml").write_text(ROOM.format(EYE))
    world = RealWorld(tmp_path / "eyes.xml", workspace=tmp_path)
    rendering = world.parts.rendering
    monkeypatch.setattr(gl_backend, "candidates", lambda: ())
    try:
        world.loop.service.watchers.add(WarmUp(world.parts))
        assert rendering.ready.wait(START_TIMEOUT)
        assert "images are made with raycast" in caplog.text
        world.simulation.load(tmp_path / "eyes.xml")
        assert not rendering.is_begun
        world.client()
        assert rendering.is_begun
        assert wait_until(lambda: rendering.wait_until_prepared(0), START_TIMEOUT)
        assert rendering._current.is_for(world.simulation.model)
    finally:
        world.close()


def test_waiting_for_images_ends_when_they_are_drawn_or_the_server_ends(tmp_path: Path) -> None:
    (tmp_path / "eyes.xml").write_text(ROOM.format(EYE))
    world = RealWorld(tmp_path / "eyes.xml", workspace=tmp_path)
    rendering, may_draw = world.parts.rendering, threading.Event()
    make = rendering._current._make

    def make_later(model: Any, backend: Any) -> Any:
        may_draw.wait(START_TIMEOUT)
        return make(model, backend)

    rendering._current._make = make_later
    try:
        WarmUp(world.parts, at_once=True)
        wait_until_warm(rendering, lambda: True)
        assert not rendering.wait_until_prepared(0)
        may_draw.set()
        wait_until_warm(rendering, lambda: False)
        assert rendering.wait_until_prepared(0)
    finally:
        may_draw.set()
        world.close()


def test_another_scene_with_cameras_is_warmed_up(world: RealWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[list[int]] = []
    rendering = world.parts.rendering
    prepare = rendering.prepare

    def noting(model: Any, data: Any, views: Sequence[CameraView], *, version: Any) -> Future[None]:
        drawn.append([view.camera_id for view in views])
        return prepare(model, data, views, version=version)

    monkeypatch.setattr(rendering, "prepare", noting)
    world.simulation.load(world.simulation.files.workspace / "eyes.xml")
    assert drawn == [[0, 1]]


def test_a_client_that_has_loaded_a_scene_finds_its_images_prepared(
    world: RealWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    rendering, waited = world.parts.rendering, []
    wait = rendering.wait_until_prepared
    monkeypatch.setattr(rendering, "wait_until_prepared", lambda seconds: waited.append(wait(60)) or True)
    client = world.client()
    eyes = str(world.simulation.files.workspace / "eyes.xml")
    assert vrep.simxLoadScene(client, eyes, 0, vrep.simx_opmode_blocking) == vrep.simx_return_ok
    assert rendering.backend is not None
    assert waited == [True]


def test_the_first_vision_sensor_that_a_client_makes_is_warmed_up_and_further_edits_are_not(
    world: RealWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = world.client()
    vrep.simxCreateDummy(client, 0.1, None, vrep.simx_opmode_blocking)
    assert not world.parts.rendering.is_begun
    eyes = str(world.simulation.files.workspace / "eyes.xml")
    assert vrep.simxLoadModel(client, eyes, 0, vrep.simx_opmode_blocking)[0] == vrep.simx_return_ok
    assert world.parts.rendering.is_begun
    monkeypatch.setattr(world.parts.rendering, "prepare", pytest.fail)
    vrep.simxCreateDummy(client, 0.1, None, vrep.simx_opmode_blocking)


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RealWorld]:
    """One of many servers, with a camera."""
    (tmp_path / "eyes.xml").write_text(ROOM.format(EYE))
    world = RealWorld(tmp_path / "eyes.xml")
    world.parts.rendering.warm_on_demand()
    monkeypatch.setattr(gl_backend, "candidates", lambda: ())
    yield world
    world.close()


def test_one_of_many_servers_prepares_images_for_who_gets_the_handle_of_a_camera(small: RealWorld) -> None:
    client, rendering = small.client(), small.parts.rendering
    assert vrep.simxGetObjectHandle(client, "box", vrep.simx_opmode_blocking)[0] == vrep.simx_return_ok
    assert not rendering.is_begun
    assert vrep.simxGetObjectHandle(client, "eye", vrep.simx_opmode_blocking)[0] == vrep.simx_return_ok
    assert rendering.backend is not None
    assert rendering.wait_until_prepared(0)


def test_a_stream_of_the_handle_of_a_camera_does_not_wait(small: RealWorld) -> None:
    client, rendering, may_draw = small.client(), small.parts.rendering, threading.Event()
    make = rendering._current._make

    def make_later(model: Any, backend: Any) -> Any:
        may_draw.wait(START_TIMEOUT)
        return make(model, backend)

    rendering._current._make = make_later
    try:
        get = lambda mode: vrep.simxGetObjectHandle(client, "eye", mode)  # noqa: E731
        get(vrep.simx_opmode_streaming)
        assert wait_until(lambda: get(vrep.simx_opmode_buffer)[0] == vrep.simx_return_ok, START_TIMEOUT)
        assert not rendering.wait_until_prepared(0)
    finally:
        may_draw.set()


def test_an_embedded_simulation_prepares_images_for_who_gets_the_handle_of_a_camera(tmp_path: Path) -> None:
    (tmp_path / "eyes.xml").write_text(ROOM.format(EYE))
    server = embedding.start([str(tmp_path / "eyes.xml")])
    try:
        rendering = server.world.rendering
        assert rendering.warms_on_demand
        assert not rendering.is_begun
    finally:
        server.close()


@pytest.fixture
def hanging(tmp_path: Path):
    """Port and process of a server whose pictures hang, with one camera."""
    scene = tmp_path / "room.xml"
    scene.write_text(ROOM.format(EYE))
    with running(spawn("-c", HANGING, scene)) as process:
        line = read_line(process)
        assert line.startswith("ready "), line
        yield int(re.findall(r"127\.0\.0\.1:(\d+)", line)[0]), process


def test_calls_are_answered_while_a_driver_hangs_and_images_say_why(
    hanging: tuple[int, subprocess.Popen[str]],
) -> None:
    port, _ = hanging
    client = connect(port)
    code, box = vrep.simxGetObjectHandle(client, "box", vrep.simx_opmode_blocking)
    assert code == vrep.simx_return_ok
    assert vrep.simxGetObjectPosition(client, box, -1, vrep.simx_opmode_blocking)[0] == vrep.simx_return_ok
    eye = vrep.simxGetObjectHandle(client, "eye", vrep.simx_opmode_blocking)[1]
    code, _, _ = vrep.simxGetVisionSensorImage(client, eye, 0, vrep.simx_opmode_blocking)
    assert code == vrep.simx_return_remote_error_flag
    errors = vrep.simxGetLastErrors(client, vrep.simx_opmode_blocking)[1]
    assert any("trying OpenGL back ends" in error and "--doctor" in error for error in errors)
    vrep.simxFinish(client)


def test_a_server_whose_driver_hangs_ends_when_it_is_told_to(
    hanging: tuple[int, subprocess.Popen[str]],
) -> None:
    _, process = hanging
    process.send_signal(signal.SIGTERM)
    assert process.wait(START_TIMEOUT) == 0


def test_a_scene_is_looked_through_for_cameras_with_what_it_includes(tmp_path: Path) -> None:
    (tmp_path / "eye.xml").write_text(f"<mujocoinclude>{EYE}</mujocoinclude>")
    scene = tmp_path / "scene.xml"
    scene.write_text(ROOM.format('<camera class="x"/>'))
    assert not may_have_cameras(scene)
    scene.write_text(ROOM.format("<include file='eye.xml'/><include file='scene.xml'/>"))
    assert may_have_cameras(scene)
    assert not may_have_cameras(tmp_path / "not there.xml")


_FORK = """
import os, threading, time
from simx_server.sensors.opengl import early_probe as gl_early

def what_is_wrong(name):
    {does}

gl_early.what_is_wrong = what_is_wrong
os.sched_getaffinity = lambda process: {cores}
probe, give_up = gl_early.EarlyProbe(), threading.Event()
child = probe._child
{then}
print(probe(gl_early.candidates()[0], give_up))
probe.close()
try:
    os.kill(child, 0)
except ProcessLookupError:
    print("gone")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only there a server forks to try a back end")
@pytest.mark.parametrize("cores", [{0}, {0, 1}])
@pytest.mark.parametrize(
    ("does", "then", "said"),
    [
        ("return None", "", "None"),
        ("return 'no such\\nlibrary'", "", "library"),
        ("os.kill(os.getpid(), 11)", "", "the driver ended its process with signal 11"),
        ("time.sleep(60)", "give_up.set()", "given up"),
        ("time.sleep(60)", "gl_early.PROBE_LIMIT = 0", "no answer within 0 s"),
    ],
)
def test_an_early_probe_tells_what_is_wrong_and_leaves_no_process(
    does: str, then: str, said: str, cores: set[int]
) -> None:
    assert _probed(does, then, cores) == [said, "gone"]


@pytest.mark.skipif(sys.platform != "linux", reason="only there a server forks to try a back end")
def test_on_one_core_an_early_probe_begins_when_the_server_waits_for_it(tmp_path: Path) -> None:
    mark = str(tmp_path / "waits")
    does, then = f"return str(os.path.exists({mark!r}))", f"open({mark!r}, 'w').close()"
    assert _probed(does, then, {0}) == ["True", "gone"]


def _probed(does: str, then: str, cores: set[int]) -> list[str]:
    """Return what a process prints that has an early probe."""
    done = subprocess.run(
        [sys.executable, "-c", _FORK.format(does=does, then=then, cores=cores)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return done.stdout.splitlines()


_BEGIN = """
import threading
from simx_server.sensors.opengl.mujoco_import import import_mujoco
import_mujoco()
from simx_server.sensors.opengl.early_probe import begin_early
for scene in ("ur5_rg2_kinect", "two_link_arm", "no such scene"):
    if (probe := begin_early(scene)) is not None:
        print(scene)
        probe.close()
threading.Thread(target=threading.Event().wait, daemon=True).start()
assert begin_early("ur5_rg2_kinect") is None
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only there a server forks to try a back end")
def test_a_back_end_is_tried_early_for_a_scene_with_cameras_by_a_process_of_one_thread() -> None:
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-c", _BEGIN],
        env=environment | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout.split()) == (0, ["ur5_rg2_kinect"]), done.stderr


def test_other_back_ends_than_the_first_are_tried_as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "simx_server.sensors.opengl.early_probe.probe_in_child", lambda name, give_up: f"{name} asked"
    )
    probe = EarlyProbe.__new__(EarlyProbe)
    probe._name, probe._child = "egl", None
    assert probe("osmesa", None) == "osmesa asked"  # type: ignore[arg-type]
