"""Robots in URDF: packages and meshes are found, joints and links arrive as V-REP's importer made them."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import mujoco
import pytest
from handler_calls import World
from urdf_robots import DIFFERENTIAL, GRIPPER, TETRAHEDRON, arm, write_arm

from simx_client.protocol.cli.installing import extra_line
from simx_server.app import cli
from simx_server.errors import CommandError
from simx_server.joints.state import JointMode
from simx_server.scene.formats import sources as sources_module
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.meshes import collada, polygons
from simx_server.scene.formats.sources import PACKAGE_FILE, Sources
from simx_server.scene.formats.urdf import joints as urdf_joints
from simx_server.scene.formats.urdf import reading
from simx_server.scene.formats.urdf.reading import read_urdf, urdf_files
from simx_server.scene.geometry.overlaps import overlaps

NO_ENVIRONMENT: dict[str, str] = {}
LINK = '<link name="{}"><inertial><mass value="{}"/><inertia {}/></inertial><collision>{}</collision></link>'
ONE = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
BALL = '<geometry><sphere radius="0.1"/></geometry>'


def sources(*packages: str, **environment: str) -> Sources:
    return Sources.of(packages, environment)


def written(folder: Path, text: str, name: str = "robot.urdf") -> Path:
    file = folder / name
    file.write_text(text)
    return file


# --- packages and meshes --------------------------------------------------------------------------


def test_package_is_found_above_the_file(tmp_path: Path) -> None:
    scene, model = load_scene(write_arm(tmp_path), sources())
    assert model.nmesh == 8
    assert scene.by_name("forearm_link") is not None


def moved_urdf(tmp_path: Path) -> tuple[Path, Path]:
    """A URDF away from its package, and the folder that holds the package."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "ros" / "src").mkdir(parents=True)
    file = write_arm(tmp_path / "ros" / "src")
    return file.rename(elsewhere / "robot.urdf"), tmp_path / "ros" / "src"


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "GAZEBO_MODEL_PATH"])
def test_package_is_found_by_the_variables_of_ros_and_gazebo(tmp_path: Path, variable: str) -> None:
    file, root = moved_urdf(tmp_path)
    with pytest.raises(SceneError, match="--package my_arm_description=DIR"):
        load_scene(file, sources())
    for path in (root, root.parent, root / "my_arm_description"):
        _, model = load_scene(file, sources(**{variable: f"/nowhere:{path}"}))
        assert model.nmesh == 8


def test_package_of_ros_2_is_found_in_an_install_prefix(tmp_path: Path) -> None:
    file, root = moved_urdf(tmp_path)
    share = tmp_path / "install" / "share"
    share.mkdir(parents=True)
    (root / "my_arm_description").rename(share / "my_arm_description")
    _, model = load_scene(file, sources(AMENT_PREFIX_PATH=str(share.parent)))
    assert model.nmesh == 8


def test_package_file_tells_the_name_of_a_folder_that_is_called_otherwise(tmp_path: Path) -> None:
    file, root = moved_urdf(tmp_path)
    (root / "my_arm_description").rename(root / "arm-noetic-devel")
    _, model = load_scene(file, sources(ROS_PACKAGE_PATH=str(root)))
    assert model.nmesh == 8


@pytest.mark.parametrize("read", [load_scene, urdf_files])
def test_package_file_is_parsed_once_however_many_meshes_name_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read: Callable[..., object]
) -> None:
    file = write_arm(tmp_path)
    package = file.parents[1].rename(tmp_path / "arm-devel")
    parsed: list[bytes] = []
    parse, error = sources_module.ElementTree.fromstring, sources_module.ElementTree.ParseError
    counting = SimpleNamespace(
        fromstring=lambda text: (parsed.append(text), parse(text))[1], ParseError=error
    )
    monkeypatch.setattr(sources_module, "ElementTree", counting)
    for _ in range(2):
        parsed.clear()
        read(package / "urdf" / file.name, sources(ROS_PACKAGE_PATH=str(tmp_path)))
        assert len(parsed) == 1, "and anew with each read, since it may have changed"


def test_package_file_that_is_too_long_gives_no_name(tmp_path: Path) -> None:
    file = write_arm(tmp_path)
    package = file.parents[1].rename(tmp_path / "arm-devel")
    named = "<package><name>my_arm_description</name>{}</package>"
    (package / PACKAGE_FILE).write_text(named.format(" " * 60_000))
    assert load_scene(package / "urdf" / file.name, sources())[1].nmesh == 8
    (package / PACKAGE_FILE).write_text(named.format(" " * 70_000))
    with pytest.raises(SceneError, match="no folder of the package my_arm_description was found"):
        load_scene(package / "urdf" / file.name, sources())


def test_package_flag_comes_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, root = moved_urdf(tmp_path)
    given = f"my_arm_description={root / 'my_arm_description'}"
    _, model = load_scene(file, sources(given))
    assert model.nmesh == 8
    assert cli.main([str(file), "--package", given, "--tree"]) == 0
    assert "shoulder_pan_joint" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        cli.main(["--package", "my_arm_description=/not/there"])
    assert "NAME=DIR with an existing folder" in capsys.readouterr().err


@pytest.mark.parametrize("scheme", ["model://my_arm_description", "file://{}", "..", "{}"])
def test_other_ways_to_name_a_mesh_are_understood(tmp_path: Path, scheme: str) -> None:
    file = write_arm(tmp_path)
    file.write_text(arm(scheme.format(file.parents[1])))
    assert load_scene(file, sources())[1].nmesh == 8


def test_mesh_that_is_not_there_is_told_with_the_places(tmp_path: Path) -> None:
    file = write_arm(tmp_path)
    (file.parents[1] / "meshes" / "visual" / "base_link.obj").unlink()
    with pytest.raises(SceneError) as problem:
        load_scene(file, sources())
    assert "names 'package://my_arm_description/meshes/visual/base_link.obj', which is not there" in str(
        problem.value
    )
    assert str(file.parents[1] / "meshes" / "visual" / "base_link.obj") in str(problem.value)


def renamed(file: Path, kind: str, ending: str = ".dae") -> None:
    for path in (file.parents[1] / "meshes" / kind).iterdir():
        path.rename(path.with_suffix(ending))


def test_damaged_mesh_is_left_out_where_it_is_only_seen(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    pytest.importorskip("collada", reason=extra_line("urdf"))
    file = write_arm(tmp_path, arm(visual_ending="dae"))
    renamed(file, "visual")
    _, model = load_scene(file, sources())
    assert model.nmesh == 4
    assert (model.geom_group[model.geom_type == mujoco.mjtGeom.mjGEOM_MESH] == 0).all(), (
        "what collides is shown then"
    )
    told = [each for each in caplog.messages if "is drawn without" in each]
    assert len(told) == 4
    assert "cannot read 'base_link.dae': it is no valid COLLADA" in told[0]


def test_damaged_mesh_that_collides_is_an_error(tmp_path: Path) -> None:
    pytest.importorskip("collada", reason=extra_line("urdf"))
    file = write_arm(tmp_path, arm(collision_ending="dae"))
    renamed(file, "collision")
    with pytest.raises(SceneError, match=r"cannot read 'base_link.dae': it is no valid COLLADA"):
        load_scene(file, sources())


@pytest.mark.parametrize("ending", ["dae", "ply"])
def test_without_the_library_a_readable_mesh_beside_the_file_is_taken(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    for module in (collada, polygons):
        monkeypatch.setattr(module, "is_available", lambda: False)
    file = write_arm(tmp_path, arm(visual_ending=ending, collision_ending=ending))
    assert load_scene(file, sources())[1].nmesh == 8
    assert not caplog.messages
    renamed(file, "visual", f".{ending}")
    assert load_scene(file, sources())[1].nmesh == 4
    assert "is drawn without" in caplog.text
    assert extra_line("urdf") in caplog.text
    renamed(file, "collision", f".{ending}")
    with pytest.raises(SceneError, match=r"a library reads those: .*pycollada"):
        load_scene(file, sources())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<robot name='r'/>", "no <link>"),
        ("<robot><link name='a'></robot>", "no well-formed XML"),
        ("<!DOCTYPE r [<!ENTITY a 'b'>]><robot><link name='&a;'/></robot>", "declares XML entities"),
    ],
)
def test_what_is_no_robot_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        load_scene(written(tmp_path, text), sources())


# --- joints and links -----------------------------------------------------------------------------


def test_joints_have_their_motor_on_position_control_and_the_limits_of_the_file(tmp_path: Path) -> None:
    world = World(file=write_arm(tmp_path))
    elbow = world.handle("elbow_joint")
    state = world.sim.joints._states[elbow]
    assert (state.mode, state.motor, state.control_loop) == (JointMode.FORCE, True, True)
    assert (state.max_force, state.upper_velocity, state.cyclic) == (28, 3.2, False)
    assert world.sim.joints.interval(elbow) == pytest.approx((False, -3.0, 2.5))
    # It may not be at 0: it starts at the nearest end, where it is told to be, and the axis need not be of length 1.
    assert state.target_position == world.call("simxGetJointPosition", elbow) == pytest.approx(-0.5)
    link = world.sim.model.body("forearm_link")
    assert link.quat == pytest.approx([0.9689124, 0, -0.2474040, 0], abs=1e-6)
    world.call("simxSetJointTargetPosition", elbow, -2.0)
    world.run(40)
    assert world.call("simxGetJointPosition", elbow) == pytest.approx(-2.0, abs=0.02)
    # A force below the file's effort and one above it are both V-REP's to set.
    world.call("simxSetJointMaxForce", elbow, 100.0)
    assert not world.sim.model.jnt_actfrclimited.any()


def test_robot_on_wheels_is_free_and_drives(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO):
        world = World(file=written(tmp_path, DIFFERENTIAL))
    assert "'base_footprint' stands on its moving links" in caplog.text
    assert "the inertia of 'caster' is zero" in caplog.text
    assert not overlaps(world.sim.scene, world.sim.model, world.sim.data)
    left, right = world.handle("left_wheel_joint"), world.handle("right_wheel_joint")
    assert world.sim.joints._states[left].cyclic
    base = world.handle("base_link")
    assert world.call("simxGetObjectPosition", base, -1)[2] == pytest.approx(0.08, abs=1e-3)
    for wheel in (left, right):
        world.call("simxSetJointTargetVelocity", wheel, 2.0)
    world.run(40)
    x, y, _ = world.call("simxGetObjectPosition", base, -1)
    assert x == pytest.approx(2 * 0.08 * 2.0, rel=0.03)
    assert abs(y) < 0.01


def test_arm_stays_where_it_is_fixed(tmp_path: Path) -> None:
    world = World(file=write_arm(tmp_path))
    base = world.handle("base_link")
    world.run(20)
    assert world.call("simxGetObjectPosition", base, -1) == [0, 0, 0]


def test_mimic_joint_follows_its_master(tmp_path: Path) -> None:
    world = World(file=written(tmp_path, GRIPPER))
    left, right = world.handle("left_finger_joint"), world.handle("right_finger_joint")
    state = world.sim.joints._states[right]
    assert (state.mode, state.master, state.factor) == (JointMode.DEPENDENT, left, -1)
    world.call("simxSetJointTargetPosition", left, 0.03)
    world.run(20)
    assert world.call("simxGetJointPosition", left) == pytest.approx(0.03, abs=1e-3)
    assert world.call("simxGetJointPosition", right) == pytest.approx(-0.03, abs=1e-3)


def test_links_that_a_joint_connects_do_not_collide_with_what_is_fixed_to_them() -> None:
    """MuJoCo parts a parent from its child, but not from the world's own bodies; and a fixed link is a body too."""
    joint = (
        '<joint name="{0}_{1}" type="{2}"><parent link="{0}"/><child link="{1}"/><origin xyz="0 0 {3}"/>'
        '<axis xyz="0 0 1"/></joint>'
    )
    text = "".join(LINK.format(name, 1, ONE, BALL) for name in ("world", "base", "plate", "arm", "hand"))
    text += joint.format("world", "base", "fixed", 0) + joint.format("base", "plate", "fixed", 0)
    text += joint.format("base", "arm", "continuous", 1) + joint.format("arm", "hand", "continuous", 1)
    spec = read_urdf(f'<robot name="r">{text}</robot>'.encode(), "r.urdf", None, sources())
    # The world's own ball and those of the base touch the hand only: between them and it lies the arm.
    assert parted(spec) == {("world", "arm"), ("base", "arm"), ("plate", "arm"), ("arm", "hand")}


def parted(spec: mujoco.MjSpec) -> set[tuple[str, str]]:
    return {(each.bodyname1, each.bodyname2) for each in spec.excludes}


def test_links_that_overlap_in_the_pose_of_the_file_do_not_collide(
    caplog: pytest.LogCaptureFixture,
) -> None:
    joint = (
        '<joint name="to_{1}" type="continuous"><parent link="{0}"/><child link="{1}"/>'
        '<origin xyz="{2} 0 0"/><axis xyz="0 0 1"/></joint>'
    )
    text = "".join(LINK.format(name, 1, ONE, BALL) for name in ("base", "arm", "hand", "tip"))
    text += (
        joint.format("base", "arm", 0.1)
        + joint.format("arm", "hand", 0.05)
        + joint.format("hand", "tip", 0.1)
    )
    with caplog.at_level(logging.INFO):
        spec = read_urdf(f'<robot name="r">{text}</robot>'.encode(), "r.urdf", None, sources())
    assert ("base", "hand") in parted(spec)
    assert ("base", "tip") not in parted(spec)
    assert "do not collide: 'arm' and 'tip', 'base' and 'hand'" in caplog.text


def joined(*joints: tuple[str, str, str]) -> bytes:
    """A URDF of balls; joints are (parent, child, type)."""
    names = dict.fromkeys(name for joint in joints for name in joint[:2])
    text = "".join(LINK.format(name, 1, ONE, BALL) for name in names)
    for parent, child, kind in joints:
        text += (
            f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'
        )
    return f'<robot name="r">{text}</robot>'.encode()


def test_each_link_is_looked_at_a_few_times_however_many_joints_its_neighbours_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked: list[str] = []
    collides = urdf_joints._collides
    monkeypatch.setattr(urdf_joints, "_collides", lambda body: looked.append(body.name) or collides(body))
    monkeypatch.setattr(reading, "part_overlapping", lambda *_: None)
    count = 50
    fixed = [("base", f"fixed{i}", "fixed") for i in range(count)]
    turning = [("base", f"turning{i}", "continuous") for i in range(count)]
    spec = read_urdf(joined(*fixed, *turning), "r.urdf", None, sources())
    assert len(spec.excludes) == count * (count + 1)
    assert len(looked) <= 3 * (2 * count + 1)


def test_long_chain_of_fixed_links_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "part_overlapping", lambda *_: None)
    names = [f"link{i}" for i in range(1000)]
    chain = [(parent, child, "fixed") for parent, child in pairwise(names)]
    spec = read_urdf(joined(("base", "link0", "continuous"), *chain), "r.urdf", None, sources())
    assert len(spec.excludes) == len(names)


@pytest.mark.parametrize("call", ["simxLoadScene", "simxLoadModel"])
def test_robot_of_more_links_than_objects_may_be_is_refused_before_it_is_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    world = World(workspace=tmp_path)
    monkeypatch.setattr(world.sim, "limits", replace(world.sim.limits, objects=40))
    monkeypatch.setattr(reading, "read_urdf", lambda *_: pytest.fail("it is built"))
    links = [("base", f"fixed{i}", "fixed") for i in range(40)]
    (tmp_path / "many.urdf").write_bytes(joined(*links))
    with pytest.raises(CommandError, match=r"at most 40 objects .*'many.urdf' has 41 links"):
        world.call(call, "many.urdf", 0)


@pytest.mark.parametrize(
    "link",
    [
        '<link name="a"/>',
        '<link name="a"><inertial><mass value="0"/></inertial></link>',
        LINK.format("a", 0, 'ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"', BALL),
        LINK.format("a", 1, 'ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"', BALL),
        LINK.format("a", 1, 'ixx="1" iyy="1" izz="9"', BALL),
        '<link name="a"><inertial><mass value="1"/></inertial></link>',
    ],
)
def test_links_without_or_with_an_odd_inertia_are_repaired(tmp_path: Path, link: str) -> None:
    text = (
        f'<robot name="r"><link name="world"/>{link}<joint name="j" type="continuous"><parent link="world"/>'
        '<child link="a"/><axis xyz="0 0 1"/></joint></robot>'
    )
    world = World(file=written(tmp_path, text))
    world.call("simxSetJointTargetVelocity", world.handle("j"), 1.0)
    world.run(10)
    assert world.call("simxGetJointPosition", world.handle("j")) == pytest.approx(0.5, abs=0.1)


def test_names_of_vreps_importer_find_the_link(tmp_path: Path) -> None:
    world = World(file=write_arm(tmp_path))
    link = world.handle("forearm_link")
    for name in ("forearm_link_visual", "forearm_link_respondable", "forearm_link_visual#"):
        assert world.handle(name) == link
    for name in ("nothing_visual", "_visual", "elbow_joint_visual"):
        with pytest.raises(CommandError):
            world.handle(name)


def test_urdf_stands_in_vreps_default_scene_and_as_a_model_alone(tmp_path: Path) -> None:
    world = World(file=write_arm(tmp_path))
    names = {item.name for item in world.sim.scene.objects.values()}
    assert {"ResizableFloor_5_25", "DefaultLightA", "DefaultCamera", "tool0"} <= names
    assert world.sim.scene.is_model_base(world.handle("base_link"))
    count = len(names)
    world.sim.files.workspace = tmp_path
    base = world.call("simxLoadModel", "my_arm_description/urdf/my_arm.urdf", 0)
    assert world.sim.scene.get(base).name == "base_link#0"
    assert len(world.sim.scene.objects) == count + 8


# --- what overlaps, and saving --------------------------------------------------------------------


def test_objects_that_overlap_at_the_start_are_named(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    boxes = "".join(
        f"<body name='{name}' pos='{x} 0 0.1'><freejoint/><geom type='box' size='.1 .1 .1'/></body>"
        for name, x in (("one", 0), ("two", 0.15), ("three", 1))
    )
    floor = "<geom name='ground' type='plane' size='5 5 1'/>"
    World(file=written(tmp_path, f"<mujoco><worldbody>{floor}{boxes}</worldbody></mujoco>", "boxes.xml"))
    (told,) = [each for each in caplog.messages if "overlap" in each]
    assert "'one' and 'two' by 50 mm" in told
    assert "three" not in told
    assert "ground" not in told


def test_saved_mjcf_is_the_same_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_arm(tmp_path)
    saved = tmp_path / "saved.xml"
    assert cli.main([str(file), "--save-mjcf", str(saved)]) == 0
    assert "my_arm_description/meshes/visual/base_link.obj" in saved.read_text()
    one, other = World(file=file), World(file=saved)
    for world in (one, other):
        world.call("simxSetJointTargetPosition", world.handle("elbow_joint"), -1.0)
        world.run(10)
    assert other.sim.data.qpos == pytest.approx(one.sim.data.qpos, abs=1e-5)
    elbows = [world.sim.joints._states[world.handle("elbow_joint")] for world in (one, other)]
    assert elbows[0].max_force == elbows[1].max_force == 28
    assert [item.name for item in one.sim.scene.objects.values()] == [
        item.name for item in other.sim.scene.objects.values()
    ]
    with pytest.raises(SystemExit):
        cli.main([str(file), "--save-mjcf", str(saved), "--speed", "2"])
    assert "has no meaning beside --save-mjcf" in capsys.readouterr().err


def test_mesh_of_a_clients_urdf_is_found_in_the_open_folders_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A package that the environment or a folder above the workspace knows is the operator's alone."""
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "part.obj").write_text(TETRAHEDRON.format(1))
    workspace = tmp_path / "workspace"
    workspace.mkdir()
    mesh = '<collision><geometry><mesh filename="{}"/></geometry></collision>'
    text = f'<robot name="r"><link name="a">{mesh}</link></robot>'
    world = World(workspace=workspace)
    monkeypatch.setattr(world.sim.files, "sources", sources(ROS_PACKAGE_PATH=str(tmp_path)))
    (workspace / "link").symlink_to(secret)
    for uri in (
        "package://secret/part.obj", "model://secret/part.obj", f"file://{secret}/part.obj", f"{secret}/part.obj",
        "../secret/part.obj", "package://workspace/../secret/part.obj", "link/part.obj", "package://../secret/part.obj",
    ):  # fmt: skip
        written(workspace, text.format(uri), "spy.urdf")
        for call in ("simxLoadScene", "simxLoadModel"):
            with pytest.raises(CommandError) as problem:
                world.call(call, "spy.urdf", 0)
            assert "not there" in str(problem.value), "it is not told whether the file exists"
    world.sim.files.sources = sources(f"secret={secret}")
    written(workspace, text.format("package://secret/part.obj"), "spy.urdf")
    world.call("simxLoadModel", "spy.urdf", 0)
