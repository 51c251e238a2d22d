"""All operations that are looked into, in this process and between two."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from functools import partial
from typing import NamedTuple

import simx_client as vrep
from bench.calls import batch, blocking
from bench.calls.client import JOINTS, check, connected, handle_of, over_zenoh, running, settle
from bench.calls.embedded import control_loop
from bench.measuring.paces import BUSY, ONE_CORE, endless_loops
from bench.measuring.resources import on_one_core

from .operations import HERE, LASTS_S, Operation, Repeated, sampled
from .sampled_server import SampledServer
from .sampling import Taken

FINGER = "RG2_openCloseJoint"
SERVERS = 8


class Profile(NamedTuple):
    """Where the time of an operation goes."""

    name: str
    seconds: float
    """Of the wall clock, for one operation."""

    processes: dict[str, Taken]
    """Processor time of one operation, by the process: this one, or client and server."""


def profiles() -> Iterator[Profile]:
    """Look into all of them, one after the other."""
    with ExitStack() as stack:
        server = SampledServer(stack)
        yield Profile("start of a server", server.started_in, {"": server.toggle()})
    for name, prepare in HERE.items():
        with ExitStack() as stack:
            seconds, _, taken = sampled(prepare(stack))
            yield Profile(name, seconds, {"": taken})
    with ExitStack() as stack:
        server = SampledServer(stack)
        server.toggle()  # ends the sample of its start
        for way in ("one host", "Zenoh"):
            with over_zenoh() if way == "Zenoh" else nullcontext(), connected(server.port) as client:
                settle(client)
                yield from _over(way, server, client)
    with ExitStack() as stack:
        yield _by_batch(stack)


def _over(way: str, server: SampledServer, client: int) -> Iterator[Profile]:
    """Look into reads while the simulation is stopped, a burst of targets over Zenoh, and the control loop."""
    handles, finger = [handle_of(client, name) for name in JOINTS], handle_of(client, FINGER)
    read = partial(vrep.simxGetJointPosition, client, finger, vrep.simx_opmode_blocking)
    yield between(f"{way}: blocking read", read, [server])
    paces: dict[str, AbstractContextManager[None]] = {
        BUSY: endless_loops(),
        ONE_CORE: on_one_core(os.getpid(), server.process_id),
    }
    for pace, kept in paces.items():
        with kept:
            yield between(f"{way}: blocking read, {pace}", read, [server])
    if way == "Zenoh":
        yield between(f"{way}: {blocking.BURST}", partial(blocking.burst, client, handles), [server])
    with running(client, stepped=True):
        for handle in handles:
            vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
        check(vrep.simxSynchronousTrigger(client))
        yield between(f"{way}: control loop of 50 ms", partial(control_loop, client, handles), [server])


def _by_batch(stack: ExitStack) -> Profile:
    """Look into a step of many servers in lock-step, with all servers' times together."""
    servers = [SampledServer(stack) for _ in range(SERVERS)]
    for server in servers:
        server.toggle()
    step = stack.enter_context(batch.lock_step(batch.TASKS[0], [server.port for server in servers]))
    return between(f"{SERVERS} servers by batch: a step of all", step, servers)


def between(
    name: str, operation: Operation, servers: Sequence[SampledServer], lasts: float = LASTS_S
) -> Profile:
    """Look into an operation in this process and in those of its servers, whose times are added."""
    operation()
    for server in servers:
        server.toggle()
    seconds, times, here = sampled(Repeated(operation), lasts)
    there = [server.toggle() for server in servers]
    by_function = Counter[str]()
    for each in there:
        by_function.update(each.by_function)
    served = Taken(
        {name: taken / times for name, taken in by_function.items()},
        sum(each.main for each in there) / times,
        sum(each.others for each in there) / times,
    )
    return Profile(name, seconds, {"client": here, "server" if len(servers) == 1 else "servers": served})
