"""Collisions and distances: checked, registered and read; collections of objects."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from handler_calls import World
from seeds import many, seeds

from simx_server.errors import CommandError, UnknownHandle, WrongKind
from simx_server.scene.formats.loader import SceneError, load_text
from simx_server.scene.geometry.forms import GeomTriangles
from simx_server.sensors.distance import meeting
from simx_server.sensors.distance.box_tree import BoxTree, Placed, turned
from simx_server.sensors.distance.triangle_pairs import come_within, least_gap

pytestmark = pytest.mark.slow

ALL = -2

SCENE = """
<mujoco>
  <asset>
    <mesh name="cup" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0  -1 -1 1  1 -1 1  1 1 1  -1 1 1"
          face="0 2 1  0 3 2  0 1 5  0 5 4  1 2 6  1 6 5  2 3 7  2 7 6  3 0 4  3 4 7" inertia="shell"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="9 9 0.1" pos="0 0 -5"/>
    <body name="box" pos="0 0 0" mocap="true"><geom type="box" size="0.5 0.5 0.5" contype="0" conaffinity="0"/></body>
    <body name="ball" pos="2 0 0"><geom type="sphere" size="0.5" contype="0" conaffinity="0" group="3"/></body>
    <body name="pair" pos="0 3 0">
      <geom type="sphere" size="0.5" pos="0 -1 0"/><geom type="sphere" size="0.5"/>
      <body name="rider" pos="0 0.4 0"><geom type="sphere" size="0.1"/></body>
    </body>
    <body name="bowl" pos="20 0 0"><geom type="mesh" mesh="cup"/></body>
    <body name="pea" pos="20 0 0.5"><geom type="sphere" size="0.2"/></body>
    <site name="mark" pos="0 0 1.5"/>
    <site name="other" pos="0 3 4.5"/>
    <camera name="eye"/>
  </worldbody>
  <custom>
    <text name="simx:collection:movers" data="objects=ball,mark tree=pair"/>
    <text name="simx:collection:below" data="below=pair"/>
    <text name="simx:collection:chain" data="chain=rider"/>
    <text name="simx:collection:most" data="all=yes without=box,floor"/>
    <text name="simx:collection:eyes" data="objects=eye"/>
    <text name="simx:collision:touch" data="entity1=box entity2=movers"/>
    <text name="simx:collision:asked" data="entity1=box explicit=yes"/>
    <text name="simx:distance:gap" data="entity1=box entity2=ball"/>
    <text name="simx:distance:asked" data="entity1=movers entity2=box explicit=yes"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def place(world: World, name: str, x: float, y: float, z: float) -> None:
    world.call("simxSetObjectPosition", world.handle(name), -1, [x, y, z])


def entity(world: World, name: str) -> int:
    if world.sim.scene.by_name(name) is not None:
        return world.handle(name)
    return world.call("simxGetCollectionHandle", name)


def collides(world: World, first: str, second: str | int) -> bool:
    other = second if isinstance(second, int) else entity(world, second)
    return world.call("simxCheckCollision", entity(world, first), other)


def gap(world: World, first: str, second: str | int) -> float:
    other = second if isinstance(second, int) else entity(world, second)
    return world.call("simxCheckDistance", entity(world, first), other)


def test_collision_is_found_now_whatever_the_physics_ignores(world: World) -> None:
    assert collides(world, "box", "ball") is False
    place(world, "box", 1.1, 0, 0)
    assert collides(world, "box", "ball") is True
    assert collides(world, "ball", "box") is True


def test_distance_is_that_of_the_nearest_geoms_and_zero_in_contact(world: World) -> None:
    assert gap(world, "box", "ball") == pytest.approx(1.0)
    assert gap(world, "box", "pair") == pytest.approx(1.0)
    assert gap(world, "floor", "box") == pytest.approx(4.5)
    place(world, "box", 1.5, 0, 0)
    assert gap(world, "box", "ball") == 0.0


def test_all_means_every_other_object(world: World) -> None:
    assert collides(world, "box", ALL) is False
    assert collides(world, "rider", ALL) is True
    assert gap(world, "box", ALL) == pytest.approx(1.0)
    place(world, "box", 0, 0, -5.3)
    assert collides(world, "box", ALL) is True


def test_dummies_are_measured_as_points_but_do_not_collide(world: World) -> None:
    assert gap(world, "box", "mark") == pytest.approx(1.0)
    assert gap(world, "mark", "ball") == pytest.approx(2.0)
    assert gap(world, "mark", "other") == pytest.approx(math.sqrt(18))
    with pytest.raises(WrongKind, match="'mark' is a dummy, but this command needs a shape"):
        collides(world, "box", "mark")
    with pytest.raises(WrongKind, match="needs a shape or octree or point cloud or dummy"):
        gap(world, "box", "eye")


@pytest.mark.parametrize("seed", seeds(4))
def test_the_distance_of_collections_is_the_least_of_their_members(seed: int) -> None:
    """Dummies count too, also where most shapes are left out since they are too far away."""
    random = np.random.default_rng(seed)
    kinds = ("sphere", "box", "capsule", "cylinder", "dummy")
    elements = ""
    for number, (kind, at) in enumerate(
        zip(random.choice(kinds, 16), random.uniform(-3, 3, (16, 3)), strict=True)
    ):
        where = f'pos="{_words(at)}" euler="{_words(random.uniform(0, 180, 3))}"'
        geom = f'<geom type="{kind}" size="0.3 0.2 0.1" contype="0" conaffinity="0"/>'
        elements += (
            f'<site name="o{number}" {where}/>'
            if kind == "dummy"
            else f'<body name="o{number}" {where}>{geom}</body>'
        )
    names = [f"o{number}" for number in range(16)]
    sets = (names[:8], names[8:])
    notes = "".join(
        f'<text name="simx:collection:c{n}" data="objects={",".join(each)}"/>' for n, each in enumerate(sets)
    )
    world = World(f"<mujoco><custom>{notes}</custom><worldbody>{elements}</worldbody></mujoco>")
    distances = [gap(world, one, other) for one in sets[0] for other in sets[1]]
    assert gap(world, "c0", "c1") == pytest.approx(min(distances), abs=1e-12)
    assert gap(world, "c1", "c0") == pytest.approx(min(distances), abs=1e-12)


def test_triangles_are_examined_only_where_boxes_meet(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    examined: list[float] = []

    def counted(first: Any, second: Any, margin: float) -> bool:
        examined.append(margin)
        return come_within(first, second, margin)

    monkeypatch.setattr(meeting, "come_within", counted)
    place(world, "pea", 21.3, 0, 0.5)  # their balls meet
    assert collides(world, "pea", "bowl") is False
    assert not examined
    place(world, "pea", 20, 0, 0.5)  # within the bowl, so within its box
    assert collides(world, "pea", "bowl") is False
    assert len(examined) == 1


@pytest.mark.parametrize("seed", seeds(3))
def test_a_collision_is_a_distance_of_zero(seed: int) -> None:
    random = np.random.default_rng(seed)
    kinds = ("sphere", "box", "capsule", "cylinder", "ellipsoid", 'mesh" mesh="cup', "plane")
    elements = ""
    for number, kind in enumerate([*random.choice(kinds[:-1], 15).tolist(), "plane"]):
        where = f'pos="{_words(random.uniform(-1.5, 1.5, 3))}" euler="{_words(random.uniform(0, 180, 3))}"'
        geom = f'<geom type="{kind}" size="{"0 0 1" if kind == "plane" else "0.4 0.2 0.1"}"/>'
        elements += f'<body name="o{number}" {where}>{geom}</body>'
    cup = SCENE[SCENE.index("<asset>") : SCENE.index("</asset>")]
    world = World(f"<mujoco>{cup}</asset><worldbody>{elements}</worldbody></mujoco>")
    pairs = [(f"o{one}", f"o{other}") for one in range(16) for other in range(one)]
    expected = [pair for pair in pairs if gap(world, *pair) == 0.0]
    assert [pair for pair in pairs if collides(world, *pair)] == expected
    assert 0 < len(expected) < len(pairs)


def test_hollow_mesh_is_measured_as_the_surface_it_is(world: World) -> None:
    assert collides(world, "pea", "bowl") is False
    # MuJoCo moves a mesh's origin to its centre of mass, so the floor of the bowl is asked for.
    bottom = min(
        world.sim.data.geom_xmat[g].reshape(3, 3)[2] @ vertex + world.sim.data.geom_xpos[g][2]
        for g in world.parts.instants.now().geoms_of([world.handle("bowl")])
        for vertex in world.sim.model.mesh_vert
    )
    assert gap(world, "pea", "bowl") == pytest.approx(0.5 - 0.2 - bottom, abs=1e-2)
    place(world, "pea", 20.9, 0, 0.5)
    assert collides(world, "pea", "bowl") is True
    assert gap(world, "pea", "bowl") == 0.0


def test_collections_have_handles_and_count_as_entities(world: World) -> None:
    movers = world.call("simxGetCollectionHandle", "movers")
    assert movers == 2_000_000
    assert world.call("simxGetCollectionHandle", "movers#") == movers
    assert gap(world, "movers", "box") == pytest.approx(1.0)
    place(world, "box", 0, 3.2, 0)
    assert collides(world, "movers", "box") is True
    assert collides(world, "below", "pair") is True
    # Objects that are in both are not held against themselves.
    assert collides(world, "below", "below") is False


def test_members_follow_the_tree(world: World) -> None:
    def members(name: str) -> set[str]:
        handles = world.parts.collections.members(entity(world, name))
        return {world.sim.scene.get(handle).name for handle in handles}

    assert members("movers") == {"ball", "mark", "pair", "rider"}
    assert members("below") == {"rider"}
    assert members("chain") == {"rider", "pair"}
    assert members("most").isdisjoint({"box", "floor"})
    world.call("simxSetObjectParent", world.handle("ball"), world.handle("pair"), True)
    assert members("below") == {"rider", "ball"}
    world.call("simxRemoveObject", world.handle("rider"))
    assert members("movers") == {"ball", "mark", "pair"}


def test_model_that_is_not_collidable_counts_alone_but_not_among_others(world: World) -> None:
    place(world, "box", 1.2, 0, 0)
    world.call("simxSetModelProperty", world.handle("ball"), 0x1 | 0x2)
    assert collides(world, "box", "ball") is True
    assert collides(world, "box", ALL) is False
    assert gap(world, "box", ALL) > 0.5


def test_registered_objects_leave_out_even_a_single_shape_that_is_not_to_be_measured(world: World) -> None:
    gap_handle = world.call("simxGetDistanceHandle", "gap")
    touch = world.call("simxGetCollisionHandle", "touch")
    place(world, "box", 1.2, 0, 0)
    world.run()
    assert world.call("simxReadCollision", touch) is True
    assert world.call("simxReadDistance", gap_handle) == 0.0
    world.call("simxSetModelProperty", world.handle("box"), 0x1 | 0x2)
    world.parts.step()
    assert world.call("simxReadCollision", touch) is False
    assert world.call("simxReadDistance", gap_handle) > 1e36


def test_shapes_annotated_as_not_collidable_or_measurable_count_alone_but_not_among_others() -> None:
    note = '<text name="simx:shape:ball" data="collidable=no"/><text name="simx:shape:pair" data="measurable=no"/>'
    world = World(SCENE.replace("<custom>", "<custom>" + note))
    place(world, "box", 1.2, 0, 0)
    assert collides(world, "box", "ball") is True
    assert collides(world, "box", ALL) is False
    assert gap(world, "box", ALL) == 0.0, "measurable it is"
    place(world, "box", 0, 2, 0)
    assert gap(world, "box", "pair") == 0.0
    assert gap(world, "box", "below") > 0.0
    assert collides(world, "box", ALL) is True, "collidable it is"


def test_all_others_are_not_the_members_of_the_first_collection(world: World) -> None:
    """The rider sits in the pair; both are movers."""
    assert collides(world, "rider", "pair") is True
    assert collides(world, "movers", ALL) is False
    assert gap(world, "movers", ALL) == pytest.approx(1.0)
    place(world, "box", 1.2, 0, 0)
    assert collides(world, "movers", ALL) is True


def test_unknown_entities_and_nothing_to_measure_are_errors(world: World) -> None:
    box = world.handle("box")
    for command in ("simxCheckCollision", "simxCheckDistance"):
        with pytest.raises(UnknownHandle):
            world.call(command, box, 999)
        with pytest.raises(CommandError, match="no collection with handle 2000099"):
            world.call(command, box, 2_000_099)
        with pytest.raises(CommandError, match="only the second may be all"):
            world.call(command, ALL, box)
    with pytest.raises(CommandError, match="nothing to measure"):
        gap(world, "box", "eyes")
    with pytest.raises(CommandError, match="nothing to measure"):
        gap(world, "box", "box")


def test_switched_off_handling_answers_success(world: World) -> None:
    place(world, "box", 1.2, 0, 0)
    for number in (2, 3):
        assert world.call("simxGetBooleanParameter", number) is True
        world.call("simxSetBooleanParameter", number, False)
    assert collides(world, "box", "ball") is False
    assert world.call("simxCheckCollision", 999, 999) is False
    assert gap(world, "box", "ball") == 0.0
    world.call("simxSetBooleanParameter", 2, True)
    assert collides(world, "box", "ball") is True


def test_registered_objects_are_handled_in_each_step(world: World) -> None:
    touch = world.call("simxGetCollisionHandle", "touch")
    distance = world.call("simxGetDistanceHandle", "gap")
    with pytest.raises(CommandError, match="has not been handled yet"):
        world.call("simxReadCollision", touch)
    assert world.call("simxReadDistance", distance) > 1e36
    world.run()
    place(world, "box", 1.2, 0, 0)
    assert world.call("simxReadCollision", touch) is False
    assert world.call("simxReadDistance", distance) == pytest.approx(1.0)
    world.parts.step()
    assert world.call("simxReadCollision", touch) is True
    assert world.call("simxReadDistance", distance) == 0.0
    world.call("simxStopSimulation")
    assert world.call("simxReadDistance", distance) > 1e36


def test_explicit_registered_objects_wait_for_their_script(world: World) -> None:
    collision = world.call("simxGetCollisionHandle", "asked")
    distance = world.call("simxGetDistanceHandle", "asked")
    assert collision != distance
    world.run(2)
    with pytest.raises(CommandError, match="has not been handled yet"):
        world.call("simxReadCollision", collision)
    assert world.call("simxReadDistance", distance) > 1e36
    assert world.parts.meters.collisions.handle(collision) == ()
    assert world.parts.meters.distances.handle(distance) == pytest.approx(1.0)
    place(world, "box", 1.2, 0, 0)
    world.parts.step()
    assert world.call("simxReadCollision", collision) is False
    assert world.call("simxReadDistance", distance) == pytest.approx(1.0)


def test_with_handling_switched_off_the_last_results_go_with_the_next_step(world: World) -> None:
    touch = world.call("simxGetCollisionHandle", "touch")
    asked = world.call("simxGetDistanceHandle", "asked")
    world.run()
    assert world.call("simxReadCollision", touch) is False
    assert world.parts.meters.distances.handle(asked) == pytest.approx(1.0)
    for number in (2, 3):
        world.call("simxSetBooleanParameter", number, False)
    assert world.call("simxReadCollision", touch) is False
    world.parts.step()
    with pytest.raises(CommandError, match="has not been handled yet"):
        world.call("simxReadCollision", touch)
    assert world.call("simxReadDistance", asked) == pytest.approx(1.0)
    assert world.parts.meters.distances.handle(asked) is None
    assert world.call("simxReadDistance", asked) > 1e36
    assert world.parts.meters.collisions.handle(touch) == ()


def test_registered_object_goes_with_what_it_measures(world: World) -> None:
    gap_handle = world.call("simxGetDistanceHandle", "gap")
    world.run()
    world.call("simxRemoveObject", world.handle("ball"))
    with pytest.raises(CommandError, match="no distance object named 'gap'; those of this scene: asked"):
        world.call("simxGetDistanceHandle", "gap")
    with pytest.raises(CommandError, match=f"no distance object with handle {gap_handle}"):
        world.call("simxReadDistance", gap_handle)
    assert world.call("simxGetCollisionHandle", "touch"), "the collection has other members"
    world.parts.step()
    world.call("simxStopSimulation")
    assert world.call("simxGetDistanceHandle", "gap") == gap_handle


def test_collection_goes_with_the_last_of_what_it_was_made_of(world: World) -> None:
    chain, movers = entity(world, "chain"), entity(world, "movers")
    world.run()
    world.call("simxRemoveObject", world.handle("rider"))
    with pytest.raises(CommandError, match="no collection and no integer signal named 'chain'"):
        world.call("simxGetCollectionHandle", "chain")
    with pytest.raises(CommandError, match=f"no collection with handle {chain}"):
        gap(world, "box", chain)
    assert entity(world, "movers") == movers
    world.call("simxStopSimulation")
    assert entity(world, "chain") == chain


def test_unknown_registered_names_list_those_there_are(world: World) -> None:
    with pytest.raises(CommandError, match="those of this scene: touch, asked"):
        world.call("simxGetCollisionHandle", "tuch")
    with pytest.raises(CommandError, match="those of this scene: gap, asked"):
        world.call("simxGetDistanceHandle", "touch")
    for command in ("simxReadCollision", "simxReadDistance"):
        with pytest.raises(CommandError, match="with handle 3"):
            world.call(command, 3)


def test_collection_name_falls_back_to_the_integer_signal(world: World) -> None:
    with pytest.raises(CommandError, match="collections of this scene: movers, below"):
        world.call("simxGetCollectionHandle", "mine")
    world.call("simxSetIntegerSignal", "mine", 7)
    assert world.call("simxGetCollectionHandle", "mine") == 7


@pytest.mark.parametrize(
    ("element", "text"),
    [
        (
            '"simx:collection:c" data="objects=a,nobody"',
            "collection:c' has objects=nobody, which is no object",
        ),
        ('"simx:collision:c" data="entity1=nobody"', "entity1=nobody, which is no object or collection"),
        ('"simx:distance:c" data="entity2=a"', "distance:c' needs entity1="),
        ('"simx:collection:c" data="object=a"', "a key of objects, tree, below, chain, all, without"),
    ],
)
def test_wrong_registration_is_told_when_the_scene_is_loaded(element: str, text: str) -> None:
    with pytest.raises(SceneError, match=text):
        load_text(
            f'<mujoco><worldbody><body name="a"/></worldbody><custom><text name={element}/></custom></mujoco>'
        )


def test_triangles_are_as_far_apart_as_mujoco_says_of_the_same_boxes() -> None:
    random = np.random.default_rng(3)
    meetings = 0
    for _ in range(60):
        sizes = random.uniform(0.05, 0.4, (2, 3))
        places, turns = random.normal(size=(2, 3)) * 0.5, random.normal(size=(2, 4))
        geoms = "".join(
            f'<geom type="box" size="{_words(s)}" pos="{_words(p)}" quat="{_words(q)}"/>'
            for s, p, q in zip(sizes, places, turns, strict=True)
        )
        model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        triangles = GeomTriangles(model)
        first, second = (
            Placed(BoxTree(triangles.of(g)[0]), data.geom_xmat[g].reshape(3, 3), data.geom_xpos[g])
            for g in (0, 1)
        )
        expected = max(0.0, mujoco.mj_geomDistance(model, data, 0, 1, 100.0, None))
        meetings += expected == 0.0
        found = least_gap(first, second, 100.0)
        assert found.gap.distance == pytest.approx(expected, abs=1e-9)
        assert least_gap(first, second, 0.01).gap.distance == pytest.approx(min(expected, 0.01), abs=1e-9)
        for guess in ((0, 0), (5, 7), found.pair):
            again = least_gap(first, second, 100.0, guess)
            assert (again.gap.distance, again.pair) == (found.gap.distance, found.pair)
            assert np.array_equal(again.gap.first, found.gap.first)
    assert 0 < meetings < 60


def test_points_of_parallel_surfaces_do_not_depend_on_what_was_measured_before() -> None:
    """Many pairs of triangles are equally near; a replay, and a second client, get the same points."""
    random = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(-1, 1, 7), np.linspace(-1, 1, 7))
    p = np.stack([x, y, np.zeros_like(x)], axis=2)
    a, b, c, d = p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]
    flat = np.concatenate([np.stack(t, 2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    for turn in map(_rotation, random.normal(size=(many(15), 4))):
        tree = BoxTree(turned(flat, turn.T))  # slanted, so that rounding decides which pair is the nearest
        places = turned(np.array([(0.0, 0.0, 0.0), (0.1, 0.2, 0.5)]), turn.T)
        one, other = (Placed(tree, np.eye(3), place) for place in places)
        found = least_gap(one, other, 9.0)
        for guess in random.integers(0, len(flat), (8, 2)).tolist():
            again = least_gap(one, other, 9.0, tuple(guess))
            assert np.array_equal(again.gap.first, found.gap.first)


def test_large_meshes_are_measured_by_their_neighbourhoods() -> None:
    """Two fields of many triangles, one above the other, nearest where one has a spike."""
    x, y = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41))
    flat, spiked = np.zeros_like(x), np.ones_like(x)
    spiked[30, 7] = 0.25

    def surface(z: np.ndarray) -> np.ndarray:
        p = np.stack([x, y, z], axis=2)
        a, b, c, d = p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]
        return np.concatenate([np.stack(t, 2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])

    shuffled = np.random.default_rng(0).permutation(surface(flat))
    one, other = (Placed(BoxTree(each), np.eye(3), np.zeros(3)) for each in (surface(spiked), shuffled))
    found = least_gap(one, other, 9.0)
    assert found.gap.distance == pytest.approx(0.25)
    assert found.pair is not None
    assert math.dist(one.tree.corners[found.pair[0]][0], found.gap.first) < 1.0


def _rotation(turn: np.ndarray) -> np.ndarray:
    """The matrix of a quaternion (4,) of any length, with the same digits on every machine."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, turn / math.hypot(*turn))
    return matrix.reshape(3, 3)


def _words(values: np.ndarray) -> str:
    return " ".join(map(str, values))


def test_a_convex_shape_wholly_within_another_collides_with_it() -> None:
    world = World(
        """
        <mujoco><worldbody>
          <body name="shell"><geom type="sphere" size="1" contype="0" conaffinity="0"/></body>
          <body name="kernel"><geom type="sphere" size="0.1" contype="0" conaffinity="0"/></body>
        </worldbody></mujoco>
        """
    )
    assert world.call("simxCheckCollision", world.handle("kernel"), world.handle("shell")) is True
