"""PyBullet's KUKA arm, in this process and behind shared memory: the rival without a network.

``python -m bench.calls.pybullet_arm KEY`` is the far end of the shared memory; it leaves when its standard input ends.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any

from bench.measuring.processes import ROOT, NotReady

ARM = range(6)
"""The joints that a loop reads and sets."""

_STEP = 1 / 240
"""PyBullet's usual physics step in seconds."""


def is_installed() -> bool:
    """Return whether PyBullet can be imported."""
    return importlib.util.find_spec("pybullet") is not None


@dataclass(frozen=True)
class Arm:
    """An arm that can be reached."""

    read: Callable[[], object]
    """Read one joint."""

    loop: Callable[[], object]
    """Read six joints, set six, make one physics step."""

    process_id: int


def direct(stack: ExitStack) -> Arm:
    """Load an arm in this process; gone when the stack is closed."""
    bullet = importlib.import_module("pybullet")
    return _arm(stack, bullet, bullet.connect(bullet.DIRECT), os.getpid())


def shared_memory(stack: ExitStack) -> Arm:
    """Load an arm in a separate process. Raises NotReady."""
    bullet = importlib.import_module("pybullet")
    key = os.getpid()
    process = stack.enter_context(
        subprocess.Popen(
            [sys.executable, "-m", "bench.calls.pybullet_arm", str(key)],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
    )
    stack.callback(process.kill)
    assert process.stdout is not None
    if not any(line.startswith("ready") for line in process.stdout):
        raise NotReady("PyBullet's server ended instead of getting ready")
    world = bullet.connect(bullet.SHARED_MEMORY, key=key)
    if world < 0:
        raise NotReady("PyBullet's server did not accept a client")
    return _arm(stack, bullet, world, process.pid)


def _arm(stack: ExitStack, bullet: Any, world: int, process_id: int) -> Arm:
    stack.callback(bullet.disconnect, world)
    data = importlib.import_module("pybullet_data")
    robot = bullet.loadURDF(f"{data.getDataPath()}/kuka_iiwa/model.urdf", physicsClientId=world)
    bullet.setTimeStep(_STEP, physicsClientId=world)

    def loop() -> None:
        for joint in ARM:
            bullet.getJointState(robot, joint, physicsClientId=world)
        for joint in ARM:
            bullet.setJointMotorControl2(
                robot, joint, bullet.POSITION_CONTROL, targetPosition=0.0, physicsClientId=world
            )
        bullet.stepSimulation(physicsClientId=world)

    return Arm(partial(bullet.getJointState, robot, 1, physicsClientId=world), loop, process_id)


def main() -> None:
    """Serve until standard input ends."""
    bullet = importlib.import_module("pybullet")
    bullet.connect(bullet.SHARED_MEMORY_SERVER, key=int(sys.argv[1]))
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    sys.stdin.read()


if __name__ == "__main__":
    main()
