"""Collections, collision and distance objects of a model that is loaded while a scene is open."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from scenes_for_tests import ARM, world_of

from simx_server.errors import CommandError
from simx_server.scene.formats.loader import load_text

pytestmark = pytest.mark.slow

TOOL = """
<mujoco model="tool">
  <worldbody>
    <body name="tool" pos="0 0 3">
      <geom type="box" size="0.1 0.1 0.1"/>
      <site name="feeler"/>
      <body name="finger" pos="0.5 0 0"><geom type="sphere" size="0.1"/></body>
    </body>
  </worldbody>
  <custom>
    <text name="simx:collection:fingers" data="objects=finger,feeler tree=finger"/>
    <text name="simx:collision:touch" data="entity1=fingers"/>
    <text name="simx:distance:gap" data="entity1=tool entity2=finger"/>
    <text name="simx:proximity:feeler" data="range=2 entity=fingers"/>
  </custom>
</mujoco>
"""
FIRST_COLLECTION = 2_000_000


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "tool.xml").write_text(TOOL)
    return World(ARM, workspace=tmp_path)


def load(world: World) -> int:
    return world.call("simxLoadModel", "tool.xml", 0)


def members(world: World, name: str) -> set[str]:
    handles = world.parts.collections.members(world.call("simxGetCollectionHandle", name))
    return {world.sim.scene.get(handle).name for handle in handles}


def test_model_brings_what_it_registers(world: World) -> None:
    load(world)
    assert world.call("simxGetCollectionHandle", "fingers") == FIRST_COLLECTION
    assert members(world, "fingers") == {"finger", "feeler"}
    touch, gap = world.call("simxGetCollisionHandle", "touch"), world.call("simxGetDistanceHandle", "gap")
    world.run()
    assert world.call("simxReadCollision", touch) is False
    assert world.call("simxReadDistance", gap) == pytest.approx(0.3)
    assert world.call("simxGetObjectIntParameter", world.handle("feeler"), 4002) == FIRST_COLLECTION


def test_loaded_in_a_run_it_is_handled_from_the_next_pass_on_and_goes_with_the_stop(world: World) -> None:
    world.run()
    load(world)
    collection = world.call("simxGetCollectionHandle", "fingers")
    touch = world.call("simxGetCollisionHandle", "touch")
    with pytest.raises(CommandError, match="has not been handled yet"):
        world.call("simxReadCollision", touch)
    world.parts.step()
    assert world.call("simxReadCollision", touch) is False
    world.call("simxStopSimulation")
    for command in ("simxGetCollectionHandle", "simxGetCollisionHandle", "simxGetDistanceHandle"):
        with pytest.raises(CommandError, match="of this scene: none"):
            world.call(command, "fingers")
    with pytest.raises(CommandError, match="no collection with handle"):
        world.parts.collections.members(collection)
    load(world)
    assert world.call("simxGetCollectionHandle", "fingers") > collection, "handles are not given again"


def test_second_one_gets_the_copy_number_of_its_objects_and_means_them(world: World) -> None:
    load(world)
    load(world)
    assert members(world, "fingers") == {"finger", "feeler"}
    assert members(world, "fingers#0") == {"finger#0", "feeler#0"}
    second = world.call("simxGetCollectionHandle", "fingers#0")
    assert world.call("simxGetObjectIntParameter", world.handle("feeler#0"), 4002) == second
    world.run()
    assert world.call("simxReadCollision", world.call("simxGetCollisionHandle", "touch")) is True, (
        "each other"
    )
    assert world.call("simxReadDistance", world.call("simxGetDistanceHandle", "gap#0")) == pytest.approx(0.3)


def test_removed_model_takes_them_along_and_frees_their_names(world: World) -> None:
    world.call("simxRemoveModel", load(world))
    with pytest.raises(CommandError, match="collections of this scene: none"):
        world.call("simxGetCollectionHandle", "fingers")
    load(world)
    assert members(world, "fingers") == {"finger", "feeler"}
    assert world.call("simxGetCollisionHandle", "touch")


def test_copies_bring_what_is_registered_of_them(world: World) -> None:
    world.call("simxCopyPasteObjects", [load(world)])
    assert members(world, "fingers#0") == {"finger#0", "feeler#0"}
    assert world.call("simxGetCollisionHandle", "touch#0")
    world.run()
    assert world.call("simxReadDistance", world.call("simxGetDistanceHandle", "gap#0")) == pytest.approx(0.3)
    world.call("simxCopyPasteObjects", [world.handle("finger")])
    assert members(world, "fingers#1") == {"finger#1"}, "what is left of the collection"
    with pytest.raises(CommandError, match="those of this scene: gap, gap#0"):
        world.call("simxGetDistanceHandle", "gap#1")
    world.call("simxCopyPasteObjects", [world.handle("cube")])
    assert world.parts.collections.names() == ["fingers", "fingers#0", "fingers#1"]
    world.call("simxStopSimulation")
    assert world.parts.collections.names() == ["fingers", "fingers#0"]


def test_shapes_of_a_loaded_model_and_of_copies_are_masked_like_all_others(world: World) -> None:
    def excluded() -> set[tuple[str, ...]]:
        return {tuple(sorted((e.bodyname1, e.bodyname2))) for e in world.sim.scene.spec.excludes}

    cube = world.handle("cube")
    world.call("simxSetObjectIntParameter", cube, 3019, 0x00FF)
    base = load(world)
    tool, finger = (world.sim.scene.get(handle).element_name for handle in (base, world.handle("finger")))
    assert {tuple(sorted(("cube", tool))), tuple(sorted(("cube", finger)))} <= excluded()
    (copy,) = world.call("simxCopyPasteObjects", [cube])
    assert world.call("simxGetObjectIntParameter", copy, 3019) == 0x00FF
    twin = world.sim.scene.get(copy).element_name
    assert {tuple(sorted((twin, tool))), tuple(sorted((twin, "cube")))} <= excluded()
    for handle in (cube, copy):
        world.call("simxSetObjectIntParameter", handle, 3019, 0xFFFF)
    assert excluded() == set()


def test_what_masks_keep_apart_in_copies_may_meet_again(world: World) -> None:
    base, hand = world.handle("base"), world.handle("hand")
    world.call("simxSetModelProperty", base, 0)
    world.call("simxSetObjectIntParameter", hand, 3019, 0xFF00)
    in_file = len(world.sim.scene.spec.excludes)
    (copy,) = world.call("simxCopyPasteObjects", [base])
    copied = [copy, *world.sim.scene.descendants(copy)]
    (hand_copy,) = (h for h in copied if world.sim.scene.get(h).name == "hand#0")
    assert world.call("simxGetObjectIntParameter", hand_copy, 3019) == 0xFF00
    assert len(world.sim.scene.spec.excludes) == 2 * in_file
    for handle in (hand, hand_copy):
        world.call("simxSetObjectIntParameter", handle, 3019, 0xFFFF)
    assert not world.sim.scene.spec.excludes


def test_another_scene_counts_the_handles_of_what_it_registers_from_the_first_again() -> None:
    scene = """<mujoco><worldbody><body name="a"><geom size="0.1"/></body></worldbody><custom>
      <text name="simx:collection:pair" data="objects=a"/>
      <text name="simx:collision:touch" data="entity1=a"/></custom></mujoco>"""
    world = world_of(scene)
    first = world.collections.find("pair"), world.meters.collisions.find("touch")
    world.simulation.use(*load_text(scene))
    assert (world.collections.find("pair"), world.meters.collisions.find("touch")) == first
