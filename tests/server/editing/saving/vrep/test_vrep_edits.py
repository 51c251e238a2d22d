"""Changes by scripts and clients in a scene of V-REP are in the file that is saved of it."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest
from saved_worlds import close_worlds
from vrep_worlds import VrepWorld, changes
from vrep_writer import VrepWriter

from simx_client.protocol import constants as c
from simx_server.editing.saving.forms import scene_files
from simx_server.editing.saving.vrep.document import vrep_model
from simx_server.editing.saving.vrep.field import NotInVrepFiles
from simx_server.handlers.numbers import write_numbers
from simx_server.handlers.scene_files.saving import save_model, save_scene
from simx_server.scene.formats.archives.archive import is_archive_file
from simx_server.scene.formats.vrep.recognising import is_vrep_file
from simx_server.scene.formats.vrep.writing.top_level import top_records
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import object_pose

_MADE = (
    ".geoms",
    "body_friction",
    "body_oldfriction",
    "priority",
    "solref",
    "Friction",
    "friction",
    "condim",
)
"""Quantities of contacts: V-REP's default counts for shapes that are in a file without any."""


@pytest.fixture(autouse=True)
def _scripts_end() -> Iterator[None]:
    yield
    close_worlds()


@pytest.fixture(params=[18, 25], scope="module")
def file(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene with objects of all kinds that change, in a version of the format."""
    writer = VrepWriter(request.param)
    floor = writer.shape("floor", cuboid=(5, 5, 0.1), position=(0, 0, -0.05), respondable=True)
    base = writer.shape(
        "base", cuboid=(0.2, 0.2, 0.1), mass=2.0, dynamic=True, respondable=True, model_base=True
    )
    motor = writer.joint(
        "motor", parent=base, position=(0, 0.1, 0), motor=True, target_velocity=1.5, max_force=10
    )
    writer.shape("wheel", parent=motor, cylinder=(0.1, 0.1, 0.02), dynamic=True, respondable=True)
    leaves = [{"cuboid": (0.1, 0.1, 0.1)}, {"cuboid": (0.1, 0.1, 0.1), "pose": ((0.2, 0, 0), (1, 0, 0, 0))}]
    writer.shape("pair", leaves=leaves, position=(1, 0, 0.5))
    tip, goal = writer.dummy("tip", parent=base), writer.dummy("goal", position=(0, 1, 1))
    writer.vision_sensor("eye", parent=base, resolution=(32, 16))
    writer.proximity_sensor("near", parent=base)
    writer.script("function sysCall_init() end", base)
    writer.script("x = 1", floor, kind="customization")
    writer.settings(time_step=0.05, engine=0)
    assert tip != goal
    path = tmp_path_factory.mktemp("vrep") / "made.ttt"
    path.write_bytes(writer.bytes())
    return path


@pytest.fixture
def world(file: Path) -> VrepWorld:
    return VrepWorld(file)


def handle(world: VrepWorld, name: str) -> int:
    found = world.sim.scene.by_name(name)
    assert found is not None
    return found


def test_names_places_and_parents(world: VrepWorld, tmp_path: Path) -> None:
    world.do("setObjectName", handle(world, "goal"), "Target")
    world.do("setObjectPosition", handle(world, "base"), -1, [1 / 3, 0.2, 0.7])
    world.do("setObjectOrientation", handle(world, "pair"), -1, [0.1, 0.2, 0.3])
    world.do("setObjectParent", handle(world, "Target"), handle(world, "pair"), True)
    again = world.reloaded(tmp_path / "again.ttt")
    # The ground's form for collisions follows from all that stands on it.
    assert changes(world, again, "floor.") == []
    base = again.sim.scene.objects[handle(again, "base")]
    assert object_pose(again.sim, base)[0][0] == pytest.approx(1 / 3, abs=1e-12)


def test_settings_of_joints(world: VrepWorld, tmp_path: Path) -> None:
    motor = handle(world, "motor")
    world.do("setJointInterval", motor, False, [-0.9, 1.9])
    world.do("setJointPosition", motor, 0.21)
    for number, value in ((2000, 1), (2001, 1), (2030, 1)):
        world.do("setObjectInt32Param", motor, number, value)
    for number, value in ((2002, 0.33), (2003, 0.02), (2004, 0.01), (2017, 1.23)):
        world.do("setObjectFloatParam", motor, number, value)
    world.do("setJointTargetVelocity", motor, 0.7)
    world.do("setJointTargetPosition", motor, 0.4)
    world.do("setJointMaxForce", motor, 3.5)
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again) == []
    assert again.sim.joints.state(handle(again, "motor")).p == pytest.approx(0.33)


def test_data_flags_and_settings(world: VrepWorld, tmp_path: Path) -> None:
    base = handle(world, "base")
    world.do("writeCustomDataBlock", base, "mine", b"some\0bytes")
    world.do("writeCustomDataBlock", -12, "ours", b"of the scene")
    world.do("setReferencedHandles", base, [handle(world, "goal"), -1])
    world.do("setExtensionString", base, -1, "an {extension}")
    world.do("setObjectInt32Param", base, 10, 3)
    world.do("setObjectSpecialProperty", base, 2)
    world.do("setObjectInt32Param", base, 3002, 0x0F0F)
    world.do("setObjectFloatParam", base, 3000, 0.25)
    world.do("setLinkDummy", handle(world, "tip"), handle(world, "goal"))
    world.do("setArrayParam", 0, [0, 0, -3.7])
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again) == []
    assert again.do("readCustomDataBlock", handle(again, "base"), "mine") == b"some\0bytes"


def test_colours_mass_and_whether_shapes_are_dynamic(world: VrepWorld, tmp_path: Path) -> None:
    world.do("setShapeColor", handle(world, "pair"), None, 0, [0.1, 0.2, 0.3])
    world.do("setShapeColor", handle(world, "pair"), None, 4, [0.4])
    world.do("setShapeMass", handle(world, "base"), 3.25)
    world.do("setObjectInt32Param", handle(world, "wheel"), 3003, 1)
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again, "mass", "inertia", "Inertia", ".geoms") == []
    assert again.do("getShapeMass", handle(again, "base")) == pytest.approx(3.25)
    assert again.do("getObjectInt32Param", handle(again, "wheel"), 3003) == 1


def test_sensors(world: VrepWorld, tmp_path: Path) -> None:
    eye = handle(world, "eye")
    for number, value in ((1002, 64), (1003, 48), (1008, handle(world, "pair"))):
        world.do("setObjectInt32Param", eye, number, value)
    for number, value in ((1000, 0.02), (1001, 7.5), (1004, 0.5)):
        world.do("setObjectFloatParam", eye, number, value)
    world.do("setExplicitHandling", eye, 1)
    world.do("setExplicitHandling", handle(world, "near"), 1)
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again) == []
    assert again.do("getVisionSensorResolution", handle(again, "eye")) == [64, 48]


def test_objects_that_were_removed_copied_and_made(world: VrepWorld, tmp_path: Path) -> None:
    world.do("removeObjects", [handle(world, "near")])
    world.do("copyPasteObjects", [handle(world, "base")], 1)
    mark = world.do("createDummy", 0.05)
    world.do("setObjectName", mark, "Mark")
    world.do("setObjectParent", mark, handle(world, "pair"), True)
    for place, kind in enumerate((3, 4, 5)):
        made = world.do("createPrimitiveShape", kind, [0.2, 0.2, 0.2], 0)
        world.do("setObjectName", made, f"Form{kind}")
        world.do("setObjectPosition", made, -1, [place, 3, 1])
        world.do("setShapeColor", made, None, 0, [0.1, 0.5, 0.2])
    hinge = world.do("createJoint", 10, 5, 0, [0.2, 0.03])
    world.do("setObjectName", hinge, "Hinge")
    world.do("setJointInterval", hinge, False, [-1, 2])
    world.do("setJointPosition", hinge, 0.3)
    world.do("setObjectPosition", hinge, -1, [0, 0, 2])
    world.do("setObjectParent", handle(world, "Form3"), hinge, True)
    some = world.do("createCollection", "some", 0)
    world.do("addObjectToCollection", some, hinge, c.sim_handle_tree, 0)
    world.do("addObjectToCollection", some, mark, c.sim_handle_single, 1)
    again = world.reloaded(tmp_path / "again.ttt")
    ignored = (*_MADE, "color.specular", "indices", "normals", "vertices", "the scene.collections")
    assert changes(world, again, *ignored) == []
    members = again.parts.collections.members(again.parts.collections.find("some") or -1)
    assert {again.sim.scene.objects[each].name for each in members} == {"Hinge", "Form3"}
    assert "near" not in again.sim.scene.by_names()
    assert {"base#0", "motor#0", "wheel#0", "Mark", "Hinge"} <= again.sim.scene.by_names().keys()


def test_octrees_and_point_clouds(world: VrepWorld, tmp_path: Path) -> None:
    tree = world.do("createOctree", 0.1, 0, 1)
    world.do("setObjectName", tree, "Tree")
    world.do(
        "insertVoxelsIntoOctree", tree, 0, [0, 0, 2, 0.5, 0.5, 2, -3, 1, 0.2], [255, 0, 0] * 3, [7, 8, 9]
    )
    cloud = world.do("createPointCloud", 0.02, 20, 0, 4)
    world.do("setObjectName", cloud, "Cloud")
    world.do("insertPointsIntoPointCloud", cloud, 0, [0, 0, 1, 0, 1, 1, 1, 1, 1, 0.25, -2, 0.5], None)
    again = world.reloaded(tmp_path / "again.ttt")
    for kind, name in (("voxels", "Tree"), ("points", "Cloud")):
        before, after = (getattr(each.parts.clouds, kind)(handle(each, name)) for each in (world, again))
        assert rows(before.places, before.colors) == rows(after.places, after.colors)
    before, after = (each.parts.clouds.voxels(handle(each, "Tree")) for each in (world, again))
    assert rows(before.places, before.tags[:, None]) == rows(after.places, after.tags[:, None])


def rows(*arrays: np.ndarray) -> set[tuple[float, ...]]:
    return {tuple(row) for row in np.hstack(arrays).astype(float).round(6).tolist()}


def test_scripts_that_were_changed_removed_and_added(world: VrepWorld, tmp_path: Path) -> None:
    scripts = {script.kind.name: script.handle for script in world.parts.scripts.all()}
    world.do("setScriptText", scripts["CHILD"], "function sysCall_init() y = 'ä' end")
    world.do("removeScript", scripts["CUSTOMIZATION"])
    added = world.do("addScript", 6)
    world.do("associateScriptWithObject", added, handle(world, "goal"))
    world.do("setScriptText", added, "z = 3")
    again = world.reloaded(tmp_path / "again.ttt")
    texts = {
        (script.kind.name, again.sim.scene.objects[script.owner].name): script.source(again.sim)
        .decode()
        .strip()
        for script in again.parts.scripts.all()
    }
    assert texts == {
        ("CHILD", "base"): "function sysCall_init() y = 'ä' end",
        ("CUSTOMIZATION", "goal"): "z = 3",
    }


def test_a_run_is_saved_where_everything_is(world: VrepWorld, tmp_path: Path) -> None:
    world.sim.start()
    for _ in range(5):
        world.parts.step()
    again = world.reloaded(tmp_path / "again.ttt")
    world.sim.refresh()
    for name in ("base", "wheel"):
        item, other = (each.sim.scene.objects[handle(each, name)] for each in (world, again))
        before, after = object_pose(world.sim, item), object_pose(again.sim, other)
        assert before[0] == pytest.approx(after[0], abs=1e-6)
    assert again.sim.joints.position(handle(again, "motor")) == pytest.approx(
        world.sim.joints.position(handle(world, "motor")), abs=1e-6
    )


def test_a_model_out_of_a_scene_stands_alone(world: VrepWorld, tmp_path: Path) -> None:
    some = world.do("createCollection", "some", 0)
    world.do("addObjectToCollection", some, handle(world, "wheel"), c.sim_handle_single, 0)
    world.do("setObjectInt32Param", handle(world, "eye"), c.sim_visionintparam_entity_to_render, some)
    (tmp_path / "base.ttm").write_bytes(vrep_model(world.parts, handle(world, "base")).data)
    again = VrepWorld(tmp_path / "base.ttm")
    names = again.sim.scene.by_names().keys()
    assert {"base", "motor", "wheel", "tip", "eye", "near"} <= names
    assert not names & {"pair", "goal"}
    assert again.parts.vision.entity(handle(again, "eye")) == again.parts.collections.find("some")
    assert [script.kind.name for script in again.parts.scripts.all()] == ["CHILD"]


def test_records_that_did_not_change_keep_their_bytes(world: VrepWorld) -> None:
    before = top_records(world.body())
    world.do("setObjectName", handle(world, "goal"), "Target")
    after = top_records(world.body())
    assert [one[0] for one, other in zip(before, after, strict=True) if one != other] == ["DMY"]


def test_a_form_that_is_not_written_makes_an_archive_and_the_log_says_why(
    world: VrepWorld, caplog: pytest.LogCaptureFixture
) -> None:
    folder = world.sim.files.workspace
    save_scene(world.parts, "plain.ttt")
    save_model(world.parts, handle(world, "base"), "base.ttm")
    assert is_vrep_file(folder / "plain.ttt")
    assert is_vrep_file(folder / "base.ttm")
    group = world.do("createIkGroup", 2, [0, 3], [0.0, 1.0, 0.01, 0.1])
    world.do("createIkElement", group, 0, [handle(world, "tip"), -1, -1, 7])
    with pytest.raises(NotInVrepFiles, match="margins from the limits of joints"):
        world.saved()
    with caplog.at_level(logging.WARNING):
        save_scene(world.parts, "more.ttt")
    assert is_archive_file(folder / "more.ttt")
    assert "cannot have margins from the limits of joints of the group" in caplog.text


def test_the_damping_of_a_joint_is_not_in_such_files(tmp_path: Path) -> None:
    world = VrepWorld(arm_file(tmp_path / "arm.ttt", 25))
    assert world.saved()
    write_numbers(world.parts, handle(world, "shoulder"), "damping", [0.5])
    with pytest.raises(NotInVrepFiles, match="the damping of a joint"):
        world.saved()


def test_other_endings_are_other_forms(world: VrepWorld) -> None:
    assert scene_files(world.parts, "scene.mjz").form.startswith("an archive")
    assert scene_files(world.parts, "scene.ttt").form == "a file of V-REP"


def test_a_setting_for_which_the_file_has_no_record_is_told(tmp_path: Path) -> None:
    writer = VrepWriter(25)
    writer.shape("base", cuboid=(0.2, 0.2, 0.1), mass=2.0)
    (tmp_path / "bare.ttt").write_bytes(writer.bytes())
    world = VrepWorld(tmp_path / "bare.ttt")
    world.do("setArrayParam", 0, [0, 0, -3.7])
    with pytest.raises(NotInVrepFiles, match="the gravity of the scene"):
        world.saved()


def arm_file(path: Path, version: int) -> Path:
    """Write a scene with an arm whose tip is linked to a target."""
    writer = VrepWriter(version)
    base = writer.shape("base", cuboid=(0.1, 0.1, 0.1), mass=1.0)
    joint = writer.joint("shoulder", parent=base, mode="ik")
    arm = writer.shape("arm", parent=joint, cuboid=(0.1, 0.1, 0.3), dynamic=True)
    elbow = writer.joint("elbow", parent=arm, mode="ik")
    tip = writer.dummy("tip", parent=elbow, linked=5, link_type=5)
    writer.dummy("goal", position=(0.1, 0, 0.3), linked=tip, link_type=5)
    writer.settings(time_step=0.05, engine=0)
    path.write_bytes(writer.bytes())
    return path


@pytest.mark.parametrize("version", [18, 25])
def test_groups_of_inverse_kinematics_that_were_made_and_changed(version: int, tmp_path: Path) -> None:
    world = VrepWorld(arm_file(tmp_path / "made.ttt", version))
    tip, base = handle(world, "tip"), handle(world, "base")
    group = world.do("createIkGroup", 4, [1, 7], [0.3])
    world.do("createIkElement", group, 0, [tip, base, -1, 7], [0.001, 0.02])
    other = world.do("createIkGroup", 32)
    world.do("createIkElement", other, 0, [tip, -1, -1, 3])
    made = world.reloaded(tmp_path / "first.ttt")
    assert changes(world, made) == []
    name, last = made.parts.ik_groups.names()
    assert made.parts.ik_groups.get(made.do("getIkGroupHandle", last)).explicit
    made.do("setIkGroupProperties", made.do("getIkGroupHandle", name), 2, 11, 0.4)
    made.do("setObjectName", handle(made, "tip"), "fingertip")
    again = made.reloaded(tmp_path / "second.ttt")
    assert changes(made, again) == []
    found = again.parts.ik_groups.get(again.do("getIkGroupHandle", name))
    assert (int(found.how.method), found.how.iterations, found.how.damping) == (2, 11, pytest.approx(0.4))
    assert found.restore == {"position"}


MATERIALS = {
    0: {"BuN": ([0.0, 0.7, 0.7, 0.0, 0.0, 0.0, 0.0], [0, 0])},
    1: {"OdN": ([0.7, 0.2, 0.0, 0.0, 0.0], [64])},
    4: {"Mj1": ([1, 0.005, 0.0001, 0.02, 1, 0.9, 0.95, 0.001, 0.5, 2, 1, 0], [3, 0])},
}
"""Parameters of contacts of a shape by engine: Bullet, ODE, MuJoCo."""


def surface_file(path: Path, engine: int) -> Path:
    """Write a scene with a floor and a box on it."""
    writer = VrepWriter(25)
    writer.shape(
        "floor", cuboid=(5, 5, 0.1), position=(0, 0, -0.05), respondable=True, material=MATERIALS[engine]
    )
    writer.shape("base", cuboid=(0.2, 0.2, 0.1), dynamic=True, respondable=True, material=MATERIALS[engine])
    writer.settings(time_step=0.05, engine=engine)
    path.write_bytes(writer.bytes())
    return path


@pytest.mark.parametrize("engine", MATERIALS)
def test_friction_of_shapes(engine: int, tmp_path: Path) -> None:
    world = VrepWorld(surface_file(tmp_path / "made.ttt", engine))
    world.do("setEngineFloatParam", 6003, handle(world, "base"), 0.123)
    again = world.reloaded(tmp_path / "again.ttt")
    assert again.do("getEngineFloatParam", 6003, handle(again, "base")) == pytest.approx(0.123, rel=1e-6)
    # Which of two surfaces decides follows from both.
    assert changes(world, again, "priority", ".geoms") == []


def test_all_parameters_of_contacts_with_mujoco(tmp_path: Path) -> None:
    world = VrepWorld(surface_file(tmp_path / "made.ttt", 4))
    base = handle(world, "base")
    for number, value in ((43002, 0.02), (43004, 0.01), (43006, 0.8), (43011, 2.0), (43012, 0.003)):
        world.do("setEngineFloatParam", number, base, value)
    for number, value in ((44001, 4), (44002, 7)):
        world.do("setEngineInt32Param", number, base, value)
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again) == []
    assert again.do("getEngineInt32Param", 44002, handle(again, "base")) == 7


def test_a_bounce_that_other_engines_lack_makes_an_archive(tmp_path: Path) -> None:
    world = VrepWorld(surface_file(tmp_path / "made.ttt", 0))
    world.do("setEngineFloatParam", 43004, handle(world, "base"), 0.5)
    with pytest.raises(NotInVrepFiles, match="only MuJoCo"):
        world.saved()


def test_height_fields_that_were_made(world: VrepWorld, tmp_path: Path) -> None:
    heights = [0.0, 0.1, 0.2, 0.05, 0.3, 0.1, 0.0, 0.2, 0.15, 0.1, 0.05, 0.0]
    made = world.do("createHeightfieldShape", 0, 0.0, 4, 3, 2.0, heights)
    world.do("setObjectPosition", made, -1, [3.0, 1.0, 0.4])
    world.do("setObjectName", made, "hills")
    again = world.reloaded(tmp_path / "again.ttt")
    model, before = again.sim.model, world.sim.model
    assert (int(model.hfield_nrow[0]), int(model.hfield_ncol[0])) == (3, 4)
    np.testing.assert_allclose(model.hfield_data, before.hfield_data, atol=1e-6)
    np.testing.assert_allclose(model.hfield_size[0][:3], before.hfield_size[0][:3], atol=1e-6)
    (old,) = np.flatnonzero(before.geom_type == mujoco.mjtGeom.mjGEOM_HFIELD)
    (new,) = (
        geom
        for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_HFIELD)
        if again.sim.scene.owner_of_geom(int(geom), model) == handle(again, "hills")
    )
    np.testing.assert_allclose(again.sim.data.geom_xpos[new], world.sim.data.geom_xpos[old], atol=1e-6)
    kept = again.reloaded(tmp_path / "third.ttt")
    assert changes(again, kept) == []


def test_graphs_that_were_made(world: VrepWorld, tmp_path: Path) -> None:
    made = world.do("callMethod", -12, "createObject", {"type": "graph"})["value"]
    world.do("setObjectName", made, "plot")
    world.do("setObjectPosition", made, -1, [1.0, 2.0, 0.5])
    again = world.reloaded(tmp_path / "again.ttt")
    assert again.sim.scene.objects[handle(again, "plot")].kind == ObjectKind.GRAPH
    assert again.do("getObjectPosition", handle(again, "plot"), -1) == [1.0, 2.0, 0.5]
    assert changes(world, again) == []
    world.do("addGraphStream", made, "height", "m", 0, [1, 0, 0])
    assert world.saved()  # a script adds its streams again
