"""The operations that are looked into, in this process and between two."""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np

import simx_client as vrep
import simx_client.gym  # makes the environments known
from bench.calls.client import JOINTS, check, connected, handle_of, over_zenoh, running, settle
from bench.calls.embedded import control_loop, reset, world
from bench.measuring import processes
from bench.world.edits import opened
from bench.world.vrep_files import SCENE, write_scene
from simx_server.scene.formats.loader import load_scene

from .sampling import Sampler, Taken

SCENE_OF_THE_TUTORIAL, FINGER = "ur5_rg2_kinect", "RG2_openCloseJoint"
CARTS = 64
LASTS_S = 3.0
"""Seconds for which an operation is repeated."""

FEWEST = 3
ANSWERS_WITHIN_S = 10.0

Operation = Callable[[], object]


def _nothing() -> None: ...


class Repeated(NamedTuple):
    """An operation that can be done again and again."""

    run: Operation
    before: Operation = _nothing
    after: Operation = _nothing
    """What it needs each time, and what is not looked into."""

    @property
    def is_whole(self) -> bool:
        """Return whether it needs nothing before and after it."""
        return self.before is self.after


class Profile(NamedTuple):
    """Where the time of an operation goes."""

    name: str
    seconds: float
    """Of the wall clock, for one operation."""

    processes: dict[str, Taken]
    """Processor time of one operation, by the process: this one, or client and server."""


def profiles() -> Iterator[Profile]:
    """Look into all of them, one after the other."""
    with ExitStack() as stack:
        yield _start_of_a_server(stack)
    for name, prepare in _HERE.items():
        with ExitStack() as stack:
            seconds, _, taken = _sampled(prepare(stack))
            yield Profile(name, seconds, {"": taken})
    with ExitStack() as stack:
        server = SampledServer(stack)
        server.toggle()  # ends the sample of its start
        for way in ("one host", "Zenoh"):
            with over_zenoh() if way == "Zenoh" else ExitStack(), connected(server.port) as client:
                settle(client)
                yield from _between(server, client, way)


def _start_of_a_server(stack: ExitStack) -> Profile:
    server = SampledServer(stack)
    return Profile("start of a server", server.started_in, {"": server.toggle()})


def _loop_of(seconds: float, stack: ExitStack) -> Repeated:
    client, handles = world(stack, seconds)
    return Repeated(partial(control_loop, client, handles))


def _stop_and_start(stack: ExitStack) -> Repeated:
    client, _ = world(stack, 0.05, is_running=False)
    return Repeated(partial(reset, client))


def _edit(what: str, static: int, stack: ExitStack) -> Repeated:
    sim, edits = opened(static, 0, stack)

    def run() -> None:
        edits[what]()
        sim.compile_edits()

    return Repeated(run, before=sim.start, after=sim.stop)


def _open_a_file(stack: ExitStack) -> Repeated:
    scene = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "scene.ttt"
    write_scene(scene, meshes=round(SCENE / 377_000))
    return Repeated(lambda: load_scene(scene))


def _cart_poles(stack: ExitStack) -> Repeated:
    vector: Any = stack.enter_context(
        closing(gymnasium.make_vec("simx/CartPole-v0", CARTS, threads=os.cpu_count()))
    )
    vector.reset(seed=1)
    return Repeated(partial(vector.step, np.zeros((CARTS, 1), np.float32)))


_HERE: dict[str, Callable[[ExitStack], Repeated]] = {
    "embedded: control loop of 50 ms": partial(_loop_of, 0.05),
    "embedded: control loop of 1 ms": partial(_loop_of, 0.001),
    "embedded: stop and start": _stop_and_start,
    "create a cuboid in 5000 static bodies": partial(_edit, "create a cuboid", 5000),
    "copy fifty bodies in 100 static ones": partial(_edit, "copy fifty", 100),
    "opening a V-REP scene of 5 MB": _open_a_file,
    f"a step of {CARTS} cart-poles": _cart_poles,
}


def _between(server: SampledServer, client: int, way: str) -> Iterator[Profile]:
    """Look into a read while the simulation is stopped, and into the control loop."""
    handles, finger = [handle_of(client, name) for name in JOINTS], handle_of(client, FINGER)
    read = partial(vrep.simxGetJointPosition, client, finger, vrep.simx_opmode_blocking)
    yield server.profile(f"{way}: blocking read", read)
    with running(client, stepped=True):
        for handle in handles:
            vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
        check(vrep.simxSynchronousTrigger(client))
        yield server.profile(f"{way}: control loop of 50 ms", partial(control_loop, client, handles))


def _sampled(repeated: Repeated, lasts: float = LASTS_S) -> tuple[float, int, Taken]:
    """Repeat an operation; return the seconds of one, how often it was done, and this process's time for one."""
    sampler, times, until = Sampler(), 0, time.perf_counter() + lasts
    _once(repeated)  # it fills caches
    sampler.start()
    while times < FEWEST or time.perf_counter() < until:
        if repeated.is_whole:
            repeated.run()
        else:
            sampler.stop()
            repeated.before()
            sampler.start()
            repeated.run()
            sampler.stop()
            repeated.after()
            sampler.start()
        times += 1
    sampler.stop()
    return sampler.seconds / times, times, sampler.taken(times)


def _once(repeated: Repeated) -> None:
    repeated.before()
    repeated.run()
    repeated.after()


class SampledServer:
    """A server in a process of its own that looks at its main thread."""

    def __init__(self, stack: ExitStack) -> None:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-profiles-"))
        self._file = Path(folder) / "found.json"
        module = (sys.executable, "-m", "bench.profiles.server", str(self._file), *processes.SERVER[3:])
        started = stack.enter_context(processes.server(SCENE_OF_THE_TUTORIAL, command=module))
        self._process_id, self.port, self.started_in = started.process_id, started.port, started.started_in

    def toggle(self) -> Taken:
        """End the sample that it takes, or begin another; return what was found, nothing in the second case.

        Raises:
            NotReady: it did not answer.
        """
        self._file.unlink(missing_ok=True)
        os.kill(self._process_id, signal.SIGUSR1)
        until = time.monotonic() + ANSWERS_WITHIN_S
        while time.monotonic() < until:
            if self._file.exists():
                found: tuple[dict[str, float], float, float] | None = json.loads(self._file.read_text())
                return Taken(*(found or ({}, 0.0, 0.0)))
            time.sleep(0.005)
        raise processes.NotReady("the sampled server wrote nothing")

    def profile(self, name: str, operation: Operation, lasts: float = LASTS_S) -> Profile:
        """Look into an operation in both processes."""
        operation()
        self.toggle()
        seconds, times, here = _sampled(Repeated(operation), lasts)
        there = self.toggle()
        by_function = {name: taken / times for name, taken in there.by_function.items()}
        return Profile(
            name,
            seconds,
            {"client": here, "server": Taken(by_function, there.main / times, there.others / times)},
        )
