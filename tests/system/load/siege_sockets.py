"""Roles of the siege at the sockets of all gateways: messages without an end, silence, names, frozen clients."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import struct
import subprocess
import sys
import time
import uuid
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import cbor2
import zenoh
import zmq

import simx_client as v
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call
from simx_server.gateways.zmq.wire.zmtp import GREETING, READY

BLOCKING = v.simx_opmode_blocking
LARGE = 30 << 20
"""Bytes of a message that is not ended."""

HELD = 6.0
"""Seconds for which something is held, and for which a client is frozen: more than the server waits."""


class Gateways(NamedTuple):
    """Ports of the server."""

    zenoh: int
    legacy: int
    zmq: int
    viewers: int

    @classmethod
    def of(cls, text: str) -> Gateways:
        return cls(*map(int, text.split(",")))

    def __str__(self) -> str:
        return ",".join(map(str, self))


class ZmqPeer:
    """A client of the ZeroMQ remote API that sends what it likes."""

    def __init__(self, port: int, name: str = "") -> None:
        self.uuid = name or str(uuid.uuid4())
        self.socket = zmq.Context.instance().socket(zmq.REQ)
        for option in (zmq.RCVTIMEO, zmq.SNDTIMEO):
            self.socket.setsockopt(option, 10_000)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.connect(f"tcp://127.0.0.1:{port}")

    def send(self, function: str, *arguments: Any) -> None:
        self.socket.send(cbor2.dumps({"func": function, "args": list(arguments), "uuid": self.uuid}))

    def ask(self, function: str, *arguments: Any) -> Any:
        """Return the answer. Raises zmq.ZMQError: there is none."""
        self.send(function, *arguments)
        return cbor2.loads(self.socket.recv())

    def close(self) -> None:
        self.socket.close()


def _connected(port: int) -> socket.socket:
    connected = socket.create_connection(("127.0.0.1", port), 5.0)
    connected.settimeout(1.0)
    return connected


def _session(port: int) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{port}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def unfinished(gateways: Gateways, chance: Random, end: float) -> None:
    """Messages of which the last bytes never come, at each gateway, by many connections."""
    zmtp = GREETING + READY.replace(b"ROUTER", b"DEALER") + b"\x01\x00\x02" + (64 << 20).to_bytes(8, "big")
    with _session(gateways.zenoh) as stranger:
        while time.monotonic() < end:
            with contextlib.ExitStack() as stack:
                for _ in range(12):
                    for port, opening in ((gateways.zmq, zmtp), (gateways.legacy, b"")):
                        with contextlib.suppress(OSError):
                            peer = stack.enter_context(_connected(port))
                            peer.sendall(opening)
                            for left in range(LARGE // 60_000):
                                head = struct.pack("<HHH", 1, 60_000, 20_000 - left) if not opening else b""
                                peer.sendall(head + bytes(60_000))
                stranger.put(
                    f"simx/simx-{gateways.zenoh}/call/stranger", bytes(chance.choice((100, 200, 600)) << 20)
                )
                time.sleep(HELD * chance.random())


def silent(gateways: Gateways, chance: Random, end: float) -> None:
    """More connections than there are places, which say nothing, half a greeting, or one call."""
    while time.monotonic() < end:
        with contextlib.ExitStack() as stack:
            for _ in range(1100):
                with contextlib.suppress(OSError):
                    peer = stack.enter_context(_connected(gateways.zmq))
                    peer.sendall(GREETING[: chance.choice((0, 5, len(GREETING)))])
            for _ in range(300):
                with contextlib.suppress(OSError):
                    stack.enter_context(_connected(gateways.legacy))
            for _ in range(260):
                peer = ZmqPeer(chance.choice((gateways.zmq, gateways.viewers)))
                stack.callback(peer.close)
                peer.send("sim.getSimulationTime")
            time.sleep(HELD)


def names(gateways: Gateways, chance: Random, end: float) -> None:
    """Calls in the names of clients of other gateways, whose names are known."""
    name = f"known-{chance.randrange(1 << 30)}"
    client = ZmqPeer(gateways.zmq, name)
    start = encode(Batch(1, 0, [Call(1, 0, 0, "simxRemoveModel", [1])]))
    realm = f"simx/simx-{gateways.zenoh}"
    with _session(gateways.zenoh) as stranger:
        while time.monotonic() < end:
            with contextlib.suppress(zmq.ZMQError):
                client.ask("sim.getSimulationTime")
            for each in (name, f"zmq-{name}", f"zmq/{name}", f"viewer-zmq/{name}"):
                stranger.put(f"{realm}/call/{each}", start)
                token = stranger.liveliness().declare_token(f"{realm}/client/{each}")
                token.undeclare()
            time.sleep(0.01)


def functions(gateways: Gateways, chance: Random, end: float) -> None:
    """Functions that the server calls and that answer late or never, also of viewers."""
    while time.monotonic() < end:
        client = ZmqPeer(chance.choice((gateways.zmq, gateways.viewers)))
        with contextlib.suppress(zmq.ZMQError):
            if chance.random() < 0.5:
                answer = client.ask("sim.visitTree", -1, "f@func")
            else:
                answer = client.ask("sim.testCB", 1, "f@func", 2, 9999)
            pause = chance.choice((0.0, 0.01, 0.3, 5.0))
            for _ in range(100):
                if "func" not in answer:
                    break
                time.sleep(pause)
                answer = client.ask("_*executed*_", 1)
        client.close()


def frozen(gateways: Gateways, chance: Random, end: float) -> None:
    """Clients that step, start the simulation and are stopped, at each gateway."""
    while time.monotonic() < end:
        gateway = chance.choice(("zmq", "zenoh", "lane"))
        environment = {**os.environ, "SIMX_LOCAL": "1" if gateway == "lane" else "0"}
        words = [sys.executable, Path(__file__), gateway, str(gateways)]
        with subprocess.Popen(words, env=environment) as child:
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(HELD * 1.5)
            child.kill()


def _freeze(gateway: str, gateways: Gateways) -> None:
    if gateway == "zmq":
        client = ZmqPeer(gateways.zmq)
        client.ask("sim.setStepping", True)
        client.ask("sim.startSimulation")
    else:
        number = v.simxStart("127.0.0.1", gateways.zenoh, True, True, 3000, 5)
        v.simxSynchronous(number, True)
        v.simxStartSimulation(number, BLOCKING)
    os.kill(os.getpid(), signal.SIGSTOP)


if __name__ == "__main__":
    _freeze(sys.argv[1], Gateways.of(sys.argv[2]))
