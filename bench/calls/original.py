"""A blocking read by the original's protocol, with the client's cycle and without, against a bare TCP socket.

The original's library sends a message in every cycle, 5 ms in nearly all programs. So the protocol itself allows one
blocking call per cycle, from a server that answers each message with the result at once; the original server answers
with the result of its next simulation step, in a later message.
"""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial

from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row

from .client import CallFailed

SCENE, JOINT = "ur5", "UR5_joint1"
CYCLE = 0.005
"""Seconds between two messages, as programs choose."""

TARGET = 1.05
"""A blocking read may cost so many cycles of a server that does nothing."""

PACED, BARE = f"blocking read, cycle of {CYCLE * 1000:g} ms", "blocking read, no cycle"
LIMIT, TCP = f"limit of the protocol, cycle of {CYCLE * 1000:g} ms", "raw TCP echo"

_PACKET, _HEADER, _COMMAND = struct.Struct("<HHH"), struct.Struct("<HBiiiHB"), struct.Struct("<iiHiiHiBB")
_BLOCKING, _GET_JOINT_POSITION, _GET_OBJECT_HANDLE = 0x10000, 0x1001, 0x3001


class Original:
    """The least client of the original's protocol: one blocking call at a time."""

    def __init__(self, port: int) -> None:
        """Connect."""
        self._socket = socket.create_connection(("127.0.0.1", port), 5.0)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._number = 0

    def close(self) -> None:
        """Leave."""
        self._socket.close()

    def call(self, id: int, ident: bytes, cycle: Callable[[], object] = lambda: None) -> bytes:
        """Make a blocking call; return the payload of its reply.

        Args:
            cycle: waits until the next message may be sent.

        Raises:
            CallFailed: the server answers with an error.
        """
        asked, size = self._number, _COMMAND.size + len(ident)
        message = _COMMAND.pack(size, size, len(ident), 0, id | _BLOCKING, 0, 0, 0, 0) + ident
        while True:
            cycle()
            number, reply = self._exchange(message)
            if number >= asked and reply:
                break
            message = b""
        if reply[24]:
            raise CallFailed(f"the call {id:#06x} of the measurement returned an error")
        return reply[size:]

    def _exchange(self, commands: bytes) -> tuple[int, bytes]:
        """Send one message; return the id of the answer and its commands."""
        message = _HEADER.pack(0, 11, self._number, 0, 0, 0, 0) + commands
        self._number += 1
        self._socket.sendall(_PACKET.pack(1, len(message), 0) + message)
        answer = self._socket.recv(1 << 16)
        return _HEADER.unpack_from(answer, _PACKET.size)[2], answer[_PACKET.size + _HEADER.size :]


class Cycle:
    """Lets one message go in each cycle."""

    def __init__(self, seconds: float) -> None:
        """Let the first one go at once."""
        self._seconds, self._next = seconds, 0.0

    def __call__(self) -> None:
        """Wait until a cycle has passed since the last message."""
        if (left := self._next - time.perf_counter()) > 0:
            time.sleep(left)
        self._next = time.perf_counter() + self._seconds


def measure(effort: Effort) -> Findings:
    """Round trips by the original's protocol."""
    found = Findings("Original clients", topic="Calls")
    taken = repeated(effort.sets, partial(_one_set, effort))
    found.ratios = [
        Ratio(f"{PACED} / {LIMIT}", ratio(taken[PACED], taken[LIMIT]), target=TARGET),
        Ratio("the same, 99th percentiles", ratio_p99(taken[PACED], taken[LIMIT])),
        Ratio(f"{BARE} / {TCP}", ratio(taken[BARE], taken[TCP])),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    per_second = {what: 1 / taken[what].median for what in (PACED, LIMIT, BARE)}
    found.notes = [
        "Blocking calls per second: "
        + ", ".join(f"{count:.0f} ({what})" for what, count in per_second.items())
        + ".",
        "The simulation is stopped; the scene is the UR5. A V-REP that simulates in steps of 50 ms answers 20 of them.",
    ]
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    server = stack.enter_context(processes.server(SCENE, "--legacy-port", "0"))
    client = stack.enter_context(closing(Original(server.ports[1])))
    handle = client.call(_GET_OBJECT_HANDLE, JOINT.encode() + b"\0")
    echo = stack.enter_context(
        closing(baselines.Tcp(stack.enter_context(processes.baseline(baselines.TCP)).port))
    )
    request = baselines.request_of(_PACKET.size + _HEADER.size + _COMMAND.size + 4, 58)
    paced, limit = Cycle(CYCLE), Cycle(CYCLE)

    def at_the_limit() -> None:
        limit()
        echo.exchange(request)

    cases = {
        PACED: lambda: client.call(_GET_JOINT_POSITION, handle, paced),
        LIMIT: at_the_limit,
        BARE: lambda: client.call(_GET_JOINT_POSITION, handle),
        TCP: lambda: echo.exchange(request),
    }
    return side_by_side("original clients", cases, rounds=effort.rounds, calls=effort.count(200))
