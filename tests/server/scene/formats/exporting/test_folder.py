"""A V-REP file as a folder of MJCF, meshes, textures and scripts: loading it gives the same world."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from same_worlds import assert_same_model, assert_same_world, objects_of, opened, scripts_of
from vrep_writer import VrepWriter

from simx_server.editing.models import load_model
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.exporting.folder import write_folder
from simx_server.scene.formats.sources import Sources

CHILD = "function sysCall_actuation()\n\tprint('tab, \"quotes\" & <signs>') -- ä\r\nend"


def car(*, is_model: bool = False) -> bytes:
    """A chassis with a textured mesh, two driven wheels, a dummy, a camera, scripts of two kinds, custom data."""
    writer = VrepWriter(23, (4, 3, 0), is_model=is_model)
    texture = writer.texture(np.random.default_rng(3).integers(0, 256, (8, 8, 3), np.uint8))
    base = writer.shape(
        "My car", cuboid=(0.4, 0.2, 0.1), dynamic=True, respondable=True, mass=1 / 3, position=(1 / 3, 0, 0.2),
        model_base=True, alias="car", texture=texture, custom_data={"speed": bytes(range(256))},
    )  # fmt: skip
    for name, side in (("left", 1), ("right", -1)):
        motor = writer.joint(
            name, parent=base, position=(0.1, side * 0.15, 0), quaternion=(0.5**0.5, 0.5**0.5, 0, 0), limits=None,
            motor=True, target_velocity=1.7 + 0.1 * side, max_force=2,
        )  # fmt: skip
        writer.shape(
            f"{name}Wheel", parent=motor, dynamic=True, respondable=True, mass=0.1, cylinder=(0.1, 0.1, 0.03)
        )
    caster = writer.dummy("caster#0", parent=base, position=(-0.1, 0, 0.01))
    writer.script("while true do simSwitchThread() end", caster, threaded=True, disabled=True)
    writer.vision_sensor("eye", parent=base, position=(0.2, 0, 0.1))
    writer.script(CHILD, base)
    writer.script("#python\ndef sysCall_init():\n    pass\n", base, kind="customization", language="python")
    if not is_model:
        plane = writer.shape("ground", cuboid=(4, 4, 0.1), respondable=True, position=(0, 0, -0.05))
        writer.shape(
            "bump", parent=plane, spheroid=(0.2, 0.3, 0.1), respondable=True, position=(0.6, 0, 0.05)
        )
        writer.settings(time_step=0.05)
    return writer.bytes()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "a car.ttt"
    path.write_bytes(car())
    return path


def converted(file: Path, folder: Path) -> Path:
    return write_folder(file, folder, Sources.of())


def test_folder_gives_the_same_world_and_the_same_hundred_steps(file: Path, tmp_path: Path) -> None:
    with opened(file, converted(file, tmp_path / "out")) as (first, second):
        assert_same_world(first, second, 100)
        assert first.sim.data.qpos[0] != pytest.approx(1 / 3, abs=0.005)  # it has driven somewhere


def test_model_becomes_a_model_and_a_scene_in_which_it_stands_on_the_floor(tmp_path: Path) -> None:
    (tmp_path / "car.ttm").write_bytes(car(is_model=True))
    target = converted(tmp_path / "car.ttm", tmp_path)
    assert target == tmp_path / "car.xml"
    (tmp_path / "empty.xml").write_text("<mujoco/>")
    with opened(tmp_path / "empty.xml", tmp_path / "empty.xml") as (first, second):
        for world, name in ((first, "car.ttm"), (second, "car.xml")):
            load_model(world.parts, tmp_path / name)
        assert objects_of(first) == objects_of(second)
        assert scripts_of(first) == scripts_of(second)
        assert len(scripts_of(first)) == 3
    with opened(tmp_path / "car.ttm", tmp_path / "car_scene.xml") as (first, second):
        assert_same_model(first, second)


def test_existing_files_stay_as_they_are(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    target = converted(file, out)
    target.write_text("edited")
    with pytest.raises(SceneError, match=r"has a_car\.xml.*already.*name another folder, or remove them"):
        converted(file, out)
    assert target.read_text() == "edited"
    target.unlink()
    with pytest.raises(SceneError, match=r"has meshes/.* already"):
        converted(file, out)
    assert not target.exists()


def test_other_kinds_of_files_are_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "plain.xml").write_text("<mujoco/>")
    with pytest.raises(
        SceneError, match=r"'plain\.xml' is not a V-REP file, a saved one or a URDF.*MJCF is edited as it is"
    ):
        converted(tmp_path / "plain.xml", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_where_the_folder_should_be_is_refused(file: Path, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="is not a folder"):
        converted(file, file)


def test_octrees_and_point_clouds_keep_their_points(tmp_path: Path) -> None:
    writer = VrepWriter(23)
    middles = [(0.05, 0.05, 0.05), (-0.35, 0.15, 0.05), (0.25, -0.05, -0.15)]
    points = np.random.default_rng(1).uniform(-3, 3, (200, 3))
    writer.octree("cells", middles, 0.1, (1, 2, 3))
    writer.point_cloud("cloud", points.tolist(), (9, 8, 7))
    path = tmp_path / "points.ttt"
    path.write_bytes(writer.bytes())
    with opened(path, converted(path, tmp_path / "out")) as worlds:
        for world in worlds:
            clouds, by_name = world.parts.clouds, world.sim.scene.by_names()
            voxels, cloud = clouds.voxels(by_name["cells"]), clouds.points(by_name["cloud"])
            assert voxels.size == 0.1
            assert sorted(voxels.places.tolist()) == pytest.approx(np.array(sorted(middles)))
            assert voxels.colors.tolist() == [[1, 2, 3]] * 3
            order, expected = np.lexsort(cloud.places.T), np.lexsort(points.T)
            assert cloud.places[order] == pytest.approx(points[expected], abs=1e-5)
            assert cloud.colors.tolist() == [[9, 8, 7]] * 200


@pytest.mark.parametrize("name", ["car.xml", "textures", "scripts"])
def test_no_link_in_the_folder_is_followed(file: Path, tmp_path: Path, name: str) -> None:
    folder, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    folder.mkdir()
    elsewhere.mkdir()
    file = file.rename(tmp_path / "car.ttt")
    (folder / name).symlink_to(elsewhere / "new.xml" if name == "car.xml" else elsewhere)
    with pytest.raises(SceneError, match=f"{name} is a link"):
        converted(file, folder)
    assert list(elsewhere.iterdir()) == []
    assert [path.name for path in folder.iterdir()] == [name]
