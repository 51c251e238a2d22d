"""Servers of one command: start, memory, processor time. And what a call through a router takes."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import simx_client as vrep
from bench.calls.client import CAMERA, JOINTS, CallFailed, check, connected, handle_of
from bench.measuring import processes
from bench.measuring.measure import Effort, in_turn, ratio, side_by_side
from bench.measuring.processes import ROOT, NotReady
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import bytes_to_port, core_share, memory_mb, private_mb, processor_seconds

MEMORY_TARGET_MB = 60
FLEET = 8
START_MOST = 2.0
"""Times the start of one server, that of eight by one command may take."""

START = "start to the ready line, {} servers"
DIRECT, ROUTED = "blocking read, directly", "blocking read, through a router"


@dataclass(frozen=True)
class Fleet:
    """Servers of one command."""

    parent: int
    process_ids: list[int]
    ports: list[int]
    started_in: float


def measure(effort: Effort) -> Findings:
    """Servers of one command, then one server with a router between."""
    found = Findings("Scale", topic="Start and memory")
    _starts(found, effort)
    _servers(found, effort)
    _router(found, effort)
    return found


@contextmanager
def fleet(count: int, *arguments: str) -> Generator[Fleet]:
    """So many servers of the tutorial's scene on free ports; ended when the block is left."""
    command = [*processes.SERVER, "--port", "0", "--count", str(count), *arguments]
    began = time.perf_counter()
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = process.stdout.readline()
            if not line:
                raise NotReady(f"{count} servers did not get ready; the log says why")
            took = time.perf_counter() - began
            servers = json.loads(line)["servers"]
            ports = [server["ports"][0] for server in servers]
            yield Fleet(process.pid, [server["pid"] for server in servers], ports, took)
        finally:
            process.terminate()


def _starts(found: Findings, effort: Effort) -> None:
    def start(count: int) -> tuple[float, ...]:
        with fleet(count) as started:
            return (started.started_in,)

    def alone() -> tuple[float, ...]:
        with processes.server() as server:
            return (server.started_in,)

    cases: dict[str, Callable[[], tuple[float, ...]]] = {START.format("1 (no --count)"): alone}
    cases |= {START.format(count): lambda count=count: start(count) for count in (1, FLEET)}
    taken = in_turn("scale, starts", cases, effort.count(5))
    found.rows += [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    first, many = taken[START.format("1 (no --count)")], taken[START.format(FLEET)]
    found.ratios.append(
        Ratio(f"start of {FLEET} servers / start of one", ratio(many, first), target=START_MOST)
    )


def _servers(found: Findings, effort: Effort) -> None:
    """Memory and processor time of one server more."""
    span = max(0.2, effort.seconds(4.0))
    with processes.server("--start", "--no-local") as server:
        with connected(server.port) as client:
            _picture(client)
        _row(found, "a server by itself, running, has made an image", memory_mb([server.process_id]), "MB")
    with fleet(1, "--start") as one:
        time.sleep(span / 4)
        base = memory_mb([one.parent, *one.process_ids])
    _row(found, "the first server of a fleet and its parent, running", base, "MB")
    with fleet(FLEET, "--start") as many:
        idle = core_share(many.process_ids, span) / FLEET
        further = statistics.median(map(private_mb, many.process_ids))
        with ExitStack() as stack:
            clients = [stack.enter_context(connected(port)) for port in many.ports]
            for client in clients:
                for joint in JOINTS:
                    vrep.simxGetJointPosition(client, handle_of(client, joint), vrep.simx_opmode_streaming)
            streaming = core_share(many.process_ids, span) / FLEET
            for client in clients:
                _picture(client)
        # Without its client, which shares the memory through which images went.
        drawn = statistics.median(map(private_mb, many.process_ids))
    found.ratios.append(Ratio("memory of a further server, running", further, "MB", MEMORY_TARGET_MB))
    found.ratios.append(
        Ratio("memory of a further server that has made an image", drawn, "MB", MEMORY_TARGET_MB)
    )
    _row(found, "a server at real time, nobody connected", idle * 100, "% core")
    _row(found, "a server at real time, one client streams 6 joints", streaming * 100, "% core")


def _picture(client: int) -> None:
    camera = handle_of(client, CAMERA)
    check(vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_blocking))


def _router(found: Findings, effort: Effort) -> None:
    calls = effort.count(400, least=20)
    command = (sys.executable, "-m", "bench.measuring.router")
    with processes.server(command=command) as router, ExitStack() as stack:
        name = ("--realm", "bench", "--connect", f"tcp/127.0.0.1:{router.port}")
        server = stack.enter_context(processes.server("--start", "--no-local", *name))
        direct = stack.enter_context(connected(server.port))
        far = vrep.simxStart("bench@127.0.0.1", router.port, True, True, 5000, 5)
        if far == -1:
            raise CallFailed("no connection through the router; the log says why")
        stack.callback(vrep.simxFinish, far)
        handle = handle_of(direct, JOINTS[0])
        _picture(direct)

        def read(client: int) -> object:
            return check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking))

        cases = {DIRECT: lambda: read(direct), ROUTED: lambda: read(far)}
        taken = side_by_side("scale, router", cases, rounds=2 * effort.sets, calls=calls)
        before = bytes_to_port(server.port)
        for _ in range(calls):
            read(direct)
        after = bytes_to_port(server.port)
        shares = {
            "server": [server.process_id],
            "router": [router.process_id],
            "client": [os.getpid()],
        }
        earlier = {name: processor_seconds(ids) for name, ids in shares.items()}
        for _ in range(calls):
            read(far)
        spent = {name: processor_seconds(ids) - earlier[name] for name, ids in shares.items()}
    found.rows += [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.ratios.append(
        Ratio("blocking read through a router / directly", ratio(taken[ROUTED], taken[DIRECT]))
    )
    for name, seconds in spent.items():
        _row(found, f"processor time of a read through a router, {name}", seconds / calls * 1e6, "us")
    for name, count, base in zip(("question", "answer"), after, before, strict=True):
        _row(found, f"bytes of a blocking read on the wire, {name}", (count - base) / calls, "B")


def _row(found: Findings, what: str, value: float, unit: str) -> None:
    found.rows.append(Row(what, value, None, unit))
