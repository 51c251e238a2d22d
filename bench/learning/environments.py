"""Environments beside those of others: one alone, and many that step together in threads.

Small physics is measured beside Gymnasium's inverted pendulum, a cart with a pole in MuJoCo too; that of a robot arm
beside MuJoCo's own `rollout` and `batch`, which make the same physics steps and return to Python in each environment
step. They have no controllers, observations and rewards. EnvPool is measured too if it is installed.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable, Generator
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from mujoco.batch import Batch
from mujoco.rollout import Rollout

import simx_client.gym  # noqa: F401 - registers the environments
from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.scheduling import cores
from bench.world.physics import Physics

CORES = cores()
COUNTS = (2, 8, 64)
MANY = COUNTS[-1]
ARMS = 8

ALONE, PENDULUM = "a step of simx/CartPole-v0", "a step of InvertedPendulum-v5"
RESET = "a reset of simx/CartPole-v0"
LONGEST_RESET = 50e-6
"""Seconds that a reset of the cart-pole is to take at most."""

SHARE = 0.8
"""Share of the steps per second of `rollout` that the arms are to make."""

SPEED_UP = 1.7
"""Times the steps per second of one thread that two are to make, where `rollout` gains 1.9."""


def carts(count: int, threads: int) -> str:
    return f"a step of {count} cart-poles by {threads} thread{'s' * (threads > 1)}"


def others(count: int, kind: str) -> str:
    return f"a step of {count} pendulums by {kind}"


def arms(what: str, threads: int) -> str:
    return f"a step of {ARMS} arms: {what} by {threads} thread{'s' * (threads > 1)}"


def measure(effort: Effort) -> Findings:
    """One environment, many small ones, and some with much physics."""
    taken = repeated(1, partial(_alone, effort))
    for count in COUNTS:
        taken |= repeated(1, partial(_carts, effort, count))
    taken |= repeated(1, partial(_arms, effort))
    found = Findings("Environments for learning", topic="Embedded simulations")
    found.ratios = [
        Ratio(f"{ALONE} / {PENDULUM}", ratio(taken[ALONE], taken[PENDULUM]), target=1.0),
        Ratio(f"{RESET} / 50 us", taken[RESET].median / LONGEST_RESET, target=1.0),
        *(
            Ratio(
                f"{carts(count, CORES)} / {carts(count, 1)}",
                ratio(taken[carts(count, CORES)], taken[carts(count, 1)]),
            )
            for count in COUNTS
        ),
        Ratio(
            f"{arms('simx/Reach-v0', CORES)} / rollout",
            ratio(taken[arms("simx/Reach-v0", CORES)], taken[arms("rollout", CORES)]),
            target=1 / SHARE,
        ),
        Ratio(
            f"{arms('simx/Reach-v0', CORES)} / 1 thread",
            ratio(taken[arms("simx/Reach-v0", CORES)], taken[arms("simx/Reach-v0", 1)]),
            target=1 / SPEED_UP if CORES > 1 else None,
        ),
        Ratio(
            f"{arms('rollout', CORES)} / 1 thread",
            ratio(taken[arms("rollout", CORES)], taken[arms("rollout", 1)]),
        ),
    ]
    if _has_envpool():
        many = carts(MANY, CORES)
        found.ratios.insert(
            5, Ratio(f"{many} / EnvPool", ratio(taken[many], taken[others(MANY, "EnvPool")]), target=1.0)
        )
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes = [
        f"{count} cart-poles make {count / taken[carts(count, CORES)].median:,.0f} environment steps per second."
        for count in COUNTS
    ]
    if not _has_envpool():
        found.notes.append("EnvPool is not installed here, so its aim is missing.")
    return found


def _has_envpool() -> bool:
    return importlib.util.find_spec("envpool") is not None


def _alone(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    cart, pendulum = (
        stack.enter_context(closing(gymnasium.make(name).unwrapped))
        for name in ("simx/CartPole-v0", "InvertedPendulum-v5")
    )
    action = np.zeros(1, np.float32)
    for each in (cart, pendulum):
        each.reset(seed=1)
    cases: dict[str, Callable[[], object]] = {
        ALONE: partial(cart.step, action),
        PENDULUM: partial(pendulum.step, action),
    }
    taken = side_by_side("one environment", cases, rounds=max(2, effort.rounds * 3), calls=effort.count(4000))
    return taken | side_by_side(
        "reset", {RESET: cart.reset}, rounds=max(2, effort.rounds), calls=effort.count(500)
    )


def _carts(effort: Effort, count: int, stack: ExitStack) -> dict[str, Rounds]:
    vectors: dict[str, Any] = {
        carts(count, threads): gymnasium.make_vec("simx/CartPole-v0", count, threads=threads)
        for threads in dict.fromkeys((1, CORES))
    }
    makers = [lambda: gymnasium.make("InvertedPendulum-v5")] * count
    vectors[others(count, "SyncVectorEnv")] = SyncVectorEnv(makers)
    if count <= 8:  # a process each
        vectors[others(count, "AsyncVectorEnv")] = AsyncVectorEnv(makers)
    if count == MANY and _has_envpool():
        vectors[others(count, "EnvPool")] = _envpool(count)
    cases: dict[str, Callable[[], object]] = {}
    for name, vector in vectors.items():
        stack.callback(vector.close)
        vector.reset(seed=1)
        cases[name] = partial(vector.step, np.zeros((count, 1), np.float32))
    return side_by_side(f"{count} carts", cases, rounds=max(2, effort.rounds * 3), calls=effort.count(400))


def _envpool(count: int) -> Any:
    """Return EnvPool's inverted pendulums, with as many threads as there are cores."""
    return importlib.import_module("envpool").make(
        "InvertedPendulum-v4", env_type="gymnasium", num_envs=count, num_threads=CORES
    )


def _arms(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    physics = Physics(stack, scene="reach")
    cases: dict[str, Callable[[], object]] = {}
    for threads in dict.fromkeys((1, CORES)):
        vector: Any = gymnasium.make_vec("simx/Reach-v0", ARMS, threads=threads)
        stack.callback(vector.close)
        vector.reset(seed=1)
        action = np.zeros(vector.action_space.shape, np.float32)
        cases[arms("simx/Reach-v0", threads)] = partial(vector.step, action)
        cases[arms("rollout", threads)] = stack.enter_context(_rollout(physics, threads))
        cases[arms("batch", threads)] = _batch(physics, threads)
    return side_by_side("arms", cases, rounds=max(2, effort.rounds * 3), calls=effort.count(20))


@contextmanager
def _rollout(physics: Physics, threads: int) -> Generator[Callable[[], object]]:
    model, data = physics.model, physics.data
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, state, full)
    states, controls = np.tile(state, (ARMS, 1)), np.tile(data.ctrl, (ARMS, physics.substeps, 1))
    each = [mujoco.MjData(model) for _ in range(threads)]
    with Rollout(nthread=threads if threads > 1 else 0) as rollout:

        def step() -> None:
            nonlocal states
            found, _ = rollout.rollout([model] * ARMS, each, states, controls, nstep=physics.substeps)
            states = np.ascontiguousarray(np.asarray(found)[:, -1])

        yield step


def _batch(physics: Physics, threads: int) -> Callable[[], object]:
    """Return a step of `mujoco.batch`; bodies of the scene may sleep, which it does with data of each world only."""
    batch = Batch(physics.model, ARMS, threads, persistent=True)
    whole = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.zeros(mujoco.mj_stateSize(physics.model, whole))
    mujoco.mj_getState(physics.model, physics.data, state, whole)
    batch.state[:] = state
    positions, controls = batch.bind("qpos"), batch.bind("ctrl")

    def step() -> object:
        controls[:] = physics.data.ctrl
        batch.step(nstep=physics.substeps)
        return positions.copy()

    return step
