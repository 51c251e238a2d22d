"""Where the time of a blocking read and of a turn of the control loop goes.

Client and server run in one thread of this process, and the seams between them note the time; what the real thing over
Zenoh takes longer is Zenoh's, and that of threads and processes that have to wake up and find their caches cold.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from functools import partial
from typing import Any
from unittest.mock import patch

import mujoco

import simx_client as vrep
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, repeated, side_by_side, timed
from bench.measuring.report import Findings, Grid
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.codec import decode_batch, decode_delivery, encode
from simx_client.protocol.messages import Call
from simx_server.app.server import open_world
from simx_server.app.settings import Settings
from simx_server.gateways.loopback import LoopbackTransport
from simx_server.handlers import HANDLERS
from simx_server.runtime.background import wait_for_step
from simx_server.runtime.clock import Pacer
from simx_server.runtime.dispatch import Dispatch
from simx_server.runtime.executor import Executor
from simx_server.runtime.server_loop import ServerLoop
from simx_server.runtime.sessions import ClientSession
from simx_server.world.world import World

from .blocking import message_sizes
from .client import JOINTS, check, handle_of, running, simulator

READ, LOOP = "a blocking read", "a turn of the control loop"
QUERY = "a bare Zenoh query"
WHOLE, BETWEEN = "over Zenoh, all together", "Zenoh there and back, waking up, cold caches"

READ_PARTS = (
    "client: from the call to the bytes",
    "server: reading the bytes",
    "server: arguments and handler",
    "server: packing the answer",
    "server: queue and loop around it",
    "client: from the bytes to the result",
)
LOOP_PARTS = (
    "client: 6 streamed reads, their message taken in",
    "client: 6 oneshot targets packed and sent",
    "client: the trigger, to the bytes",
    "server: 7 messages read and executed",
    "server: MuJoCo's steps",
    "server: the rest of the pass",
    "server: 6 streams computed and packed",
    "server: the answer to the trigger",
    "client: from the bytes to the result",
)

now = time.perf_counter


class StampedTransport(LoopbackTransport):
    """The seam in this process; turns the engine when its client waits, and notes the time at every hand-over."""

    def __init__(self, loop: ServerLoop) -> None:
        super().__init__(loop, turns=False)
        self.loop = loop
        self.question = self.answer = b""
        self.sent = self.began = self.published = self.turned = 0.0
        self._waiting = 0
        """Deliveries that were not taken yet."""

    def connect(self, connection: Connection) -> None:
        """Have the engine turn for the greeting, which is not noted."""
        self._turns = True
        connection.connect(1.0)
        self._turns = False

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        self.sent, self.question = now(), payload
        super().send(payload, deadline)

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        if timeout > 0 and not self._waiting:
            self.began = now()
            while not self._waiting and now() < self.began + timeout:
                self.loop.turn(max_wait=timeout)
            self.turned = now()
        payload = super().receive(0)
        self._waiting -= payload is not None
        return payload

    def deliver(self, payload: bytes) -> None:
        self.answer = payload
        self._waiting += 1
        super().deliver(payload)

    def publish(self, payload: bytes) -> None:
        super().publish(payload)
        self.published = now()


def measure(effort: Effort) -> Findings:
    """The tutorial's scene; the read while it is stopped."""
    taken = repeated(max(1, effort.sets // 3), partial(_one_set, effort))
    found = Findings("Where the time goes")
    for whole, parts in ((READ, READ_PARTS), (LOOP, LOOP_PARTS)):
        found.grids.append(_grid(whole, {part: taken[f"{whole}, {part}"].median for part in parts}, taken))
    found.notes = [
        f"{QUERY} of as many bytes takes {taken[QUERY].median * 1e6:.0f} us.",
        "Parts are medians, taken with client and server in one thread of one process; what is between is the rest. "
        "MuJoCo's steps are the bare mj_step calls of the pass.",
    ]
    return found


def _grid(name: str, parts: Mapping[str, float], taken: Mapping[str, Rounds]) -> Grid:
    whole = taken[name].median
    lines = {**parts, BETWEEN: whole - sum(parts.values()), WHOLE: whole}
    return Grid((name, "us", "%"), [(part, (each * 1e6, 100 * each / whole)) for part, each in lines.items()])


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    calls = effort.count(300, 20)
    simulation = open_world(Settings(), stack)
    loop = ServerLoop(simulation, HANDLERS, Pacer(math.inf))
    transport = StampedTransport(loop)
    client = CLIENTS.add(connection := Connection(lambda: transport, where="this process"))
    stack.callback(vrep.simxFinish, client)
    transport.connect(connection)
    handles = [handle_of(client, name) for name in JOINTS]
    parts = _parts_of_read(client, handles[0], transport, calls)
    parts |= _parts_of_loop(client, handles, transport, effort.count(60, 10))
    return parts | _over_zenoh(effort, calls)


def _over_zenoh(effort: Effort, calls: int) -> dict[str, Rounds]:
    """The real thing, all of it."""
    with ExitStack() as stack:
        client = stack.enter_context(simulator())
        handles = [handle_of(client, name) for name in JOINTS]
        far = stack.enter_context(processes.baseline(baselines.QUERY))
        query = stack.enter_context(closing(baselines.Query(far.port)))
        request = baselines.request_of(*message_sizes(handles[0]))
        cases: dict[str, Callable[[], object]] = {
            READ: lambda: check(vrep.simxGetJointPosition(client, handles[0], vrep.simx_opmode_blocking)),
            QUERY: lambda: query.exchange(request),
        }
        taken = side_by_side("parts", cases, rounds=effort.rounds, calls=calls)
        with running(client, stepped=True):
            _arm(client, handles)
            cases = {LOOP: lambda: _turn(client, handles)}
            return taken | side_by_side("parts", cases, rounds=effort.rounds, calls=effort.count(60, 10))


def _parts_of_read(client: int, handle: int, transport: StampedTransport, calls: int) -> dict[str, Rounds]:
    marks: list[tuple[float, float, float]] = []

    def read() -> None:
        began = now()
        check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_blocking))
        ended = now()
        marks.append((transport.sent - began, transport.turned - transport.began, ended - transport.turned))

    timed(read, calls)
    there, server, back = map(statistics.median, zip(*marks, strict=True))
    loop = transport.loop
    session = next(iter(loop.sessions.values()))
    executor = Executor(Dispatch(loop.world, HANDLERS), loop.metrics)
    question, answer = transport.question, decode_delivery(transport.answer)
    call = decode_batch(question).calls[0]
    inner = [
        statistics.median(timed(part, calls))
        for part in (
            lambda: decode_batch(question),
            lambda: _execute(executor, session, call),
            lambda: encode(answer),
        )
    ]
    return _named(READ, READ_PARTS, [there, *inner, server - sum(inner), back])


def _execute(executor: Executor, session: ClientSession, call: Call) -> None:
    tally = executor.tally(session.called)
    command, work = executor.dispatch.find(session, call.command)
    assert command is not None
    assert work is not None
    executor.execute(session, tally, command, work, call.arguments, wait_for_step)
    tally.end()


def _parts_of_loop(
    client: int, handles: list[int], transport: StampedTransport, calls: int
) -> dict[str, Rounds]:
    simulation = transport.loop.simulation
    passes: list[tuple[float, float]] = []
    marks: list[list[float]] = []
    step = World.step

    def stamped(world: World) -> None:
        began = now()
        step(world)
        passes.append((began, now()))

    def turn() -> None:
        began = now()
        _read(client, handles)
        read = now()
        _target(client, handles)
        told = now()
        check(vrep.simxSynchronousTrigger(client))
        ended, (first, last) = now(), passes[-1]
        marks.append(
            [
                read - began,
                told - read,
                transport.sent - told,
                first - transport.began,
                last - first,
                transport.published - last,
                transport.turned - transport.published,
                ended - transport.turned,
            ]
        )

    with patch.object(World, "step", stamped), running(client, stepped=True):
        _arm(client, handles)
        timed(turn, calls)
        model, data = simulation.model, mujoco.MjData(simulation.model)
        mujoco.mj_copyData(data, model, simulation.data)
        physics = statistics.median(timed(lambda: _step(model, data, simulation.substeps), calls))
    *before, whole_pass, streams, answer, back = map(statistics.median, zip(*marks, strict=True))
    return _named(LOOP, LOOP_PARTS, [*before, physics, whole_pass - physics, streams, answer, back])


def _named(whole: str, parts: tuple[str, ...], seconds: list[float]) -> dict[str, Rounds]:
    return {f"{whole}, {part}": Rounds(((each,),)) for part, each in zip(parts, seconds, strict=True)}


def _arm(client: int, handles: list[int]) -> None:
    for handle in handles:
        vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
    check(vrep.simxSynchronousTrigger(client))


def _turn(client: int, handles: list[int]) -> None:
    """The usual control loop once."""
    _read(client, handles)
    _target(client, handles)
    check(vrep.simxSynchronousTrigger(client))


def _read(client: int, handles: list[int]) -> None:
    for handle in handles:
        check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer))


def _target(client: int, handles: list[int]) -> None:
    for handle in handles:
        vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot)


def _step(model: Any, data: Any, steps: int) -> None:
    for _ in range(steps):
        mujoco.mj_step(model, data)
