"""Worlds of two files that are to be the same scene, compared."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from handler_calls import QuickPainter, World


@contextmanager
def opened(*files: Path) -> Iterator[list[World]]:
    """Worlds with these scenes, whose scripts end with the context."""
    worlds: list[World] = []
    try:
        for file in files:
            worlds.append(World(file=file, painter=QuickPainter()))
        yield worlds
    finally:
        for world in worlds:
            world.sim.stop()
            world.parts.scripts.close()


def objects_of(world: World) -> list[tuple[Any, ...]]:
    """The visible state of all objects, in the order of their handles."""
    scene = world.sim.scene
    return [
        (
            *(item.handle, item.name, item.kind, item.parent, item.alias, item.element, item.element_name),
            *({kind: note for kind, note in item.annotations.items() if "script" not in kind},),
        )
        for item in scene.objects.values()
    ]


def scripts_of(world: World) -> list[tuple[Any, ...]]:
    return [
        (
            script.kind,
            script.owner,
            script.language,
            script.threaded,
            script.enabled,
            script.source(world.sim),
        )
        for script in world.parts.scripts.all()
    ]


def run_of(world: World, steps: int) -> np.ndarray:
    """Positions and velocities after each simulation step."""
    states: list[np.ndarray] = []
    world.sim.start()
    for _ in range(steps):
        world.parts.step()
        states.append(np.concatenate([world.sim.data.qpos, world.sim.data.qvel]))
    return np.array(states)


def assert_same_world(first: World, second: World, steps: int) -> None:
    assert objects_of(first) == objects_of(second)
    assert scripts_of(first) == scripts_of(second)
    assert first.sim.scene.annotations.registered == second.sim.scene.annotations.registered
    assert first.sim.time_step == second.sim.time_step
    np.testing.assert_array_equal(run_of(first, steps), run_of(second, steps))


def assert_same_model(first: World, second: World) -> None:
    """The same objects, whatever their handles: the parts of a scene come in another order."""
    found: list[dict[str, tuple[Any, ...]]] = []
    for world in (first, second):
        objects = world.sim.scene.objects
        poses = {item.name: world.call("simxGetObjectPosition", item.handle, -1) for item in objects.values()}
        parents = {
            item.name: objects[item.parent].name if item.parent != -1 else "" for item in objects.values()
        }
        found.append(
            {
                item.name: (item.kind, parents[item.name], *np.round(poses[item.name], 6))
                for item in objects.values()
            }
        )
    assert found[0] == found[1]
