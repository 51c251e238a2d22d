"""A simulation step of an arm with six joints, alone, as a ROS 2 node, and with a listener of all its topics."""

from __future__ import annotations

import sys
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, difference, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_server.app.server import open_world
from simx_server.app.serving import make_service
from simx_server.gateways.ros2.gateway import Ros2Gateway, Ros2Options
from simx_server.gateways.ros2.wire.session import Router
from simx_server.settings.settings import Settings
from simx_server.world.world import World

JOINTS = 6
STEP = "a simulation step of six joints"
SILENT = "the same as a node of ROS 2 without listeners"
HEARD = "the same with a listener of clock, joint states and tf"
LISTENER, NODE = "the listener beyond the step", "the node without listeners beyond the step"
TARGET_US = 100.0
"""Microseconds that six joints, tf and clock may take of the physics thread in each simulation step."""


def measure(effort: Effort) -> Findings:
    """Measure in one process, so that nothing but the node is between the cases."""
    found = Findings("A node of ROS 2")
    taken = repeated(effort.sets, partial(_one_set, effort))
    listener, node = difference(taken[HEARD], taken[STEP]), difference(taken[SILENT], taken[STEP])
    found.ratios = [
        Ratio(
            "six joints, tf and clock for a listener, each simulation step",
            listener.median * 1e6,
            "us",
            TARGET_US,
        ),
        Ratio("the same topics without a listener", node.median * 1e6, "us"),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.rows += [Row.of(LISTENER, listener, "us"), Row.of(NODE, node, "us")]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    worlds = {STEP: _world(stack), SILENT: _world(stack), HEARD: heard(stack)}
    _node(worlds[SILENT], Router("tcp/127.0.0.1:0", is_self=True), stack)
    return side_by_side(
        "ros2, steps",
        {name: world.step for name, world in worlds.items()},
        rounds=effort.rounds,
        calls=effort.count(1000, 50),
    )


def heard(stack: ExitStack) -> World:
    """Open a world with a node of ROS 2 that a router beside it listens to."""
    listener = stack.enter_context(processes.server(command=(sys.executable, "-m", "bench.ros2.listener")))
    world = _world(stack)
    node = _node(world, Router(f"tcp/127.0.0.1:{listener.port}"), stack)
    until = time.monotonic() + processes.READY_WITHIN_S
    while not node.has_listeners:
        if time.monotonic() > until:
            raise processes.NotReady("the listener is not seen")
        time.sleep(0.01)
    return world


def _world(stack: ExitStack) -> World:
    scene = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "arm.xml"
    scene.write_text(_arm(), encoding="utf-8")
    world = open_world(Settings(scene=str(scene)), stack)
    world.simulation.start()
    stack.callback(world.simulation.stop)
    return world


def _node(world: World, router: Router, stack: ExitStack) -> Ros2Gateway:
    gateway = Ros2Gateway(make_service(world, Settings()), Ros2Options(router=router))
    stack.callback(gateway.close)
    return gateway


def _arm() -> str:
    links, motors = "", ""
    for number in range(JOINTS, 0, -1):
        links = (
            f'<body name="link{number}" pos="0 0 0.2"><joint name="joint{number}" axis="0 1 0"/>'
            f'<geom type="capsule" fromto="0 0 0 0 0 0.2" size="0.02" contype="0" conaffinity="0"/>{links}</body>'
        )
        motors += f'<position name="joint{number}" joint="joint{number}" kp="1000" kv="50"/>'
    return f"<mujoco><worldbody>{links}</worldbody><actuator>{motors}</actuator></mujoco>"
