"""Distances, collisions and collections in scripts."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import SCENE as WORKSHOP
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

PAIRS = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -10"/>
  <worldbody>
    <body name="floor"><geom type="box" size="2 2 0.1" pos="0 0 -0.1"/></body>
    <body name="ball" pos="0 0 0.099"><freejoint/><geom size="0.1" mass="3"/></body>
    <body name="far" pos="1 0 1"><geom size="0.1"/></body>
    <body name="base" pos="5 0 0"><geom size="0.1"/>
      <body name="middle" pos="0 0 1"><geom size="0.1"/>
        <body name="top" pos="0 0 1"><geom size="0.1"/></body>
      </body>
    </body>
    <body name="bowl" pos="0 5 0"><geom type="mesh" mesh="vee"/></body>
    <body name="pin" pos="0 5 1"><geom size="0.1"/></body>
  </worldbody>
  <asset>
    <mesh name="vee" inertia="shell" vertex="-1 -1 1 -1 1 1 0 -1 0 0 1 0 1 -1 1 1 1 1" face="0 2 1 1 2 3 2 4 3 3 4 5"/>
  </asset>
  <custom>
    <text name="simx:collection:tower" data="tree=middle"/>
    <text name="simx:shape:pin" data="collidable=no measurable=no detectable=no"/>
    <text name="simx:collision:meet" data="entity1=ball entity2=floor"/>
    <text name="simx:collision:miss" data="entity1=ball entity2=far explicit=yes"/>
    <text name="simx:distance:gap" data="entity1=ball entity2=far"/>
    <text name="simx:distance:wide" data="entity1=ball entity2=top explicit=yes"/>
  </custom>
</mujoco>
"""

H = "local h = sim.getObjectHandle\n"


@pytest.fixture
def pairs(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, PAIRS, owner="far")


def test_a_collision_is_checked_with_who_collides(pairs: ScriptWorld) -> None:
    ball, floor = pairs.handle("ball"), pairs.handle("floor")
    assert pairs.lua(H + "return sim.checkCollision(h'ball', h'floor')") == [1, [ball, floor]]
    assert pairs.lua(H + "return sim.checkCollision(h'floor', sim.handle_all)") == [1, [floor, ball]]
    assert pairs.lua(H + "return sim.checkCollision(h'ball', h'far')") == [0, [-1, -1]]


def test_a_box_cuts_the_floor_in_a_square(pairs: ScriptWorld) -> None:
    pairs.lua(
        "box = sim.createPrimitiveShape(3, {0.2, 0.2, 0.2}) sim.setObjectPosition(box, -1, {1, 1, 0.05})"
    )
    count, numbers = pairs.lua(H + "return sim.checkCollisionEx(h'floor', box)")
    points = [numbers[3 * i : 3 * i + 3] for i in range(2 * count)]
    assert len(numbers) == 6 * count
    assert all(z == pytest.approx(0, abs=1e-9) for _, _, z in points)
    assert all(max(abs(x - 1), abs(y - 1)) == pytest.approx(0.1) for x, y, _ in points)
    length = sum(math.dist(*points[2 * i : 2 * i + 2]) for i in range(count))
    assert length == pytest.approx(0.8)
    assert pairs.lua("return sim.checkCollisionEx(box, sim.handle_all)")[0] == count
    assert pairs.lua(H + "return sim.checkCollisionEx(h'ball', h'far')") == [0, []]


def test_a_distance_comes_with_its_ends_and_objects(pairs: ScriptWorld) -> None:
    base, middle = pairs.handle("base"), pairs.handle("middle")
    ends = pytest.approx([5, 0, 0.1, 5, 0, 0.9, 0.8], abs=1e-6)
    assert pairs.lua(H + "return sim.checkDistance(h'base', h'middle', 0)") == [1, ends, [base, middle]]
    assert pairs.lua(H + "return sim.checkDistance(h'base', sim.getCollectionHandle('tower'))")[1] == ends
    assert pairs.lua(H + "return sim.checkDistance(h'base', h'middle', 0.9)")[1] == ends
    assert pairs.lua(H + "return sim.checkDistance(h'base', h'middle', 0.7)") == [0, [0] * 7, [-1, -1]]


def test_the_ends_on_a_hollow_mesh_are_found(pairs: ScriptWorld) -> None:
    result, numbers, _ = pairs.lua(H + "return sim.checkDistance(h'pin', h'bowl')")
    away = math.sqrt(0.5) - 0.1
    assert (result, numbers[6]) == (1, pytest.approx(away, abs=2e-3))
    assert math.dist(numbers[:3], numbers[3:6]) == pytest.approx(numbers[6])
    assert abs(numbers[3]) == pytest.approx(0.5, abs=0.01)
    assert numbers[5] == pytest.approx(abs(numbers[3]), abs=1e-6)


def test_things_that_overlap_are_at_distance_zero_in_one_point(pairs: ScriptWorld) -> None:
    _, numbers, _ = pairs.lua(H + "return sim.checkDistance(h'ball', h'floor')")
    assert numbers == pytest.approx([0, 0, 0, 0, 0, 0, 0], abs=2e-3)
    assert numbers[:3] == numbers[3:6]


def test_registered_collisions_are_read_handled_and_reset(pairs: ScriptWorld) -> None:
    both = "local meet, miss = sim.getCollisionHandle('meet'), sim.getCollisionHandle('miss')\n"
    assert pairs.lua(both + "return sim.readCollision(meet)") == [-1]
    pairs.passes()
    assert pairs.lua(both + "return sim.readCollision(miss)") == [-1]
    assert pairs.lua(both + "return sim.readCollision(meet)") == [
        1,
        [pairs.handle("ball"), pairs.handle("floor")],
    ]
    assert pairs.lua(both + "return sim.handleCollision(miss), sim.readCollision(miss)") == [0, 0]
    assert pairs.lua(both + "return sim.resetCollision(sim.handle_all), sim.readCollision(meet)") == [1, -1]
    assert pairs.lua(both + "return sim.handleCollision(sim.handle_all_except_explicit), "
                     "(sim.readCollision(meet)), sim.readCollision(miss)") == [1, 1, -1]  # fmt: skip


def test_names_of_registered_things_take_the_suffix_of_the_script(tmp_path: Path) -> None:
    first = PAIRS.partition("<custom>")[2]
    second = first.replace("meet", "meet#0").replace("gap", "gap#0").replace("tower", "tower#0")
    text = PAIRS.replace("<custom>", "<custom>" + second.partition("</custom>")[0], 1)
    text = text.replace('<text name="simx:shape:pin"', '<text name="simx:shape:far"', 1)
    text = text.replace("collision:miss", "collision:other", 1).replace("distance:wide", "distance:other", 1)
    world = ScriptWorld(tmp_path, text, owner="far")
    ask = "return sim.getCollisionHandle('meet'), sim.getDistanceHandle('gap'), sim.getCollectionHandle('tower')"
    plain = world.lua(ask)
    assert world.lua("sim.setNameSuffix(0)\n" + ask) == world.lua(ask.replace("')", "#0')")) != plain


def test_registered_distances_are_read_handled_and_reset(pairs: ScriptWorld) -> None:
    both = "local gap, wide = sim.getDistanceHandle('gap'), sim.getDistanceHandle('wide')\n"
    assert pairs.lua(both + "return sim.readDistance(gap)") == [0, 0]
    near, far = math.hypot(1, 0.901) - 0.2, math.hypot(5, 1.901) - 0.2
    assert pairs.lua(both + "return sim.handleDistance(wide)") == [1, pytest.approx(far)]
    assert pairs.lua(both + "return sim.handleDistance(sim.handle_all)") == [1, pytest.approx(near)]
    assert pairs.lua(both + "return sim.readDistance(gap)") == [1, pytest.approx(near)]
    assert pairs.lua(both + "return sim.resetDistance(gap), sim.readDistance(gap)") == [1, 0, 0]


def test_contacts_are_listed_until_there_are_no_more(pairs: ScriptWorld) -> None:
    ball, floor = pairs.handle("ball"), pairs.handle("floor")
    pairs.passes(20)
    objects, point, force, normal = pairs.lua(H + "return sim.getContactInfo(sim.handle_all, h'ball', 0)")
    assert objects == [ball, floor]
    assert point == pytest.approx([0, 0, 0], abs=0.01)
    assert force == pytest.approx([0, 0, 30], abs=1)
    assert normal == pytest.approx([0, 0, 1], abs=1e-6)
    assert pairs.lua("return sim.getContactInfo(sim.handle_all, sim.handle_all, 0)")[1] == point
    extended = H + "return sim.getContactInfo(0, h'floor', sim.handleflag_extended)"
    assert pairs.lua(extended)[2] == pytest.approx([0, 0, -30], abs=1)
    assert pairs.lua("return sim.getContactInfo(sim.handle_all, sim.handle_all, 1)") in ([], [None])
    assert pairs.lua(H + "return sim.getContactInfo(0, h'far', 0)") in ([], [None])


def test_contacts_of_each_physics_step_are_told_from_the_first_question_on(pairs: ScriptWorld) -> None:
    pairs.passes(20)
    ask = H + "return sim.getContactInfo({}, h'ball', 0)"
    every = "local n = 0 while sim.getContactInfo({}, h'ball', n) do n = n + 1 end return n"
    assert pairs.lua(H + every.format("sim.handle_all")) == [1], "those of the last physics step"
    pairs.passes(1)
    steps = pairs.sim.substeps
    assert steps > 1
    assert pairs.lua(H + every.format("sim.handle_all")) == [steps]
    assert pairs.lua(ask.format(steps)) in ([], [None])
    points = [pairs.lua(ask.format(step))[1] for step in range(steps)]
    assert pairs.lua(ask.format("sim.handle_all"))[1] == points[0]
    assert all(point == pytest.approx([0, 0, 0], abs=0.01) for point in points)
    pairs.lua(H + "sim.addForceAndTorque(h'ball', {0, 0, 400}, {0, 0, 0})")
    pairs.passes(1)
    touching = [pairs.lua(H + every.format(step))[0] for step in range(steps)]
    assert touching[-1] == 0, "it has left the floor"
    assert sum(touching) < steps
    pairs.call("simxStopSimulation")
    pairs.call("simxStartSimulation")
    pairs.passes(20)
    assert pairs.lua(H + every.format("sim.handle_all")) == [steps]


def members(world: ScriptWorld, *names: str) -> list[int]:
    return [world.handle(name) for name in names]


def test_a_collection_is_made_of_objects_trees_and_chains(pairs: ScriptWorld) -> None:
    (made,) = pairs.lua(
        H
        + "c = sim.createCollection('mine', 0) sim.addObjectToCollection(c, h'middle', sim.handle_tree, 0) return c"
    )
    get = "return sim.getCollectionObjects(c)"
    assert pairs.lua(get) == [members(pairs, "middle", "top")]
    assert pairs.lua("return sim.getCollectionHandle('mine'), sim.getCollectionName(c)") == [made, "mine"]
    add = H + "sim.addObjectToCollection(c, h'{}', sim.handle_{}, {}) " + get
    assert pairs.lua(add.format("middle", "single", 1)) == [members(pairs, "top")]
    assert pairs.lua(add.format("middle", "single", 0)) == [members(pairs, "middle", "top")]
    assert pairs.lua(add.format("base", "tree", 1 + 2)) == [[]]
    assert pairs.lua(add.format("top", "chain", 2)) == [members(pairs, "base", "middle")]
    assert pairs.lua(add.format("top", "all", 0)) == [list(pairs.sim.scene.objects)]
    assert pairs.lua(f"return sim.emptyCollection(c) {get.replace('return', ',')}") == [1, []]
    pairs.fails("sim.addObjectToCollection(c, 1, 7, 0)", "sim.handle_single, sim.handle_tree")


def test_the_new_forms_of_collections_have_no_name(pairs: ScriptWorld) -> None:
    new = H + "local c = sim.createCollection(0) sim.addItemToCollection(c, sim.handle_single, h'far', 0) "
    assert pairs.lua(new + "return sim.getCollectionObjects(c), (sim.checkCollision(h'ball', c))") == [
        members(pairs, "far"),
        0,
    ]
    gone = (
        "local c = sim.createCollection() return sim.destroyCollection(c), pcall(sim.getCollectionObjects, c)"
    )
    assert pairs.lua(gone)[:2] == [1, False]


def test_what_scripts_do_to_collections_ends_with_the_run(pairs: ScriptWorld) -> None:
    pairs.lua("sim.createCollection('mine') return sim.removeCollection(sim.getCollectionHandle('tower'))")
    pairs.fails("sim.getCollectionHandle('tower')", "no collection .*; collections of this scene")
    pairs.call("simxStopSimulation")
    assert pairs.parts.collections.find("tower") is not None
    assert pairs.parts.collections.find("mine") is None


def test_a_sensor_can_be_held_against_a_collection_a_script_made(world: ScriptWorld) -> None:
    source = (
        H
        + "local c = sim.createCollection('walls', 0) sim.addObjectToCollection(c, h'wall', sim.handle_single, 0) "
    )
    assert world.lua(source + "return sim.checkProximitySensor(h'ray', c)")[0] == 1


def test_a_collection_that_overrides_holds_what_is_not_collidable_or_measurable(pairs: ScriptWorld) -> None:
    made = H + "local c = sim.createCollection({}) sim.addItemToCollection(c, sim.handle_single, h'pin', 0)\n"
    made += "sim.setObjectPosition(h'pin', -1, {{1, 0, 1}})\n"
    both = "local a, b = sim.checkCollision(h'far', c), sim.checkDistance(h'far', c)\nreturn a, b"
    assert pairs.lua(made.format(0) + both) == [0, 0]
    assert pairs.lua(made.format(1) + both) == [1, 1]


def test_a_sensor_sees_an_undetectable_object_in_a_collection_only_if_that_overrides(tmp_path: Path) -> None:
    scene = WORKSHOP.replace("<custom>", '<custom><text name="simx:shape:wall" data="detectable=no"/>')
    world = ScriptWorld(tmp_path, scene)
    source = (
        H + "local c = sim.createCollection({}) sim.addItemToCollection(c, sim.handle_single, h'wall', 0) "
    )
    source += "return sim.checkProximitySensor(h'ray', c)"
    assert world.lua(source.format(0))[0] == 0
    assert world.lua(source.format(1))[0] == 1


def test_a_collection_gets_another_name(pairs: ScriptWorld) -> None:
    assert pairs.lua("return sim.setCollectionName(sim.getCollectionHandle('tower'), 'mast')") == [1]
    assert pairs.lua("return #sim.getCollectionObjects(sim.getCollectionHandle('mast'))") == [2]
    pairs.lua("sim.createCollection('mine', 0)")
    pairs.fails(
        "sim.setCollectionName(sim.getCollectionHandle('mine'), 'mast')", "cannot name this collection"
    )
