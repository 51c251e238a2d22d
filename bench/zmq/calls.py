"""A call of the official client, beside the same client and call at an empty server of the same protocol."""

from __future__ import annotations

import importlib.util
import os
import socket
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any

from bench.calls.client import CAMERA
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import on_one_core, processor_seconds

SCENE = "ur5_rg2_kinect"
CALL, RUNNING, STUB = "a call", "a call while the simulation runs", "the same call at an empty server"
STEP = "sim.step in stepped mode"
ON_ONE_CORE = "{}, all on one core"
PROCESSOR = "processor time of the server: {}"
TARGET = 1.2
"""Times the call at the empty server."""


def measure(effort: Effort) -> Findings:
    """Measure a call that reads a position, and a step of the tutorial's scene."""
    found = Findings("Calls of a client of the ZeroMQ remote API", topic="Calls")
    if importlib.util.find_spec("coppeliasim_zmqremoteapi_client") is None:
        found.notes.append("The official ZeroMQ client is not installed here, so nothing was measured.")
        return found
    taken = repeated((effort.sets + 1) // 2, partial(_one_set, effort))
    for call in (CALL, RUNNING):
        found.ratios.append(Ratio(f"{call} / {STUB}", ratio(taken[call], taken[STUB]), target=TARGET))
    found.ratios.append(Ratio(f"{CALL} / {STUB}, p99", ratio_p99(taken[CALL], taken[STUB])))
    alone, empty = ON_ONE_CORE.format(CALL), ON_ONE_CORE.format(STUB)
    found.ratios.append(Ratio(f"{alone} / {empty}", ratio(taken[alone], taken[empty]), target=TARGET))
    found.rows += [Row.of(name, rounds, "us") for name, rounds in taken.items()]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    stub = stack.enter_context(processes.server(command=(sys.executable, "-m", "bench.zmq.stub")))
    server, sim = _server(stack)
    _, running = _server(stack)
    empty = _sim(stub.port)
    camera = sim.getObject(f"/{CAMERA}")
    running.startSimulation()
    cases: dict[str, Callable[[], Any]] = {
        CALL: lambda: sim.getObjectPosition(camera, -1),
        RUNNING: lambda: running.getObjectPosition(camera, -1),
        STUB: lambda: empty.getObjectPosition(camera, -1),
    }
    calls = effort.count(1000)
    taken = side_by_side("zmq, calls", cases, rounds=effort.rounds, calls=calls)
    running.stopSimulation()
    for name, owner in ((CALL, server), (STUB, stub)):
        taken[PROCESSOR.format(name)] = Rounds(((_processor_time(owner.process_id, cases[name], calls),),))
    with on_one_core(os.getpid(), server.process_id, stub.process_id):
        both = {name: cases[name] for name in (CALL, STUB)}
        alone = side_by_side("zmq, calls on one core", both, rounds=effort.rounds, calls=calls)
    taken |= {ON_ONE_CORE.format(name): rounds for name, rounds in alone.items()}
    _, fast = _server(stack, "--speed", "max")
    fast.setStepping(True)
    fast.startSimulation()
    stack.callback(fast.stopSimulation)
    return taken | side_by_side(
        "zmq, steps", {STEP: fast.step}, rounds=effort.rounds, calls=effort.count(100)
    )


def _processor_time(process_id: int, case: Callable[[], Any], calls: int) -> float:
    """Return the seconds that a process works for a call."""
    before = processor_seconds([process_id])
    for _ in range(calls):
        case()
    return (processor_seconds([process_id]) - before) / calls


def _server(stack: ExitStack, *arguments: str) -> tuple[processes.Running, Any]:
    """Start a server; return it, and sim of a client."""
    port = _free_port()
    return stack.enter_context(processes.server(SCENE, *arguments, "--zmq", str(port))), _sim(port)


def _sim(port: int) -> Any:
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    return RemoteAPIClient(port=port).getObject("sim")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
