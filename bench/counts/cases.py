"""The counted operations: a read, a set, a turn of the control loop and an image, by each way to a server."""

from __future__ import annotations

import json
import os
import signal
import socket
import statistics
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

import simx_client as vrep
from bench.calls.client import CAMERA, JOINTS, check, connected, handle_of, over_zenoh
from bench.calls.embedded import control_loop
from bench.measuring import processes
from simx_client.client import Client
from simx_client.transport.busy_wait import BusyWait
from simx_client.transport.lane import Lane
from simx_client.transport.zenoh import ZenohTransport

from .tally import count

Counts = Mapping[str, float]
"""By what is counted, the number for one operation."""

Operation = Callable[[], object]

TIMES, USUALLY = {"image": 20}, 100
"""How often an operation is done in a round of counts, by its name."""

ROUNDS = 3
"""The medians of so many are taken: a server looks about now and then, with the operation or without it."""

SCENE, FINGER = "ur5_rg2_kinect", "RG2_openCloseJoint"
ANSWER_WITHIN_S = 10.0

ZMQ = "ZeroMQ"


def counted() -> dict[str, Counts]:
    """Return all counts, by operation and way."""
    found: dict[str, Counts] = {}
    with ExitStack() as stack:
        client = stack.enter_context(Client.embedded(SCENE)).id
        for name, operation in _operations(client).items():
            found[f"{name}, embedded"] = _here(operation, TIMES.get(name, USUALLY))
    with ExitStack() as stack:
        port = _free_port()
        server = _CountingServer(stack, "--zmq", str(port))
        found |= _by_transport(server, "one host", Lane)
        with over_zenoh():
            found |= _by_transport(server, "Zenoh", ZenohTransport)
        found |= _of_zmq(server, port)
    return found


def _operations(client: int) -> dict[str, Operation]:
    """Return the operations of a client, whose simulation runs step by step from now on."""
    handles, camera = [handle_of(client, name) for name in JOINTS], handle_of(client, CAMERA)
    finger = handle_of(client, FINGER)  # a blocking call would end the stream of a joint of the loop
    blocking = vrep.simx_opmode_blocking
    for handle in handles:
        vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
    check(vrep.simxSynchronous(client, True))
    check(vrep.simxStartSimulation(client, blocking))
    for _ in range(2):  # until all streams have values
        check(vrep.simxSynchronousTrigger(client))
        check(vrep.simxGetPingTime(client))
    return {
        "read": lambda: check(vrep.simxGetJointPosition(client, finger, blocking)),
        "set": lambda: check(vrep.simxSetJointTargetPosition(client, finger, 0.0, blocking)),
        "control loop": partial(control_loop, client, handles),
        "image": lambda: check(vrep.simxGetVisionSensorImage(client, camera, 0, blocking)),
    }


def _here(operation: Operation, times: int) -> Counts:
    """Count an operation of an embedded simulation, which is executed by this thread."""
    calls, _ = count(operation, times)
    return {"Python calls": calls, "most bytes at once": _most_bytes(operation)}


def _most_bytes(operation: Operation) -> float:
    """Return the bytes by which an operation exceeds what is in use before it."""
    tracemalloc.start()
    try:
        most: list[int] = []
        for _ in range(5):
            tracemalloc.reset_peak()
            before, _ = tracemalloc.get_traced_memory()
            operation()
            most.append(tracemalloc.get_traced_memory()[1] - before)
        return min(most)
    finally:
        tracemalloc.stop()


class _CountingServer:
    """A server in a process of its own that counts what it does."""

    def __init__(self, stack: ExitStack, *arguments: str) -> None:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-counts-"))
        self._file = Path(folder) / "counts.json"
        module = (sys.executable, "-m", "bench.counts.server", str(self._file), *processes.SERVER[3:])
        self.running = stack.enter_context(processes.server(SCENE, *arguments, command=module))

    def totals(self) -> tuple[int, int]:
        """Return the calls of Python functions and the system calls until now.

        Raises:
            NotReady: it did not answer.
        """
        self._file.unlink(missing_ok=True)
        os.kill(self.running.process_id, signal.SIGUSR1)
        until = time.monotonic() + ANSWER_WITHIN_S
        while time.monotonic() < until:
            if self._file.exists():
                calls, system_calls = json.loads(self._file.read_text())
                return calls, system_calls
            time.sleep(0.005)
        raise processes.NotReady("the counting server wrote no counts")

    def during(self, operation: Operation, times: int) -> tuple[float, float]:
        """Return the server's calls and system calls for one operation of a client: the medians of some rounds.

        What it does in the same time without the operation does not count: on a busy machine that time is longer.
        """
        found: list[tuple[float, float]] = []
        for _ in range(ROUNDS):
            before, began = self.totals(), time.monotonic()
            for _ in range(times):
                operation()
            taken, after = time.monotonic() - began, self.totals()
            time.sleep(taken)
            calls, system_calls = (
                max(0, 2 * there - here - later) / times
                for here, there, later in zip(before, after, self.totals(), strict=True)
            )
            found.append((calls, system_calls))
        calls, system_calls = map(statistics.median, zip(*found, strict=True))
        return calls, system_calls


def _by_transport(server: _CountingServer, way: str, transport: type[Any]) -> dict[str, Counts]:
    """Count the operations of a client that comes by a transport, in both processes."""
    sizes: list[int] = []
    found: dict[str, Counts] = {}
    # how often a waiting thread looks depends on the machine
    sleeping = patch.object(BusyWait, "poll", lambda _wait, _take: None)
    with sleeping, _noted(transport, sizes), connected(server.running.port) as client:
        for name, operation in _operations(client).items():
            found[f"{name}, {way}"] = _of_both(server, operation, TIMES.get(name, USUALLY), sizes)
        check(vrep.simxStopSimulation(client, vrep.simx_opmode_blocking))
    return found


def _of_both(server: _CountingServer, operation: Operation, times: int, sizes: list[int]) -> Counts:
    """Count an operation in both processes; `sizes` receives those of the messages."""
    sizes.clear()
    calls_there, system_calls_there = server.during(operation, times)
    messages = len(sizes) / (times * ROUNDS), sum(sizes) / (times * ROUNDS)
    calls, system_calls = count(operation, times)
    return {
        "Python calls of the client": calls,
        "Python calls of the server": calls_there,
        "system calls of the client": system_calls,
        "system calls of the server": system_calls_there,
        "messages": messages[0],
        "bytes": messages[1],
    }


@contextmanager
def _noted(transport: type[Any], sizes: list[int]) -> Generator[None]:
    """Note the size of each message of both directions, of connections that are made within the block."""
    send, receive = transport.send, transport.receive

    def noting_send(self: Any, payload: bytes, *arguments: Any) -> None:
        sizes.append(len(payload))
        send(self, payload, *arguments)

    def noting_receive(self: Any, timeout: float, *, is_soon: bool = False) -> bytes | None:
        payload: bytes | None = receive(self, timeout, is_soon=is_soon)
        if payload is not None:
            sizes.append(len(payload))
        return payload

    with patch.object(transport, "send", noting_send), patch.object(transport, "receive", noting_receive):
        yield


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _of_zmq(server: _CountingServer, port: int) -> dict[str, Counts]:
    """Count what the server does for calls of CoppeliaSim's ZeroMQ client; the client's part is not ours."""
    try:
        from coppeliasim_zmqremoteapi_client import RemoteAPIClient
    except ImportError:
        return {}
    sim: Any = RemoteAPIClient("127.0.0.1", port).require("sim")
    joint = sim.getObject("/UR5_joint1")
    sim.setStepping(True)
    sim.startSimulation()
    operations: dict[str, Operation] = {
        "read": lambda: sim.getJointPosition(joint),
        "set": lambda: sim.setJointTargetPosition(joint, 0.0),
        "step": sim.step,
    }
    found: dict[str, Counts] = {}
    for name, operation in operations.items():
        calls, system_calls = server.during(operation, USUALLY)
        found[f"{name}, {ZMQ}"] = {
            "Python calls of the server": calls,
            "system calls of the server": system_calls,
        }
    return found
