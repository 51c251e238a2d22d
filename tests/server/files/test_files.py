"""Files from the client's side to the server's: transfer, erase, and loading what lies beside the script."""

from __future__ import annotations

import logging
import os
import zipfile
from pathlib import Path

import pytest
from processes import PENDULUM, server
from real_world import BLOCKING, RealWorld, handle_of
from scenes_for_tests import ARM

import simx_client as v
from simx_client.legacy import files
from simx_client.protocol.commands import BY_NAME
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.library import list_scenes

pytestmark = [pytest.mark.slow, pytest.mark.gl]

LOCAL_ERROR = v.simx_return_local_error_flag
REMOTE_ERROR = v.simx_return_remote_error_flag
CUBE = "<mujoco><worldbody><body name='cube'><geom type='box' size='.1 .1 .1'/></body></worldbody></mujoco>"


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """The client's folder."""
    folder = tmp_path / "client"
    folder.mkdir()
    (folder / "pendulum.xml").write_text(PENDULUM)
    (folder / "cube.xml").write_text(CUBE)
    return folder


@pytest.fixture
def there(tmp_path: Path) -> Path:
    """The server's workspace."""
    folder = tmp_path / "server"
    folder.mkdir()
    (folder / "arm.xml").write_text(ARM)
    return folder


@pytest.fixture
def world(there: Path):
    world = RealWorld(there / "arm.xml", workspace=there)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> int:
    return world.client()


def error_of(client: int) -> str:
    code, texts = v.simxGetLastErrors(client, BLOCKING)
    assert code == 0
    return "\n".join(texts)


def left_over(there: Path) -> list[str]:
    return sorted(path.name for path in there.iterdir() if path.name != "arm.xml")


# --- transfer and erase ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["copy.bin", b"copy.bin", "new/folder/copy.bin", "new\\folder\\copy.bin"])
def test_transferred_file_has_the_same_bytes_whatever_kind_of_name(client, here, there, name):
    data = bytes(range(256)) * 300
    (here / "some.bin").write_bytes(data)
    assert v.simxTransferFile(client, str(here / "some.bin"), name, 5000, BLOCKING) == 0
    text = name.decode() if isinstance(name, bytes) else name
    stored = there / text.replace("\\", "/")
    assert stored.read_bytes() == data
    assert v.simxTransferFile(client, os.fsencode(here / "cube.xml"), name, 5000, BLOCKING) == 0
    assert stored.read_text() == CUBE
    assert v.simxEraseFile(client, name, BLOCKING) == 0
    assert not stored.exists()
    assert v.simxEraseFile(client, name, BLOCKING) == REMOTE_ERROR
    assert "no file" in error_of(client)


def test_missing_local_file_is_a_local_error_and_nothing_is_sent(client, here, there, caplog):
    for mode in (BLOCKING, v.simx_opmode_oneshot):
        assert v.simxTransferFile(client, str(here / "no.bin"), "no.bin", 5000, mode) == LOCAL_ERROR
    assert v.simxTransferFile(client, str(here), "folder", 5000, BLOCKING) == LOCAL_ERROR
    assert left_over(there) == []
    assert "cannot be read" in caplog.text


def test_file_that_is_too_large_stays_here(client, here, there, caplog):
    with (here / "large.bin").open("wb") as file:
        file.truncate(files.MAX_FILE + 1)
    assert v.simxTransferFile(client, str(here / "large.bin"), "large.bin", 5000, BLOCKING) == LOCAL_ERROR
    assert "at most" in caplog.text
    assert left_over(there) == []


def test_other_modes_work_as_with_every_command(client, world, here, there):
    path = str(here / "cube.xml")
    assert v.simxTransferFile(client, path, "a.xml", 5000, v.simx_opmode_oneshot) == 1
    v.simxGetPingTime(client)
    assert (there / "a.xml").read_text() == CUBE
    assert v.simxTransferFile(client, path, "a.xml", 5000, v.simx_opmode_buffer) == 0
    assert v.simxTransferFile(client, "is not read", "a.xml", 5000, v.simx_opmode_remove) == 0
    assert v.simxTransferFile(client, "is not read", "a.xml", 5000, v.simx_opmode_remove) == 1
    assert v.simxEraseFile(client, "a.xml", v.simx_opmode_oneshot) == 1
    v.simxGetPingTime(client)
    assert not (there / "a.xml").exists()
    assert v.simxTransferFile(99, path, "a.xml", 5000, BLOCKING) == v.simx_return_initialize_error_flag


def test_time_out_of_the_transfer_is_the_one_that_was_given(client, here, monkeypatch):
    waits: list[float | None] = []
    connection = files.CLIENTS.get(client)
    assert connection is not None
    monkeypatch.setattr(
        connection, "blocking", lambda _shape, _values, timeout=None: waits.append(timeout) or 0
    )
    for milliseconds in (250, 0, -1):
        v.simxTransferFile(client, str(here / "cube.xml"), "a.xml", milliseconds, BLOCKING)
    assert waits == [0.25, None, None]


@pytest.mark.parametrize(
    "name",
    [
        "../out.bin",
        "a/../../out.bin",
        "/tmp/out.bin",
        "C:\\out.bin",
        "c:out.bin",
        "\\\\host\\share\\x",
        "",
        "  ",
        ".",
        "link/x",
    ],
)
def test_names_that_lead_out_of_the_workspace_are_refused(client, here, there, tmp_path, name):
    (tmp_path / "elsewhere").mkdir()
    (there / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "elsewhere" / "x").write_text("keep")
    (tmp_path / "out.bin").write_text("keep")
    assert v.simxTransferFile(client, str(here / "cube.xml"), name, 5000, BLOCKING) == REMOTE_ERROR
    assert v.simxEraseFile(client, name, BLOCKING) == REMOTE_ERROR
    assert "workspace" in error_of(client)
    assert (tmp_path / "elsewhere" / "x").read_text() == "keep"
    assert (tmp_path / "out.bin").read_text() == "keep"


def test_link_to_a_file_elsewhere_and_nul_are_refused(client, here, there, tmp_path):
    (tmp_path / "secret").write_text("keep")
    (there / "innocent.xml").symlink_to(tmp_path / "secret")
    assert v.simxTransferFile(client, str(here / "cube.xml"), "innocent.xml", 5000, BLOCKING) == REMOTE_ERROR
    assert v.simxEraseFile(client, "innocent.xml", BLOCKING) == REMOTE_ERROR
    assert v.simxLoadModel(client, "innocent.xml", 0, BLOCKING) == (REMOTE_ERROR, 0)
    assert "link" in error_of(client)
    assert (tmp_path / "secret").read_text() == "keep"
    with pytest.raises(CommandError, match="no file name"):
        workspace.path_within(there, "a\0b")


def test_folder_in_the_way_is_said(client, here, there):
    (there / "data").mkdir()
    assert v.simxTransferFile(client, str(here / "cube.xml"), "data", 5000, BLOCKING) == REMOTE_ERROR
    assert v.simxTransferFile(client, str(here / "cube.xml"), "arm.xml/x", 5000, BLOCKING) == REMOTE_ERROR
    assert v.simxEraseFile(client, "data", BLOCKING) == REMOTE_ERROR
    text = error_of(client)
    assert "is a folder" in text
    assert "cannot be written" in text


# --- loading from the client's side ---------------------------------------------------------------


@pytest.mark.parametrize("options", [1, 0xFF])
def test_scene_of_the_clients_side_is_loaded_and_leaves_no_file(client, world, here, there, options):
    assert v.simxLoadScene(client, str(here / "pendulum.xml"), options, BLOCKING) == 0
    assert handle_of(client, "hinge") == 1
    assert world.simulation.scene.name == "pendulum"
    assert left_over(there) == []
    assert v.simxStartSimulation(client, BLOCKING) == 0
    assert v.simxLoadScene(client, str(here / "cube.xml"), options, BLOCKING) == REMOTE_ERROR
    assert "stop it first" in error_of(client)
    assert v.simxStopSimulation(client, BLOCKING) == 0


def test_missing_vrep_scene_of_the_clients_side_is_replaced_by_the_file_beside_it(client, here, caplog):
    with caplog.at_level(logging.INFO):
        assert v.simxLoadScene(client, str(here / "pendulum.ttt"), 0xFF, BLOCKING) == 0
    assert "'pendulum.xml' beside it is sent in its place" in caplog.text
    assert handle_of(client, "hinge")


@pytest.mark.parametrize("name", ["pendulum.ttt", "ur5_rg2_kinect.ttt"])
def test_vrep_scene_that_the_client_sends_is_not_replaced_by_another_one(client, here, name):
    """Neither by the file beside it nor by the server's of that name: what is wrong with it must not stay hidden."""
    (here / name).write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    assert v.simxLoadScene(client, str(here / name), 1, BLOCKING) == REMOTE_ERROR
    assert f"'{name}' cannot be read: it is a Git LFS pointer" in error_of(client)


def test_xml_scene_of_coppeliasim_is_replaced_by_the_file_beside_it(client, here, caplog):
    (here / "pendulum.simscene.xml").write_text("<CoppeliaSim/>")
    with caplog.at_level(logging.INFO):
        assert v.simxLoadScene(client, str(here / "pendulum.simscene.xml"), 1, BLOCKING) == 0
    assert "'pendulum.xml' beside it is sent in its place" in caplog.text


def test_xml_scene_of_coppeliasim_alone_is_refused_with_what_to_do(client, here):
    (here / "other.simscene.xml").write_text("<CoppeliaSim/>")
    assert v.simxLoadScene(client, str(here / "other.simscene.xml"), 1, BLOCKING) == REMOTE_ERROR
    assert "save it as a .ttt" in error_of(client)


@pytest.mark.parametrize("name", ["cube.xml", b"cube.xml"])
def test_model_of_the_clients_side_is_loaded_while_running(client, world, here, there, monkeypatch, name):
    monkeypatch.chdir(here)
    assert v.simxStartSimulation(client, BLOCKING) == 0
    highest = max(world.simulation.scene.objects)
    code, base = v.simxLoadModel(client, name, 1, BLOCKING)
    assert code == 0
    assert base > highest
    assert v.simxGetObjectHandle(client, "cube#0", BLOCKING) == (0, base)
    assert v.simxGetObjectSelection(client, BLOCKING) == (0, [base])
    assert left_over(there) == []
    assert v.simxStopSimulation(client, BLOCKING) == 0
    assert v.simxGetObjectHandle(client, "cube#0", BLOCKING)[0] == REMOTE_ERROR


def test_mesh_of_the_clients_side_is_named_as_its_file_and_outlives_it(client, here, there):
    (here / "wedge.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    code, base = v.simxLoadModel(client, str(here / "wedge.obj"), 1, BLOCKING)
    assert code == 0
    assert handle_of(client, "wedge") == base
    assert v.simxCopyPasteObjects(client, [base], BLOCKING) == (0, [base + 1])
    assert left_over(there) == []


@pytest.mark.parametrize(
    ("call", "nothing"),
    [
        (lambda client, path: v.simxLoadScene(client, path, 1, BLOCKING), LOCAL_ERROR),
        (lambda client, path: v.simxLoadModel(client, path, 1, BLOCKING), (LOCAL_ERROR, 0)),
        (lambda client, path: v.simxLoadUI(client, path, 1, BLOCKING), (LOCAL_ERROR, [])),
    ],
)
def test_what_cannot_be_read_here_is_a_local_error(client, world, here, call, nothing, caplog):
    scene = world.simulation.scene
    assert call(client, str(here / "missing.xml")) == nothing
    assert "missing.xml' cannot be read" in caplog.text
    assert world.simulation.scene is scene


def test_references_of_a_file_that_came_alone_are_named_until_they_are_brought(client, here, there):
    (here / "table.xml").write_text(
        "<mujoco><asset><mesh name='m' file='top.obj'/></asset>"
        "<worldbody><body name='table'><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
    )
    (here / "top.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    assert v.simxLoadModel(client, str(here / "table.xml"), 1, BLOCKING) == (REMOTE_ERROR, 0)
    text = error_of(client)
    assert "top.obj" in text
    assert "'table.xml' alone" in text
    assert "simxTransferFile" in text
    assert "TEMPFILE" not in text
    assert left_over(there) == []
    assert v.simxTransferFile(client, str(here / "top.obj"), "top.obj", 5000, BLOCKING) == 0
    code, table = v.simxLoadModel(client, str(here / "table.xml"), 1, BLOCKING)
    assert code == 0
    assert handle_of(client, "table") == table


def test_ui_of_the_clients_side_is_loaded(client, here, there):
    (here / "panel.toml").write_text('[[ui]]\nname = "panel"\n[[ui.element]]\nid = 3\nkind = "button"\n')
    (here / "panel.ttb").write_bytes(b"VREP")
    code, handles = v.simxLoadUI(client, str(here / "panel.ttb"), 1, BLOCKING)
    assert code == 0, error_of(client)
    assert v.simxGetUIHandle(client, "panel", BLOCKING) == (0, handles[0])
    assert left_over(there) == []


def test_oneshot_load_keeps_the_key_of_the_given_path(client, here):
    path = str(here / "cube.xml")
    assert v.simxLoadModel(client, path, 1, v.simx_opmode_oneshot) == (1, 0)
    v.simxGetPingTime(client)
    code, base = v.simxLoadModel(client, path, 1, v.simx_opmode_buffer)
    assert code == 0
    assert handle_of(client, "cube#0") == base
    assert v.simxLoadModel(client, path, 1, v.simx_opmode_remove) == (0, 0)
    assert v.simxLoadModel(client, path, 1, v.simx_opmode_remove) == (1, 0)


def test_server_keeps_few_lent_files_and_needs_each_one_sent(client, world):
    connection = files.CLIENTS.get(client)
    assert connection is not None
    for number in range(6):
        assert connection.blocking(files._LEND, [f"path{number}", "a.xml", CUBE.encode()]) == 0
    (session,) = world.loop.service.clients.sessions.values()
    assert list(session.lent_files) == ["path2", "path3", "path4", "path5"]
    load = files.Marshal(BY_NAME["simxLoadModel"])
    assert connection.blocking(load, ["path0", 1]) == (REMOTE_ERROR, 0)
    assert "has not sent 'path0'" in error_of(client)
    assert connection.blocking(load, ["path5", 1])[0] == 0
    assert connection.blocking(load, ["path5", 1])[0] == REMOTE_ERROR


def test_lent_file_under_a_hostile_name_is_refused(client, there):
    connection = files.CLIENTS.get(client)
    assert connection is not None
    paths = ("../../x.xml", "a/x.xml", "/x.xml", "a\\x.xml", "..\\x.xml")
    for name in ("C:\\x.xml", "", "a\0b", "/", "..", "x.xml/", "x" * 300 + ".xml", *paths):
        assert connection.blocking(files._LEND, ["path", name, CUBE.encode()]) == REMOTE_ERROR, name
        assert connection.blocking(files.Marshal(BY_NAME["simxLoadScene"]), ["path", 1]) == REMOTE_ERROR
    assert "'a/x.xml' is a path; give the file's name alone" in error_of(client)
    assert left_over(there) == []
    assert left_over(there.parent) == ["server"]


@pytest.mark.parametrize(
    "path", ["C:\\scenes\\cube.xml", "\\\\host\\cube.xml", "../client/cube.xml", "/etc/hostname", "C:\\", "/"]
)
def test_server_side_paths_outside_are_refused(client, here, path):
    assert v.simxLoadScene(client, path, 0, BLOCKING) == REMOTE_ERROR
    assert error_of(client)


@pytest.mark.parametrize("path", ["/", "//", ".", "..", "models/", "\\", "a/..", "x.xml/", " "])
def test_what_names_no_file_is_said_before_anything_is_loaded(client, world, path):
    before = len(world.simulation.scene.objects)
    assert v.simxLoadScene(client, path, 0, BLOCKING) == REMOTE_ERROR
    assert v.simxLoadModel(client, path, 0, BLOCKING) == (REMOTE_ERROR, 0)
    assert v.simxTransferFile(client, str(world.simulation.scene.path), path, 5000, BLOCKING) == REMOTE_ERROR
    text = error_of(client)
    assert text.count("names a folder; give a file's path") + text.count("is no file name") == 3
    for options in (0, 1):
        assert v.simxLoadUI(client, path, options, BLOCKING)[0] != 0
    assert v.simxLoadScene(client, path, 1, BLOCKING) != 0
    assert v.simxLoadModel(client, path, 1, BLOCKING)[0] != 0
    assert len(world.simulation.scene.objects) == before


@pytest.mark.parametrize(
    "folder", ["C:/Program Files/V-REP3/models/", "C:\\V-REP3\\models\\", "\\\\host\\models\\"]
)
def test_model_of_an_installed_original_is_found_by_its_name(client, folder):
    code, base = v.simxLoadModel(client, f"{folder}RG2.ttm", 0, BLOCKING)
    assert code == 0
    assert v.simxGetObjectHandle(client, "RG2", BLOCKING) == (0, base)


def test_unknown_model_lists_the_models_that_there_are(client):
    assert v.simxLoadModel(client, "C:/V-REP3/models/Asti.ttm", 0, BLOCKING) == (REMOTE_ERROR, 0)
    assert "no model 'Asti.ttm'; shipped models: 7_dof_manipulator, " in error_of(client)


OUTSIDE = {
    "absolute": "<mujoco><asset><hfield name='h' file='{outside}/h.bin' size='1 1 1 1'/></asset></mujoco>",
    "above": "<mujoco><asset><mesh name='m' file='../elsewhere/m.obj'/></asset></mujoco>",
    "directory": "<mujoco><compiler meshdir='{outside}'/><asset><mesh name='m' file='m.obj'/></asset></mujoco>",
    "include": "<mujoco><include file='inner.xml'/></mujoco>",
    "malformed": "<mujoco><asset><mesh name='m' file='{outside}/m.obj'/></asset><bad></mujoco>",
}


@pytest.mark.parametrize("kind", OUTSIDE)
def test_file_that_names_files_outside_the_workspace_is_refused(client, world, here, there, tmp_path, kind):
    outside = tmp_path / "elsewhere"
    outside.mkdir()
    (outside / "m.obj").write_text("v 0 0 0\n")
    (here / "spy.xml").write_text(OUTSIDE[kind].format(outside=outside))
    (there / "inner.xml").write_text(OUTSIDE["above"])
    scene = world.simulation.scene
    assert v.simxLoadScene(client, str(here / "spy.xml"), 1, BLOCKING) == REMOTE_ERROR
    assert v.simxLoadModel(client, str(here / "spy.xml"), 1, BLOCKING) == (REMOTE_ERROR, 0)
    (there / "spy.xml").write_text((here / "spy.xml").read_text())
    assert v.simxLoadScene(client, "spy.xml", 0, BLOCKING) == REMOTE_ERROR
    assert ("well-formed" if kind == "malformed" else "outside the folders") in error_of(client)
    assert world.simulation.scene is scene


@pytest.mark.parametrize("scene", list_scenes())
def test_each_shipped_scene_is_loaded_by_a_client(client, scene):
    assert v.simxLoadScene(client, f"{scene}.xml", 0, BLOCKING) == 0, error_of(client)


def test_zip_of_a_model_is_looked_into(client, here):
    for name, text in (("good", CUBE), ("bad", OUTSIDE["above"])):
        with zipfile.ZipFile(here / f"{name}.zip", "w") as archive:
            archive.writestr(f"{name}.xml", text)
    assert v.simxLoadModel(client, str(here / "bad.zip"), 1, BLOCKING) == (REMOTE_ERROR, 0)
    assert "outside the folders" in error_of(client)
    code, base = v.simxLoadModel(client, str(here / "good.zip"), 1, BLOCKING)
    assert code == 0
    assert handle_of(client, "cube#0") == base
    (here / "no.zip").write_text("no archive")
    assert v.simxLoadModel(client, str(here / "no.zip"), 1, BLOCKING) == (REMOTE_ERROR, 0)


# --- over the network -----------------------------------------------------------------------------


def test_files_travel_over_a_real_connection(tmp_path, here, there):
    data = os.urandom(3 << 20)
    (here / "large.bin").write_bytes(data)
    with server(there / "arm.xml", "--workspace", there) as process:
        client = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
        try:
            assert v.simxTransferFile(client, str(here / "large.bin"), "large.bin", 20000, BLOCKING) == 0
            assert (there / "large.bin").read_bytes() == data
            assert v.simxEraseFile(client, "large.bin", BLOCKING) == 0
            code, base = v.simxLoadModel(client, str(here / "cube.xml"), 1, BLOCKING)
            assert code == 0
            assert v.simxGetObjectHandle(client, "cube#0", BLOCKING) == (0, base)
            assert v.simxLoadScene(client, str(here / "pendulum.xml"), 1, BLOCKING) == 0
            assert v.simxGetObjectHandle(client, "hinge", BLOCKING)[0] == 0
            assert left_over(there) == []
        finally:
            v.simxFinish(client)
