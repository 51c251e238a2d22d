"""From an MJCF or URDF to V-REP's tree: kinds, parents, handles, names, paths, annotations."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest
from scenes_for_tests import arm, world_of

from simx_server.errors import CommandError, UnknownHandle, UnknownName, WrongKind
from simx_server.files.library import find_scene, list_scenes
from simx_server.scene.formats.loader import SceneError, load_scene, load_text
from simx_server.scene.naming.paths import path_of
from simx_server.scene.object_listing import list_objects
from simx_server.scene.objects import NOT_A_MODEL, ObjectKind, Scene

pytestmark = pytest.mark.slow


def outline(scene: Scene, handle: int = -1) -> dict[str, dict]:
    return {scene.get(child).name: outline(scene, child) for child in scene.children(handle)}


def test_tree_of_the_arm_is_what_vrep_would_show() -> None:
    scene = arm().simulation.scene
    hand = {"mount": {}}
    lower = {"tip": {}, "eye": {}, "hand": hand}
    assert outline(scene) == {
        "floor": {},
        "overview": {},
        "sun": {},
        "base": {"shoulder": {"upper": {"elbow": {"lower": lower}}}},
        "cube": {},
        "wall": {},
    }
    kinds = {item.name: item.kind for item in scene.objects.values()}
    assert kinds["mount"] == ObjectKind.FORCE_SENSOR
    assert kinds["tip"] == ObjectKind.DUMMY
    assert kinds["eye"] == ObjectKind.VISION_SENSOR
    assert kinds["sun"] == ObjectKind.LIGHT


def test_leaves_come_first_also_after_the_tree_has_changed() -> None:
    scene = arm().simulation.scene

    def order() -> list[str]:
        places = scene.leaves_first()
        return [scene.objects[handle].name for handle in sorted(places, key=lambda handle: places[handle])]

    assert sorted(order()) == sorted(item.name for item in scene.objects.values())
    assert order().index("mount") < order().index("hand") < order().index("lower") < order().index("cube")
    scene.override_parent(scene.resolve("cube"), scene.resolve("mount"))
    assert order().index("cube") < order().index("mount")


def test_handles_are_small_and_in_tree_order() -> None:
    scene = arm().simulation.scene
    assert list(scene.objects) == list(range(1, len(scene.objects) + 1))
    assert [scene.objects[h].name for h in scene.of_kind(ObjectKind.JOINT)] == ["shoulder", "elbow"]


def test_force_sensor_stands_between_a_body_and_its_parent() -> None:
    scene = world_of("""<mujoco><worldbody><body name="a"><geom size="1"/><body name="b">
        <joint name="j"/><geom size="1"/><site name="f"/></body></body></worldbody>
        <sensor><force site="f"/><torque site="f"/></sensor></mujoco>""").simulation.scene
    assert outline(scene) == {"a": {"j": {"f": {"b": {}}}}}
    item = scene.get(scene.resolve("f"))
    assert len(item.sensors) == 2


def test_site_with_a_rangefinder_is_a_proximity_sensor() -> None:
    scene = world_of("""<mujoco><worldbody><body name="a"><geom size="1"/><site name="ray"/></body></worldbody>
        <sensor><rangefinder site="ray"/></sensor></mujoco>""").simulation.scene
    item = scene.get_kind(scene.resolve("ray"), ObjectKind.PROXIMITY_SENSOR)
    assert item.sensors == (0,)
    with pytest.raises(
        WrongKind, match="'ray' is a proximity sensor, but this command needs a joint or dummy"
    ):
        scene.get_kind(item.handle, ObjectKind.JOINT, ObjectKind.DUMMY)


def test_unnamed_elements_get_names_and_empty_unnamed_bodies_are_passed_over() -> None:
    scene = world_of("""<mujoco><worldbody><light pos="0 0 1"/><body><body name="b"><joint/><joint type="slide"/>
        <geom size="1"/><body><geom size="1"/></body></body></body></worldbody></mujoco>""").simulation.scene
    assert outline(scene) == {"light1": {}, "joint1": {"joint2": {"b": {"shape1": {}}}}}


def test_same_name_for_a_body_and_a_camera_stays_unique() -> None:
    scene = world_of("""<mujoco><worldbody><body name="eye"><geom size="1"/><camera name="eye"/></body></worldbody>
        </mujoco>""").simulation.scene
    assert outline(scene) == {"eye": {"eye_camera": {}}}


def test_urdf_keeps_its_links_and_joints() -> None:
    scene, model = (
        load_text("""<robot name="r"><link name="foot"><collision><geometry><sphere radius="0.1"/></geometry>
        </collision></link><link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
        iyz="0"/></inertial></link><link name="tool"/>
        <joint name="hinge" type="continuous"><parent link="foot"/><child link="arm"/><axis xyz="0 0 1"/></joint>
        <joint name="glue" type="fixed"><parent link="arm"/><child link="tool"/></joint></robot>""")
    )
    hinge = scene.get(scene.resolve("hinge"))
    assert hinge.kind == ObjectKind.JOINT
    assert outline(scene, hinge.handle) == {"arm": {"tool": {}}}
    assert model.nu == 1


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("upper", "upper"),
        ("upper#", "upper"),
        ("upper@silentError", "upper"),
        ("upper@alt", "upper"),
        ("/upper", "upper"),
        ("/base/elbow", "elbow"),
        ("/base/shoulder/upper", "upper"),
        ("/base/*pper", "upper"),
        ("./base/lower", "lower"),
        ("/hand/..", "lower"),
    ],
)
def test_names_and_paths_lead_to_the_object(text: str, name: str) -> None:
    scene = arm().simulation.scene
    assert scene.get(scene.resolve(text)).name == name


def test_index_in_a_path_picks_among_equal_aliases() -> None:
    scene = world_of("""<mujoco><worldbody><body name="cup"><geom size="1"/></body>
        <body name="cup#0"><geom size="1"/>
        </body><body name="cup#1"><geom size="1"/></body></worldbody></mujoco>""").simulation.scene
    assert [scene.get(scene.resolve(f"/cup[{i}]")).name for i in range(3)] == ["cup", "cup#0", "cup#1"]
    assert scene.get(scene.resolve("cup#0")).name == "cup#0"
    assert path_of(scene, scene.resolve("cup#1")) == "/cup[2]"
    with pytest.raises(UnknownName):
        scene.resolve("/cup[3]")


def test_listing_has_the_paths_and_looks_at_each_family_once(monkeypatch: pytest.MonkeyPatch) -> None:
    world = world_of("""<mujoco><worldbody>
        <body name="cup"><geom size="1"/><site name="rim"/><site name="rim#0"/></body>
        <body name="cup#0"><geom size="1"/><body name="spoon"><geom size="1"/></body></body>
        </worldbody></mujoco>""")
    sim = world.simulation
    families: list[int] = []
    children = Scene.children
    monkeypatch.setattr(
        Scene, "children", lambda self, handle: families.append(handle) or children(self, handle)
    )
    listed = list_objects(sim)
    assert sorted(families) == sorted([-1, *sim.scene.objects]), (
        "thousands of siblings are listed in good time"
    )
    paths = {each["name"]: each["path"] for each in listed}
    assert (paths["rim#0"], paths["spoon"]) == ("/cup[0]/rim[1]", "/cup[1]/spoon")
    assert all(path_of(sim.scene, each["handle"]) == each["path"] for each in listed)


def test_relative_paths_start_at_the_given_object() -> None:
    scene = arm().simulation.scene
    upper = scene.resolve("upper")
    assert scene.resolve("./tip", upper) == scene.resolve("tip")
    assert scene.resolve("..", upper) == scene.resolve("shoulder")
    assert scene.resolve(".", upper) == upper
    with pytest.raises(UnknownName):
        scene.resolve("./cube", upper)
    assert path_of(scene, upper) == "/base/shoulder/upper"


def test_a_colon_is_the_model_of_the_given_object_and_two_the_model_above() -> None:
    """In a path, where `.` is the object itself."""
    scene = world_of("""<mujoco><worldbody><body name="robot"><geom size="1"/>
        <body name="arm"><geom size="1"/><body name="gripper"><geom size="1"/><site name="pad"/></body></body>
        <site name="tag#0"/></body></worldbody></mujoco>""").simulation.scene
    robot, arm_, gripper, pad = (scene.resolve(name) for name in ("robot", "arm", "gripper", "pad"))
    for handle in scene.objects:
        scene.set_model_property(handle, 0 if handle in (robot, gripper) else NOT_A_MODEL)
    paths = {
        ":": gripper,
        ":/": gripper,
        ":/pad": pad,
        "::": robot,
        "::/arm": arm_,
        "::/tag#0": scene.resolve("tag#0"),
    }
    assert {path: scene.resolve(path, pad) for path in paths} == paths
    assert scene.resolve(":", robot) == robot
    assert scene.resolve("/arm#/pad#") == pad
    with pytest.raises(UnknownName):
        scene.resolve(":::", pad)
    with pytest.raises(UnknownName):
        scene.resolve("::", robot)


def test_a_wrong_path_suggests_paths() -> None:
    scene = arm().simulation.scene
    with pytest.raises(UnknownName, match=r"no object named '/Sholder'; did you mean '/base/shoulder'\?"):
        scene.resolve("/Sholder")


def test_wrong_name_suggests_the_nearest() -> None:
    scene = arm().simulation.scene
    with pytest.raises(UnknownName, match=r"no object named 'Sholder'; did you mean 'shoulder'\?"):
        scene.resolve("Sholder")
    with pytest.raises(UnknownName, match="no name of this scene is close"):
        scene.resolve("qqqq")
    with pytest.raises(UnknownName) as caught:
        scene.resolve("qqqq@silentError")
    assert caught.value.silent


def test_wrong_handle_names_the_valid_ones() -> None:
    with pytest.raises(UnknownHandle, match=r"no object with handle 99; handles of this scene are 1\.\.14$"):
        arm().simulation.scene.get(99)


def annotated(custom: str) -> None:
    load_text(f"""<mujoco><worldbody><body name="b"><joint name="j"/><geom size="1"/><camera name="c"/></body>
        </worldbody><custom>{custom}</custom></mujoco>""")


@pytest.mark.parametrize(
    ("custom", "message"),
    [
        ('<text name="simx:joint:k" data="mode=force"/>', "'simx:joint:k' names no object"),
        ('<text name="simx:joint:b" data="mode=force"/>', "is for a joint, but 'b' is a shape"),
        ('<text name="simx:joynt:j" data="mode=force"/>', "a KIND of object, joint, vision, camera"),
        (
            '<text name="simx:joint:j" data="mood=force"/>',
            "has 'mood=force'; valid is key=value with a key of mode, mo",
        ),
        (
            '<text name="simx:joint:j" data="mode=fast"/>',
            "valid for mode is one of force, passive, ik, dependent, motion",
        ),
        ('<text name="simx:joint:j" data="motor=maybe"/>', "valid for motor is on/yes or off/no"),
        ('<text name="simx:vision:c" data="near=-1"/>', "valid for near is a number above 0"),
        ('<text name="simx:joint:j" data="P=nan"/>', "valid for P is a finite number"),
        ('<numeric name="simx:time_step" data="0"/>', "valid is one number above 0"),
        ('<numeric name="simx:time_stop" data="1"/>', "valid are 'simx:time_step' and 'simx:spec"),
        ('<numeric name="simx:specular:gold" data="1 2 0"/>', "red, green and blue, each from 0 to 1"),
    ],
)
def test_bad_annotation_names_the_element_and_what_is_valid(custom: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        annotated(custom)


def test_annotations_arrive_as_checked_values() -> None:
    world = world_of("""<mujoco><worldbody><camera name="c"/><camera name="v"/></worldbody><custom>
        <text name="simx:vision:c" data="near=0.01 far=3.5 explicit=no"/><text name="simx:camera:v" data="view=yes"/>
        <text name="other" data="free text"/><numeric name="simx:time_step" data="0.02"/></custom></mujoco>""")
    sim = world.simulation
    item = sim.scene.get(sim.scene.resolve("c"))
    assert item.annotations == {"vision": {"near": 0.01, "far": 3.5, "explicit": False}}
    assert sim.scene.get(sim.scene.resolve("v")).kind == ObjectKind.CAMERA
    assert sim.time_step == 0.02


def test_unreadable_scene_says_why(tmp_path: Path) -> None:
    bad = tmp_path / "bad.xml"
    bad.write_text("<mujoco><worldbody><geom size='-1'/></worldbody></mujoco>")
    with pytest.raises(SceneError, match=r"bad\.xml"):
        load_scene(bad)
    bad.write_text("no xml")
    with pytest.raises(SceneError, match=r"cannot read 'bad\.xml'"):
        load_scene(bad)


def test_file_with_defaults_keyframes_and_every_sort_of_actuator_loads(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text("""<mujoco><default><general ctrllimited="true" ctrlrange="-1 1" gear="7"/></default><worldbody>
        <body><freejoint/><geom size="0.1"/><body><joint name="a"/><geom size="0.1"/><body><joint name="b"/>
        <geom size="0.1"/><body><joint name="c"/><geom size="0.1"/></body></body></body></body></worldbody>
        <actuator><muscle joint="a" lengthrange="0 1"/><motor joint="b"/></actuator>
        <keyframe><key name="home" qpos="0 0 0 1 0 0 0 1 2 3" ctrl="0.1 0.2"/></keyframe></mujoco>""")
    _, model = load_scene(file)
    assert model.nu == 4
    assert model.key_ctrl.tolist() == [[0.1, 0.2, 0.0, 0.0]]
    assert model.actuator_gear[2:, 0].tolist() == [1.0, 1.0]
    assert model.actuator_ctrllimited[2:].tolist() == [0, 0]
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def test_scene_is_found_by_path_by_name_and_in_place_of_a_vrep_file(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert "ur5_rg2_kinect" in list_scenes()
    shipped = find_scene("ur5_rg2_kinect")
    assert find_scene("ur5_rg2_kinect.xml") == shipped
    own = tmp_path / "mine.xml"
    own.write_text("<mujoco/>")
    assert find_scene(own) == own
    assert find_scene(tmp_path / "mine") == own
    with caplog.at_level("INFO"):
        assert find_scene(tmp_path / "mine.ttt") == own
        assert find_scene("somewhere/ur5_rg2_kinect.ttt") == shipped
    assert "mine.ttt' is not there" in caplog.text
    vrep = tmp_path / "mine.ttt"
    vrep.write_bytes(b"VREP")
    assert find_scene(vrep) == vrep
    assert find_scene(tmp_path / "mine") == own
    with pytest.raises(
        CommandError, match=r"no scene 'nothing\.ttt'; looked in .* the shipped scenes: .*ur5_rg2_kinect"
    ):
        find_scene("nothing.ttt")
    with pytest.raises(CommandError, match=r"looked in .*/nowhere, which does not exist, and among"):
        find_scene(tmp_path / "nowhere" / "mine.ttt")


@pytest.mark.parametrize("name", ["", ".", "inner"])
def test_a_folder_is_no_scene_and_its_scenes_are_listed(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inner").mkdir()
    for folder in (tmp_path, tmp_path / "inner"):
        (folder / "arm.ttt").touch()
        (folder / "notes.txt").touch()
    with pytest.raises(CommandError, match=f"'{name or '.'}' is a folder; it holds arm.ttt; give the path"):
        find_scene(name or ".")


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        (
            "robot.py",
            "import vrep",
            "cannot read 'robot.py': it is a Python program; run it with: simx-run robot.py",
        ),
        (
            "robot.c",
            "int main() {}",
            r"cannot read 'robot.c': it is a program in C or C\+\+, for V-REP's own library: .*--legacy-port",
        ),
        (
            "robot.txt",
            "robot",
            r"cannot read 'robot.txt': it is no scene; files that the server opens end with \.xml, .*\.ttt",
        ),
        (
            "robot.xml",
            "\n hello\nworld",
            "'robot.xml': it starts with 'hello'; a scene in XML is MJCF or URDF",
        ),
        ("robot.urdf", "", "'robot.urdf': it is empty;"),
    ],
)
def test_a_file_that_is_no_scene_is_named_for_what_it_is(
    tmp_path: Path, name: str, text: str, why: str
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(SceneError, match=why):
        load_scene(tmp_path / name)


def test_model_is_found_by_the_path_that_vrep_has_it_under() -> None:
    found = find_scene("models/robots/mobile/pioneer p3dx.ttm")
    assert found.parts[-3:] == ("scenes", "models", "pioneer_p3dx.xml")


def test_a_robot_is_its_model_where_a_model_is_wanted_and_its_scene_otherwise(tmp_path: Path) -> None:
    assert find_scene("quadricopter", model=True).parent.name == "models"
    assert find_scene("Quadricopter.ttm").parent.name == "models"
    assert find_scene("quadricopter").parent.name == "scenes"
    assert find_scene("Quadricopter.ttt", model=True).parent.name == "scenes"
    own = tmp_path / "quadricopter.xml"
    own.write_text("<mujoco/>")
    assert find_scene(tmp_path / "quadricopter", model=True) == own
