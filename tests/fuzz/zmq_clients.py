"""Hostile clients of the ZeroMQ remote API at a server of this process, while another client makes its calls."""

from __future__ import annotations

import contextlib
import logging
import random
import socket
from pathlib import Path
from typing import Any

from zmq_world import RawClient, ZmqWorld, cbor2, zmq, zmq_world

from simx_server.gateways.zmq.listing import offered
from simx_server.gateways.zmq.wire.zmtp import GREETING

from .scene import SCENE

_ENDS = ("sim.quitSimulator",)
"""Does what it is for, and ends the test."""

FUNCTIONS = sorted(
    name for name, about in offered().items() if about["support"] != "constant" and name not in _ENDS
)

READY = b"\x04\x19\x05READY\x0bSocket-Type\x00\x00\x00\x03REQ"
NAMES = (
    "/base",
    "hinge",
    "/base/arm",
    "eye",
    "box",
    "returns@/base",
    "fails@/base",
    "f@func",
    "",
    "x" * 3000,
    b"\xff\x00",
)
NUMBERS = (
    0,
    1,
    -1,
    2,
    5,
    16,
    100,
    -2,
    -11,
    2**31 - 1,
    -(2**31),
    2**63,
    0.0,
    -1.5,
    1e-9,
    1e308,
    float("nan"),
    float("inf"),
)
WAIT = 250
"""Milliseconds to wait for an answer: some calls wait for a simulation that does not run."""


class Attacker:
    """The random messages of one client."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance

    def call(self) -> tuple[str, list[Any]]:
        """A function that exists, with arguments of any kind."""
        chance = self._chance
        return chance.choice(FUNCTIONS), [
            self._value(0) for _ in range(chance.choice((0, 1, 1, 2, 2, 3, 4, 7)))
        ]

    def message(self, uuid: str) -> bytes:
        """A call as bytes, which may be wrong."""
        chance = self._chance
        name, arguments = self.call()
        fields: dict[str, Any] = {"func": name, "args": arguments, "argsL": len(arguments), "uuid": uuid}
        if chance.random() < 0.1:
            fields[chance.choice(list(fields))] = self._value(0)
        data = bytearray(cbor2.dumps(fields))
        for _ in range(chance.choice((0, 0, 0, 1, 3))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.05:
            del data[chance.randrange(len(data)) :]
        return bytes(data)

    def stream(self) -> bytes:
        """The bytes of a whole connection, which may be wrong at any place."""
        chance = self._chance
        frames = [self._framed(self.message("a-peer")) for _ in range(chance.choice((0, 1, 3)))]
        data = bytearray(GREETING + READY + b"".join(frames))
        for _ in range(chance.choice((0, 1, 1, 4))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        return bytes(data)

    def _framed(self, payload: bytes) -> bytes:
        flag = self._chance.choice((2, 2, 2, 3, 6, 7, 255))
        size = len(payload) + self._chance.choice((0, 0, 0, 0, 1, -1, 1 << 40))
        return b"\x01\x00" + bytes((flag,)) + (size % (1 << 64)).to_bytes(8, "big") + payload

    def _value(self, depth: int) -> Any:
        chance = self._chance
        match chance.randrange(8 if depth < 3 else 5):
            case 0 | 1:
                return chance.choice(NUMBERS)
            case 2:
                return chance.randrange(40)
            case 3:
                return chance.choice(NAMES)
            case 4:
                return chance.choice((None, True, False, chance.randbytes(chance.choice((0, 1, 48, 300)))))
            case 5:
                return [self._value(depth + 1) for _ in range(chance.randrange(8))]
            case 6:
                return [chance.choice((0.0, 0.1, -1.0, 5.0)) for _ in range(chance.choice((3, 4, 7, 12)))]
            case _:
                return {chance.choice(("pos", "index", "targetPos", "callback", "x")): self._value(depth + 1)}


def run(cases: int, seed: int, folder: Path) -> str:
    """Send this number of messages.

    Returns:
        The counts, for people.
    """
    chance = random.Random(seed)
    log = _Errors()
    logging.getLogger("simx_server").addHandler(log)
    made, seen = Attacker(chance), {"ret": 0, "err": 0, "func": 0, "silence": 0}
    with zmq_world(folder, scene=SCENE) as server:
        sent = 0
        while sent < cases:
            if chance.random() < 0.1:
                sent += 1
                _pour(server.port, made.stream())
            else:
                sent += _calls(server, made, min(50, cases - sent), seen)
            _is_served(server, log)
    logging.getLogger("simx_server").removeHandler(log)
    return ", ".join(f"{count} {kind}" for kind, count in seen.items())


def _calls(server: ZmqWorld, made: Attacker, count: int, seen: dict[str, int]) -> int:
    """Send up to this number of messages by one client, until one of them gets no answer; return how many."""
    client = RawClient(server.port)
    client.socket.setsockopt(zmq.RCVTIMEO, WAIT)
    try:
        for number in range(1, count + 1):
            try:
                answer = client.ask_bytes(made.message(client.uuid))
            except zmq.Again:
                seen["silence"] += 1
                return number
            kind = next((each for each in seen if each in answer), "err")
            seen[kind] += 1
    finally:
        client.close()
    return count


def _pour(port: int, data: bytes) -> None:
    with socket.create_connection(("127.0.0.1", port)) as peer, contextlib.suppress(OSError):
        peer.settimeout(WAIT / 1000)
        peer.sendall(data)
        while peer.recv(1 << 16):
            pass


class _Errors(logging.Handler):
    """Keeps the faults of the server itself; a script that ends by its own error is not a fault."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        if record.exc_info:
            self.found.append(logging.Formatter().format(record))


def _is_served(server: ZmqWorld, log: _Errors) -> None:
    """Another client is answered, by a server that still has no error."""
    bystander = RawClient(server.port)
    assert "ret" in bystander.ask("sim.getSimulationTime")
    bystander.close()
    faults = {name: each.last for name, each in server.loop.service.metrics.failures.items() if each.internal}
    assert not faults, faults
    assert not log.found, log.found[0]
