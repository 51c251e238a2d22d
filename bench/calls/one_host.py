"""Client and server on one host: a read by the local way and over Zenoh, beside the official ZeroMQ client.

The ZeroMQ client calls an empty server, which answers at once. It is measured on idle cores, beside other programs
that take all cores, and with all three processes on one core.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any

import simx_client as vrep
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import context_switches, on_one_core
from simx_client.transport.local import VARIABLE

from .client import JOINTS, check, connected, handle_of, settle

TARGET = 0.9
"""Times the call of the ZeroMQ client at an empty server, median and 99th percentile."""

MOST_SWITCHES = 4.0
"""Context switches of both processes for a read."""

PAUSE = 0.002
"""Seconds between calls that find both processes asleep."""

LOCAL, ZENOH = "simxGetJointPosition, blocking, local way", "the same over Zenoh"
ZMQ = "sim.getJointPosition of the ZeroMQ client at an empty server"
IDLE, BUSY, ONE_CORE = "idle", "all cores busy", "all on one core"


def measure(effort: Effort) -> Findings:
    """Reads in three states of the machine."""
    found = Findings("Client and server on one host")
    taken = repeated(effort.sets, partial(_one_set, effort))
    for state in (IDLE, BUSY, ONE_CORE):
        local, zenoh, zmq = (taken[f"{case}, {state}"] for case in (LOCAL, ZENOH, ZMQ))
        found.ratios += [
            Ratio(
                f"local read / ZeroMQ client at an empty server, {state}", ratio(local, zmq), target=TARGET
            ),
            Ratio(f"the same, 99th percentiles, {state}", ratio_p99(local, zmq), target=TARGET),
            Ratio(f"local read / read over Zenoh, {state}", ratio(local, zenoh)),
        ]
    for case in (LOCAL, ZENOH):
        switches = taken.pop(f"switches, {case}").median
        bound = MOST_SWITCHES if case is LOCAL else None
        found.ratios.append(
            Ratio(f"context switches of both processes, {case}", switches, unit="", target=bound)
        )
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes = [
        f"Context switches are counted for reads {PAUSE * 1000:g} ms apart, so that both processes sleep in between; "
        "reads in a row need fewer. Busy means as many endless loops as cores, on equal terms."
    ]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    from coppeliasim_zmqremoteapi_client import RemoteAPIClient

    server = stack.enter_context(processes.server())
    local = stack.enter_context(connected(server.port))
    with _without_local_way():
        zenoh = stack.enter_context(connected(server.port, "localhost"))
    settle(local)
    joint = handle_of(local, JOINTS[0])
    stub = stack.enter_context(processes.server(command=(sys.executable, "-m", "bench.zmq.stub")))
    sim: Any = RemoteAPIClient(port=stub.port).getObject("sim")
    cases: dict[str, Callable[[], Any]] = {
        LOCAL: partial(_read, local, joint),
        ZENOH: partial(_read, zenoh, joint),
        ZMQ: lambda: sim.getObjectPosition(joint, -1),
    }

    def take(state: str) -> dict[str, Rounds]:
        taken = side_by_side(f"one host, {state}", cases, rounds=effort.rounds, calls=effort.count(1000))
        return {f"{what}, {state}": rounds for what, rounds in taken.items()}

    taken = take(IDLE)
    ends = (os.getpid(), server.process_id)
    for case in (LOCAL, ZENOH):
        switches = _switches(cases[case], effort.count(200), ends)
        taken[f"switches, {case}"] = Rounds(((switches,),))
    with _endless_loops():
        taken |= take(BUSY)
    with on_one_core(*ends, stub.process_id):
        taken |= take(ONE_CORE)
    return taken


def _read(client: int, joint: int) -> None:
    check(vrep.simxGetJointPosition(client, joint, vrep.simx_opmode_blocking))


def _switches(case: Callable[[], object], calls: int, ends: tuple[int, int]) -> float:
    """Return the context switches of a call between sleeping processes, without those of the sleep itself."""

    def counted(call: Callable[[], object]) -> int:
        before = context_switches(ends)
        for _ in range(calls):
            time.sleep(PAUSE)
            call()
        return context_switches(ends) - before

    return max(0, counted(case) - counted(lambda: None)) / calls


@contextmanager
def _without_local_way() -> Generator[None]:
    """Have clients that connect within the block use Zenoh alone."""
    os.environ[VARIABLE] = "0"
    try:
        yield
    finally:
        del os.environ[VARIABLE]


@contextmanager
def _endless_loops() -> Generator[None]:
    """Keep all cores busy within the block."""
    with ExitStack() as stack:
        for _ in range(os.cpu_count() or 1):
            loop = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(loop.wait)
            stack.callback(loop.kill)
        yield
