"""The shipped scenes: what a pass costs of the time it stands for, with scripts and without cameras."""

from __future__ import annotations

import statistics
from contextlib import ExitStack
from functools import partial
from typing import Any

import mujoco

from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Grid, Ratio
from simx_server.app.server import open_world
from simx_server.files.library import list_scenes
from simx_server.settings.settings import Settings

MOST = 2.0
"""Times the same `mj_step` calls, that a simulation step of the middle one of the scenes may take."""

MIDDLE = "a simulation step of the shipped scenes, their median / the same mj_step calls"
DEAREST = "a simulation step of the dearest shipped scene / the same mj_step calls"
HEAD = ("scene", "a pass of ... ms", "takes, ms", "p99, ms", "beside mj_step alone", "% of real time")


def measure(effort: Effort) -> Findings:
    """Every scene of the library, running from its start, beside the same `mj_step` calls."""
    found = Findings("Shipped scenes, without cameras", topic="Simulation step")
    lines: list[tuple[str, list[float | None]]] = []
    beside: dict[str, float] = {}
    for scene in list_scenes():
        taken = repeated(max(1, effort.sets // 4), partial(_one_set, effort, scene))
        step = time_step_of(scene)
        passes, steps = taken[scene], taken[f"{scene}: the same mj_step calls"]
        beside[scene] = ratio(passes, steps)
        share = 100 * passes.median / step
        lines.append((scene, [step * 1e3, passes.median * 1e3, passes.p99 * 1e3, beside[scene], share]))
    dearest = max(beside, key=beside.__getitem__)
    found.ratios += [
        Ratio(MIDDLE, statistics.median(beside.values()), target=MOST),
        Ratio(f"{DEAREST}: {dearest}", beside[dearest]),
    ]
    found.grids.append(Grid(HEAD, lines))
    return found


def time_step_of(scene: str) -> float:
    """Seconds of a scene's pass."""
    with ExitStack() as stack:
        return open_world(Settings(scene=scene), stack).simulation.time_step


def _one_set(effort: Effort, scene: str, stack: ExitStack) -> dict[str, Rounds]:
    simulation = open_world(Settings(scene=scene), stack)
    simulation.simulation.start()
    stack.callback(simulation.simulation.stop)
    simulation.step()
    model, data = simulation.simulation.model, mujoco.MjData(simulation.simulation.model)
    mujoco.mj_copyData(data, model, simulation.simulation.data)
    return side_by_side(
        scene,
        {
            scene: simulation.step,
            f"{scene}: the same mj_step calls": lambda: _step(model, data, simulation.simulation.substeps),
        },
        rounds=effort.rounds,
        calls=effort.count(60),
    )


def _step(model: Any, data: Any, steps: int) -> None:
    for _ in range(steps):
        mujoco.mj_step(model, data)
