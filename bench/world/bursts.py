"""Bursts of edits: fifty that wait for one compile, beside fifty that are compiled one by one."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

from bench.measuring.measure import Effort, Progress, Rounds, ratio
from bench.measuring.report import Findings, Grid, Ratio
from simx_server.app.building import build_world
from simx_server.editing import creating
from simx_server.handlers.objects import objects, poses
from simx_server.scene.editing import recompile
from simx_server.scene.formats.loader import load_text
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.world.world import World

from .boxes import boxes

BODIES, BURST = 1000, 50

MOST = 0.2
"""Share of the time of edits that are compiled one by one."""

READ = ", the model is read after each"

Action = Callable[[bool, World], None]


def measure(effort: Effort) -> Findings:
    """In process, in seconds of the processor: an edit is the same with a client in front, plus a round trip."""
    found = Findings("Bursts of edits", topic="Growth")
    taken, compiles = _taken(effort)
    lines: list[tuple[str, list[float | None]]] = []
    for what in BURSTS:
        for each in (what, what + READ):
            lines.append((f"{each}: ms", [taken[each].median * 1e3]))
            lines.append((f"{each}: compiles", [compiles[each]]))
        found.ratios.append(
            Ratio(f"{what} / the same{READ}", ratio(taken[what], taken[what + READ]), target=MOST)
        )
    found.grids.append(Grid(["", f"scene of {BODIES} static bodies"], lines))
    found.notes.append(
        "New shapes of a primitive form, and removals of shapes that nothing else has to do with, wait until something "
        "reads the model. All of them are compiled then. A pose or a colour of a new shape waits with it."
    )
    return found


def _create(reads: bool, world: World) -> None:
    for _ in range(BURST):
        creating.create_primitive(world, "cuboid", [0.1] * 3, creating.Body())
        if reads:
            world.simulation.compile_edits()


def _create_and_place(reads: bool, world: World) -> None:
    for number in range(BURST):
        handle = creating.create_primitive(world, "cuboid", [0.1] * 3, creating.Body())
        poses.set_object_position(world, handle, -1, [number, -1.0, 0.1])
        world.shape_colors.set(handle, 0, [1.0, 0.0, 0.0])
        if reads:
            world.simulation.compile_edits()


def _remove(reads: bool, world: World) -> None:
    scene = world.simulation.scene
    for handle in [each for each in scene.children(-1) if scene.objects[each].element == "body"][:BURST]:
        objects.remove_object(world, handle)
        if reads:
            world.simulation.compile_edits()


BURSTS: dict[str, Action] = {
    f"create {BURST} cuboids": _create,
    f"create {BURST} cuboids, place and colour them": _create_and_place,
    f"remove {BURST} shapes": _remove,
}


def _taken(effort: Effort) -> tuple[dict[str, Rounds], Counter[str]]:
    """Return seconds and compiles of each burst, in turn, in runs whose stops take them back."""
    rounds, compiles = effort.count(9, 3), Counter[str]()
    bursts: dict[str, Callable[[World], None]] = {}
    for what, burst in BURSTS.items():
        bursts[what] = partial(burst, False)
        bursts[what + READ] = partial(burst, True)
    taken: dict[str, list[float]] = {name: [] for name in bursts}
    with ExitStack() as stack:
        rendering = RenderThread()
        stack.callback(rendering.close)
        world = build_world(rendering)
        sim = world.simulation
        sim.use(*load_text(boxes(BODIES)))
        progress = Progress(f"bursts in {BODIES} bodies", (rounds + 1) * len(bursts))
        for turn in range(rounds + 1):
            for name, burst in bursts.items():
                sim.start()
                with _counted() as made:
                    began = time.process_time()
                    burst(world)
                    sim.compile_edits()
                    seconds = time.process_time() - began
                sim.stop()
                if turn:  # the first one is made with cold caches
                    taken[name].append(seconds)
                    compiles[name] = made["compiles"]
                progress.step()
    return {name: Rounds(tuple((each,) for each in values)) for name, values in taken.items()}, compiles


@contextmanager
def _counted() -> Generator[Counter[str]]:
    """Count the compiles of the scene within the block."""
    made, compile_spec = Counter[str](), recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        made["compiles"] += 1
        return compile_spec(*arguments)

    recompile.compile_spec = counted
    try:
        yield made
    finally:
        recompile.compile_spec = compile_spec
