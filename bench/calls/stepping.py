"""Stepped mode: simulation steps per second, against the same physics in one process without a server."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from unittest.mock import patch

import simx_client as vrep
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, difference, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from bench.world.physics import Physics
from simx_client.transport.lane import Lane

from .blocking import message_sizes
from .client import JOINTS, check, handle_of, running, simulator

TRIGGER = "simxSynchronousTrigger"
LOOP = "trigger, 6 streamed reads, 6 oneshot targets"
STEPS = "the same mj_step calls in process"
TARGET = 1.4
"""The loop may cost so many bare queries beyond the pass itself."""

SHARE_OF_RATE = 0.7
"""Of the rate of the same physics in process, the loop must keep so much."""

MESSAGES = "messages to the client for a turn of the control loop, streams included"
PASS = "a pass of the server's simulation in process"
QUERY = "bare Zenoh query"
STEPPING_QUERY = "bare Zenoh query, answered after the same mj_step calls"


def measure(effort: Effort) -> Findings:
    """The tutorial's scene, as it is after the start."""
    taken = repeated(effort.sets, partial(_one_set, effort))
    messages = taken.pop(MESSAGES).median
    found = Findings("Stepped mode", topic="Simulation step")
    beyond = difference(taken[LOOP], taken[PASS])
    beyond_steps = difference(taken[STEPPING_QUERY], taken[STEPS])
    found.ratios = [
        Ratio("stepped pass / the same mj_step calls", ratio(taken[TRIGGER], taken[STEPS])),
        Ratio("stepped pass / a pass in process", ratio(taken[TRIGGER], taken[PASS])),
        Ratio("control loop / stepped pass alone", ratio(taken[LOOP], taken[TRIGGER])),
        Ratio(
            "control loop / the same mj_step calls",
            ratio(taken[LOOP], taken[STEPS]),
            target=1 / SHARE_OF_RATE,
        ),
        Ratio("control loop beyond the pass / bare Zenoh query", ratio(beyond, taken[QUERY]), target=TARGET),
        Ratio(MESSAGES, messages, unit="", target=1.0),
        Ratio(f"control loop / {STEPPING_QUERY}", ratio(taken[LOOP], taken[STEPPING_QUERY])),
        Ratio(f"{STEPPING_QUERY} / these calls alone", ratio(taken[STEPPING_QUERY], taken[STEPS])),
        Ratio(f"the same, beyond these calls / {QUERY}", ratio(beyond_steps, taken[QUERY])),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.rows.append(Row.of("control loop beyond the pass itself", beyond, "us"))
    found.rows.append(Row.of("trigger beyond the pass itself", difference(taken[TRIGGER], taken[PASS]), "us"))
    found.rows += [
        Row(f"simulation steps per second, {what}", 1 / taken[what].median, None, "1/s")
        for what in (TRIGGER, LOOP, STEPS)
    ]
    found.notes = [
        "The bare query that steps is the most that can be had with Zenoh: without names and values, and without the "
        "scene's sensors and scripts. Who has slept while another computed is woken later than in a row of short calls."
    ]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    received = stack.enter_context(_counted())
    client = stack.enter_context(simulator())
    handles = [handle_of(client, name) for name in JOINTS]
    query, stepping = (
        stack.enter_context(closing(baselines.Query(stack.enter_context(processes.baseline(name)).port)))
        for name in (baselines.QUERY, baselines.STEPPING)
    )
    request = baselines.request_of(*message_sizes(handles[0]))
    physics = Physics(stack)
    stack.enter_context(running(client, stepped=True))
    for handle in handles:
        vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
    _loop(client, handles)  # brings the first answers of the streams
    turns, before = effort.count(50), received.total()
    for _ in range(turns):
        _loop(client, handles)
    counted = (received.total() - before) / turns
    taken = side_by_side(
        "stepping",
        {
            TRIGGER: lambda: check(vrep.simxSynchronousTrigger(client)),
            LOOP: lambda: _loop(client, handles),
            STEPS: physics.step,
            PASS: physics.simulation.step,
            QUERY: lambda: query.exchange(request),
            STEPPING_QUERY: lambda: stepping.exchange(request),
        },
        rounds=effort.rounds,
        calls=effort.count(60),
    )
    return taken | {MESSAGES: Rounds(((counted,),))}


@contextmanager
def _counted() -> Generator[Counter[str]]:
    """Count the messages by the lane to a client that connects within the block; streams come in shared memory."""
    received, receive = Counter[str](), Lane.receive

    def counting(self: Lane, timeout: float, *, is_soon: bool = False) -> bytes | None:
        payload = receive(self, timeout, is_soon=is_soon)
        received["messages"] += payload is not None
        return payload

    with patch.object(Lane, "receive", counting):
        yield received


def _loop(client: int, handles: list[int]) -> None:
    """One turn of the usual control loop."""
    for handle in handles:
        check(
            vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer), vrep.simx_return_novalue_flag
        )
    for handle in handles:
        vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot)
    check(vrep.simxSynchronousTrigger(client))
