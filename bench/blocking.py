"""One blocking read, against what the network between the two processes costs by itself."""

from __future__ import annotations

from contextlib import ExitStack, closing

import simx_client as vrep
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call, Delivery, Operation, Reply

from . import baselines, processes
from .client import JOINTS, check, connected, handle_of, running
from .measure import Effort, Rounds, ratio, side_by_side
from .report import Findings, Ratio, Row

TARGET = 1.5
"""A blocking read may cost so many bare queries: the promise of a drop-in that is not slow."""

READ = "simxGetJointPosition, blocking"
QUERY = "bare Zenoh query"
PUBLICATIONS = "bare Zenoh publications both ways"
TCP = "raw TCP echo"


def message_sizes(handle: int) -> tuple[int, int]:
    """Bytes of the request and of the answer of one blocking read, as they travel."""
    question = encode(
        Batch(1000, 1 << 25, [Call(1000, Operation.EXECUTE, 0, "simxGetJointPosition", [handle])])
    )
    answer = encode(Delivery(1000, 1 << 25, 1 << 30, 0, 5, [Reply(1000, 0, 1000, [1.5])]))
    return len(question), len(answer)


def measure(effort: Effort) -> Findings:
    """Round trips, with the simulation stopped and running in real time."""
    with ExitStack() as stack:
        client = stack.enter_context(connected(stack.enter_context(processes.server()).port))
        handle = handle_of(client, JOINTS[0])
        sizes = message_sizes(handle)
        request = baselines.request_of(*sizes)
        query, publications, tcp = (
            stack.enter_context(closing(near(stack.enter_context(processes.baseline(far)).port)))
            for near, far in (
                (baselines.Query, baselines.QUERY),
                (baselines.Publications, baselines.PUBLICATIONS),
                (baselines.Tcp, baselines.TCP),
            )
        )
        cases = {
            READ: lambda: check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking)),
            QUERY: lambda: query.exchange(request),
            PUBLICATIONS: lambda: publications.exchange(request),
            TCP: lambda: tcp.exchange(request),
        }
        calls = effort.count(500)
        stopped = side_by_side("blocking read, stopped", cases, rounds=effort.rounds, calls=calls)
        with running(client):
            moving = side_by_side("blocking read, running", cases, rounds=effort.rounds, calls=calls)
    found = Findings("Blocking read")
    for state, taken in (("stopped", stopped), ("running in real time", moving)):
        _tell(found, state, taken)
    found.notes.append(
        f"A question has {sizes[0]} bytes and an answer {sizes[1]}; so have those of the baselines."
    )
    return found


def _tell(found: Findings, state: str, taken: dict[str, Rounds]) -> None:
    found.rows += [Row.of(f"{what}, {state}", rounds, "us") for what, rounds in taken.items()]
    for other, target in ((QUERY, TARGET), (PUBLICATIONS, None), (TCP, None)):
        found.ratios.append(
            Ratio(f"blocking read / {other}, {state}", ratio(taken[READ], taken[other]), target=target)
        )
