"""Edits of a scene: what each costs beside what MuJoCo itself needs to add a body and compile that scene."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from itertools import count
from pathlib import Path

from bench.measuring.measure import Effort, Progress, Rounds, ratio
from bench.measuring.report import Findings, Grid, Ratio
from simx_server.app.building import build_world
from simx_server.editing import copying, creating, models
from simx_server.scene.editing import editing
from simx_server.scene.formats.loader import load_text
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

from .boxes import MODEL

SIZES = ((100, 0), (1000, 0), (5000, 0), (500, 250))
"""Static bodies, and bodies with a free joint."""

MOST = 3.0
"""Times as long as MuJoCo, that an edit may take."""

COMPILE = "MuJoCo: add a body, compile"
COMPILE_FIFTY = "MuJoCo: add fifty bodies, compile"
DELETE = "MuJoCo: delete a body, compile"
BASELINES = {
    COMPILE_FIFTY: ("copy fifty",),
    DELETE: ("set a parent", "remove one"),
}
"""Where it is not `COMPILE`."""


def measure(effort: Effort) -> Findings:
    """In process: an edit is the same with a client in front, plus a round trip.

    Seconds are the processor's: nothing waits here, and a busy machine does not count.
    """
    found = Findings("Edits", topic="Growth")
    sizes = SIZES if effort.factor == 1.0 else (*SIZES[:2], SIZES[3])
    lines: dict[str, list[float | None]] = {}
    head = ["seconds"]
    for static, free in sizes:
        taken = _taken(static, free, effort)
        scene = f"{static} static" + (f", {free} free" if free else "")
        head.append(scene)
        dearest: dict[str, float] = {}
        for what, rounds in taken.items():
            lines.setdefault(what, []).append(rounds.median)
            if what in (COMPILE, *BASELINES):
                continue
            baseline = next((name for name, whats in BASELINES.items() if what in whats), COMPILE)
            each = f"{what} in {scene} / {baseline}"
            dearest[each] = ratio(rounds, taken[baseline])
            found.ratios.append(Ratio(each, dearest[each]))
        worst = max(dearest, key=dearest.__getitem__)
        found.ratios.append(Ratio(f"the dearest edit: {worst}", dearest[worst], target=MOST))
    found.grids.append(Grid(head, list(lines.items())))
    found.notes.append(
        "`MjSpec.delete` of a body takes MuJoCo several times as long as compiling static bodies: it copies the scene. "
        "To remove an object and to give a body another parent need it, so it belongs to their baseline."
    )
    return found


def _taken(static: int, free: int, effort: Effort) -> dict[str, Rounds]:
    """Seconds of each edit, in turn, in a run whose stop takes all of them back."""
    rounds = effort.count(9, 3)
    with ExitStack() as stack:
        sim, edits = opened(static, free, stack)
        taken: dict[str, list[float]] = {what: [] for what in edits}
        progress = Progress(f"edits in {static + free} bodies", (rounds + 1) * len(edits))
        for turn in range(rounds + 1):
            sim.start()
            for what, edit in edits.items():
                began = time.process_time()
                edit()
                sim.compile_edits()
                if turn:  # the first one is made with cold caches
                    taken[what].append(time.process_time() - began)
                progress.step()
            sim.stop()
    return {what: Rounds(tuple((seconds,) for seconds in values)) for what, values in taken.items()}


def opened(static: int, free: int, stack: ExitStack) -> tuple[Simulation, dict[str, Callable[[], object]]]:
    """Return a simulation of so many bodies, and edits of it by name."""
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    rendering = RenderThread()
    stack.callback(rendering.close)
    world = build_world(rendering, workspace=folder)
    world.simulation.use(*load_text(_scene(static, free)))
    return world.simulation, _edits(world, folder)


def _edits(world: World, folder: Path) -> dict[str, Callable[[], object]]:
    sim = world.simulation
    model = folder / "lamp.xml"
    model.write_text(MODEL, encoding="utf-8")
    alone = sim.scene.spec.copy()
    alone.compile()

    def compile_alone(bodies: int) -> None:
        for _ in range(bodies):
            alone.worldbody.add_body().add_geom(size=[0.1] * 3)
        alone.compile()

    def compile_without_one() -> None:
        alone.delete(next(bodies))
        alone.compile()

    bodies = (alone.body(f"b{i}") for i in count())
    first, second, third, *_ = fifty = sim.scene.children(-1)[:50]
    return {
        COMPILE: partial(compile_alone, 1),
        "create a dummy": lambda: editing.create_dummy(sim, 0.1),
        "create a cuboid": lambda: creating.create_primitive(world, "cuboid", [0.1] * 3, creating.Body()),
        "copy one": lambda: copying.copy_objects(world, [first]),
        COMPILE_FIFTY: partial(compile_alone, 50),
        "copy fifty": lambda: copying.copy_objects(world, fifty),
        DELETE: compile_without_one,
        "set a parent": lambda: editing.set_parent(sim, second, first, True),
        "remove one": lambda: editing.remove_object(sim, third),
        "load a model": lambda: models.load_model(world, model),
    }


def _scene(static: int, free: int) -> str:
    boxes = "".join(
        f'<body name="b{i}" pos="{i % 50} {i // 50} 0.1"><geom type="box" size=".1 .1 .1"/></body>'
        for i in range(static)
    )
    balls = "".join(
        f'<body name="f{i}" pos="{i % 50} {i // 50} 3"><freejoint/><geom size=".1"/></body>'
        for i in range(free)
    )
    return f'<mujoco><size memory="400M"/><worldbody>{boxes}{balls}</worldbody></mujoco>'
