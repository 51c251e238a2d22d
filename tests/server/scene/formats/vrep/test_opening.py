"""V-REP's own files among those that the server opens: known by their content, loaded like any other scene."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import pytest
from handler_calls import World
from vrep_writer import VrepWriter

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.objects import Scene


def robot(*, is_model: bool = False, ser: int = 21, name: str = "robot") -> bytes:
    """A base 0.5 m above the ground, with a wheel on a motor."""
    writer = VrepWriter(ser, is_model=is_model)
    base = writer.shape(
        name, cuboid=(0.2, 0.2, 0.1), dynamic=True, respondable=True, model_base=is_model,
        position=(0.25, 0, 0.5),
    )  # fmt: skip
    motor = writer.joint("motor", parent=base, position=(0, 0.1, 0), at=0.3, motor=True, target_velocity=1.5)
    writer.shape("wheel", parent=motor, cylinder=(0.1, 0.1, 0.02), dynamic=True)
    if not is_model:
        writer.settings()
    return writer.bytes()


def names(scene: Scene) -> list[str]:
    return [item.name for item in scene.objects.values()]


@pytest.mark.parametrize("name", ["robot.ttt", "ROBOT.TTT", "robot.xml", "robot", "robot.zip"])
def test_file_is_known_by_its_content_whatever_its_name(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(robot())
    scene, _ = load_scene(tmp_path / name)
    assert names(scene) == ["robot", "motor", "wheel"]


@pytest.mark.parametrize("ser", [18, 21, 25])
def test_model_stands_on_the_default_floor_where_it_was_saved(tmp_path: Path, ser: int) -> None:
    (tmp_path / "robot.ttm").write_bytes(robot(is_model=True, ser=ser))
    world = World(file=tmp_path / "robot.ttm")
    found = names(world.sim.scene)
    assert found[:3] == ["robot", "motor", "wheel"]
    assert {"ResizableFloor_5_25", "DefaultLightA", "DefaultCamera"} <= set(found)
    assert world.call("simxGetObjectPosition", world.handle("robot"), -1) == pytest.approx((0.25, 0, 0.5))
    assert world.call("simxGetJointPosition", world.handle("motor")) == pytest.approx(0.3)


def test_model_falls_onto_the_floor_and_stays_there(tmp_path: Path) -> None:
    (tmp_path / "robot.ttm").write_bytes(robot(is_model=True))
    world = World(file=tmp_path / "robot.ttm")
    world.run(40)
    height = world.call("simxGetObjectPosition", world.handle("robot"), -1)[2]
    assert 0 < height < 0.4


def test_names_that_the_default_scene_has_too_belong_to_the_model(tmp_path: Path) -> None:
    (tmp_path / "x.ttm").write_bytes(robot(is_model=True, name="DefaultCamera"))
    scene, _ = load_scene(tmp_path / "x.ttm")
    found = names(scene)
    assert found[:3] == ["DefaultCamera", "motor", "wheel"]
    assert "DefaultCamera#0" in found
    camera = next(item for item in scene.objects.values() if item.name == "DefaultCamera#0")
    assert camera.annotations["camera"]["view"] is True


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("robot.ttt", b"version https://git-lfs.github.com/spec/v1\noid x\n", "Git LFS pointer"),
        ("robot.ttm", b"", "empty"),
        ("robot.ttt", b"<CoppeliaSim></CoppeliaSim>", "XML"),
        ("robot.ttt", b"VREP\x15", "cut off"),
        (
            "robot.simscene.xml",
            b"<CoppeliaSim filetype='simpleScene'><a/></CoppeliaSim>",
            "save it as a .ttt",
        ),
        ("robot.xml", b"<CoppeliaSim/>", "CoppeliaSim's XML format"),
    ],
)
def test_other_content_is_refused_with_what_it_is(
    tmp_path: Path, name: str, content: bytes, text: str
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError) as problem:
        load_scene(tmp_path / name)
    assert text in str(problem.value)
    assert f"'{name}'" in str(problem.value)


def test_log_has_one_line_about_the_import(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "robot.ttt").write_bytes(robot())
    with caplog.at_level(logging.INFO):
        World(file=tmp_path / "robot.ttt")
    assert caplog.text.count("'robot.ttt' has 2 shape, 1 joint") == 1
    assert caplog.text.count("--import-report") == 1


def test_other_formats_have_no_line_about_an_import(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "plain.xml").write_text("<mujoco/>")
    with caplog.at_level(logging.INFO):
        World(file=tmp_path / "plain.xml")
    assert "import" not in caplog.text


def test_joint_drives_as_the_file_says(tmp_path: Path) -> None:
    writer = VrepWriter(21)
    base = writer.shape("base", cuboid=(0.2, 0.2, 0.1))
    motor = writer.joint("motor", parent=base, limits=None, motor=True, target_velocity=1.5, max_force=0.5)
    writer.shape("wheel", parent=motor, cylinder=(0.1, 0.1, 0.02), dynamic=True)
    (tmp_path / "m.ttt").write_bytes(writer.bytes())
    world = World(file=tmp_path / "m.ttt")
    world.run(20)
    assert math.isclose(world.call("simxGetJointPosition", world.handle("motor")), 1.5, abs_tol=0.05)
