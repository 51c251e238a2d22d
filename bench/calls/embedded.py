"""Embedded simulations: calls and stepped loops in one process, beside bare MuJoCo and, if installed, PyBullet."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

import simx_client as vrep
from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Rival, Row
from bench.world.physics import Physics
from simx_client.client import Client

from .client import JOINTS, check, handle_of
from .pybullet_arm import direct, is_installed, shared_memory

READ, SET = "embedded: blocking read", "embedded: blocking set"
RESET = "embedded: stop and start"
PYBULLET, PYBULLET_LOOP = "PyBullet DIRECT: read of a joint", "PyBullet DIRECT: stepped loop of 4.2 ms"
SHARED_LOOP = "PyBullet shared memory: stepped loop of 4.2 ms"
STEPS_S = (0.05, 0.001)
"""Simulation steps in seconds."""

SHARES = {0.05: 0.88, 0.001: 0.45}
"""Of the rate of bare mj_step, the stepped loop is to keep this share."""

READS = 1.0
"""Reads of PyBullet that an embedded read may cost."""

RESETS = 2.5
"""Times the bare mj_step of 50 ms that a reset may take: 1 ms where these take 0.4 ms."""


def measure(effort: Effort) -> Findings:
    """The tutorial's scene in this process."""
    taken = repeated(max(1, effort.sets // 3), partial(_one_set, effort))
    found = Findings("Embedded simulations", topic="Embedded simulations")
    for seconds, share in SHARES.items():
        found.ratios.append(
            Ratio(
                f"{_loop_of(seconds)} / {_bare_of(seconds)}",
                ratio(taken[_loop_of(seconds)], taken[_bare_of(seconds)]),
                target=1 / share,
            )
        )
    found.ratios.append(
        Ratio(f"{RESET} / {_bare_of(0.05)}", ratio(taken[RESET], taken[_bare_of(0.05)]), target=RESETS)
    )
    loops = {"simx, embedded, 1 ms": taken[_loop_of(0.001)], "MuJoCo alone, 1 ms": taken[_bare_of(0.001)]}
    if PYBULLET in taken:
        found.ratios.append(Ratio(f"{READ} / {PYBULLET}", ratio(taken[READ], taken[PYBULLET]), target=READS))
        loops |= {
            "PyBullet DIRECT, 4.2 ms": taken[PYBULLET_LOOP],
            "PyBullet shared memory, 4.2 ms": taken[SHARED_LOOP],
        }
    else:
        found.notes.append("PyBullet is not installed here, so its aim is missing.")
    found.rivals.append(
        Rival("stepped loop, one physics step, us", {name: each.median * 1e6 for name, each in loops.items()})
    )
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes.append(
        "The loop: 6 streamed reads, 6 oneshot targets, a trigger. The reset starts the gripper's Lua script anew; "
        "making its state takes most of that time. PyBullet's arm has no gripper, camera, sensor or script."
    )
    return found


def _loop_of(seconds: float) -> str:
    return f"embedded: stepped loop of {seconds * 1000:g} ms"


def _bare_of(seconds: float) -> str:
    return f"mj_step for {seconds * 1000:g} ms"


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    cases: dict[str, Callable[[], object]] = {}
    for seconds in STEPS_S:
        client, handles = world(stack, seconds)
        cases[_loop_of(seconds)] = partial(control_loop, client, handles)
        cases[_bare_of(seconds)] = Physics(stack, seconds).step
    stopped, handles = world(stack, 0.05, is_running=False)
    cases[READ] = partial(vrep.simxGetJointPosition, stopped, handles[0], vrep.simx_opmode_blocking)
    cases[SET] = partial(vrep.simxSetJointTargetPosition, stopped, handles[0], 0.0, vrep.simx_opmode_blocking)
    cases[RESET] = partial(reset, stopped)
    if is_installed():
        arm = direct(stack)
        cases[PYBULLET], cases[PYBULLET_LOOP] = arm.read, arm.loop
    rounds, calls = 2 * effort.rounds, effort.count(200)
    taken = side_by_side("embedded", cases, rounds=rounds, calls=calls)
    if is_installed():  # alone, since its server never sleeps
        shared = {SHARED_LOOP: shared_memory(stack).loop}
        taken |= side_by_side("embedded", shared, rounds=rounds, calls=calls)
    return taken


def world(stack: ExitStack, seconds: float, *, is_running: bool = True) -> tuple[int, list[int]]:
    """Return a client of an embedded simulation of the tutorial's scene, and the handles of the arm's joints."""
    client = stack.enter_context(Client.embedded("ur5_rg2_kinect", time_step=seconds)).id
    handles = [handle_of(client, name) for name in JOINTS]
    if is_running:
        for handle in handles:
            vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
        check(vrep.simxSynchronous(client, True))
        check(vrep.simxStartSimulation(client, vrep.simx_opmode_blocking))
    return client, handles


def control_loop(client: int, handles: list[int]) -> None:
    """One turn of the usual control loop."""
    for handle in handles:
        check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer))
    for handle in handles:
        vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot)
    check(vrep.simxSynchronousTrigger(client))


def reset(client: int) -> None:
    """Stop the simulation and start it anew, step by step."""
    check(vrep.simxStopSimulation(client, vrep.simx_opmode_blocking))
    check(vrep.simxSynchronous(client, True))
    check(vrep.simxStartSimulation(client, vrep.simx_opmode_blocking))
