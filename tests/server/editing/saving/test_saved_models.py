"""A model that is saved can be loaded again: into its own scene with other names, and into any other one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from handler_calls import QuickPainter, World
from saved_worlds import close_worlds, opened
from seeds import chosen
from world_listing import differences, listing

from simx_server.editing.models import load_model
from simx_server.editing.saving.packing import pack_model
from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes

_ALIKE = {
    *(
        "abb_irb_140",
        "frankaemikapanda",
        "jaco_arm",
        "kuka_lbr4",
        "kuka_lbr_iiwa_14_r820",
        "kuka_lbr_iiwa_7_r800",
    ),
    *("dr12", "k_junior", "mico_arm", "nao", "ur10", "ur3"),
}
"""Models that have nothing which others lack: the same kinds of objects with the same settings."""

_MODELS = sorted(
    path for path in (shipped_scenes() / "models").glob("*.xml") if "<mujocoinclude" not in path.read_text()
)

_DIFFERENT = chosen(_MODELS, [path for path in _MODELS if path.stem not in _ALIKE])

_SCENE = """<mujoco><option gravity="0 0 0"/>
  <asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/><material name="red" rgba="1 0 0 1"/></asset>
  <worldbody>
    <geom name="Floor" type="plane" size="5 5 1"/>
    <site name="Outside" pos="0 0 4"/>
    <body name="Arm" pos="1 2 3">
      <geom type="mesh" mesh="wedge" material="red"/><site name="Mark" pos="0.1 0.2 0.3"/>
      <body name="Link" pos="0 0 2">
        <joint name="Hinge" axis="0 1 0" range="-60 60" limited="true"/><geom size="0.1" mass="2"/>
        <body name="Feeler" pos="0 0 0.2"><site name="Feel"/><geom size="0.05" mass="0.1"/></body>
        <camera name="Eye" resolution="8 4"/>
      </body>
    </body>
    <body name="Other" pos="5 0 1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <actuator><position name="servo" joint="Hinge" kp="50"/></actuator>
  <sensor><force site="Feel"/><torque site="Feel"/></sensor>
  <custom>
    <text name="simx:model:Arm" data="base=yes"/>
    <text name="simx:references:Arm" data="all=Mark,Outside"/>
    <text name="simx:collection:parts" data="tree=Arm objects=Other"/>
    <text name="simx:vision:Eye" data="entity=collection:parts"/>
    <text name="simx:dummy:Mark" data="linked=Outside"/>
    <text name="simx:dummy:Outside" data="linked=Mark"/>
    <text name="simx:lua:Arm" data="function sysCall_sensing()
      sim.setIntegerSignal(sim.getObjectName(sim.getObjectAssociatedWithScript(sim.handle_self)), 1) end"/>
  </custom></mujoco>"""


@pytest.fixture(autouse=True)
def _scripts_end() -> Iterator[None]:
    yield
    close_worlds()


def save(world: World, base: int, folder: Path) -> Path:
    file = folder / "saved.ttm"
    file.write_bytes(pack_model(world.parts, base).data)
    return file


@pytest.mark.parametrize("path", _DIFFERENT, ids=lambda path: path.stem)
def test_a_shipped_model_is_the_same(path: Path, tmp_path: Path) -> None:
    first, second = (opened(World(painter=QuickPainter())) for _ in range(2))
    base = load_model(first.parts, path)
    for handle in first.sim.scene.children(-1):
        assert handle == base
    load_model(second.parts, save(first, base, tmp_path))
    assert differences(listing(first.parts), listing(second.parts)) == []


def test_a_model_that_is_loaded_twice_gets_other_names_each_time(tmp_path: Path) -> None:
    world = opened(World(_SCENE))
    file = save(world, world.handle("Arm"), tmp_path)
    handles = [load_model(world.parts, file) for _ in range(2)]
    assert [world.sim.scene.get(handle).name for handle in handles] == ["Arm#0", "Arm#1"]
    for number in range(2):
        tree = [world.sim.scene.get(each).name for each in world.sim.scene.descendants(handles[number])]
        assert sorted(tree) == [
            f"{name}#{number}" for name in ("Eye", "Feel", "Feeler", "Hinge", "Link", "Mark")
        ]
        members = world.parts.collections.members(world.parts.collections.find(f"parts#{number}") or 0)
        assert sorted(members) == sorted([handles[number], *world.sim.scene.descendants(handles[number])])
    world.run(1)
    assert {"Arm", "Arm#0", "Arm#1"} <= world.parts.signals.integers.keys()


def test_a_model_stands_where_its_joints_were_and_forgets_what_lies_outside(tmp_path: Path) -> None:
    world = opened(World(_SCENE))
    world.call("simxSetJointPosition", world.handle("Hinge"), 0.5)
    file = save(world, world.handle("Arm"), tmp_path)
    again = opened(World())
    base = load_model(again.parts, file)
    before, after = listing(world.parts), listing(again.parts)
    lines = differences({name: before[name] for name in after if name in before}, after)
    changed = {line.partition(":")[0] for line in lines if not line.startswith("the scene")}
    assert changed == {
        "Arm.property childOrder",
        "Arm.references",
        "Mark.parameter dummyintparam_link_type",
        "Mark.property dummyType",
        "Mark.property linkedDummy",
        "Mark.property linkedDummyHandle",
    }
    assert after["Arm"]["references"] == {"references/all": ["Mark", -1]}
    assert again.call("simxGetJointPosition", again.handle("Hinge")) == pytest.approx(0.5)
    assert again.sim.scene.children(-1) == [base]
    assert again.parts.force.read(again.handle("Feel")) is None


def test_a_joint_that_follows_another_does_so_in_a_model_of_a_copy(tmp_path: Path) -> None:
    world = opened(
        World("""<mujoco><option gravity="0 0 0"/><worldbody><body name="base"><geom size="0.1"/>
      <body name="a" pos="1 0 0"><joint name="first" axis="0 0 1"/><geom size="0.1"/></body>
      <body name="b" pos="-1 0 0"><joint name="second" axis="0 0 1"/><geom size="0.1"/></body></body></worldbody>
      <custom><text name="simx:model:base" data="base=yes"/>
      <text name="simx:joint:second" data="mode=dependent master=first multiplication=2"/></custom></mujoco>""")
    )
    first = load_model(world.parts, save(world, world.handle("base"), tmp_path))
    second = load_model(world.parts, save(world, first, tmp_path))
    assert world.sim.scene.get(second).name == "base#1"
    assert world.sim.model.neq == 3
    world.call("simxSetJointPosition", world.handle("first#1"), 0.25)
    assert world.call("simxGetJointPosition", world.handle("second#1")) == pytest.approx(0.5)
    assert world.call("simxGetJointPosition", world.handle("second#0")) == 0


def test_a_model_file_is_opened_as_a_scene_on_the_default_floor(tmp_path: Path) -> None:
    world = opened(World(_SCENE))
    file = save(world, world.handle("Arm"), tmp_path)
    scene = opened(World(file=file))
    assert {"Arm", "Hinge", "ResizableFloor_5_25"} <= {each.name for each in scene.sim.scene.objects.values()}


def test_only_the_base_of_a_model_is_saved_as_one() -> None:
    world = World(_SCENE)
    with pytest.raises(CommandError, match=r"'Other' is not the base of a model.*sim\.setModelProperty"):
        pack_model(world.parts, world.handle("Other"))


def test_a_model_in_a_running_simulation_is_saved_and_loaded_as_it_is(tmp_path: Path) -> None:
    world = opened(World(_SCENE))
    world.call("simxSetJointTargetPosition", world.handle("Hinge"), 0.8)
    world.run(40)
    position = world.call("simxGetJointPosition", world.handle("Hinge"))
    assert position > 0.1
    load_model(world.parts, save(world, world.handle("Arm"), tmp_path))
    assert world.call("simxGetJointPosition", world.handle("Hinge#0")) == pytest.approx(position)


def test_a_part_of_the_world_is_not_saved_as_a_model() -> None:
    world = World(_SCENE)
    world.call("simxSetModelProperty", world.handle("Floor"), 0)
    with pytest.raises(CommandError, match="'Floor' is a part of the world itself"):
        pack_model(world.parts, world.handle("Floor"))


def test_meshes_of_a_model_in_another_folder_are_saved_with_it(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "bump.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    (tmp_path / "bump.xml").write_text(
        '<mujoco><compiler meshdir="parts"/><asset><mesh name="bump" file="bump.obj"/></asset><worldbody>'
        '<body name="Bump"><geom type="mesh" mesh="bump"/></body></worldbody></mujoco>'
    )
    world, again = opened(World()), opened(World())
    base = load_model(world.parts, tmp_path / "bump.xml")
    file = save(world, base, tmp_path)
    (tmp_path / "parts" / "bump.obj").unlink()
    load_model(again.parts, file)
    assert differences(listing(world.parts), listing(again.parts)) == []
    load_model(again.parts, file)
    assert again.sim.model.ngeom == 2
