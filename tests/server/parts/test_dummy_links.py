"""Links between dummies: physics holds the two together, from a file or a program, until the stop."""

from __future__ import annotations

import pytest
from handler_calls import World

from simx_server.errors import CommandError

SCENE = """<mujoco><custom>
<text name="simx:dummy:hook" data="linked=eye"/><text name="simx:dummy:eye" data="linked=hook"/>
</custom><worldbody>
<body name="crane" pos="0 0 2"><geom size="0.1" contype="0" conaffinity="0"/><site name="grip" pos="0 0 -0.2"/></body>
<body name="load" pos="0 0 1.5"><freejoint/><geom size="0.1"/><site name="ring" pos="0 0 0.3"/></body>
<site name="hook" pos="1 0 2"/>
<body name="lamp" pos="1 0 2"><freejoint/><geom size="0.1"/><site name="eye"/></body>
</worldbody><equality><weld name="~link:hook" site1="hook" site2="eye" solref="0.005 1"/></equality></mujoco>"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def handle(world: World, name: str) -> int:
    return world.sim.scene.resolve(name)


def height(world: World, name: str) -> float:
    return float(world.sim.data.body(name).xpos[2])


def run(world: World, steps: int = 10) -> None:
    for _ in range(steps):
        world.parts.step()


def test_a_link_of_the_file_holds_until_it_is_undone(world: World) -> None:
    links = world.parts.dummy_links
    assert links.linked(handle(world, "hook")) == handle(world, "eye")
    world.sim.start()
    run(world)
    assert height(world, "lamp") == pytest.approx(2, abs=1e-3)
    links.link(handle(world, "eye"), -1)
    assert links.linked(handle(world, "hook")) == -1
    run(world)
    assert height(world, "lamp") < 1.5
    world.sim.stop()
    assert links.linked(handle(world, "hook")) == handle(world, "eye")
    world.sim.start()
    run(world)
    assert height(world, "lamp") == pytest.approx(2, abs=1e-3)


def test_a_link_of_a_program_holds_a_falling_body_until_the_stop(world: World) -> None:
    links = world.parts.dummy_links
    world.sim.start()
    links.link(handle(world, "grip"), handle(world, "ring"))
    run(world)
    assert height(world, "load") == pytest.approx(1.5, abs=1e-3)
    world.sim.stop()
    assert links.linked(handle(world, "grip")) == -1
    world.sim.start()
    run(world)
    assert height(world, "load") < 1


def test_a_new_link_ends_those_of_both(world: World) -> None:
    links = world.parts.dummy_links
    links.link(handle(world, "grip"), handle(world, "eye"))
    assert links.linked(handle(world, "hook")) == -1
    assert links.linked(handle(world, "eye")) == handle(world, "grip")


def test_a_dummy_cannot_be_linked_to_itself(world: World) -> None:
    with pytest.raises(CommandError, match="linked to itself"):
        world.parts.dummy_links.link(handle(world, "grip"), handle(world, "grip"))


def test_inverse_kinematics_leaves_physics_alone(world: World) -> None:
    links = world.parts.dummy_links
    links.set_type(handle(world, "hook"), 5)
    world.sim.start()
    run(world)
    assert height(world, "lamp") < 1.5
