"""sim.saveScene and sim.saveModel as scripts and clients call them: files, buffers, and what is refused."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest
from handler_calls import World
from saved_worlds import close_worlds, opened
from sim_api_calls import ScriptWorld
from world_listing import differences, listing

from simx_server.errors import CommandError
from simx_server.handlers.files import store_file
from simx_server.scene.formats.archives.archive import NOTE, is_archive


@pytest.fixture(autouse=True)
def _scripts_end() -> Iterator[None]:
    yield
    close_worlds()


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    """A stopped world, whose customization script does what a test says."""
    made = ScriptWorld(tmp_path, kind="customization")
    opened(made)
    made.sim.stop()
    return made


def names(world: World) -> list[str]:
    return [item.name for item in world.sim.scene.objects.values()]


def test_a_scene_is_saved_into_the_workspace_and_loaded_again(world: ScriptWorld, tmp_path: Path) -> None:
    assert world.lua(
        "sim.setObjectName(sim.getObjectHandle('cube'), 'Block') return sim.saveScene('a/b.ttt')"
    ) == [1]
    assert is_archive((tmp_path / "a" / "b.ttt").read_bytes())
    before = names(world)
    world.sim.close()
    world.call("simxLoadScene", "a/b.ttt", 0)
    assert names(world) == before
    assert "Block" in before


def test_a_model_is_saved_and_loaded_beside_the_original(world: ScriptWorld) -> None:
    assert world.lua("return sim.saveModel(sim.getObjectHandle('robot'), 'robot.ttm')") == [1]
    handle = world.call("simxLoadModel", "robot.ttm", 0)
    assert world.sim.scene.get(handle).name == "robot#0"
    assert world.lua("return sim.getObjectName(sim.loadModel('robot.ttm'))") == ["robot#1"]


def test_without_a_file_the_content_is_returned_and_can_be_loaded(world: ScriptWorld) -> None:
    assert world.lua("""
        local buffer = sim.saveModel(sim.getObjectHandle('robot'))
        return sim.getObjectName(sim.loadModel(buffer))
    """) == ["robot#0"]
    assert world.lua("content = sim.saveScene() return sim.loadScene(content)") == [1]
    before = names(world)
    world.sim.settle()
    assert names(world) == before


def test_of_a_path_elsewhere_only_the_last_part_counts(world: ScriptWorld, tmp_path: Path) -> None:
    world.lua(
        f"sim.saveScene('/no/such/folder/one.ttt') sim.saveScene('../two.ttt') sim.saveScene('{tmp_path}/three.ttt')"
    )
    assert all((tmp_path / f"{name}.ttt").is_file() for name in ("one", "two", "three"))


def test_an_existing_file_is_replaced_as_a_whole(world: ScriptWorld, tmp_path: Path) -> None:
    (tmp_path / "old.ttt").write_text("something else")
    world.lua("sim.saveScene('old.ttt')")
    assert is_archive((tmp_path / "old.ttt").read_bytes())
    assert not [path.name for path in tmp_path.iterdir() if "TEMP" in path.name]


def test_a_link_that_leads_out_of_the_workspace_is_not_followed(world: ScriptWorld, tmp_path: Path) -> None:
    outside = tmp_path.parent / f"{tmp_path.name}_outside"
    outside.mkdir()
    (tmp_path / "away").symlink_to(outside)
    world.fails("sim.saveScene('away/x.ttt')", "leads out of the server's workspace")
    assert not any(outside.iterdir())


@pytest.mark.parametrize("name", [".xml", "...xml", "a/.mjcf"])
def test_a_text_needs_a_name_for_its_folder(world: ScriptWorld, name: str) -> None:
    world.fails(f"sim.saveScene('{name}')", "has no name before its ending")


@pytest.mark.parametrize("name", ["x.simmodel.xml", "x.simscene.xml", "x.urdf"])
def test_names_of_texts_are_refused(world: ScriptWorld, name: str) -> None:
    world.fails(
        f"sim.saveScene('{name}')", "has the ending of a text that the server does not write; choose .mjz"
    )


def test_mjcf_is_written_beside_a_folder_of_what_it_names(world: ScriptWorld, tmp_path: Path) -> None:
    assert world.lua("return sim.saveScene('a/b.xml')") == [1]
    assert {path.name for path in (tmp_path / "a").iterdir()} == {"b.xml", "b"}
    assert [path.name for path in (tmp_path / "a" / "b" / "scripts").iterdir()]
    before = listing(world.parts)
    again = opened(World(file=tmp_path / "a" / "b.xml", workspace=tmp_path))
    assert differences(before, listing(again.parts)) == []


def test_a_model_is_written_as_mjcf(world: ScriptWorld) -> None:
    world.lua("sim.saveModel(sim.getObjectHandle('robot'), 'robot.xml')")
    assert world.lua("return sim.getObjectName(sim.loadModel('robot.xml'))") == ["robot#0"]


def test_mujoco_opens_what_is_saved_as_its_archive(world: ScriptWorld, tmp_path: Path) -> None:
    world.lua("sim.saveScene('all.mjz')")
    model = mujoco.MjSpec.from_file(str(tmp_path / "all.mjz")).compile()
    assert (model.nq, model.ngeom) == (world.sim.model.nq, world.sim.model.ngeom)


def test_an_archive_that_mujoco_has_written_is_opened_as_a_scene(tmp_path: Path) -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
        '<worldbody><body name="one"><geom type="mesh" mesh="wedge"/></body></worldbody></mujoco>'
    )
    spec.compile()
    spec.encode(str(tmp_path / "theirs.mjz"))
    assert names(World(file=tmp_path / "theirs.mjz", workspace=tmp_path)) == ["one"]


def test_of_several_files_none_is_left_when_one_cannot_be_written(world: ScriptWorld, tmp_path: Path) -> None:
    (tmp_path / "x.xml").mkdir()
    world.fails("sim.saveScene('x.xml')", "x.xml")
    assert not list((tmp_path / "x").rglob("*.*"))


def test_a_limit_of_files_holds(world: ScriptWorld, tmp_path: Path) -> None:
    world.sim.limits = dataclasses.replace(world.sim.limits, file=1000)
    world.fails("sim.saveScene('x.ttt')", "limit")
    assert not (tmp_path / "x.ttt").exists()


def test_only_the_base_of_a_model_is_saved(world: ScriptWorld, tmp_path: Path) -> None:
    world.fails("sim.saveModel(sim.getObjectHandle('cube'), 'x.ttm')", "is not the base of a model")
    assert not (tmp_path / "x.ttm").exists()


def test_the_file_says_in_plain_text_what_it_is(world: ScriptWorld, tmp_path: Path) -> None:
    world.lua("sim.saveScene('x.ttt')")
    start = (tmp_path / "x.ttt").read_bytes()[:400].decode("latin-1")
    assert NOTE in start
    assert "V-REP and CoppeliaSim cannot open it" in start


def test_scripts_of_the_operator_run_after_saving_and_those_of_clients_do_not(tmp_path: Path) -> None:
    pytest.importorskip("lupa")
    text = """<mujoco><worldbody><body name="box"><geom size="0.1"/></body></worldbody><custom>
      <text name="simx:lua:customization:box" data="sim.setIntegerSignal('ran', 1)"/></custom></mujoco>"""
    (tmp_path / "scene.xml").write_text(text)
    world = opened(World(file=tmp_path / "scene.xml", workspace=tmp_path))
    assert "ran" in world.parts.signals.integers
    world.call("simxClearIntegerSignal", "")
    save_scene(world, "own.ttt")
    world.call("simxLoadScene", "own.ttt", 0)
    assert "ran" in world.parts.signals.integers
    store_file(world.parts, "sent.xml", text.encode())
    world.call("simxClearIntegerSignal", "")
    world.call("simxLoadScene", "sent.xml", 0)
    save_scene(world, "theirs.ttt")
    world.call("simxLoadScene", "theirs.ttt", 0)
    assert "ran" not in world.parts.signals.integers
    store_file(world.parts, "copy.ttt", (tmp_path / "own.ttt").read_bytes())
    world.call("simxLoadScene", "copy.ttt", 0)
    assert "ran" not in world.parts.signals.integers


def save_scene(world: World, name: str) -> None:
    from simx_server.handlers.scene_files.saving import save_scene as save

    save(world.parts, name)


def test_what_cannot_be_saved_is_said_and_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "bump.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    (tmp_path / "scene.xml").write_text(
        '<mujoco><asset><mesh name="bump" file="bump.obj"/></asset><worldbody><body name="b">'
        '<geom type="mesh" mesh="bump"/></body></worldbody></mujoco>'
    )
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    save_scene(world, "first.ttt")
    again = World(file=tmp_path / "first.ttt", workspace=tmp_path)
    assert again.sim.model.nmeshvert == world.sim.model.nmeshvert == 4
    (tmp_path / "bump.obj").unlink()
    with pytest.raises(CommandError, match=r"bump\.obj"):
        save_scene(world, "second.ttt")
    assert not (tmp_path / "second.ttt").exists()
    save_scene(again, "third.ttt")
    assert (tmp_path / "third.ttt").is_file()
