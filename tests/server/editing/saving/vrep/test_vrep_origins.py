"""The files from which objects come: how long they are known, and whose scripts they bring along."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from saved_worlds import close_worlds
from vrep_worlds import VrepWorld
from vrep_writer import VrepWriter

from simx_server.editing.saving.vrep.document import vrep_model
from simx_server.editing.saving.vrep.field import Writing
from simx_server.handlers.files import store_file
from simx_server.handlers.scene_files.saving import save_scene
from simx_server.scene.formats.vrep.container import unpack
from simx_server.scene.formats.vrep.objects import Shape
from simx_server.scene.formats.vrep.reading import read_file
from simx_server.scene.formats.vrep.recognising import is_vrep_file
from simx_server.scene.formats.vrep.writing.record_lists import parse_list
from simx_server.scene.formats.vrep.writing.top_level import top_records


@pytest.fixture(autouse=True)
def _scripts_end() -> Iterator[None]:
    yield
    close_worlds()


def made(*scripts: str, is_model: bool = False) -> bytes:
    """A file with one shape that has these customization scripts."""
    writer = VrepWriter(25)
    base = writer.shape("base", cuboid=(0.2, 0.2, 0.1), mass=2.0, dynamic=True, model_base=True)
    for text in scripts:
        writer.script(text, base, kind="customization")
    if not is_model:
        writer.settings(time_step=0.05, engine=0)
    return writer.bytes()


@pytest.fixture
def world(tmp_path: Path) -> VrepWorld:
    (tmp_path / "start.ttt").write_bytes(made())
    return VrepWorld(tmp_path / "start.ttt")


def test_the_file_of_a_removed_model_is_released(world: VrepWorld, tmp_path: Path) -> None:
    (tmp_path / "model.ttm").write_bytes(made(is_model=True))
    model = world.do("loadModel", "model.ttm")
    assert world.parts.origins.of(model) is not None
    world.do("removeObjects", [model])
    assert world.parts.origins.of(model) is None


def test_what_a_run_removed_has_its_file_again_after_the_stop(world: VrepWorld) -> None:
    (base,) = (item.handle for item in world.sim.scene.objects.values() if item.name == "base")
    world.sim.start()
    world.do("removeObjects", [base])
    world.sim.stop()
    origin = world.parts.origins.of(base)
    assert origin is not None
    assert origin[0] is world.parts.origins.scene


def test_a_further_script_of_a_client_does_not_run_when_the_first_one_is_removed(world: VrepWorld) -> None:
    pytest.importorskip("lupa")
    world.parts.scripts.allows_code = False
    store_file(world.parts, "sent.ttt", made("x = 1", "sim.setIntegerSignal('ran', 1)"))
    world.call("simxLoadScene", "sent.ttt", 0)
    (script,) = world.parts.scripts.all()
    world.do("removeScript", script.handle)
    save_scene(world.parts, "theirs.ttt")
    assert is_vrep_file(world.sim.files.workspace / "theirs.ttt")
    world.call("simxLoadScene", "theirs.ttt", 0)
    assert len(world.parts.scripts.all()) == 1
    assert "ran" not in world.parts.signals.integers


def test_a_copy_has_the_texture_of_its_original_and_a_model_has_its_meshes_alone(tmp_path: Path) -> None:
    writer = VrepWriter(25)
    picture = writer.texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))
    writer.shape("plain", cuboid=(0.3, 0.3, 0.3), position=(1, 0, 0))
    writer.shape("painted", leaves=[{"cuboid": (0.2, 0.2, 0.1), "texture": picture}], model_base=True)
    writer.settings(time_step=0.05, engine=0)
    (tmp_path / "scene.ttt").write_bytes(writer.bytes())
    world = VrepWorld(tmp_path / "scene.ttt")
    painted = world.sim.scene.by_names()["painted"]
    world.do("copyPasteObjects", [painted], 1)
    again = read_file(world.saved(), "again.ttt")
    shapes = [each for each in again.objects.values() if isinstance(each, Shape)]
    uses = {shape.name: shape.leaves[0].texture for shape in shapes}
    assert {name: use and use.texture for name, use in uses.items()} == {
        "plain": None,
        "painted": picture,
        "painted#0": picture,
    }
    model = vrep_model(world.parts, painted).data
    (shape,) = read_file(model, "model.ttm").objects.values()
    assert isinstance(shape, Shape)
    assert shape.leaves[0].texture is not None
    (pools,) = (payload for tag, payload in top_records(bytes(unpack(model)[1])) if tag == "VIN")
    assert [tag for tag, _ in parse_list("VIN", pools, 25)] == ["Ver", "Ind", "Nor"]


def test_new_textures_and_those_of_other_files_have_different_numbers() -> None:
    writing = Writing(25, {}, free_texture=7)
    first = writing.add_texture(np.zeros((2, 2, 4), np.uint8))
    numbers = [first, writing.take_texture_number(), writing.add_texture(np.ones((2, 2, 4), np.uint8))]
    assert numbers == [7, 8, 9]
