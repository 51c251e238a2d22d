"""Where the simulations of a vector environment run: in threads, one after the other, or in workers."""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np

from simx_client.client.servers import Servers
from simx_client.client.worlds.worlds import cores
from simx_client.errors import ConnectionFailed
from simx_client.gym.task import Task

from .episodes import Episodes
from .opening import open_alone, open_many
from .together import Together

_STEPS = 12
"""Steps of a measurement; the median counts."""

_LITTLE, _MUCH = 60e-6, 4e-3
"""Seconds a step: with less to gain, workers are not tried, because an exchange with them takes 100 to 600 us; with
more, they are used without a trial.
"""

_GOOD = 1.25
"""Threads are used without a trial of workers if their step is estimated to take at most this part of that on perfect
cores.
"""


class Wanted(NamedTuple):
    """The places that the user has asked for."""

    processes: int | None = None
    """Number of worker processes, 0 for this process."""

    threads: int | None = None
    """Number of threads, 0 for none."""


class Place(NamedTuple):
    """The simulations, a sentence that says where they run and why, and the number of threads, 0 for calls."""

    servers: Servers
    backend: str
    threads: int


def start(
    task: Task,
    count: int,
    wanted: Wanted,
    timeout: float,
    settings: Mapping[str, object],
    stack: ExitStack,
) -> Place:
    """Start the simulations of a task where a step of all takes the least time.

    The scene and the task decide whether threads can make the steps: where compiled code does everything of them, or
    their physics at least. Otherwise a measurement decides. It starts one simulation in this process; where its step
    leaves a doubt, it starts the workers as well and compares.

    Args:
        wanted: leaves fewer choices, or none.
        count, timeout, settings: as for `Worlds`.
        stack: its end ends the simulations.

    Raises:
        ValueError: the wanted threads cannot be used; the text gives the reason.
    """
    return _Placing(task, count, wanted, timeout, settings, stack).start()


class _Placing:
    """The choice of a place; the arguments are those of `start`."""

    def __init__(
        self,
        task: Task,
        count: int,
        wanted: Wanted,
        timeout: float,
        settings: Mapping[str, object],
        stack: ExitStack,
    ) -> None:
        processes, threads = self._wanted = wanted
        if processes and threads:
            raise ValueError(
                f"worker processes have no threads; leave out processes={processes} or threads={threads}"
            )
        if threads is not None and threads < 0:
            raise ValueError(f"threads must be 0 or more, not {threads}")
        self._task, self._count, self._stack = task, count, stack
        self._timeout, self._settings = timeout, settings
        self._several = min(count, cores())
        self._may_work = processes is None and not threads and self._several > 1 and os.name == "posix"

    def start(self) -> Place:
        processes, threads = self._wanted
        if processes:
            return self._in(self._stack, processes, "as `processes` says")
        # One world alone may have files and ports that another one, for a trial, cannot have too.
        may_thread = threads != 0 and not (self._count == 1 and threads is None and self._settings)
        why = "as `processes` says" if processes == 0 else _few(self._count)
        if not (may_thread or self._may_work):
            return self._in(self._stack, 0, why)
        with ExitStack() as trial:
            alone, _ = open_alone(self._task.scene, self._timeout, self._settings, trial)
            found = try_threads(self._task, alone) if may_thread else why
            if isinstance(found, str) and threads:
                raise ValueError(f"threads={threads} cannot be used: {found}")
            is_whole = isinstance(found, Threaded) and found.is_whole
            in_turn = (
                self._count * seconds_per_step(self._task, alone) if self._may_work and not is_whole else 0.0
            )
        if isinstance(found, str):
            return self._by_calls(in_turn) if self._may_work else self._in(self._stack, 0, found)
        number, in_threads = threads or self._several, found.seconds_of_all(self._count, self._several)
        if found.is_whole:
            return self._in(self._stack, 0, "compiled code does everything of a step", number)
        perfect = self._count * found.seconds / self._several
        if not self._may_work or in_threads <= _GOOD * perfect:
            return self._in(self._stack, 0, _PHYSICS_IN_THREADS, number)
        return self._by_calls(in_turn, in_threads)

    def _by_calls(self, in_turn: float, in_threads: float = math.inf) -> Place:
        """Return workers, or a process without them, where a step takes the least time; or threads.

        Args:
            in_turn: seconds that a step of all takes one after the other.
            in_threads: about how many it takes in threads.
        """
        processes, why = choice(in_turn, self._several)
        if processes is None:
            with ExitStack() as trial:
                workers = self._in(trial, self._several, "")
                together = seconds_per_step(self._task, workers.servers)
                why = (
                    f"a step of all takes {_shown(in_turn)} in one process, {_shown(together)} in {self._several} "
                    "workers"
                )
                if together < min(in_turn, in_threads):
                    self._stack.push(trial.pop_all())
                    return workers._replace(backend=_backend(self._several, 0, why))
            processes = 0
        if processes == 0 and in_threads < in_turn:
            return self._in(self._stack, 0, _PHYSICS_IN_THREADS, self._several)
        return self._in(self._stack, processes, why)

    def _in(self, stack: ExitStack, processes: int, why: str, threads: int = 0) -> Place:
        servers = open_many(self._task.scene, self._count, processes, self._timeout, self._settings, stack)
        return Place(servers, _backend(processes, threads, why), threads)


_PHYSICS_IN_THREADS = "compiled code makes the physics, Python the rest of a step"


class Threaded(NamedTuple):
    """A step of one simulation whose physics threads can make."""

    is_whole: bool
    """Compiled code does everything."""

    seconds: float
    physics: float
    """The part of these seconds that is physics."""

    def seconds_of_all(self, count: int, threads: int) -> float:
        """Return about how long a step of this many simulations takes: one thread does all that Python does."""
        return count * max(self.seconds - self.physics, self.seconds / threads)


def try_threads(task: Task, alone: Servers) -> Threaded | str:
    """Return how a step of one simulation is made where threads make its physics, or why they cannot.

    The simulation is stopped afterwards.
    """
    episodes = Episodes(task, alone)
    episodes.start({0: np.random.default_rng(0)})
    try:
        together = Together(episodes, 1)
    except ConnectionFailed as problem:
        episodes.end()
        return str(problem)
    try:
        times: list[float] = []
        for _ in range(_STEPS):
            began = time.perf_counter()
            together.step((0,), (together.actions.first,))
            times.append(time.perf_counter() - began)
        reason = together.crew.reason_against(0)
        if reason is not None:
            return reason
        physics = together.crew.physics_seconds(0) * task.frame_skip
        return Threaded(together.crew.is_whole, statistics.median(times), physics)
    finally:
        together.end()


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
        actions = [space.sample() for _ in everywhere]
        began = time.perf_counter()
        episodes.step(everywhere, actions)
        times.append(time.perf_counter() - began)
    episodes.end()
    return statistics.median(times)


def _few(count: int) -> str:
    return "one simulation" if count == 1 else "one processor core"


def _backend(processes: int, threads: int, why: str) -> str:
    if threads:
        where = f"{threads} thread{'s' * (threads > 1)} of this process"
    else:
        where = {0: "this process", 1: "1 worker process"}.get(processes, f"{processes} worker processes")
    return f"{where}: {why}"


def _shown(seconds: float) -> str:
    return f"{seconds * 1e3:.2f} ms"
