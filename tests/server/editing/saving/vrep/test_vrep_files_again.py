"""A V-REP file that was opened, and is saved as it is, is the same file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from saved_worlds import close_worlds
from seeds import chosen
from vrep_samples import each_kind_of_sample, needs_samples, sample
from vrep_worlds import VrepWorld, changes
from vrep_writer import VrepWriter

from simx_server.editing.saving.vrep.field import NotInVrepFiles
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition


@pytest.fixture(autouse=True)
def _scripts_end(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(decomposition, "is_available", lambda: False)  # it takes seconds
    yield
    close_worlds()


@needs_samples
@each_kind_of_sample
def test_the_same_bytes_are_written(path: Path) -> None:
    assert VrepWorld(path).body() == bytes(unpack(path.read_bytes())[1])


_OF_THE_GROUND = (".geoms", "body_friction", "body_oldfriction", "priority", "solref", "Friction")
"""Quantities that follow from the ground and the other shapes of a file, which a model does not know."""


def small(ser: int, folder: Path) -> Path:
    """A scene of a few objects in a version of the format."""
    writer = VrepWriter(ser)
    base = writer.shape(
        "base", cuboid=(0.2, 0.2, 0.1), mass=2.0, dynamic=True, respondable=True, model_base=True
    )
    motor = writer.joint(
        "motor", parent=base, position=(0, 0.1, 0), motor=True, target_velocity=1.5, max_force=10
    )
    writer.shape("wheel", parent=motor, cylinder=(0.1, 0.1, 0.02), dynamic=True, respondable=True)
    writer.dummy("mark", parent=base, position=(0, 0, 0.3))
    writer.script("function sysCall_init() end", base)
    writer.settings(time_step=0.01, engine=0)
    path = folder / "small.ttt"
    path.write_bytes(writer.bytes())
    return path


@pytest.mark.parametrize("ser", [18, 20, 21, 22, 23, 24, 25])
def test_each_version_is_written_again(ser: int, tmp_path: Path) -> None:
    path = small(ser, tmp_path)
    world = VrepWorld(path)
    assert world.body() == bytes(unpack(path.read_bytes())[1])
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again) == []


@needs_samples
@pytest.mark.parametrize(
    "scene", chosen(["robot.ttt", "controlledViaLegacyRemoteApi.ttt"], ["controlledViaLegacyRemoteApi.ttt"])
)
def test_models_come_along_with_meshes_textures_scripts_and_entries(scene: str, tmp_path: Path) -> None:
    world = VrepWorld(sample(scene))
    for name in ("MTB robot.ttm", "Hokuyo URG 04LX UG01_Fast.ttm", "customizable table.ttm"):
        handle = world.do("loadModel", str(_beside(world, sample(name), tmp_path)))
        world.do("setObjectPosition", handle, -1, [1.0, 2.0, 0.5])
    again = world.reloaded(tmp_path / "again.ttt")
    assert changes(world, again, *_OF_THE_GROUND) == []
    assert len(again.sim.scene.objects) == len(world.sim.scene.objects)


@needs_samples
def test_a_script_that_would_run_differently_is_not_written(tmp_path: Path) -> None:
    world = VrepWorld(sample("Mobile_robots.ttt"))
    world.do("loadModel", str(_beside(world, sample("MTB robot.ttm"), tmp_path)))
    with pytest.raises(NotInVrepFiles, match="of another version than the scene"):
        world.saved()


def _beside(world: VrepWorld, model: Path, folder: Path) -> Path:
    """A copy of a model where the world may load it."""
    world.sim.files.workspace = folder
    copy = folder / model.name
    copy.write_bytes(model.read_bytes())
    return copy
