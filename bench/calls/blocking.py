"""One blocking read over Zenoh, as between hosts, against what the network between the processes costs alone."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial

import simx_client as vrep
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call, Delivery, Operation, Reply

from .client import JOINTS, check, handle_of, over_zenoh, running, simulator

TARGET = 1.2
"""A blocking read may cost so many bare queries: the promise of a drop-in that is not slow."""

TARGET_P99 = 2.0
"""So much its 99th percentile, of that of the bare queries."""

TARGET_BURST = 2.0
"""A burst may cost so many blocking reads: as they are, and as dear as one may be."""

READ = "simxGetJointPosition, blocking"
BURST = "12 oneshot targets within a pause, until executed"
QUERY = "bare Zenoh query"
PUBLICATIONS = "bare Zenoh publications both ways"
TCP = "raw TCP echo"

STOPPED = "stopped"
RUNNING = "running in real time"


def message_sizes(handle: int) -> tuple[int, int]:
    """Bytes of the request and of the answer of one blocking read, as they travel."""
    question = encode(
        Batch(1000, 1 << 25, [Call(1000, Operation.EXECUTE, 0, "simxGetJointPosition", [handle])])
    )
    answer = encode(Delivery(1000, 1 << 25, 1 << 30, 0, 5, [Reply(1000, 0, 1000, [1.5])]))
    return len(question), len(answer)


def measure(effort: Effort) -> Findings:
    """Round trips, with the simulation stopped and running in real time."""
    found = Findings("Blocking read over Zenoh", topic="Calls")
    taken = repeated(effort.sets, partial(_one_set, effort))
    for state in (STOPPED, RUNNING):
        found.ratios += [
            Ratio(
                f"blocking read over Zenoh / {other}, {state}",
                ratio(taken[f"{READ}, {state}"], taken[f"{other}, {state}"]),
                target=target,
            )
            for other, target in ((QUERY, TARGET), (PUBLICATIONS, None), (TCP, None))
        ]
        read, burst = taken[f"{READ}, {state}"], taken[f"{BURST}, {state}"]
        found.ratios += [
            Ratio(
                f"blocking read over Zenoh / {QUERY}, 99th percentiles, {state}",
                ratio_p99(read, taken[f"{QUERY}, {state}"]),
                target=TARGET_P99,
            ),
            Ratio(f"{BURST} / blocking read over Zenoh, {state}", ratio(burst, read), target=TARGET_BURST),
            Ratio(
                f"{BURST} / {QUERY}, {state}",
                ratio(burst, taken[f"{QUERY}, {state}"]),
                target=None,
            ),
        ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    sizes = message_sizes(1)
    found.notes = [
        f"A question has {sizes[0]} bytes and an answer {sizes[1]}; so have those of the baselines.",
        "Where the system places the processes decides a quarter of a round trip, so the ratios of single sets range "
        "widely. While a pass is made nobody is answered: a 99th percentile shows it if that is one call in a hundred.",
        "A burst ends with a question whose answer says that all before it was executed: it is two messages.",
    ]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    with over_zenoh():
        client = stack.enter_context(simulator())
    handles = [handle_of(client, name) for name in JOINTS]
    handle = handles[0]
    request = baselines.request_of(*message_sizes(handle))
    query, publications, tcp = processes.all_baselines(stack)
    cases = {
        READ: lambda: check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking)),
        BURST: lambda: burst(client, handles),
        QUERY: lambda: query.exchange(request),
        PUBLICATIONS: lambda: publications.exchange(request),
        TCP: lambda: tcp.exchange(request),
    }

    def take(state: str) -> dict[str, Rounds]:
        taken = side_by_side(f"blocking read, {state}", cases, rounds=effort.rounds, calls=effort.count(500))
        return {f"{what}, {state}": rounds for what, rounds in taken.items()}

    stopped = take(STOPPED)
    with running(client):
        return stopped | take(RUNNING)


def burst(client: int, handles: list[int]) -> None:
    """Two targets for each joint, sent together; then whatever waits."""
    vrep.simxPauseCommunication(client, True)
    for handle in handles:
        vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot)
    for handle in handles:
        vrep.simxSetJointTargetVelocity(client, handle, 1.0, vrep.simx_opmode_oneshot)
    vrep.simxPauseCommunication(client, False)
    check(vrep.simxGetPingTime(client))
