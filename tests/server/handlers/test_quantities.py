"""The table of numbered quantities, and the named properties that view it."""

from __future__ import annotations

from handler_calls import World
from scenes_for_tests import ARM

from simx_server.handlers.quantities.engine import ENGINE
from simx_server.handlers.quantities.objects import OBJECTS, entries_of
from simx_server.handlers.quantities.simulator import SIMULATOR
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.properties.table import of_kind


def test_each_quantity_has_a_number_of_its_own() -> None:
    of_objects = {each.name for kind in ObjectKind for each in entries_of(kind).values()}
    assert of_objects == set(OBJECTS), "a constant of no kind of object, or two with one number"
    for prefix in ("bool", "int", "float", "string", "array"):
        numbers = [each.number for name, each in SIMULATOR.items() if name.startswith(f"{prefix}param_")]
        assert len(numbers) == len(set(numbers)), prefix
    assert len({each.name for each in ENGINE.values()}) == len(ENGINE)


def test_a_number_and_a_name_are_one_quantity() -> None:
    world = World(ARM)
    cube = world.handle("cube")
    shape = of_kind(ObjectKind.SHAPE)
    dynamic, mass, speed = shape["dynamic"], shape["mass"], shape["initLinearVelocity"]
    assert dynamic.get
    assert dynamic.set
    assert mass.get
    assert speed.set
    world.call("simxSetObjectFloatParameter", cube, 3005, 0.25)
    assert mass.get(world.parts, cube) == 0.25
    speed.set(world.parts, cube, [1.0, 2.0, 3.0])
    assert [world.call("simxGetObjectFloatParameter", cube, number) for number in (3000, 3001, 3002)] == [
        1,
        2,
        3,
    ]
    dynamic.set(world.parts, cube, False)
    assert world.call("simxGetObjectIntParameter", cube, 3003) == 1
    assert dynamic.get(world.parts, cube) is False
