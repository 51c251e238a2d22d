"""How long until something can be done: the server's start, the client's import, the connection."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

import simx_client as vrep
from bench.calls.client import JOINTS, check, connected, handle_of
from bench.measuring import processes
from bench.measuring.measure import Effort, in_turn, ratio
from bench.measuring.report import Findings, Ratio, Row

SERVER = "server, from spawning it to its ready line"
LIBRARIES = "Python that imports mujoco, numpy and zenoh"
CLIENT = "import simx_client"
ZENOH = "import zenoh"
CONNECT = "simxStart, in a process that had a connection before"
PYTHON = "Python that does nothing"
WORST = "slowest blocking read in the first second after the ready line"

FIRST_S = 1.0

_TIMED_IMPORT = "import time; began = time.perf_counter(); import {}; print(time.perf_counter() - began)"


def measure(effort: Effort) -> Findings:
    """Each in processes of its own, in turn; files are in the system's cache from the second on."""
    with ExitStack() as stack:
        port = stack.enter_context(processes.server()).port
        cases: dict[str, Callable[[], float]] = {
            SERVER: _server_start,
            LIBRARIES: lambda: _whole_process("import mujoco, numpy, zenoh"),
            PYTHON: lambda: _whole_process("pass"),
            CLIENT: lambda: processes.figure_of(_TIMED_IMPORT.format("simx_client")),
            ZENOH: lambda: processes.figure_of(_TIMED_IMPORT.format("zenoh")),
            CONNECT: lambda: _connect(port),
            WORST: _worst_at_first,
        }
        taken = in_turn(
            "start-up",
            {name: lambda case=case: (case(),) for name, case in cases.items()},
            effort.count(7),
        )
    found = Findings("Start-up")
    found.rows = [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    found.ratios = [Ratio("server start / importing its libraries", ratio(taken[SERVER], taken[LIBRARIES]))]
    return found


def _server_start() -> float:
    with processes.server() as running:
        return running.started_in


def _whole_process(code: str) -> float:
    began = time.perf_counter()
    processes.figure_of(f"{code}; print(0)")
    return time.perf_counter() - began


def _connect(port: int) -> float:
    began = time.perf_counter()
    with connected(port):
        return time.perf_counter() - began


def _worst_at_first() -> float:
    """The server makes its renderer meanwhile; this tells how much of that a client feels."""
    with processes.server() as server, connected(server.port) as client:
        handle, worst, end = handle_of(client, JOINTS[0]), 0.0, time.perf_counter() + FIRST_S
        while (began := time.perf_counter()) < end:
            check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking))
            worst = max(worst, time.perf_counter() - began)
        return worst
