"""How cost grows with the values that are streamed: processor time and bytes of a pass, a thousand passes a second."""

from __future__ import annotations

import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import simx_client as vrep
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, repeated
from bench.measuring.report import Findings, Grid, Panel, Plot
from bench.measuring.resources import bytes_to_port, processor_seconds
from simx_client.protocol.codec import encode_delivery, pack_answer, pack_reply_head
from simx_client.protocol.messages import Delivery

from .client import check, connected, handle_of, running
from .streaming import PASS_S, pendulums

COUNTS = (1, 10, 100, 300, 1000)
LISTENERS = 8

ALONE = "nobody"
ONE = "1 client"
MANY = f"{LISTENERS} clients"
MESSAGE, WIRE = "bytes of the message", "bytes through TCP"
RATE = "passes"
NUMBER_BYTES = 4
"""A value travels as a float32."""


def measure(effort: Effort) -> Findings:
    """So many pendulums, whose angles are streamed to nobody, one and eight clients."""
    taken = {count: repeated(1, partial(_one_set, effort, count)) for count in COUNTS}
    found = Findings("Cost against streamed values")

    def curve(name: str, scale: float = 1.0) -> list[tuple[float, float]]:
        return [(count, taken[count][name].median * scale) for count in COUNTS]

    message = [(float(count), float(message_size(count))) for count in COUNTS]
    bare = [(float(count), float(NUMBER_BYTES * count)) for count in COUNTS]
    columns = [
        *(curve(name, 1e6) for name in (ALONE, ONE, MANY)),
        curve(RATE),
        message,
        curve(WIRE),
        bare,
    ]
    found.grids.append(
        Grid(
            (
                "values",
                "pass alone, us",
                "1 client, us",
                f"{LISTENERS} clients, us",
                "passes / s",
                MESSAGE,
                WIRE,
                "bare numbers",
            ),
            [(str(count), [column[place][1] for column in columns]) for place, count in enumerate(COUNTS)],
        )
    )
    found.plots.append(
        Plot(
            "values",
            [
                Panel(
                    "processor time of the server for a pass, us",
                    "streamed joint positions",
                    {ONE: curve(ONE, 1e6), MANY: curve(MANY, 1e6)},
                    {"nobody listens: the pass alone": curve(ALONE, 1e6)},
                    is_log=True,
                ),
                Panel(
                    "bytes of a pass to a client",
                    "streamed joint positions",
                    {MESSAGE: message, WIRE: curve(WIRE)},
                    {"bare float32 numbers": bare},
                    is_log=True,
                ),
            ],
        )
    )
    found.notes += [
        f"1,000 us of a pass are one core at 1,000 passes per second, the rate that was asked for; what {LISTENERS} "
        "clients left of it is in the table. Physics is that of as many pendulums as values.",
    ]
    return found


def message_size(count: int) -> int:
    """Bytes of the message with so many streamed numbers."""
    head = Delivery(1000, 1 << 25, 1 << 30, 0, 5, [])
    values = b"".join(pack_reply_head(1000 + n) + pack_answer(0, 1000, [1.5]) for n in range(count))
    return len(encode_delivery(head, values, count))


@dataclass(frozen=True)
class Span:
    """What happened in a time."""

    processor: float
    """Seconds of the server."""

    passes: float
    received: int
    """Bytes, by this process."""

    seconds: float


def _one_set(effort: Effort, count: int, stack: ExitStack) -> dict[str, Rounds]:
    scene = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "pendulums.xml"
    scene.write_text(pendulums(count), encoding="utf-8")
    server = stack.enter_context(processes.server(str(scene), "--no-local", "--time-step", str(PASS_S)))
    # One client per address and process; every loopback address is this host.
    first, *others = (
        stack.enter_context(connected(server.port, f"127.0.0.{place}")) for place in range(1, LISTENERS + 1)
    )
    handles = [handle_of(first, f"joint{place}") for place in range(count)]
    span = max(0.1, effort.seconds(1.0))

    def observe() -> Span:
        before = (
            _passes(first, handles[0]),
            processor_seconds([server.process_id]),
            bytes_to_port(server.port)[1],
        )
        began = time.perf_counter()
        time.sleep(span)
        took, processor = time.perf_counter() - began, processor_seconds([server.process_id]) - before[1]
        received = bytes_to_port(server.port)[1] - before[2]
        return Span(processor, _passes(first, handles[0]) - before[0], received, took)

    with running(first):
        alone = observe()
        _arm(first, handles)
        one = observe()
        for client in others:
            _arm(client, handles)
        many = observe()
    return {
        ALONE: _single(alone.processor / alone.passes),
        ONE: _single(one.processor / one.passes),
        MANY: _single(many.processor / many.passes),
        WIRE: _single(one.received / one.passes),
        RATE: _single(many.passes / many.seconds),
    }


def _single(value: float) -> Rounds:
    return Rounds(((value,),))


def _arm(client: int, handles: list[int]) -> None:
    vrep.simxPauseCommunication(client, True)
    for handle in handles:
        vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
    vrep.simxPauseCommunication(client, False)
    check(vrep.simxGetPingTime(client))


def _passes(client: int, handle: int) -> float:
    """Made since the start. Asked for by a call without a stream: a blocking read would end the joint's."""
    check(vrep.simxGetPingTime(client))
    return vrep.simxGetLastCmdTime(client) / 1000 / PASS_S
