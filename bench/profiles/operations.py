"""The operations of this process that are looked into: what is repeated, and what each repetition needs."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from bench.calls import worlds
from bench.calls.embedded import control_loop, reset, world
from bench.images import picture
from bench.ros2 import steps
from bench.world import script_calls
from bench.world.edits import opened
from bench.world.vrep_files import SCENE, write_scene
from simx_server.scene.formats.loader import load_scene

from .sampling import Sampler, Taken

CARTS = 64
IMAGE = f"{picture.BUILD} of an image"
LASTS_S = 3.0
"""Seconds for which an operation is repeated."""

FEWEST = 3

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


def sampled(repeated: Repeated, lasts: float = LASTS_S) -> tuple[float, int, Taken]:
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
        closing(gymnasium.make_vec("simx_client.gym:simx/CartPole-v0", CARTS, threads=os.cpu_count()))
    )
    vector.reset(seed=1)
    return Repeated(partial(vector.step, np.zeros((CARTS, 1), np.float32)))


def _many_worlds(processes: int, stack: ExitStack) -> Repeated:
    return Repeated(stack.enter_context(worlds.stepped(processes)))


def _with_a_listener(stack: ExitStack) -> Repeated:
    return Repeated(steps.heard(stack).step)


def _scan(stack: ExitStack) -> Repeated:
    world, script = script_calls.opened(stack)
    return Repeated(partial(world.scripts.run, script, "scan"))


def _image(what: str, stack: ExitStack) -> Repeated:
    return Repeated(picture.lists(stack)[what])


HERE: dict[str, Callable[[ExitStack], Repeated]] = {
    "embedded: control loop of 50 ms": partial(_loop_of, 0.05),
    "embedded: control loop of 1 ms": partial(_loop_of, 0.001),
    "embedded: stop and start": _stop_and_start,
    "create a cuboid in 5000 static bodies": partial(_edit, "create a cuboid", 5000),
    "copy fifty bodies in 100 static ones": partial(_edit, "copy fifty", 100),
    "opening a V-REP scene of 5 MB": _open_a_file,
    f"a step of {CARTS} cart-poles": _cart_poles,
    worlds.ALONE: partial(_many_worlds, 0),
    worlds.TOGETHER: partial(_many_worlds, worlds.CORES),
    steps.HEARD: _with_a_listener,
    script_calls.SCAN: _scan,
    picture.FRAME: partial(_image, picture.FRAME),
    IMAGE: partial(_image, picture.BUILD),
}
