"""Errors inside a server: images, physics, disks and files. The client is told, and the next try works."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import mujoco
import pytest
from observing import observe
from real_world import BLOCKING, RealWorld, handle_of, render_with, start_stepped

import simx_client as v
from simx_server.scene.cameras.image import CameraImage, CameraView, Renderer, nothing
from simx_server.sensors.opengl.backend import Backend
from simx_server.sensors.rendering.current_renderer import make_renderer
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.simulation.simulation import SimulationState

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/><geom name="rod" size="0.1" mass="1"/>
    </body>
    <body name="cube" pos="1 0 1"><geom size="0.1"/></body>
    <camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 0 1" resolution="16 12"/>
  </worldbody>
  <actuator><motor name="hinge" joint="hinge"/></actuator>
</mujoco>
"""
TIMEOUT = 30.0
Record = Callable[[str, object], None]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    folder = tmp_path / "scenes"
    folder.mkdir()
    path = folder / "arm.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    folder = tmp_path / "workspace"
    folder.mkdir()
    return folder


@pytest.fixture
def world(scene: Path, workspace: Path) -> Iterator[RealWorld]:
    world = RealWorld(scene, workspace=workspace)
    yield world
    world.close()


def errors(client: int) -> str:
    return "\n".join(v.simxGetLastErrors(client, BLOCKING)[1])


# --- pictures ------------------------------------------------------------------------------------


class LosesItsContext:
    """A renderer of which every picture fails once `lost` is set, as with a GL context that the driver took away;
    one that is made again works."""

    def __init__(self, real: Renderer) -> None:
        self._real = real
        self.is_lost = False

    def render(
        self, data: mujoco.MjData, view: CameraView, rgb: bool, depth: bool, let_in: Any = nothing
    ) -> CameraImage:
        if self.is_lost:
            raise mujoco.FatalError("gladLoadGL error")
        return self._real.render(data, view, rgb, depth, let_in)

    def rest(self) -> None: ...

    def close(self) -> None:
        self._real.close()
        if self.is_lost:
            raise mujoco.FatalError("the context is gone")


@pytest.fixture
def made(world: RealWorld) -> list[LosesItsContext]:
    """Every renderer that was made, the newest last."""
    renderers: list[LosesItsContext] = []

    def make(model: mujoco.MjModel, backend: Backend) -> Renderer:
        renderers.append(LosesItsContext(make_renderer(model, backend)))
        return cast(Renderer, renderers[-1])

    render_with(world, RenderThread(lambda: Backend("raycast", "a test asked for it"), make))
    return renderers


def test_a_lost_gl_context_fails_one_image_and_the_next_is_made_with_a_new_one(
    world: RealWorld, made: list[LosesItsContext], record_property: Record
) -> None:
    client = world.client()
    eye = handle_of(client, "eye")
    code, resolution, pixels = v.simxGetVisionSensorImage(client, eye, 0, BLOCKING)
    assert (code, resolution) == (0, [16, 12])
    made[-1].is_lost = True
    v.simxSetObjectPosition(client, handle_of(client, "cube"), -1, [1.0, 0.0, 1.1], BLOCKING)
    assert v.simxGetVisionSensorImage(client, eye, 0, BLOCKING)[0] == 8
    assert "could not be rendered with raycast: gladLoadGL error" in errors(client)
    began = time.monotonic()
    code, resolution, again = v.simxGetVisionSensorImage(client, eye, 0, BLOCKING)
    record_property(
        "figures", f"the picture after a lost context comes in {1000 * (time.monotonic() - began):.0f} ms"
    )
    assert (code, resolution, len(again)) == (0, [16, 12], len(pixels))
    assert len(made) == 2


def test_a_stream_of_images_goes_on_after_one_that_failed(
    world: RealWorld, made: list[LosesItsContext]
) -> None:
    client = world.client()
    eye = handle_of(client, "eye")
    start_stepped(client)
    v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_streaming)
    codes = []
    for number in range(8):
        if number == 3:
            made[-1].is_lost = True
        assert v.simxSynchronousTrigger(client) == 0, "no trigger waits for a picture that will not come"
        codes.append(v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_buffer)[0])
    assert codes[-1] == 0
    assert 8 in codes
    assert codes.count(8) == 1
    assert len(made) == 2


# --- physics -------------------------------------------------------------------------------------


def test_diverged_physics_is_told_to_every_client_and_the_next_run_is_as_good_as_the_first(
    world: RealWorld,
) -> None:
    driver, watcher = world.client(), world.client()
    hinge = handle_of(driver, "hinge")
    start_stepped(driver)
    assert v.simxSynchronousTrigger(driver) == 0
    world.simulation.data.qvel[:] = 1e12
    assert v.simxSynchronousTrigger(driver) == v.simx_return_remote_error_flag, "the trigger is let go"
    assert world.simulation.state is SimulationState.STOPPED
    for client in (driver, watcher):
        assert "the physics diverged at 0.050 s; the simulation is stopped" in errors(client)
        assert v.simxGetJointPosition(client, hinge, BLOCKING) == (0, 0.0)
    start_stepped(driver)
    for _ in range(3):
        assert v.simxSynchronousTrigger(driver) == 0
    assert world.simulation.time == pytest.approx(0.15)
    assert errors(driver) == ""


def test_what_the_last_step_of_a_pass_makes_infinite_is_seen_as_diverged(
    world: RealWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = world.client()
    start_stepped(client)
    step = world.simulation.joints.controllers.step

    def diverge(count: int) -> None:
        step(count)
        world.simulation.data.qpos[0] = float("inf")

    monkeypatch.setattr(world.simulation.joints.controllers, "step", diverge)
    v.simxSynchronousTrigger(client)
    assert world.simulation.state is SimulationState.STOPPED
    assert "diverged" in v.simxGetLastErrors(client, BLOCKING)[1][-1]
    assert v.simxGetJointPosition(client, handle_of(client, "hinge"), BLOCKING) == (0, 0.0)


@pytest.mark.parametrize("value", [float("inf"), float("nan"), 1e308])
def test_an_edit_amid_diverged_physics_is_made_and_the_run_goes_on(world: RealWorld, value: float) -> None:
    client = world.client()
    start_stepped(client)
    v.simxSynchronousTrigger(client)
    world.simulation.data.qpos[0] = value  # no call can set this; what MuJoCo makes of 1e12 rad/s can
    world.simulation.joints.measure()
    v.simxGetJointPosition(client, handle_of(client, "hinge"), BLOCKING)
    assert not any("internal error" in error for error in v.simxGetLastErrors(client, BLOCKING)[1])
    code, dummy = v.simxCreateDummy(client, 0.1, None, BLOCKING)
    assert code == v.simx_return_ok
    assert v.simxGetObjectOrientation(client, dummy, -1, BLOCKING) == (0, pytest.approx([0, 0, 0]))
    assert v.simxStopSimulation(client, BLOCKING) == v.simx_return_ok
    start_stepped(client)
    assert v.simxSynchronousTrigger(client) == v.simx_return_ok


def test_a_model_that_stops_do_not_reset_is_reset_when_its_physics_diverged(world: RealWorld) -> None:
    client = world.client()
    hinge = handle_of(client, "hinge")
    start_stepped(client)
    assert v.simxSynchronousTrigger(client) == 0
    for handle in v.simxGetObjects(client, v.sim_handle_all, BLOCKING)[1]:
        v.simxSetModelProperty(client, handle, v.sim_modelproperty_not_reset, BLOCKING)
    world.simulation.data.qpos[0] = float("inf")
    assert v.simxStopSimulation(client, BLOCKING) == 0
    assert world.simulation.state is SimulationState.STOPPED
    assert v.simxGetJointPosition(client, hinge, BLOCKING) == (0, 0.0)


def test_a_run_ends_also_when_part_of_its_end_fails(
    world: RealWorld, caplog: pytest.LogCaptureFixture
) -> None:
    client = world.client()
    start_stepped(client)
    told: list[str] = []
    failing = observe(world.simulation, run_stopping=lambda: 1 // 0)
    observe(world.simulation, run_stopping=lambda: told.append("the others are told"))
    assert v.simxStopSimulation(client, BLOCKING) == 0
    assert world.simulation.state is SimulationState.STOPPED
    assert told == ["the others are told"]
    assert "the simulation stops all the same" in caplog.text
    world.simulation.parts.detach(failing)
    start_stepped(client)
    assert v.simxSynchronousTrigger(client) == 0


def test_a_pass_that_fails_is_told_to_every_client_and_the_next_run_works(
    world: RealWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver, watcher = world.client(), world.client()
    start_stepped(driver)

    def fail(substeps: int, *within: object) -> None:
        raise mujoco.FatalError("mj_stackAlloc: out of memory")

    with monkeypatch.context() as patched:
        patched.setattr(world.simulation.joints.controllers, "step", fail)
        assert v.simxSynchronousTrigger(driver) == v.simx_return_remote_error_flag
    assert "MuJoCo cannot go on: mj_stackAlloc: out of memory" in errors(watcher)
    start_stepped(driver)
    assert v.simxSynchronousTrigger(driver) == 0
    assert world.simulation.time == pytest.approx(0.05)


# --- disk and files ------------------------------------------------------------------------------


@contextmanager
def full_disk(left: int) -> Iterator[None]:
    """No file of this process can become longer than this many bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (left, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def files_in(workspace: Path) -> list[str]:
    """Without what the server keeps there for itself."""
    return [
        path.name
        for path in workspace.rglob("*")
        if path.is_file() and not path.name.startswith(".simx-from-clients")
    ]


def test_a_full_disk_refuses_a_file_leaves_the_old_one_and_nothing_half(
    world: RealWorld, workspace: Path, tmp_path: Path
) -> None:
    client = world.client()
    old, new = tmp_path / "old.bin", tmp_path / "new.bin"
    old.write_bytes(b"old")
    new.write_bytes(bytes(100_000))
    assert v.simxTransferFile(client, str(old), "kept.bin", 0, BLOCKING) == 0
    with full_disk(10_000):
        assert v.simxTransferFile(client, str(new), "kept.bin", 0, BLOCKING) == 8
        assert v.simxTransferFile(client, str(new), "folder/new.bin", 0, BLOCKING) == 8
        told = errors(client)
    assert "'kept.bin' cannot be written into" in told
    assert "File too large" in told
    assert (workspace / "kept.bin").read_bytes() == b"old"
    assert files_in(workspace) == ["kept.bin"]
    assert v.simxTransferFile(client, str(new), "kept.bin", 0, BLOCKING) == 0
    assert (workspace / "kept.bin").read_bytes() == bytes(100_000)


def test_a_full_disk_refuses_a_scene_of_the_clients_side_and_the_old_one_stays(
    world: RealWorld, workspace: Path, tmp_path: Path
) -> None:
    client = world.client()
    large = tmp_path / "large.xml"
    large.write_text(SCENE.replace("<worldbody>", "<worldbody>" + "<!-- much -->" * 10_000))
    hinge = handle_of(client, "hinge")
    with full_disk(10_000):
        assert v.simxLoadScene(client, str(large), 1, BLOCKING) == 8
    assert "cannot be written" in errors(client)
    assert v.simxGetJointPosition(client, hinge, BLOCKING)[0] == 0
    assert files_in(workspace) == []
    assert v.simxLoadScene(client, str(large), 1, BLOCKING) == 0


@pytest.mark.parametrize("spoil", [Path.unlink, lambda path: path.write_text("<mujoco>no XML")])
def test_a_scene_file_that_changes_or_goes_harms_no_run_and_a_reload_says_what_is_wrong(
    world: RealWorld, scene: Path, spoil: Callable[[Path], object]
) -> None:
    client = world.client()
    hinge, cube = handle_of(client, "hinge"), handle_of(client, "cube")
    start_stepped(client)
    assert v.simxSynchronousTrigger(client) == 0
    spoil(scene)
    assert v.simxSynchronousTrigger(client) == 0
    code, [copy] = v.simxCopyPasteObjects(client, [cube], BLOCKING)
    assert code == 0, "copies are made from memory"
    assert v.simxSynchronousTrigger(client) == 0
    assert v.simxGetObjectPosition(client, copy, -1, BLOCKING)[0] == 0
    assert v.simxStopSimulation(client, BLOCKING) == 0
    start_stepped(client)
    assert v.simxSynchronousTrigger(client) == 0
    assert v.simxStopSimulation(client, BLOCKING) == 0
    assert v.simxLoadScene(client, str(scene), 0, BLOCKING) == 8
    assert scene.stem in errors(client)
    assert v.simxGetJointPosition(client, hinge, BLOCKING)[0] == 0, "the old scene stays"
    scene.write_text(SCENE.replace('name="cube"', 'name="box"'))
    assert v.simxLoadScene(client, str(scene), 0, BLOCKING) == 0
    assert v.simxGetObjectHandle(client, "box", BLOCKING)[0] == 0


def test_a_mesh_that_goes_after_the_load_is_missed_by_name_when_the_model_is_made_again(
    tmp_path: Path,
) -> None:
    """The run does not need it. An edit does, is refused as a whole, and works when the file is back."""
    mesh = tmp_path / "tetrahedron.obj"
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    mesh.write_text(text)
    path = tmp_path / "meshes.xml"
    path.write_text(
        """<mujoco><asset><mesh name="m" file="tetrahedron.obj"/></asset><worldbody>
        <body name="one"><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
    )
    world = RealWorld(path)
    try:
        client = world.client()
        one = handle_of(client, "one")
        mesh.unlink()
        start_stepped(client)
        assert v.simxSynchronousTrigger(client) == 0
        assert v.simxCopyPasteObjects(client, [one], BLOCKING) == (8, [])
        assert "tetrahedron.obj" in errors(client)
        assert v.simxSynchronousTrigger(client) == 0
        assert v.simxStopSimulation(client, BLOCKING) == 0
        assert v.simxLoadScene(client, str(path), 0, BLOCKING) == 8
        assert "tetrahedron.obj" in errors(client)
        assert v.simxGetObjectPosition(client, one, -1, BLOCKING)[0] == 0
        mesh.write_text(text)
        assert v.simxCopyPasteObjects(client, [one], BLOCKING)[0] == 0
    finally:
        world.close()
