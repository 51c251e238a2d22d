"""Embedded simulations: calls and stepped loops in one process, beside bare MuJoCo and, if installed, PyBullet."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

import simx_client as vrep
from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.world.physics import Physics
from simx_client.client import Client

from .client import JOINTS, check, handle_of

READ, SET = "embedded: blocking read", "embedded: blocking set"
RESET = "embedded: stop and start"
PYBULLET = "PyBullet DIRECT: read of a joint"
STEPS_S = (0.05, 0.001)
"""Simulation steps in seconds."""

SHARES = {0.05: 0.75, 0.001: 0.25}
"""Of the rate of bare mj_step, the stepped loop is to keep this share."""

READS = 3.0
"""Reads of PyBullet that an embedded read may cost."""


def measure(effort: Effort) -> Findings:
    """The tutorial's scene in this process."""
    taken = repeated(1, partial(_one_set, effort))
    found = Findings("Embedded simulations")
    for seconds, share in SHARES.items():
        found.ratios.append(
            Ratio(
                f"{_loop_of(seconds)} / {_bare_of(seconds)}",
                ratio(taken[_loop_of(seconds)], taken[_bare_of(seconds)]),
                target=1 / share,
            )
        )
    if PYBULLET in taken:
        found.ratios.append(Ratio(f"{READ} / {PYBULLET}", ratio(taken[READ], taken[PYBULLET]), target=READS))
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes = [
        "The loop: 6 streamed reads, 6 oneshot targets, a trigger. The reset starts the gripper's Lua script anew; "
        "making its state takes most of that time."
    ]
    return found


def _loop_of(seconds: float) -> str:
    return f"embedded: stepped loop of {seconds * 1000:g} ms"


def _bare_of(seconds: float) -> str:
    return f"mj_step for {seconds * 1000:g} ms"


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    cases: dict[str, Callable[[], object]] = {}
    for seconds in STEPS_S:
        client, handles = _world(stack, seconds)
        cases[_loop_of(seconds)] = partial(_loop, client, handles)
        cases[_bare_of(seconds)] = Physics(stack, seconds).step
    stopped, handles = _world(stack, 0.05, is_running=False)
    read = partial(vrep.simxGetJointPosition, stopped, handles[0], vrep.simx_opmode_blocking)
    change = partial(vrep.simxSetJointTargetPosition, stopped, handles[0], 0.0, vrep.simx_opmode_blocking)
    cases[READ] = read
    cases[SET] = change
    cases[RESET] = partial(_reset, stopped)
    if importlib.util.find_spec("pybullet") is not None:
        cases[PYBULLET] = _pybullet(stack)
    return side_by_side("embedded", cases, rounds=effort.rounds, calls=effort.count(300))


def _world(stack: ExitStack, seconds: float, *, is_running: bool = True) -> tuple[int, list[int]]:
    client = stack.enter_context(Client.embedded("ur5_rg2_kinect", time_step=seconds)).id
    handles = [handle_of(client, name) for name in JOINTS]
    if is_running:
        for handle in handles:
            vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
        check(vrep.simxSynchronous(client, True))
        check(vrep.simxStartSimulation(client, vrep.simx_opmode_blocking))
    return client, handles


def _loop(client: int, handles: list[int]) -> None:
    """One turn of the usual control loop."""
    for handle in handles:
        check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer))
    for handle in handles:
        vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot)
    check(vrep.simxSynchronousTrigger(client))


def _reset(client: int) -> None:
    check(vrep.simxStopSimulation(client, vrep.simx_opmode_blocking))
    check(vrep.simxSynchronous(client, True))
    check(vrep.simxStartSimulation(client, vrep.simx_opmode_blocking))


def _pybullet(stack: ExitStack) -> Callable[[], object]:
    """Return a read of a joint of PyBullet's KUKA arm, in this process."""
    bullet, data = importlib.import_module("pybullet"), importlib.import_module("pybullet_data")
    world = bullet.connect(bullet.DIRECT)
    stack.callback(bullet.disconnect, world)
    robot = bullet.loadURDF(f"{data.getDataPath()}/kuka_iiwa/model.urdf", physicsClientId=world)
    return partial(bullet.getJointState, robot, 1, physicsClientId=world)
