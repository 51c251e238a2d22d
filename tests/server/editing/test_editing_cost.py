"""An edit does not walk through the scene: it does as much for one object in a large scene as in a small one."""

from __future__ import annotations

import gc
import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from handler_calls import World

from simx_server.editing import copying, creating, models
from simx_server.scene.editing import editing, recompile
from simx_server.scene.objects import Scene
from simx_server.scene.tree import Builder

pytestmark = pytest.mark.slow

SMALL, LARGE = 40, 160


def scene(bodies: int) -> str:
    """Static and free ones, by turns; every tenth has a child on a motor, a site and a sensor."""
    parts = []
    for i in range(bodies):
        joint = "<freejoint/>" if i % 2 else ""
        more = (
            f'<site name="s{i}"/><body name="c{i}"><joint name="j{i}"/><geom size="0.01"/></body>'
            if i % 10 == 0
            else ""
        )
        parts.append(f'<body name="b{i}" pos="{i} 0 0">{joint}<geom size="0.01"/>{more}</body>')
    sensors = "".join(f'<jointpos joint="j{i}"/>' for i in range(0, bodies, 10))
    return f"<mujoco><worldbody>{''.join(parts)}</worldbody><sensor>{sensors}</sensor></mujoco>"


def statics(bodies: int) -> str:
    """Shapes that stand still, as most of a large scene does."""
    shapes = (f'<body name="b{i}" pos="{i} 0 0"><geom size="0.01"/></body>' for i in range(bodies))
    return f"<mujoco><worldbody>{''.join(shapes)}</worldbody></mujoco>"


def calls_in(action: Callable[[], object]) -> int:
    """Functions called meanwhile, MuJoCo's included; not those of a garbage collection, which comes when it likes."""
    count = 0

    def note(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    gc.disable()
    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
        gc.enable()
    return count


EDITS: dict[str, Callable[[World, Path], object]] = {
    "a dummy is created": lambda world, _: editing.create_dummy(world.sim, 0.1),
    "a shape is created": lambda world, _: creating.create_primitive(
        world.parts, "cuboid", [0.1] * 3, creating.Body()
    ),
    "a shape is copied": lambda world, _: copying.copy_objects(world.parts, [world.handle("b4")]),
    "a shape is removed": lambda world, _: editing.remove_object(world.sim, world.sim.scene.children(-1)[-1]),
    "a parent is set": lambda world, _: editing.set_parent(
        world.sim, world.sim.scene.children(-1)[-1], world.sim.scene.children(-1)[-2], True
    ),
    "a model is loaded": lambda world, folder: models.load_model(world.parts, folder / "model.xml"),
}


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS)
def test_an_edit_does_as_much_in_a_large_scene_as_in_a_small_one(
    edit: Callable[[World, Path], object], tmp_path: Path
) -> None:
    (tmp_path / "model.xml").write_text(statics(2).replace('"b', '"m'), encoding="utf-8")
    counts = []
    for bodies in (SMALL, LARGE):
        world = World(statics(bodies))
        edit(world, tmp_path)  # what is made once
        counts.append(calls_in(partial(edit, world, tmp_path)))
    small, large = counts
    assert large - small < (LARGE - SMALL) / 2, "something is done for each object of the scene"


def test_many_copies_are_one_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    world = World(statics(60))
    compiled: Counter[str] = Counter()
    compile_spec = recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        compiled["all"] += 1
        return compile_spec(*arguments)

    monkeypatch.setattr(recompile, "compile_spec", counted)
    copies = copying.copy_objects(world.parts, [world.handle(f"b{i}") for i in range(50)])
    assert len(copies) == len(set(copies)) == 50
    assert world.sim.model.nbody > 50
    assert compiled["all"] == 1


def test_the_scene_after_edits_is_the_one_that_its_whole_model_makes() -> None:
    """`successor.py` makes only what an edit concerns; `tree.py` makes all."""
    world = World(scene(40))
    sim = world.sim
    handle = world.handle

    def check() -> None:
        assert described(sim.scene) == described_by_its_model(world)

    for edit in (
        lambda: editing.create_dummy(sim, 0.1),
        lambda: copying.copy_objects(world.parts, [handle("b4"), handle("j10"), handle("s20")]),
        lambda: editing.remove_object(sim, handle("c20")),
        lambda: editing.remove_object(sim, handle("j30")),
        lambda: editing.remove_object(sim, handle("b2")),
        lambda: editing.set_parent(sim, handle("b6"), handle("c10"), True),
        lambda: editing.set_parent(sim, handle("s10"), handle("b8"), True),
        lambda: copying.copy_objects(world.parts, [handle("b10")]),
        lambda: editing.remove_object(sim, handle("b10")),
    ):
        edit()
        check()


def described(scene: Scene) -> dict[Any, Any]:
    return {
        (item.element, item.element_name): (item.kind, item.id, item.body, item.sensors)
        for item in scene.objects.values()
    }


def described_by_its_model(world: World) -> dict[Any, Any]:
    sim = world.sim
    scene = sim.scene
    builder = Builder(sim.model, scene.annotations, scene.hidden_bodies, None, scene.unseen_sites)
    builder.build()
    assert np.array_equal(
        [structural(builder.objects, builder.owner[body]) for body in range(sim.model.nbody)],
        [structural(sim.scene.objects, int(owner)) for owner in sim.scene.owners],
    )
    return {
        (item.element, item.element_name): (item.kind, item.id, item.body, item.sensors)
        for item in builder.objects.values()
    }


def structural(objects: Any, handle: int) -> str:
    return "" if handle == -1 else f"{objects[handle].element} {objects[handle].element_name}"
