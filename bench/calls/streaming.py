"""Streams: what reading one costs, how old the value is, how many arrive; and the call that does not wait."""

from __future__ import annotations

import random
import statistics
import tempfile
import time
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

import msgpack

import simx_client as vrep
from bench.measuring import baselines, processes
from bench.measuring.measure import (
    Effort,
    Rounds,
    difference,
    in_turn,
    ratio,
    repeated,
    side_by_side,
    timed,
)
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import processor_seconds

from .blocking import message_sizes
from .client import JOINTS, check, connected, handle_of, running, simulator

READ = "streamed value, buffer read"
SET = "simxSetJointTargetPosition, oneshot"
DICTIONARY = "a look-up in a dict and a tuple"
PUT = "bare Zenoh put"
READ_MOST = 40.0
"""Times `DICTIONARY`: 4 us where that takes 0.1 us."""

AGE = "age of a value when read"
COUNTS = "values and simulation steps per second"

CLIENTS, VALUES, PASS_S = 8, 100, 0.001
"""Who listens, to how many joints each, and how often they are told."""

SPENT = f"processor time of a simulation step that streams {VALUES} values to {CLIENTS} clients"
SPENT_ALONE = "processor time of the same simulation step, nobody listening"
PACKED = f"packing {VALUES} values one by one, and copying the message {CLIENTS} times"
MOST = 8.0
"""Times `PACKED`, that streaming may take beyond the simulation step itself."""

_JOINT = """<body pos="{place} 0 0"><joint name="joint{place}" axis="0 1 0"/>
<geom type="capsule" size=".05 .1" pos="0 0 -.1" contype="0" conaffinity="0"/></body>"""

_SERVER_TIME_MASK = 0x7FFF_FFFF
_ROUNDING_MS = 0.5
"""The server's stamp is cut to whole milliseconds, so ages look older by this on average."""

_PAUSES_S = (0.001, 0.009)
"""Range of the random pauses between reads of the age: independent of the passes."""


def measure(effort: Effort) -> Findings:
    """Cost of a call in a running simulation; age and number of values at two speeds."""
    found = Findings("Streaming", topic="Calls")
    calls = repeated(effort.sets, partial(_calls, effort))
    found.rows += [Row.of(what, rounds, "us") for what, rounds in calls.items()]
    found.ratios += [
        Ratio(f"{READ} / {DICTIONARY}", ratio(calls[READ], calls[DICTIONARY]), target=READ_MOST),
        Ratio(f"oneshot set / {PUT}", ratio(calls[SET], calls[PUT])),
    ]
    for speed in ("1", "max"):
        _tell_values(found, speed, repeated((effort.sets + 1) // 2, partial(_values, effort, speed)))
    spent = repeated((effort.sets + 1) // 2, partial(_spent, effort))
    beyond = difference(spent[SPENT], spent[SPENT_ALONE])
    found.ratios.append(
        Ratio(
            f"streaming {VALUES} values to {CLIENTS} clients / {PACKED}",
            ratio(beyond, spent[PACKED]),
            target=MOST,
        )
    )
    found.rows += [Row.of(what, taken, "us") for what, taken in spent.items()]
    found.notes.append(
        "The age is from the server's stamp, made when the values of a pass leave, to the return of the read. "
        "In real time values are new every 50 ms, so 25 ms on average is as fresh as they can be."
    )
    return found


def _calls(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    client = stack.enter_context(simulator())
    handle = handle_of(client, JOINTS[0])
    far = stack.enter_context(processes.baseline(baselines.PUBLICATIONS))
    bare = stack.enter_context(closing(baselines.Publications(far.port)))
    request_size = message_sizes(handle)[0]
    one_way = baselines.request_of(request_size, 0)
    there_and_back = baselines.request_of(request_size, 8)
    known = {("simxGetJointPosition", handle): 0.25}
    stack.enter_context(running(client))
    _arm(client, handle)

    def settle() -> None:
        check(vrep.simxGetPingTime(client))
        bare.exchange(there_and_back)

    return side_by_side(
        "streaming, calls",
        {
            READ: lambda: vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer),
            DICTIONARY: lambda: (0, known["simxGetJointPosition", handle]),
            SET: lambda: vrep.simxSetJointTargetPosition(client, handle, 0.0, vrep.simx_opmode_oneshot),
            PUT: lambda: bare.put(one_way),
        },
        rounds=effort.rounds,
        calls=effort.count(2000),
        settle=settle,
    )


def _arm(client: int, handle: int) -> None:
    """Ask for the stream and wait for its first value."""
    vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
    deadline = time.monotonic() + baselines.TIMEOUT_S
    while vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer)[0]:
        if time.monotonic() > deadline:
            check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer))
        time.sleep(0.001)


def _values(effort: Effort, speed: str, stack: ExitStack) -> dict[str, Rounds]:
    client = stack.enter_context(simulator("--speed", speed))
    handle = handle_of(client, JOINTS[0])
    stack.enter_context(running(client))
    _arm(client, handle)
    pass_ms, span = _pass_ms(client), effort.seconds(0.6)
    return in_turn(
        f"streaming, values at speed {speed}",
        {AGE: lambda: _ages(client, handle, span), COUNTS: lambda: _counts(client, handle, span, pass_ms)},
        effort.rounds,
    )


def _tell_values(found: Findings, speed: str, taken: dict[str, Rounds]) -> None:
    found.rows.append(Row.of(f"{AGE}, speed {speed}", taken[AGE], "ms"))
    seen, passes = (statistics.median(counts) for counts in zip(*taken[COUNTS].values, strict=True))
    found.rows.append(Row(f"new values a busy reader sees per second, speed {speed}", seen, None, "1/s"))
    found.rows.append(Row(f"simulation steps per second meanwhile, speed {speed}", passes, None, "1/s"))


def _pass_ms(client: int) -> float:
    step = vrep.simxGetFloatingParameter(
        client, vrep.sim_floatparam_simulation_time_step, vrep.simx_opmode_blocking
    )
    return float(check(step)[1]) * 1000


def _ages(client: int, handle: int, span: float) -> tuple[float, ...]:
    """Seconds since the newest value left the server, at random moments."""
    ages = []
    end = time.monotonic() + span
    while time.monotonic() < end:
        time.sleep(random.uniform(*_PAUSES_S))
        check(vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer))
        now = time.monotonic() * 1000
        stamp = vrep.simxGetInMessageInfo(client, vrep.simx_headeroffset_server_time)[1]
        ages.append(((now - stamp) % (_SERVER_TIME_MASK + 1) - _ROUNDING_MS) / 1000)
    return tuple(ages)


def _counts(client: int, handle: int, span: float, pass_ms: float) -> tuple[float, float]:
    """New values seen, and passes made, per second, by a reader that does nothing else."""
    first = last = _time_of_value(client, handle)
    began = time.perf_counter()
    seen = 0
    while (elapsed := time.perf_counter() - began) < span:
        now = _time_of_value(client, handle)
        if now != last:
            seen, last = seen + 1, now
    return seen / elapsed, (last - first) / pass_ms / elapsed


def _time_of_value(client: int, handle: int) -> int:
    """Simulation time in ms of the newest value."""
    vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_buffer)
    return vrep.simxGetLastCmdTime(client)


def pendulums(count: int) -> str:
    """A scene of so many, one physics step a pass; their joints are joint0, joint1, ..."""
    bodies = "".join(_JOINT.format(place=place) for place in range(count))
    return f'<mujoco><option timestep="{PASS_S}"/><worldbody>{bodies}</worldbody></mujoco>'


def _spent(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    """Processor time of a server for a simulation step, physics included, alone and for many listeners."""
    scene = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "pendulums.xml"
    scene.write_text(pendulums(VALUES), encoding="utf-8")
    server = stack.enter_context(processes.server(str(scene), "--time-step", str(PASS_S)))
    # One client per address and process; every loopback address is this host.
    ids = [stack.enter_context(connected(server.port, f"127.0.0.{place}")) for place in range(1, CLIENTS + 1)]
    handles = [handle_of(ids[0], f"joint{place}") for place in range(VALUES)]
    span = max(0.1, effort.seconds(1.0))

    def spend() -> float:
        steps, seconds = _steps(ids[0]), processor_seconds([server.process_id])
        time.sleep(span)
        return (processor_seconds([server.process_id]) - seconds) / (_steps(ids[0]) - steps)

    with running(ids[0]):
        alone = spend()
        for client in ids:
            for handle in handles:
                vrep.simxGetJointPosition(client, handle, vrep.simx_opmode_streaming)
            check(vrep.simxGetPingTime(client))
        many = spend()
    packed = statistics.median(timed(_pack, effort.count(200, 10)))
    return {
        name: Rounds(((each,),)) for name, each in ((SPENT, many), (SPENT_ALONE, alone), (PACKED, packed))
    }


def _steps(client: int) -> float:
    """Simulation steps since the start. A call without a stream: a blocking read would end a joint's."""
    check(vrep.simxGetPingTime(client))
    return vrep.simxGetLastCmdTime(client) / 1000 / PASS_S


def _pack() -> list[bytes]:
    """Do the least that sends many single values to many clients."""
    message = b"".join([msgpack.packb([place, 0, 1000, [1.5]]) for place in range(VALUES)])
    return [bytes(bytearray(message)) for _ in range(CLIENTS)]
