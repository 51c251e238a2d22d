"""Start and memory: the server's start, the client's import, the connection, and what an idle server holds."""

from __future__ import annotations

import compileall
import time
from collections.abc import Callable
from contextlib import ExitStack

import simx_client as vrep
from bench.calls.client import JOINTS, check, connected, handle_of
from bench.measuring import processes
from bench.measuring.measure import Effort, difference, in_turn, ratio
from bench.measuring.processes import ROOT
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import memory_mb

SERVER = "server, from spawning it to its ready line"
LIBRARIES = "Python that imports mujoco, numpy and zenoh"
CLIENT = "Python that imports simx_client"
FIRST_CALL = "Python that imports simx_client and calls one of its functions, which makes all"
ZENOH = "import zenoh"
CONNECT = "simxStart, in a process that had a connection before"
PYTHON = "Python that does nothing"
WORST = "slowest blocking read in the first second after the ready line"

FIRST_S = 1.0

START_MOST = 1.35
"""Times the import of its libraries: 0.35 s where these take 0.26 s."""

IMPORT_MOST = 4.0
"""Times the start of Python: 60 ms where that takes 15 ms."""

IMPORT_MB, SERVER_MB = 12.0, 90.0
"""Private memory that an import adds, and proportional memory of a server of the tutorial's scene."""

SETTLES_S = 1.0
"""Seconds after which a server has given back what its start left unused."""

_TIMED_IMPORT = "import time; began = time.perf_counter(); import {}; print(time.perf_counter() - began)"


def measure(effort: Effort) -> Findings:
    """Each in separate processes, in turn; files are in the system's cache from the second on."""
    for package in (
        "simx_client",
        "simx_server",
    ):  # as after an installation, also where Python writes no bytecode
        compileall.compile_dir(ROOT / package, quiet=2)
    with ExitStack() as stack:
        port = stack.enter_context(processes.server()).port
        cases: dict[str, Callable[[], float]] = {
            SERVER: _server_start,
            LIBRARIES: lambda: _whole_process("import mujoco, numpy, zenoh"),
            PYTHON: lambda: _whole_process("pass"),
            CLIENT: lambda: _whole_process("import simx_client"),
            FIRST_CALL: lambda: _whole_process("import simx_client; simx_client.simxFinish(-1)"),
            ZENOH: lambda: processes.figure_of(_TIMED_IMPORT.format("zenoh")),
            CONNECT: lambda: _connect(port),
            WORST: _worst_at_first,
        }
        taken = in_turn(
            "start-up",
            {name: lambda case=case: (case(),) for name, case in cases.items()},
            effort.count(7),
        )
    found = Findings("Start-up", topic="Start and memory")
    memory, memory_later = _memory_of_server()
    found.rows = [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    found.rows.append(
        Row("memory of a server that has had a client, with its renderer", memory_later, None, "MB")
    )
    own = difference(taken[CLIENT], taken[PYTHON])
    found.ratios = [
        Ratio(
            "server start / importing its libraries",
            ratio(taken[SERVER], taken[LIBRARIES]),
            target=START_MOST,
        ),
        Ratio("import simx_client / starting Python", ratio(own, taken[PYTHON]), target=IMPORT_MOST),
        Ratio("memory of import simx_client", _memory_of_import(), "MB", IMPORT_MB),
        Ratio("memory of an idle server", memory, "MB", SERVER_MB),
    ]
    return found


def _memory_of_import() -> float:
    """Return the private memory in MB that the import adds to Python."""
    code = (
        "import os, sys; sys.path.insert(0, os.getcwd())\n{}\n"
        "from bench.measuring.resources import private_mb; print(private_mb(os.getpid()))"
    )
    with_it, without = (processes.figure_of(code.format(line)) for line in ("import simx_client", "pass"))
    return with_it - without


def _memory_of_server() -> tuple[float, float]:
    """Return the memory of a server in MB, before its first client and after it."""
    with processes.server() as server:
        time.sleep(SETTLES_S)
        before = memory_mb([server.process_id])
        with connected(server.port) as client:
            check(vrep.simxGetPingTime(client))
        time.sleep(SETTLES_S)
        return before, memory_mb([server.process_id])


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
