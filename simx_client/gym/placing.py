"""Where the simulations of a vector environment run: in this process or in workers, as a measurement says."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from simx_client.client.servers import Servers
from simx_client.client.worlds.worlds import cores

from .episodes import Episodes
from .opening import open_alone, open_many
from .task import Task

_STEPS = 12
"""Steps of a measurement; the median counts."""

_LITTLE, _MUCH = 60e-6, 4e-3
"""Seconds a step: with less to gain, workers are not tried, because an exchange with them takes 100 to 600 us; with
more, they are used without a trial.
"""


class Place(NamedTuple):
    """The simulations, and a sentence that says where they run and why."""

    servers: Servers
    backend: str


def start(
    task: Task,
    count: int,
    processes: int | None,
    timeout: float,
    settings: Mapping[str, object],
    stack: ExitStack,
) -> Place:
    """Start the simulations of a task where a step of all takes the least time.

    Args:
        processes: number of worker processes, 0 for this process; None: a measurement decides. It starts one simulation
            in this process; where its step leaves a doubt, it starts the workers as well and compares.
        count, timeout, settings: as for `Worlds`.
        stack: its end ends the simulations.
    """
    several = min(count, cores())
    if processes is not None:
        why = "as `processes` says"
    elif several < 2 or os.name != "posix":
        processes, why = 0, "one simulation" if count == 1 else "one processor core"
    else:
        with ExitStack() as trial:
            alone, _ = open_alone(task.scene, timeout, settings, trial)
            in_turn = count * seconds_per_step(task, alone)
        processes, why = choice(in_turn, several)
        if processes is None:
            with ExitStack() as trial:
                workers = open_many(task.scene, count, several, timeout, settings, trial)
                together = seconds_per_step(task, workers)
                why = f"a step of all takes {_shown(in_turn)} in one process, {_shown(together)} in {several} workers"
                if together < in_turn:
                    stack.push(trial.pop_all())
                    return Place(workers, _backend(several, why))
            processes = 0
    return Place(open_many(task.scene, count, processes, timeout, settings, stack), _backend(processes, why))


def choice(in_turn: float, workers: int) -> tuple[int | None, str]:
    """Return the number of worker processes and the reason; None: an estimate cannot tell.

    Args:
        in_turn: seconds that a step of all simulations takes one after the other.
        workers: number of worker processes that there would be.
    """
    gain = in_turn * (1 - 1 / workers)
    why = f"a step of all takes {_shown(in_turn)} in one process"
    if gain < _LITTLE:
        return 0, f"{why}, which workers cannot make shorter"
    return (workers if gain > _MUCH else None), why


def seconds_per_step(task: Task, servers: Servers) -> float:
    """Return the time of a step of all simulations with random actions; they are stopped afterwards."""
    episodes = Episodes(task, servers)
    space = episodes.actions.space
    space.seed(0)
    everywhere = range(len(servers))
    episodes.start({each: np.random.default_rng(0) for each in everywhere})
    times: list[float] = []
    for _ in range(_STEPS):
        actions = {each: space.sample() for each in everywhere}
        began = time.perf_counter()
        episodes.step(actions)
        times.append(time.perf_counter() - began)
    episodes.end()
    return statistics.median(times)


def _backend(processes: int, why: str) -> str:
    where = {0: "this process", 1: "1 worker process"}.get(processes, f"{processes} worker processes")
    return f"{where}: {why}"


def _shown(seconds: float) -> str:
    return f"{seconds * 1e3:.2f} ms"
