"""A call of the official client, beside the same client and call at an empty server of the same protocol."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any

from bench.calls.client import CAMERA
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row

SCENE = "ur5_rg2_kinect"
CALL, STUB, STEP = "a call", "the same call at an empty server", "sim.step in stepped mode"
TARGET = 1.3
"""Times the call at the empty server."""


def measure(effort: Effort) -> Findings:
    """Measure a call that reads a position, and a step of the tutorial's scene."""
    found = Findings("Calls of a client of the ZeroMQ remote API")
    taken = repeated(effort.sets, partial(_one_set, effort))
    found.ratios.append(Ratio(f"{CALL} / {STUB}", ratio(taken[CALL], taken[STUB]), target=TARGET))
    found.rows += [Row.of(name, taken[name], "us") for name in (CALL, STUB, STEP)]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    stub = stack.enter_context(processes.server(command=(sys.executable, "-m", "bench.zmq.stub")))
    port = _free_port()
    stack.enter_context(processes.server(SCENE, "--speed", "max", "--zmq", str(port)))
    sim, empty = _sim(port), _sim(stub.port)
    camera = sim.getObject(f"/{CAMERA}")
    read: Callable[[], Any] = lambda: sim.getObjectPosition(camera, -1)  # noqa: E731
    cases = {CALL: read, STUB: lambda: empty.getObjectPosition(camera, -1)}
    taken = side_by_side("zmq, calls", cases, rounds=effort.rounds, calls=effort.count(1000))
    sim.setStepping(True)
    sim.startSimulation()
    stack.callback(sim.stopSimulation)
    steps = side_by_side("zmq, steps", {STEP: sim.step}, rounds=effort.rounds, calls=effort.count(100))
    return {**taken, **steps}


def _sim(port: int) -> Any:
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    return RemoteAPIClient(port=port).getObject("sim")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
