"""Scenes and models that a client names: by a name, or a path of the machine that its program was written on."""

from __future__ import annotations

import logging
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest
from handler_calls import World
from processes import PENDULUM
from real_world import BLOCKING, handle_of, start_stepped
from recordings import recorded, replay
from scenes_for_tests import ARM
from urdf_robots import write_arm

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE
from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes
from simx_server.handlers.files import lend_file, store_file
from simx_server.handlers.scene_files.script_files import load_scene_of_server
from simx_server.recording.log_file import LogReader
from simx_server.recording.records import Kind
from simx_server.scene.formats.sources import Sources
from simx_server.service.clients.sessions import ClientSession
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow


@pytest.fixture
def world(tmp_path: Path) -> World:
    """The open scene is `project/My Robot.xml`; a pendulum lies beside it, a cube in the workspace."""
    project, workspace = tmp_path / "project", tmp_path / "workspace"
    project.mkdir()
    workspace.mkdir()
    (project / "My Robot.xml").write_text(ARM)
    (project / "pendulum.xml").write_text(PENDULUM)
    cube = "<mujoco><worldbody><body name='cube'><geom size='.1'/></body></worldbody></mujoco>"
    (workspace / "cube.urdf.xml").write_text(cube)
    (workspace / "cube.xml").write_text(cube)
    return World(file=project / "My Robot.xml", workspace=workspace)


PATHS = {
    "open": [
        "My Robot",
        "My Robot.ttt",
        "my_robot.ttt",
        "C:\\Users\\me\\My Robot.ttt",
        "/home/me/scenes/My Robot.ttt",
    ],
    "beside": [
        "pendulum",
        "pendulum.xml",
        "C:\\Users\\me\\pendulum.ttt",
        "D:/old/pendulum.xml",
        "../x/pendulum.ttt",
    ],
    "workspace": ["cube", "cube.ttt", "/home/me/cube.ttt", "\\\\server\\share\\cube.ttt", "C:\\cube.xml"],
    "shipped": ["ur5_rg2_kinect", "/opt/V-REP/scenes/ur5 rg2 kinect.ttt", "C:\\scenes\\ur5_rg2_kinect.xml"],
}
OBJECTS = {"open": "shoulder", "beside": "hinge", "workspace": "cube", "shipped": "UR5_joint1"}


@pytest.mark.parametrize(
    ("where", "path"), [(where, path) for where, paths in PATHS.items() for path in paths]
)
def test_scene_is_found_by_its_name_whatever_the_path(world: World, where: str, path: str) -> None:
    world.call("simxLoadScene", path, 0)
    assert world.handle(OBJECTS[where])


def test_scene_that_a_script_names_is_found_too(world: World) -> None:
    load_scene_of_server(world.parts, "C:\\Users\\me\\pendulum.ttt")
    world.sim.settle()
    assert world.handle("hinge")


def test_open_scene_is_loaded_anew_by_its_old_name_whatever_its_ending(tmp_path: Path) -> None:
    file = write_arm(tmp_path)
    world = World(file=file, workspace=tmp_path)
    for name in ("my_arm.ttt", "C:\\V-REP\\my_arm.ttt", "my_arm.xml", "/home/me/my_arm.urdf"):
        before = world.sim.scene
        world.call("simxLoadScene", name, 0)
        assert world.sim.scene is not before
        assert world.sim.scene.path == file


def test_file_at_the_path_comes_before_one_of_the_same_name(world: World, tmp_path: Path) -> None:
    inner = tmp_path / "workspace" / "inner"
    inner.mkdir()
    (inner / "cube.xml").write_text(PENDULUM)
    world.call("simxLoadScene", "inner/cube.ttt", 0)
    assert world.handle("hinge")
    world.call("simxLoadScene", str(inner / "cube.xml"), 0)
    assert world.handle("hinge")


def test_message_tells_where_it_was_searched(world: World, tmp_path: Path) -> None:
    with pytest.raises(CommandError) as problem:
        world.call("simxLoadScene", "C:\\Users\\me\\robot.ttt", 0)
    text = str(problem.value)
    assert "no scene 'robot.ttt'" in text
    assert "looked for robot.ttt, robot.xml, robot.mjcf, robot.urdf, ..." in text
    assert f"in {tmp_path / 'project'} and {tmp_path / 'workspace'} and among the shipped ones" in text
    assert text.endswith("; put it there")


def test_stand_in_for_a_path_elsewhere_is_told(world: World, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        world.call("simxLoadScene", "/home/me/cube.xml", 0)
    assert "'/home/me/cube.xml' is not among what clients may open" in caplog.text


def test_answer_does_not_tell_what_lies_outside(world: World, tmp_path: Path) -> None:
    (tmp_path / "secret.xml").write_text(ARM)
    texts = []
    for name in ("secret.xml", "nothing.xml"):
        with pytest.raises(CommandError) as problem:
            world.call("simxLoadScene", str(tmp_path / name), 0)
        texts.append(str(problem.value).replace(name, "").replace(Path(name).stem, ""))
    assert texts[0] == texts[1]


@pytest.mark.parametrize("path", ["panel.ttb", "C:\\Users\\me\\panel.ttb", "/home/me/panel.toml"])
def test_ui_is_found_by_its_name_too(world: World, tmp_path: Path, path: str) -> None:
    (tmp_path / "workspace" / "panel.toml").write_text('[[ui]]\nname = "panel"\n')
    world.call("simxLoadUI", path, 0)
    assert world.call("simxGetUIHandle", "panel") >= 0


# --- what the operator's scene names, and recordings ----------------------------------------------


def test_scene_of_the_start_may_be_loaded_again_with_what_it_names_elsewhere(tmp_path: Path) -> None:
    """A URDF's meshes lie beside its folder, and not within it; it was the operator who named them."""
    file = write_arm(tmp_path)
    workspace = tmp_path / "workspace"
    workspace.mkdir()
    world = World(file=file, workspace=workspace)
    world.sim.files.own_scene = file
    world.call("simxLoadScene", "my_arm.ttt", 0)
    assert world.handle("elbow_joint")
    (workspace / "copy.urdf").write_text(file.read_text())
    with pytest.raises(CommandError, match="not there"):
        world.call("simxLoadScene", "copy.urdf", 0)


def test_scene_of_the_start_that_a_client_has_changed_is_trusted_no_more(tmp_path: Path) -> None:
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    workspace = tmp_path / "workspace"
    workspace.mkdir()
    file = workspace / "scene.xml"
    file.write_text(PENDULUM)
    world = World(file=file, workspace=workspace)
    world.sim.files.own_scene = file
    spy = "<mujoco><asset><mesh name='m' file='../secret.obj'/></asset></mujoco>"
    store_file(world.parts, "scene.xml", spy.encode())
    with pytest.raises(CommandError, match="outside the folders"):
        world.call("simxLoadScene", "scene.xml", 0)


def test_recording_has_shipped_parts_and_meshes_of_packages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The replay finds them, although none of them is where it was."""
    shipped, packages, place = tmp_path / "shipped", tmp_path / "ros", tmp_path / "place"
    place.mkdir()
    packages.mkdir()
    for part in (
        "parts/settings.xml",
        "parts/default_scene.xml",
        "parts/floor_tiles.png",
        "models/pioneer_p3dx.xml",
    ):
        (shipped / part).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(shipped_scenes() / part, shipped / part)
    made = Sources.of
    monkeypatch.setattr(Sources, "of", lambda packages=(), *_, **__: replace(made(packages), shipped=shipped))
    robots = place / "robots.xml"
    robots.write_text(
        "<mujoco><include file='models/pioneer_p3dx.xml'/>"
        "<custom><text name='simx:copies:Pioneer_p3dx' data='y=1'/></custom></mujoco>"
    )
    urdf = write_arm(packages).rename(place / "my_arm.urdf")
    recording = place / "run.simxlog"
    package = f"my_arm_description={packages / 'my_arm_description'}"
    with recorded(urdf, recording, package=(package,)) as server:
        client = server.client()
        for scene, joint in (("my_arm.urdf", "elbow_joint"), ("robots.xml", "Pioneer_p3dx_leftMotor#0")):
            assert v.simxLoadScene(client, scene, 0, BLOCKING) == 0
            start_stepped(client)
            v.simxSetJointTargetVelocity(client, handle_of(client, joint), 1.0, BLOCKING)
            for _ in range(3):
                v.simxSynchronousTrigger(client)
            assert v.simxStopSimulation(client, BLOCKING) == 0
    monkeypatch.undo()
    for folder in (shipped, packages):
        shutil.rmtree(folder)
    robots.unlink()
    urdf.unlink()
    assert replay(recording) == DONE


@pytest.mark.parametrize("is_in_first_scene", [False, True])
def test_what_a_clients_robot_was_refused_is_refused_in_the_replay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_in_first_scene: bool
) -> None:
    """Its package is in ROS_PACKAGE_PATH, which the scene of the start alone may use."""
    packages, place = tmp_path / "ros", tmp_path / "place"
    packages.mkdir()
    place.mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(packages))
    urdf = write_arm(packages).rename(place / "my_arm.urdf")
    mesh = packages / "my_arm_description" / "meshes" / "visual" / "base_link.obj"
    mine = tmp_path / "mine.urdf"
    mine.write_text(urdf.read_text().replace('"tool0_joint" type="fixed"', '"tool0_joint" type="continuous"'))
    other = place / "pendulum.xml"
    other.write_text(PENDULUM)
    recording = place / "run.simxlog"
    with recorded(urdf if is_in_first_scene else other, recording) as server:
        client = server.client()
        assert v.simxTransferFile(client, str(mine), "mine.urdf", 1, BLOCKING) == 0
        assert v.simxLoadScene(client, "mine.urdf", 0, BLOCKING) != 0
        start_stepped(client)
        v.simxSynchronousTrigger(client)
        assert v.simxStopSimulation(client, BLOCKING) == 0
    assert (mesh.read_bytes() in recorded_contents(recording)) == is_in_first_scene
    assert replay(recording) == DONE


def recorded_contents(recording: Path) -> list[bytes]:
    """Of all files in it."""
    return [record[3] for record in LogReader(recording) if record[0] == Kind.FILE]


# --- lent files -----------------------------------------------------------------------------------


def lend(world: World, name: str, text: str) -> None:
    lend_file(world.parts, cast(ClientSession, world.client), name, name, text.encode())


def test_lent_file_keeps_its_name_in_log_errors_and_listings(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = World(workspace=tmp_path)
    names: list[str] = []
    use = Simulation.use

    def noting(self: Simulation, *arguments: Any, **more: Any) -> None:
        use(self, *arguments, **more)
        names.append(self.scene.name)

    monkeypatch.setattr(Simulation, "use", noting)
    with caplog.at_level(logging.DEBUG):
        lend(world, "robot.xml", ARM)
        world.call("simxLoadScene", "robot.xml", 1)
        lend(world, "table.xml", "<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
        base = world.call("simxLoadModel", "table.xml", 1)
        problems = []
        for bad in (
            "<mujoco><bad></mujoco>",
            "<mujoco><bad/></mujoco>",
            "<mujoco><include file='missing.xml'/></mujoco>",
            "<mujoco><worldbody><body><joint/></body></worldbody></mujoco>",
            "<robot name='r'><xacro:a/></robot>",
            "<robot name='r'><link name='a'><collision><geometry><mesh filename='m.obj'/></geometry></collision></link>"
            "</robot>",
        ):
            for call in ("simxLoadScene", "simxLoadModel"):
                lend(world, "broken.xml", bad)
                with pytest.raises(CommandError) as problem:
                    world.call(call, "broken.xml", 1)
                problems.append(str(problem.value))
    assert world.sim.scene.get(base).name == "table"
    assert names == ["robot"]
    assert "scene 'robot' is loaded" in caplog.text
    assert all("'broken.xml'" in text for text in problems), problems
    assert "TEMPFILE" not in caplog.text + "".join(problems)
