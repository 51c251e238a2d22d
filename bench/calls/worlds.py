"""Many simulations stepped together, beside MuJoCo's own ``rollout``.

An environment step is that of the reach task: six targets, a simulation step, six joints and the ball in the camera's
frame. ``rollout`` makes the same physics steps from the same states with constant controls, and returns the states.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.scheduling import cores
from bench.world.physics import Physics
from simx_client.client import Answer, Calls, Worlds

from .batch import TASKS

COUNT = 8
CORES = cores()

ALONE = "a step of 8 worlds in this process"
TOGETHER = f"a step of 8 worlds in {CORES} processes"
ROLLOUT_ALONE = "rollout of 8 worlds by 1 thread"
ROLLOUT = f"rollout of 8 worlds by {CORES} threads"

SPEED_UP = 1.7
"""Times the steps per second of one process that two processes are to make."""

SHARE = 0.7
"""Share of the steps per second of `ROLLOUT` that the worlds are to make."""


def measure(effort: Effort) -> Findings:
    """The tutorial's scene, simulation steps of 50 ms."""
    taken = repeated(1, partial(_one_set, effort))
    found = Findings("Many worlds", topic="Embedded simulations")
    found.ratios = [
        Ratio(f"{TOGETHER} / {ROLLOUT}", ratio(taken[TOGETHER], taken[ROLLOUT]), target=1 / SHARE),
        Ratio(
            f"{TOGETHER} / {ALONE}",
            ratio(taken[TOGETHER], taken[ALONE]),
            target=1 / SPEED_UP if CORES > 1 else None,
        ),
        Ratio(f"{ROLLOUT} / {ROLLOUT_ALONE}", ratio(taken[ROLLOUT], taken[ROLLOUT_ALONE])),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes = [
        f"{COUNT / taken[TOGETHER].median:,.0f} environment steps per second. The third ratio is the speed-up that "
        "this machine gives to two threads of MuJoCo alone."
    ]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    physics = Physics(stack)
    cases: dict[str, Callable[[], object]] = {
        ROLLOUT_ALONE: stack.enter_context(_rollout(physics, 1)),
        ALONE: stack.enter_context(stepped(0)),
        TOGETHER: stack.enter_context(stepped(CORES)),
        ROLLOUT: stack.enter_context(_rollout(physics, CORES)),
    }
    return side_by_side("worlds", cases, rounds=max(2, effort.rounds * 3), calls=effort.count(20))


@contextmanager
def stepped(processes: int) -> Generator[Callable[[], object]]:
    """Give an environment step of all worlds, in so many processes or, for 0, in this one."""
    task = TASKS[0]
    with Worlds(task.scene, COUNT, processes=processes) as worlds:
        names = (*task.joints, task.seen_from, task.ball)
        handles = [
            [answer.value for answer in answers]
            for answers in worlds.each(lambda calls, _: [calls.simxGetObjectHandle(name) for name in names])
        ]

        def prepare(calls: Calls, place: int) -> None:
            calls.simxSynchronous(True)
            calls.simxStartSimulation()
            for joint, angle in zip(handles[place], task.pose, strict=False):
                calls.simxSetJointPosition(joint, angle)

        def read(calls: Calls, place: int) -> list[Answer[Any]]:
            *joints, camera, ball = handles[place]
            return [
                *[calls.simxGetJointPosition(joint) for joint in joints],
                calls.simxGetObjectPosition(ball, camera),
            ]

        def write(calls: Calls, place: int) -> None:
            for joint, angle in zip(handles[place], task.pose, strict=False):
                calls.simxSetJointTargetPosition(joint, angle)

        worlds.each(prepare)
        worlds.watch(read)
        yield partial(worlds.step, write)


@contextmanager
def _rollout(physics: Physics, threads: int) -> Generator[Callable[[], object]]:
    """The physics of as many worlds, without controllers and scripts."""
    model, data, steps = physics.model, physics.data, physics.substeps
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, state, full)
    states = np.tile(state, (COUNT, 1))
    controls = np.tile(data.ctrl, (COUNT, steps, 1))
    each = [mujoco.MjData(model) for _ in range(threads)]
    with Rollout(nthread=threads if threads > 1 else 0) as rollout:

        def step() -> None:
            nonlocal states
            found, _ = rollout.rollout([model] * COUNT, each, states, controls, nstep=steps)
            states = np.ascontiguousarray(np.asarray(found)[:, -1])

        yield step
