"""Environment steps per second for 1, 2, 4, 8, 16 worlds: in this process, in worker processes, and as Ray actors.

A step is that of `simx/Reach-v0`: six targets, a simulation step of 50 ms, six joints and the ball. As Ray actors, each
world plays a part of an episode without a message per step, as in a training with a policy in each actor.
"""

from __future__ import annotations

import importlib.util
import logging
import os
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

import gymnasium
import numpy as np

import simx_client.gym  # noqa: F401 - registers the environment
from bench.measuring.measure import Effort, Rounds, in_turn, repeated
from bench.measuring.report import Findings, Grid

ENVIRONMENT = "simx/Reach-v0"
ACTIONS = 6
"""Numbers of an action."""

COUNTS = (1, 2, 4, 8, 16)
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
HERE, WORKERS, RAY = "in this process", f"in {CORES} worker processes", "as Ray actors"
ACTOR_MEMORY, WORLD_MEMORY = (
    "memory of an actor with a world, MB",
    "memory of a further world in a process, MB",
)


def has_ray() -> bool:
    """Whether Ray is installed."""
    return importlib.util.find_spec("ray") is not None


def measure(effort: Effort) -> Findings:
    """Steps per second of all worlds together."""
    ways = (HERE, WORKERS, *([RAY] if has_ray() else []))
    lines: list[tuple[str, tuple[float | None, ...]]] = []
    memory: dict[str, float] = {}
    for count in COUNTS:
        taken = repeated(1, partial(_one_count, effort, count, ways, memory))
        lines.append((str(count), tuple(count / taken[way].median for way in ways)))
    found = Findings("Growth: worlds for learning")
    found.grids = [Grid(("worlds", *(f"steps/s {way}" for way in ways)), lines)]
    found.notes = [f"{what}: {value:.0f}." for what, value in memory.items()]
    if RAY not in ways:
        found.notes.append("Ray is not installed; its column is missing.")
    return found


def _one_count(
    effort: Effort, count: int, ways: tuple[str, ...], memory: dict[str, float], stack: ExitStack
) -> dict[str, Rounds]:
    steps = effort.count(100, least=4)
    cases: dict[str, Callable[[], tuple[float, ...]]] = {}
    before = _memory(os.getpid())
    for way in ways:
        played = stack.enter_context(
            _actors(count, memory) if way == RAY else _vector(count, 0 if way == HERE else min(count, CORES))
        )
        played(2)
        cases[way] = partial(_seconds_per_step, played, steps)
        if way == HERE and count > 1:
            memory[WORLD_MEMORY] = (_memory(os.getpid()) - before) / count
    return in_turn(f"{count} worlds", cases, max(2, effort.rounds))


def _seconds_per_step(play: Callable[[int], object], steps: int) -> tuple[float, ...]:
    began = time.perf_counter()
    play(steps)
    return ((time.perf_counter() - began) / steps,)


@contextmanager
def _vector(count: int, processes: int) -> Generator[Callable[[int], object]]:
    vector = gymnasium.make_vec(ENVIRONMENT, count, processes=processes)
    vector.reset(seed=1)
    actions = np.zeros((count, ACTIONS), np.float32)

    def play(steps: int) -> None:
        for _ in range(steps):
            vector.step(actions)

    yield play
    vector.close()


class _Actor:
    """A world in a process of Ray."""

    def __init__(self) -> None:
        # By the id with its module: Ray's processes have not imported it.
        self._environment: Any = gymnasium.make(f"simx_client.gym:{ENVIRONMENT}", max_episode_steps=-1)
        self._environment.reset(seed=1)

    def play(self, steps: int) -> float:
        """Make steps; return the memory of this process in MB."""
        action = np.zeros(ACTIONS, np.float32)
        for _ in range(steps):
            self._environment.step(action)
        return _memory(os.getpid())


@contextmanager
def _actors(count: int, memory: dict[str, float]) -> Generator[Callable[[int], object]]:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray

    ray.init(
        address="local",
        num_cpus=count,
        include_dashboard=False,
        log_to_driver=False,
        logging_level=logging.ERROR,
    )
    try:
        actors: list[Any] = [ray.remote(_Actor).remote() for _ in range(count)]  # pyright: ignore

        def play(steps: int) -> None:
            sizes = ray.get([actor.play.remote(steps) for actor in actors], timeout=300)
            memory[ACTOR_MEMORY] = sum(sizes) / len(sizes)

        yield play
    finally:
        ray.shutdown()


def _memory(process: int) -> float:
    """Return the share of memory of a process in MB; 0 where the system does not tell."""
    try:
        with open(f"/proc/{process}/smaps_rollup", encoding="ascii") as lines:
            return sum(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1000
    except OSError:
        return 0.0
