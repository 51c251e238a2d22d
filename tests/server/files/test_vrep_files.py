"""V-REP's own files that clients and scripts load: files of the server, files of the client, and buffers."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from processes import PENDULUM
from real_world import BLOCKING, RealWorld, handle_of, start_stepped
from recordings import recorded, replay
from scenes_for_tests import ARM
from scripted_world import evaluate, scripted
from vrep_concave import bowl
from vrep_writer import VrepWriter

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE
from simx_server.errors import CommandError
from simx_server.service.calls.background import refuse_steps

REMOTE_ERROR = v.simx_return_remote_error_flag


def file_of(name: str, *, is_model: bool = False) -> bytes:
    """A file with one dynamic shape."""
    writer = VrepWriter(21, is_model=is_model)
    writer.shape(
        name,
        cuboid=(0.1, 0.1, 0.1),
        dynamic=True,
        respondable=True,
        position=(2, 0, 0.3),
        model_base=is_model,
    )
    if not is_model:
        writer.settings()
    return writer.bytes()


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """The client's folder."""
    folder = tmp_path / "client"
    folder.mkdir()
    (folder / "mine.ttt").write_bytes(file_of("mine"))
    (folder / "block.ttm").write_bytes(file_of("block", is_model=True))
    return folder


@pytest.fixture
def there(tmp_path: Path) -> Path:
    """The server's workspace: the open scene is `robot.xml`, and `robot.ttt` lies beside it."""
    folder = tmp_path / "server"
    folder.mkdir()
    (folder / "robot.xml").write_text(ARM)
    (folder / "robot.ttt").write_bytes(file_of("original"))
    (folder / "brick.ttm").write_bytes(file_of("brick", is_model=True))
    return folder


@pytest.fixture
def world(there: Path) -> Iterator[RealWorld]:
    world = RealWorld(there / "robot.xml", workspace=there)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> int:
    return world.client(timeout=60.0)  # a trial that divides meshes takes seconds on a busy machine


def error_of(client: int) -> str:
    return "\n".join(v.simxGetLastErrors(client, BLOCKING)[1])


def names(world: RealWorld) -> list[str]:
    return [item.name for item in world.simulation.scene.objects.values()]


@pytest.mark.parametrize("path", ["robot.ttt", "C:\\Users\\me\\robot.ttt", "/home/me/scenes/robot.ttt"])
def test_file_itself_is_opened_rather_than_the_open_scene_of_its_stem(client, world, path) -> None:
    assert v.simxLoadScene(client, path, 0, BLOCKING) == 0
    assert names(world) == ["original"]


def test_file_itself_is_opened_rather_than_a_shipped_scene(client, world, there) -> None:
    (there / "ur5_rg2_kinect.ttt").write_bytes(file_of("own"))
    assert v.simxLoadScene(client, "ur5_rg2_kinect.ttt", 0, BLOCKING) == 0
    assert names(world) == ["own"]


def test_name_without_ending_finds_it_too(client, world, there) -> None:
    (there / "other.ttt").write_bytes(file_of("other"))
    assert v.simxLoadScene(client, "other", 0, BLOCKING) == 0
    assert names(world) == ["other"]


def test_scene_of_the_clients_side_is_sent_and_opened(client, world, here, there) -> None:
    (here / "mine.xml").write_text(PENDULUM)
    assert v.simxLoadScene(client, str(here / "mine.ttt"), 1, BLOCKING) == 0
    assert names(world) == ["mine"]
    assert world.simulation.scene.name == "mine"
    assert world.simulation.scene_is_of_client
    assert sorted(path.name for path in there.iterdir()) == ["brick.ttm", "robot.ttt", "robot.xml"]


@pytest.mark.parametrize("where", ["server", "client"])
def test_model_is_added_and_selected_while_the_simulation_runs(client, world, here, where) -> None:
    path, options, name = (
        ("brick.ttm", 0, "brick") if where == "server" else (str(here / "block.ttm"), 1, "block")
    )
    assert v.simxStartSimulation(client, BLOCKING) == 0
    code, base = v.simxLoadModel(client, path, options, BLOCKING)
    assert (code, base) == (0, handle_of(client, name))
    assert v.simxGetObjectSelection(client, BLOCKING) == (0, [base])
    code, second = v.simxLoadModel(client, path, options, BLOCKING)
    assert (code, second) == (0, handle_of(client, f"{name}#0"))
    assert v.simxGetObjectPosition(client, second, -1, BLOCKING)[1][0] == pytest.approx(2)
    assert v.simxStopSimulation(client, BLOCKING) == 0
    assert v.simxGetObjectHandle(client, name, BLOCKING)[0] != 0


@pytest.mark.parametrize("size", [3, 500, 1021, 1100, -1])
def test_cut_file_of_a_client_is_refused_and_the_scene_stays(client, world, here, size) -> None:
    (here / "cut.ttt").write_bytes((here / "mine.ttt").read_bytes()[:size])
    before = names(world)
    assert v.simxLoadScene(client, str(here / "cut.ttt"), 1, BLOCKING) == REMOTE_ERROR
    assert "cut.ttt" in error_of(client)
    assert names(world) == before


def test_transferred_file_counts_as_the_clients(client, world, here) -> None:
    assert v.simxTransferFile(client, str(here / "mine.ttt"), "sent.ttt", 5000, BLOCKING) == 0
    assert v.simxLoadScene(client, "sent.ttt", 0, BLOCKING) == 0
    assert world.simulation.scene_is_of_client
    assert v.simxLoadScene(client, "robot.ttt", 0, BLOCKING) == 0
    assert not world.simulation.scene_is_of_client


def test_content_counts_and_not_the_ending(client, world, here) -> None:
    (here / "disguised.xml").write_bytes((here / "mine.ttt").read_bytes())
    assert v.simxLoadScene(client, str(here / "disguised.xml"), 1, BLOCKING) == 0
    assert names(world) == ["mine"]
    assert v.simxTransferFile(client, str(here / "disguised.xml"), "disguised.xml", 5000, BLOCKING) == 0
    assert v.simxLoadScene(client, "disguised.xml", 0, BLOCKING) == 0
    assert world.simulation.scene_is_of_client


def test_mesh_of_a_client_that_is_not_convex_passes_its_trial(client, world, here) -> None:
    """Its parts need a library or a file on the way, and the process of a trial opens none any more."""
    square = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], float) / 10
    points = np.array([(x, y, z) for z in (0, 0.1) for x, y in square])
    bottom = np.array([(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 5, 4)])
    sides = [
        face for a in range(6) for face in ((a, (a + 1) % 6, a + 6), ((a + 1) % 6, (a + 1) % 6 + 6, a + 6))
    ]
    writer = VrepWriter(21)
    mesh = points, np.concatenate([bottom, bottom[:, ::-1] + 6, np.array(sides)])
    writer.shape("corner", mesh=mesh, dynamic=True, respondable=True)
    writer.shape("bowl", mesh=bowl(), respondable=True, position=(0, 0, 5))
    writer.shape("swing", mesh=bowl(3, 8), dynamic=True, respondable=True, position=(0, 0, 9))
    writer.settings()
    (here / "corner.ttt").write_bytes(writer.bytes())
    assert v.simxLoadScene(client, str(here / "corner.ttt"), 1, BLOCKING) == 0, error_of(client)
    assert names(world) == ["corner", "bowl", "swing"]


def with_scripts(*, is_model: bool = False) -> bytes:
    """A file whose child, customization and main script say that they have run."""
    writer = VrepWriter(21, is_model=is_model)
    base = writer.shape("talker", cuboid=(0.1, 0.1, 0.1), model_base=is_model)
    writer.script("function sysCall_init() sim.setInt32Signal('child', 1) end", base)
    text = "function sysCall_init() sim.setInt32Signal('customization', 1) end"
    writer.script(text, base, kind="customization")
    if not is_model:
        main = (
            "function sysCall_init() sim.setInt32Signal('main', 1) sim.handleChildScripts(sim.syscb_init) end"
        )
        writer.script(main, -1)
        writer.settings()
    return writer.bytes()


def said(client: int) -> set[str]:
    """Which scripts have run, after a start of the simulation."""
    assert v.simxStartSimulation(client, BLOCKING) == 0
    names = ("child", "customization", "main")
    found = {name for name in names if v.simxGetIntegerSignal(client, name, BLOCKING) == (0, 1)}
    assert v.simxStopSimulation(client, BLOCKING) == 0
    return found


@pytest.mark.parametrize("way", ["lent", "transferred", "model"])
def test_scripts_of_a_clients_file_do_not_run_without_allow_code(client, here, there, way) -> None:
    (here / "talker.ttt").write_bytes(with_scripts())
    (here / "talker.ttm").write_bytes(with_scripts(is_model=True))
    if way == "lent":
        assert v.simxLoadScene(client, str(here / "talker.ttt"), 1, BLOCKING) == 0
    elif way == "transferred":
        assert v.simxTransferFile(client, str(here / "talker.ttt"), "talker.ttt", 5000, BLOCKING) == 0
        assert v.simxLoadScene(client, "talker.ttt", 0, BLOCKING) == 0
    else:
        assert v.simxLoadModel(client, str(here / "talker.ttm"), 1, BLOCKING)[0] == 0
    assert "--allow-code" in error_of(client)
    assert said(client) == set()
    handle_of(client, "talker")


def test_scripts_of_the_operators_file_run(client, there) -> None:
    (there / "talker.ttt").write_bytes(with_scripts())
    assert v.simxLoadScene(client, "talker.ttt", 0, BLOCKING) == 0
    assert said(client) == {"child", "customization", "main"}


def test_scripts_of_a_buffer_do_not_run_without_allow_code() -> None:
    world = scripted({"lua:customization:base": "function sysCall_init() end"})
    evaluate(world, f"return sim.loadModel({as_text(with_scripts(is_model=True))})", kind=6)
    (script,) = [each for each in world.parts.scripts.all() if each.file.startswith("talker.custom")]
    assert script.of_client
    assert "--allow-code" in script.problem


def test_scene_named_by_a_stream_is_refused_with_what_to_do() -> None:
    class Call:
        task = SimpleNamespace(may_be_skipped=False)

        def abandon(self) -> None:
            pass

    with pytest.raises(
        CommandError, match="of V-REP, cannot be loaded by a stream; call it with a blocking mode"
    ):
        refuse_steps(Call())  # type: ignore[arg-type]


def test_log_tells_that_a_file_is_loaded_in_place_of_a_missing_one(client, world, there, caplog) -> None:
    (there / "robot.ttt").unlink()
    with caplog.at_level(logging.INFO):
        assert v.simxLoadScene(client, "robot.ttt", 0, BLOCKING) == 0
    assert "'robot.ttt' is not there" in caplog.text
    assert "robot.xml' is loaded in its place" in caplog.text


# --- scripts of the scene ---------------------------------------------------------------------------


def as_text(data: bytes) -> str:
    """A string of Lua with these bytes."""
    return '"' + "".join(f"\\{byte:03d}" for byte in data) + '"'


def test_script_loads_a_model_from_a_buffer() -> None:
    world = scripted({"lua:customization:base": "function sysCall_init() end"})
    data = as_text(file_of("brick", is_model=True))
    (handle,) = evaluate(world, f"return sim.loadModel({data})", kind=6)
    assert handle == world.handle("brick")
    assert world.parts.selection.handles == [handle]


def test_script_gets_an_error_for_a_broken_buffer() -> None:
    world = scripted({"lua:customization:base": "function sysCall_init() end"})
    data = as_text(file_of("brick", is_model=True)[:1100])
    done, text = evaluate(world, f"return pcall(sim.loadModel, {data})", kind=6)
    assert not done
    assert b"buffer.ttm" in text
    assert not {item.name for item in world.sim.scene.objects.values()} & {"brick"}


def test_script_loads_a_scene_from_a_buffer() -> None:
    world = scripted({"lua:customization:base": "function sysCall_init() end"})
    evaluate(world, f"return sim.loadScene({as_text(file_of('other'))})", kind=6)
    world.sim.settle()
    assert [item.name for item in world.sim.scene.objects.values()] == ["other"]
    assert world.sim.scene_is_of_client


# --- recordings -------------------------------------------------------------------------------------


def test_recording_has_the_files_that_were_opened(here: Path, there: Path) -> None:
    """The replay needs none of them: not the model of the start, the scene and models of either side."""
    recording = there / "run.simxlog"
    with recorded(there / "brick.ttm", recording) as server:
        client = server.client()
        assert v.simxLoadScene(client, "robot.ttt", 0, BLOCKING) == 0
        start_stepped(client)
        assert v.simxLoadModel(client, str(here / "block.ttm"), 1, BLOCKING)[0] == 0
        assert v.simxLoadModel(client, "brick.ttm", 0, BLOCKING)[0] == 0
        for _ in range(5):
            v.simxSynchronousTrigger(client)
        assert v.simxStopSimulation(client, BLOCKING) == 0
    for path in (*here.iterdir(), *there.iterdir()):
        if path != recording:
            path.unlink()
    assert replay(recording) == DONE
