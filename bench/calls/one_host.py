"""Client and server on one host beside the rivals: the official ZeroMQ client, PyBullet, bare sockets, bare Zenoh.

The ZeroMQ client calls an empty server, which answers at once. Reads are measured on idle cores, beside other programs
that take all cores, and with all processes on one core. Rivals that are not installed are left out.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

import simx_client as vrep
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, repeated, side_by_side
from bench.measuring.paces import BUSY, IDLE, ONE_CORE, endless_loops
from bench.measuring.report import Findings, Ratio, Rival, Row
from bench.measuring.resources import context_switches, on_one_core
from simx_client.client import Client

from .blocking import message_sizes
from .client import JOINTS, check, connected, handle_of, over_zenoh, settle
from .pybullet_arm import direct, is_installed, shared_memory

TARGET = 0.8
"""Times the call of the ZeroMQ client at an empty server, median and 99th percentile."""

MOST_SWITCHES = 4.0
"""Context switches of both processes for a read."""

PAUSE = 0.002
"""Seconds between calls that find both processes asleep."""

EMBEDDED, LOCAL, ZENOH = "simx, embedded", "simx, one host", "simx, over Zenoh"
ZMQ, DIRECT, SHARED = "ZeroMQ client, empty server", "PyBullet DIRECT", "PyBullet shared memory"
TCP, QUERY = "bare TCP echo", "bare Zenoh query"
CASES = (EMBEDDED, LOCAL, ZENOH, ZMQ, DIRECT, SHARED, TCP, QUERY)


def measure(effort: Effort) -> Findings:
    """Reads in three states of the machine."""
    found = Findings("Client and server on one host", topic="Calls")
    taken = repeated(max(1, effort.sets * 2 // 3), partial(_one_set, effort))
    for state in (IDLE, BUSY, ONE_CORE):
        local, zenoh = (taken[f"{case}, {state}"] for case in (LOCAL, ZENOH))
        if zmq := taken.get(f"{ZMQ}, {state}"):
            found.ratios += [
                Ratio(f"read on one host / {ZMQ}, {state}", ratio(local, zmq), target=TARGET),
                Ratio(
                    f"read on one host / {ZMQ}, 99th percentiles, {state}",
                    ratio_p99(local, zmq),
                    target=TARGET,
                ),
            ]
        found.ratios.append(Ratio(f"read on one host / read over Zenoh, {state}", ratio(local, zenoh)))
        figures = {
            case: taken[f"{case}, {state}"].median * 1e6 for case in CASES if f"{case}, {state}" in taken
        }
        found.rivals.append(Rival(f"blocking read, us, {state}", figures))
    for case in (LOCAL, ZENOH):
        switches = taken.pop(f"switches, {case}").median
        bound = MOST_SWITCHES if case is LOCAL else None
        found.ratios.append(
            Ratio(f"context switches of both processes, {case}", switches, unit="", target=bound)
        )
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.notes = [
        f"Context switches are counted for reads {PAUSE * 1000:g} ms apart, so that both processes sleep in between; "
        "reads in a row need fewer. Busy means as many endless loops as cores, on equal terms.",
        *_missing(),
    ]
    return found


def _missing() -> list[str]:
    """Return a note for each rival that is not installed."""
    notes: list[str] = []
    if not _has_zmq_client():
        notes.append("The official ZeroMQ client is not installed here, so its aims are missing.")
    if not is_installed():
        notes.append("PyBullet is not installed here, so its figures are missing.")
    return notes


def _has_zmq_client() -> bool:
    return importlib.util.find_spec("coppeliasim_zmqremoteapi_client") is not None


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    server = stack.enter_context(processes.server())
    local = stack.enter_context(connected(server.port))
    with over_zenoh():
        zenoh = stack.enter_context(connected(server.port, "localhost"))
    settle(local)
    joint = handle_of(local, JOINTS[0])
    embedded = stack.enter_context(Client.embedded("ur5_rg2_kinect")).id
    request = baselines.request_of(*message_sizes(joint))
    tcp = stack.enter_context(processes.baseline(baselines.TCP))
    query = stack.enter_context(processes.baseline(baselines.QUERY))
    ends = [os.getpid(), server.process_id, tcp.process_id, query.process_id]
    echo = stack.enter_context(closing(baselines.Tcp(tcp.port)))
    asked = stack.enter_context(closing(baselines.Query(query.port)))
    cases: dict[str, Callable[[], Any]] = {
        EMBEDDED: partial(_read, embedded, handle_of(embedded, JOINTS[0])),
        LOCAL: partial(_read, local, joint),
        ZENOH: partial(_read, zenoh, joint),
        TCP: partial(echo.exchange, request),
        QUERY: partial(asked.exchange, request),
    }
    if _has_zmq_client():
        from coppeliasim_zmqremoteapi_client import RemoteAPIClient

        stub = stack.enter_context(processes.server(command=(sys.executable, "-m", "bench.zmq.stub")))
        sim: Any = RemoteAPIClient(port=stub.port).getObject("sim")
        cases[ZMQ] = lambda: sim.getObjectPosition(joint, -1)
        ends.append(stub.process_id)
    if is_installed():
        cases[DIRECT] = direct(stack).read

    def take(state: str) -> dict[str, Rounds]:
        taken = side_by_side(f"one host, {state}", cases, rounds=effort.rounds, calls=effort.count(500))
        return {f"{what}, {state}": rounds for what, rounds in taken.items()}

    taken = take(IDLE)
    for case in (LOCAL, ZENOH):
        switches = _switches(cases[case], effort.count(200), (os.getpid(), server.process_id))
        taken[f"switches, {case}"] = Rounds(((switches,),))
    with endless_loops():
        taken |= take(BUSY)
    with on_one_core(*ends):
        taken |= take(ONE_CORE)
    if is_installed():  # alone, since its server never sleeps
        shared = {f"{SHARED}, {IDLE}": shared_memory(stack).read}
        taken |= side_by_side("one host", shared, rounds=effort.rounds, calls=effort.count(500))
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
