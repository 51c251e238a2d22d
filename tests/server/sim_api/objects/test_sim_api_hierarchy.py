"""The order of siblings, and the pose that a joint gives to its children."""

from __future__ import annotations

import math

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


def tops(world: ScriptWorld) -> list[int]:
    return world.sim.scene.children(-1)


def test_an_object_moves_among_its_siblings(world: ScriptWorld) -> None:
    before = tops(world)
    cube = world.handle("cube")
    place = before.index(cube)
    assert world.lua(f"return sim.getObjectHierarchyOrder({cube})") == [place, len(before)]
    world.lua(f"sim.setObjectHierarchyOrder({cube}, 0)")
    assert tops(world) == [cube, *(each for each in before if each != cube)]
    assert world.value(f"sim.getIntProperty({cube}, 'childOrder')") == 0
    world.lua(f"sim.setIntProperty({cube}, 'childOrder', {place})")
    assert tops(world) == before
    world.fails(f"sim.setObjectHierarchyOrder({cube}, {len(before)})", "has a place from 0 to")


def test_an_object_with_another_parent_is_the_last_of_its_siblings_again(world: ScriptWorld) -> None:
    cube, wall, robot = (world.handle(name) for name in ("cube", "wall", "robot"))
    world.lua(f"sim.setObjectHierarchyOrder({cube}, 0)")
    world.lua(f"sim.setObjectParent({cube}, {robot}, true) sim.setObjectParent({cube}, -1, true)")
    assert tops(world).index(cube) > tops(world).index(wall)


def test_the_order_of_siblings_outlasts_an_edit(world: ScriptWorld) -> None:
    cube = world.handle("cube")
    world.lua(f"sim.setObjectHierarchyOrder({cube}, 0)")
    world.lua("sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.1})")
    assert tops(world)[0] == cube


def test_a_joint_gives_its_children_its_own_motion(world: ScriptWorld) -> None:
    world.lua("hinge, cube = sim.getObject('hinge'), sim.getObject('cube')")
    world.lua("sim.setJointPosition(hinge, 0.4)")
    half = 0.2
    pose = [0, 0, 0, 0, 0, math.sin(half), math.cos(half)]
    assert world.value("sim.getObjectChildPose(hinge)") == pytest.approx(pose)
    world.lua("sim.setObjectChildPose(hinge, {0, 0, 0, 0, 0, math.sin(-0.15), math.cos(-0.15)})")
    assert world.value("sim.getJointPosition(hinge)") == pytest.approx(-0.3)
    assert world.value("sim.getObjectChildPose(cube)") == [0, 0, 0, 0, 0, 0, 1]
    world.lua("sim.setObjectChildPose(cube, {0, 0, 0, 0, 0, 0, 1})")
    world.fails("sim.setObjectChildPose(cube, {1, 0, 0, 0, 0, 0, 1})", "'cube' is not a joint")


def test_objects_are_found_by_the_names_of_their_data(world: ScriptWorld) -> None:
    world.lua("cube = sim.getObject('cube') sim.writeCustomStringData(cube, 'mine', 'x')")
    assert world.value("sim.getObjectsWithTag('mine')") == [world.handle("cube")]
    assert world.value("#sim.getObjectsWithTag('mine', true)") == 0
    assert world.value("#sim.getObjectsWithTag('other')") == 0


def test_references_are_added_and_their_objects_removed(world: ScriptWorld) -> None:
    world.lua("cube, wall, robot = sim.getObject('cube'), sim.getObject('wall'), sim.getObject('robot')")
    world.lua("sim.addReferencedHandle(robot, cube, 'a') sim.addReferencedHandle(robot, wall, 'b')")
    assert world.value("sim.getReferencedHandle(robot, 'a')") == world.handle("cube")
    world.lua("sim.addReferencedHandle(robot, wall, 'a')")
    world.fails("sim.getReferencedHandle(robot, 'a')", "'a' refers to 2 objects, not to one")
    tree = len(world.sim.scene.descendants(world.handle("robot"))) + 1
    world.lua("sim.addReferencedHandle(cube, robot, {wholeTree = true})")
    assert world.value("#sim.getReferencedHandles(cube)") == tree
    world.lua("sim.removeReferencedObjects(robot, 'b')")
    assert world.value("sim.isHandle(wall)") is False
    assert world.value("#sim.getReferencedHandles(robot, 'b')") == 0


def test_configurations_whole_turns_away_are_found(world: ScriptWorld) -> None:
    world.lua("hinge = sim.getObject('hinge') sim.setJointInterval(hinge, false, {-7, 14})")
    found = world.value("sim.getAlternateConfigs({hinge}, {1})")
    assert found == pytest.approx([1 - math.tau, 1])
    found = world.value("sim.getAlternateConfigs({hinge}, {1}, -1, {0}, {14})")
    assert found == pytest.approx([1, 1 + math.tau, 1 + 2 * math.tau])
    assert world.value("sim.getAlternateConfigs({hinge}, {1}, -1, {0}, {-1})") == pytest.approx([])
    world.fails("sim.getAlternateConfigs({hinge}, {1, 2})", "1 joints need as many values, not 2")
    world.fails(
        "sim.getAlternateConfigs({hinge}, {1}, -1, {0}, {1e9})", "more than 10000 such configurations"
    )
