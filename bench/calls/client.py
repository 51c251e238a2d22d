"""The client's side of the measurements: a connection that closes itself, and calls that must succeed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import simx_client as vrep
from bench.measuring import processes
from simx_client.transport.lane import VARIABLE

JOINTS = tuple(f"UR5_joint{number}" for number in range(1, 7))
CAMERA = "kinect_rgb"


class CallFailed(Exception):
    """A call of the measurement itself did not succeed, so its figures would mean nothing."""


@contextmanager
def connected(port: int, address: str = "127.0.0.1") -> Iterator[int]:
    """A client of the server on this port; closed when the block is left."""
    client = vrep.simxStart(address, port, True, True, 5000, 5)
    if client == -1:
        raise CallFailed(f"no connection to the server on port {port}; its log says why")
    try:
        yield client
    finally:
        vrep.simxFinish(client)


@contextmanager
def simulator(*arguments: str) -> Iterator[int]:
    """A client of a fresh server with these flags, once that has settled.

    In its first half second a server makes its renderer beside serving; the first picture comes after that.
    """
    with processes.server(*arguments) as server, connected(server.port) as client:
        settle(client)
        yield client


@contextmanager
def over_zenoh() -> Iterator[None]:
    """Have clients that connect within the block use Zenoh alone, as between hosts."""
    os.environ[VARIABLE] = "0"
    try:
        yield
    finally:
        del os.environ[VARIABLE]


def settle(client: int) -> None:
    """Wait until the server has made its renderer."""
    camera = handle_of(client, CAMERA)
    check(vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_blocking))


def check(result: Any, *allowed: int) -> Any:
    """What a simx function returned, if its code is 0 or one of `allowed`."""
    code = result[0] if isinstance(result, tuple) else result
    if code != 0 and code not in allowed:
        raise CallFailed(f"a call of the measurement returned code {code}")
    return result


def handle_of(client: int, name: str) -> int:
    return int(check(vrep.simxGetObjectHandle(client, name, vrep.simx_opmode_blocking))[1])


@contextmanager
def running(client: int, *, stepped: bool = False) -> Iterator[None]:
    """The simulation runs within the block and is stopped afterwards."""
    blocking = vrep.simx_opmode_blocking
    if stepped:
        check(vrep.simxSynchronous(client, True))
    check(vrep.simxStartSimulation(client, blocking))
    try:
        yield
    finally:
        check(vrep.simxStopSimulation(client, blocking))
