"""Scenes anywhere include shipped parts and models; a robot stands in them several times."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import pytest
from handler_calls import World
from scenes_for_tests import ARM
from urdf_robots import TETRAHEDRON

from simx_server.scene.formats.annotations import SceneError, read_annotations
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.model_copies import copy_models
from simx_server.scene.formats.sources import Sources
from simx_server.scene.objects import Scene

pytestmark = pytest.mark.slow

CUSTOM = "<mujoco>{}<custom>{}</custom></mujoco>"


def scene_of(folder: Path, includes: list[str], custom: str = "") -> Path:
    file = folder / "mine.xml"
    file.write_text(CUSTOM.format("".join(f"<include file='{name}'/>" for name in includes), custom))
    return file


def names(scene: Scene) -> set[str]:
    return {item.name for item in scene.objects.values()}


# --- includes -------------------------------------------------------------------------------------


def test_shipped_model_with_its_parts_is_included_from_any_folder(tmp_path: Path) -> None:
    file = scene_of(
        tmp_path, ["parts/settings.xml", "parts/surroundings.xml", "models/ur5.xml", "models/rg2.xml"]
    )
    scene, model = load_scene(file)
    assert {"UR5_joint6", "RG2", "ResizableFloor_5_25", "Target"} <= names(scene)
    assert model.opt.timestep == 0.005


def test_included_file_of_ones_own_includes_a_shipped_one(tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "robots.xml").write_text(
        "<mujocoinclude><include file='models/pioneer_p3dx.xml'/></mujocoinclude>"
    )
    scene, _ = load_scene(scene_of(tmp_path, ["own/robots.xml"]))
    assert "Pioneer_p3dx_leftMotor" in names(scene)


def test_file_beside_the_scene_comes_before_a_shipped_one(tmp_path: Path) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "ur5.xml").write_text("<mujoco><worldbody><body name='own'/></worldbody></mujoco>")
    scene, _ = load_scene(scene_of(tmp_path, ["models/ur5.xml"]))
    assert names(scene) == {"own"}


def test_own_and_shipped_files_of_one_name_are_told_apart_or_refused(tmp_path: Path) -> None:
    """MuJoCo would take the one for the other."""
    (tmp_path / "rg2.xml").write_text("<mujoco><worldbody><body name='own'/></worldbody></mujoco>")
    with pytest.raises(SceneError, match="give your file another name"):
        load_scene(scene_of(tmp_path, ["rg2.xml", "models/rg2.xml"]))
    with pytest.raises(SceneError, match="include one of the two"):
        load_scene(scene_of(tmp_path, ["parts/rg2.xml", "models/rg2.xml"]))


def test_include_that_is_nowhere_is_told_with_the_places(tmp_path: Path) -> None:
    with pytest.raises(
        SceneError, match=r"models/pionier.xml.*beside the scene, then in the shipped scenes /.*scenes"
    ):
        load_scene(scene_of(tmp_path, ["models/pionier.xml"]))


def test_meshes_and_nested_parts_of_shipped_models_are_found_where_they_ship(tmp_path: Path) -> None:
    """As from an installed package, whose scenes lie elsewhere."""
    shipped, own = tmp_path / "site-packages" / "shipped_scenes", tmp_path / "own"
    for folder in (shipped / "models" / "shapes", shipped / "parts", own):
        folder.mkdir(parents=True)
    (shipped / "models" / "robot.xml").write_text(
        "<mujoco><compiler meshdir='models/shapes'/><include file='parts/looks.xml'/>"
        "<worldbody><body name='Robot'><geom type='mesh' mesh='part'/></body></worldbody></mujoco>"
    )
    (shipped / "parts" / "looks.xml").write_text(
        "<mujocoinclude><asset><mesh name='part' file='models/shapes/part.obj'/></asset></mujocoinclude>"
    )
    (shipped / "models" / "shapes" / "part.obj").write_text(TETRAHEDRON.format(0.1))
    sources = replace(Sources.of(), shipped=shipped)
    scene, model = load_scene(scene_of(own, ["models/robot.xml"]), sources)
    assert (names(scene), model.nmesh) == ({"Robot"}, 1)


def test_script_of_an_included_model_runs(tmp_path: Path) -> None:
    file = scene_of(tmp_path, ["parts/settings.xml", "parts/default_scene.xml", "models/quadricopter.xml"])
    world = World(file=file)
    world.run(40)
    height = world.call("simxGetObjectPosition", world.handle("Quadricopter"), -1)[2]
    assert height > 0.4, "its script holds it in the air"


def test_clients_scene_includes_shipped_models(tmp_path: Path) -> None:
    scene_of(tmp_path, ["models/pioneer_p3dx.xml"])
    world = World(workspace=tmp_path)
    world.call("simxLoadScene", "mine.xml", 0)
    assert world.handle("Pioneer_p3dx_leftMotor")
    world.call("simxLoadModel", "mine.xml", 0)
    assert world.handle("Pioneer_p3dx_leftMotor#0")


# --- copies ---------------------------------------------------------------------------------------


def copied(tmp_path: Path, includes: list[str], *texts: tuple[str, str]) -> World:
    custom = "".join(f"<text name='simx:{name}' data='{data}'/>" for name, data in texts)
    return World(file=scene_of(tmp_path, ["parts/default_scene.xml", *includes], custom))


def test_one_line_has_a_robot_several_times_under_vreps_names(tmp_path: Path) -> None:
    world = copied(
        tmp_path, ["models/pioneer_p3dx.xml"], ("copies:Pioneer_p3dx", "count=2 x=0.5 y=1 turn_deg=90")
    )
    for copy, place, turn in (("", (0, 0), 0.0), ("#0", (0.5, 1), 90.0), ("#1", (1, 2), 180.0)):
        base = world.handle(f"Pioneer_p3dx{copy}")
        assert world.call("simxGetObjectPosition", base, -1)[:2] == pytest.approx(place)
        assert abs(world.call("simxGetObjectOrientation", base, -1)[2]) == pytest.approx(
            turn * 3.14159 / 180, abs=1e-3
        )
        below = {world.sim.scene.objects[h].name for h in world.sim.scene.descendants(base)}
        assert all(name.endswith(copy) for name in below)
        assert len(below) == 35
        assert world.sim.scene.is_model_base(base)


def test_copies_are_driven_one_by_one(tmp_path: Path) -> None:
    world = copied(tmp_path, ["models/pioneer_p3dx.xml"], ("copies:Pioneer_p3dx", "y=1"))
    for side in ("left", "right"):
        world.call("simxSetJointTargetVelocity", world.handle(f"Pioneer_p3dx_{side}Motor#0"), 3.0)
    world.run(20)
    first, second = (
        world.call("simxGetObjectPosition", world.handle(name), -1)
        for name in ("Pioneer_p3dx", "Pioneer_p3dx#0")
    )
    assert abs(first[0]) < 0.01
    assert second[0] == pytest.approx(3 * 0.0975, rel=0.15)
    nose = world.sim.scene.get(world.handle("Pioneer_p3dx_ultrasonicSensor5#0"))
    assert nose.annotations["proximity"]["angle_deg"] == 30


def test_script_of_a_copy_acts_on_its_own_robot(tmp_path: Path) -> None:
    world = copied(
        tmp_path, ["parts/settings.xml", "models/quadricopter.xml"], ("copies:Quadricopter", "count=1 x=2")
    )
    target = world.handle("Quadricopter_target#0")
    place = world.call("simxGetObjectPosition", target, -1)
    world.sim.start()
    world.call("simxSetObjectPosition", target, -1, [place[0], place[1], place[2] + 0.3])
    for _ in range(40):
        world.parts.step()
    one, other = (
        world.call("simxGetObjectPosition", world.handle(name), -1)
        for name in ("Quadricopter", "Quadricopter#0")
    )
    assert other[2] - one[2] == pytest.approx(0.3, abs=0.1)
    assert other[0] - one[0] == pytest.approx(2, abs=0.1)


def test_what_is_registered_of_a_robot_is_registered_of_its_copies(tmp_path: Path) -> None:
    world = copied(
        tmp_path,
        ["models/two_link_arm.xml"],
        ("copies:two_link_arm", "x=2"),
        ("collection:arm", "tree=two_link_arm"),
        ("collision:hit", "entity1=arm"),
    )
    registered = world.sim.scene.annotations.registered
    assert registered["collection"]["arm#0"] == {"tree": "two_link_arm#0"}
    assert registered["collision"]["hit#0"] == {"entity1": "arm#0"}
    assert world.call("simxGetCollisionHandle", "hit#0") != world.call("simxGetCollisionHandle", "hit")


def test_dependent_joints_follow_the_master_of_their_own_copy(tmp_path: Path) -> None:
    (tmp_path / "hand.xml").write_text("""<mujoco><worldbody><body name="hand">
        <geom size=".05"/>
        <body name="finger"><joint name="finger" type="slide"/><geom size=".01" contype="0" conaffinity="0"/></body>
        <body name="thumb"><joint name="thumb" type="slide"/><geom size=".01" contype="0" conaffinity="0"/></body>
        </body></worldbody>
        <custom><text name="simx:joint:thumb" data="mode=dependent master=finger multiplication=-2"/></custom>
        </mujoco>""")
    world = copied(tmp_path, ["hand.xml"], ("copies:hand", "count=1 x=1"))
    world.call("simxSetJointPosition", world.handle("finger#0"), 0.1)
    positions = [world.call("simxGetJointPosition", world.handle(name)) for name in ("thumb", "thumb#0")]
    assert positions == pytest.approx([0, -0.2])
    # A body that is called as its joint is has its kind in its name, before the copy number.
    assert world.handle("finger_body#0")


def test_copies_of_a_scene_with_keyframes_and_free_bodies_stop_where_they_began(tmp_path: Path) -> None:
    (tmp_path / "cube.xml").write_text(
        ARM.replace("</custom>", '<text name="simx:copies:cube" data="count=3 y=0.5"/></custom>').replace(
            "</worldbody>", "</worldbody><keyframe><key name='k' qpos='0 0 0 0 0 0 0 0 0'/></keyframe>"
        )
    )
    world = World(file=tmp_path / "cube.xml")
    before = world.sim.data.qpos.copy()
    world.run(5)
    world.sim.stop()
    assert (world.sim.data.qpos == before).all()
    assert len(before) == 2 + 4 * 7


def test_names_that_are_taken_are_passed_over(tmp_path: Path) -> None:
    text = "<mujoco><worldbody><body name='a'/><body name='a#0' pos='1 0 0'/></worldbody><custom>{}</custom></mujoco>"
    file = tmp_path / "two.xml"
    file.write_text(text.format("<text name='simx:copies:a' data='count=2 x=5'/>"))
    assert names(load_scene(file)[0]) == {"a", "a#0", "a#1", "a#2"}


@pytest.mark.parametrize(
    ("note", "told"),
    [
        ("name='simx:copies:nobody' data='count=2'", "for a body at the top of the scene; 'nobody' is none"),
        ("name='simx:copies:lower' data='count=2'", "for a body at the top of the scene; 'lower' is none"),
        ("name='simx:copies:cube' data='count=0'", "a whole number from 1 to 10000"),
        ("name='simx:copies:cube' data='number=2'", "with a key of count, x, y, z, turn_deg"),
        ("name='simx:copies:base' data='count=10000'", "more than 5000 elements"),
    ],
)
def test_copies_that_cannot_be_are_told(tmp_path: Path, note: str, told: str) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(ARM.replace("</custom>", f"<text {note}/></custom>"))
    with pytest.raises(SceneError, match=told):
        load_scene(file)


def lines_of_different_counts(lines: int, geoms: int) -> str:
    """A scene of bodies of which the first is copied once, the second twice, and so on."""
    body = "<body name='b{}'>" + "<geom size='1'/>" * geoms + "</body>"
    note = "<text name='simx:copies:b{0}' data='count={1}'/>"
    bodies = "".join(body.format(i) for i in range(lines))
    notes = "".join(note.format(i, i + 1) for i in range(lines))
    return f"<mujoco><worldbody>{bodies}</worldbody><custom>{notes}</custom></mujoco>"


@pytest.fixture
def specs(monkeypatch: pytest.MonkeyPatch) -> list[mujoco.MjSpec]:
    """All copies that are made of a whole spec."""
    copy, made = mujoco.MjSpec.copy, list[mujoco.MjSpec]()

    def noted(spec: mujoco.MjSpec) -> mujoco.MjSpec:
        made.append(copy(spec))
        return made[-1]

    monkeypatch.setattr(mujoco.MjSpec, "copy", noted)
    return made


def test_lines_of_different_counts_are_copied_out_of_one_spec(specs: list[mujoco.MjSpec]) -> None:
    spec = mujoco.MjSpec.from_string(lines_of_different_counts(6, 1))
    copy_models(spec, read_annotations(spec), set())
    assert len(specs) == 1
    found = {body.name for body in spec.bodies} - {"world"}
    originals = {f"b{i}" for i in range(6)}
    assert found == originals | {f"b{i}#{number}" for i in range(6) for number in range(i + 1)}


def test_too_many_copies_are_refused_before_anything_is_copied(specs: list[mujoco.MjSpec]) -> None:
    spec = mujoco.MjSpec.from_string(lines_of_different_counts(20, 30))
    with pytest.raises(SceneError, match="more than 5000 elements"):
        copy_models(spec, read_annotations(spec), set())
    assert not specs
