"""Collections by steps, and references to collections, also where an object has the same name."""

from __future__ import annotations

import pytest
from handler_calls import World

from simx_server.editing.copying import copy_objects
from simx_server.scene.formats.annotations import Annotation, SceneError
from simx_server.scene.registered import concerned, renamed, renamed_registered

BODIES = """
<body name="robot"><geom size="0.1"/>
  <body name="arm" pos="0 0 1"><geom size="0.1"/><body name="hand" pos="0 0 1"><geom size="0.1"/></body></body>
</body>
<body name="wall" pos="5 0 0"><geom size="0.1"/></body>
"""


def world_with(custom: str) -> World:
    return World(f"<mujoco><worldbody>{BODIES}</worldbody><custom>{custom}</custom></mujoco>")


def members(world: World, name: str) -> set[str]:
    handle = world.parts.collections.find(name)
    assert handle is not None
    return {world.sim.scene.get(each).name for each in world.parts.collections.members(handle)}


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ("+all,-tree:arm", {"robot", "wall"}),
        ("-tree:arm,+all", {"robot", "arm", "hand", "wall"}),
        ("+tree:robot,-object:arm", {"robot", "hand"}),
        ("+below:robot", {"arm", "hand"}),
        ("+chain:hand,-above:arm", {"arm", "hand"}),
        ("+above:hand", {"robot", "arm"}),
        ("+all,-below:robot,+object:hand", {"robot", "wall", "hand"}),
    ],
)
def test_steps_add_and_remove_in_their_order(steps: str, expected: set[str]) -> None:
    world = world_with(f'<text name="simx:collection:c" data="steps={steps}"/>')
    assert members(world, "c") == expected


def test_steps_follow_the_other_keys() -> None:
    world = world_with('<text name="simx:collection:c" data="tree=robot steps=-object:hand,+object:wall"/>')
    assert members(world, "c") == {"robot", "arm", "wall"}


def test_a_step_must_name_an_object() -> None:
    with pytest.raises(SceneError, match="has steps=nobody, which is no object"):
        world_with('<text name="simx:collection:c" data="steps=+tree:nobody"/>')


def test_a_reference_can_insist_on_the_collection() -> None:
    note = '<text name="simx:collection:robot" data="steps=+object:wall"/>'
    world = world_with(note)
    assert world.parts.collections.named("collection:robot") == world.parts.collections.find("robot")
    assert world.parts.collections.named("robot") == world.sim.scene.by_name("robot")


def test_a_pair_can_name_such_a_collection() -> None:
    notes = '<text name="simx:collection:robot" data="steps=+all"/>'
    notes += '<text name="simx:collision:bump" data="entity1=collection:robot entity2=wall"/>'
    assert "bump" in world_with(notes).parts.meters.collisions.names()
    with pytest.raises(SceneError, match="no object or collection"):
        world_with('<text name="simx:collision:bump" data="entity1=collection:nobody"/>')


def test_a_copy_of_the_objects_brings_a_copy_of_the_collection() -> None:
    notes = '<text name="simx:model:robot" data="base=yes"/>'
    notes += '<text name="simx:collection:others" data="steps=+all,-tree:robot"/>'
    world = world_with(notes)
    robot = world.sim.scene.by_name("robot")
    assert robot is not None
    copy_objects(world.parts, [robot])
    assert members(world, "others#0") == {"robot", "arm", "hand", "wall"}
    assert members(world, "others") == {"robot#0", "arm#0", "hand#0", "wall"}


def test_steps_of_objects_that_are_not_copied_are_left_out() -> None:
    present: dict[str, dict[str, Annotation]] = {
        "collection": {"c": {"steps": "+tree:robot,+object:wall"}, "d": {"steps": "+all,-tree:wall"}}
    }
    assert concerned(present, {"robot"})["collection"] == {"c": {"steps": "+tree:robot"}}


def test_references_get_the_new_names() -> None:
    names = {"robot": "robot#0", "c": "c#0"}
    assert renamed_registered({"steps": "+all,-tree:robot"}, names) == {"steps": "+all,-tree:robot#0"}
    assert renamed_registered({"entity1": "collection:c"}, names) == {"entity1": "collection:c#0"}
    assert renamed_registered({"tip": "robot;wall", "base": "world"}, names)["tip"] == "robot#0;wall"
    notes: dict[str, Annotation] = {
        "proximity": {"entity": "collection:c"},
        "parameters": {"entity": "robot"},
    }
    assert renamed(notes, names) == {
        "proximity": {"entity": "collection:c#0"},
        "parameters": {"entity": "robot"},
    }
