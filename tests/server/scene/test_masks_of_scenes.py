"""Shapes whose scene file gives them a mask: a change writes bits, and compiles nothing."""

from __future__ import annotations

import pytest
from handler_calls import World

STATIC, RESPONDABLE, MASK = 3003, 3004, 3019

SCENE = """
<mujoco>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 0.1"/>
    <body name="a" pos="0 0 1"><freejoint/><geom size="0.1"/></body>
    <body name="b" pos="0 0 2"><freejoint/><geom size="0.1"/><geom size="0.1" contype="0" conaffinity="0"/></body>
    <body name="wall" pos="0 0 3"><geom size="0.1"/></body>
  </worldbody>
  <custom>
    <text name="simx:shape:a" data="mask=0xffff"/>
    <text name="simx:shape:b" data="mask=0xffff"/>
    <text name="simx:shape:wall" data="mask=0xffff static=yes"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def write(world: World, name: str, parameter: int, value: int) -> None:
    world.call("simxSetObjectIntParameter", world.handle(name), parameter, value)


def meet(world: World, one: str, other: str) -> bool:
    """Whether MuJoCo compares the first geoms of two bodies, or those of the world."""
    model = world.sim.model
    first, second = (model.body(name).geomadr[0] for name in (one, other))
    contype, affinity = model.geom_contype, model.geom_conaffinity
    return bool(contype[first] & affinity[second] or contype[second] & affinity[first])


def test_masks_take_effect_without_a_new_model(world: World) -> None:
    model = world.sim.model
    assert meet(world, "a", "b")
    write(world, "a", MASK, 0x0FFF)
    write(world, "b", MASK, 0xF0FF)
    assert not meet(world, "a", "b")
    assert meet(world, "a", "world")
    assert meet(world, "b", "wall")
    write(world, "a", MASK, 0x00FF)
    assert not meet(world, "a", "world")
    write(world, "a", MASK, 0xFFFF)
    assert meet(world, "a", "b")
    assert world.sim.model is model
    assert not world.sim.scene.spec.excludes
    assert model.geom_contype[model.body("b").geomadr[0] + 1] == 0, "a geom that only looks so stays so"


def test_local_byte_counts_once_shapes_are_in_one_tree(world: World) -> None:
    write(world, "a", MASK, 0xFF0F)
    write(world, "b", MASK, 0xFFF0)
    assert meet(world, "a", "b")
    world.call("simxSetObjectParent", world.handle("b"), world.handle("a"), True)
    assert not meet(world, "a", "b")
    world.call("simxSetObjectParent", world.handle("b"), -1, True)
    assert meet(world, "a", "b")


def test_shape_that_became_respondable_again_has_the_bits_of_its_mask(world: World) -> None:
    write(world, "a", RESPONDABLE, 0)
    write(world, "a", MASK, 0x0FFF)
    write(world, "b", MASK, 0xF0FF)
    assert not meet(world, "a", "world")
    write(world, "a", RESPONDABLE, 1)
    assert meet(world, "a", "world")
    assert not meet(world, "a", "b")


def test_shape_of_a_model_that_may_not_collide_gets_its_bits_afterwards(world: World) -> None:
    write(world, "b", MASK, 0xF0FF)
    world.call("simxSetModelProperty", world.handle("a"), 0x40)
    write(world, "a", MASK, 0x0FFF)
    assert not meet(world, "a", "world")
    world.call("simxSetModelProperty", world.handle("a"), 0)
    assert meet(world, "a", "world")
    assert not meet(world, "a", "b")


def test_stop_brings_back_the_masks_of_the_start(world: World) -> None:
    world.run(1)
    write(world, "a", MASK, 0)
    assert not meet(world, "a", "world")
    world.call("simxStopSimulation")
    world.parts.step()
    assert world.call("simxGetObjectIntParameter", world.handle("a"), MASK) == 0xFFFF
    assert meet(world, "a", "b")


def test_static_shape_carried_by_another_meets_no_static_one(world: World) -> None:
    """A wall that something carries would otherwise push against the one it passes."""
    world.call("simxSetObjectParent", world.handle("wall"), world.handle("a"), True)
    assert meet(world, "wall", "b")
    write(world, "b", STATIC, 1)
    assert not meet(world, "wall", "b")
    write(world, "b", STATIC, 0)
    assert meet(world, "wall", "b")
