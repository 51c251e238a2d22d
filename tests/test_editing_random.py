"""Random edits of a scene, stopped and running: what succeeds leaves a tree, and a stop brings the first one back."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from handler_calls import World

from simx_server.errors import CommandError

SCENE = Path(__file__).parent / "conformance" / "scene.xml"
EDITS = 80
MOST_OBJECTS = 60


def random_edit(world: World, choose: random.Random) -> None:
    """One edit with handles of the scene; most are possible."""
    handles = list(world.sim.scene.objects) or [1]
    one, other, third = (choose.choice([*handles, -1]) for _ in range(3))
    name = choose.choice(
        ["simxSetObjectParent"] * 6 + ["simxRemoveObject", "simxRemoveModel", "simxCreateDummy"]
    )
    if len(handles) < MOST_OBJECTS and choose.random() < 0.15:
        name = choose.choice(["simxCopyPasteObjects", "simxLoadModel"])
    world.call(
        name,
        *{
            "simxSetObjectParent": [one, other, choose.random() < 0.5],
            "simxRemoveObject": [one],
            "simxRemoveModel": [one],
            "simxCreateDummy": [0.01, None],
            "simxCopyPasteObjects": [[one, other, third]],
            "simxLoadModel": [str(SCENE), 0],
        }[name],
    )


def tree(world: World) -> dict[int, tuple[str, int]]:
    return {handle: (item.name, item.parent) for handle, item in world.sim.scene.objects.items()}


def check_tree(world: World) -> None:
    """Every object has a way up to the top; no name stands twice."""
    objects = world.sim.scene.objects
    for handle in objects:
        way: list[int] = []
        while handle != -1:
            assert handle not in way, f"{[objects[each].name for each in way]} are each other's ancestors"
            way.append(handle)
            handle = objects[handle].parent
    names = [item.name for item in objects.values()]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("seed", range(4))
def test_random_edits_leave_a_tree_and_stop_restores_it(seed: int) -> None:
    choose, world, edited = random.Random(seed), World(file=SCENE), 0
    before: dict[int, tuple[str, int]] | None = None
    for number in range(EDITS):
        if number % 20 == 10:
            before = tree(world)
            world.run()
        elif number % 20 == 0 and before is not None:
            world.call("simxStopSimulation")
            assert tree(world) == before
        try:
            random_edit(world, choose)
            edited += 1
        except CommandError:
            continue
        check_tree(world)
    assert edited > EDITS / 4


def test_a_force_sensor_moved_into_a_link_is_its_child() -> None:
    world = World(file=SCENE)
    scale, upper, weight = (world.handle(name) for name in ("scale", "upper", "weight"))
    world.call("simxSetObjectParent", weight, -1, True)
    world.call("simxSetObjectParent", scale, upper, True)
    parent = world.sim.scene.get(upper).parent
    assert world.sim.scene.get(scale).parent == upper
    assert parent == world.handle("shoulder")


def test_a_link_cannot_move_to_what_its_own_joint_carries() -> None:
    world = World(file=SCENE)
    elbow, lower, cube = (world.handle(name) for name in ("elbow", "lower", "cube"))
    world.call("simxSetObjectParent", cube, elbow, True)
    with pytest.raises(CommandError, match="'lower' moves with its joint 'elbow', which carries 'cube'"):
        world.call("simxSetObjectParent", lower, cube, True)
