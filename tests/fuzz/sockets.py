"""Hostile connections at the socket of the lane of a server of this process, while a client makes its calls."""

from __future__ import annotations

import contextlib
import random
import socket
import struct
import threading
from collections.abc import Callable
from pathlib import Path

from real_world import RealWorld

from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.lane.frames import MESSAGE, Frames, frame, memory_frame
from simx_client.protocol.lane.offer import read_offer
from simx_client.protocol.messages import Batch, Call, Operation
from simx_server.gateways.lane.gateway import LaneGateway
from simx_server.service.answers.link import PackingLink

from .scene import SCENE

WAIT = 5.0
"""Seconds for an answer to a client that breaks no rules."""

LENGTHS = (0, 1, 4, 5, 60, 70_000, 1 << 28, (1 << 32) - 1)


class _Zenoh(PackingLink):
    """The link that a client had before."""

    def put_replies(self, payload: bytes) -> None:
        """Do nothing."""

    put_values = put_replies

    def put_image(self, stream_id: int, payload: bytes) -> None:
        """Do nothing."""


class _Victim:
    """A server with the socket, whose loop runs in a thread."""

    def __init__(self, folder: Path) -> None:
        scene = folder / "victim.xml"
        scene.write_text(SCENE)
        self.world = RealWorld(scene, workspace=folder)
        self.gateway = LaneGateway(self.world.loop.service)
        self._thread = threading.Thread(target=self.world.loop.run, daemon=True)
        self._thread.start()

    def token(self, client: str) -> bytes:
        """Let a client join, as the Zenoh gateway does; return its token."""
        loop, offers, came = self.world.loop, list[str](), threading.Event()

        def join() -> None:
            if client not in loop.service.clients.sessions:
                loop.service.clients.join(client, client, 0, self.gateway.invite(client, _Zenoh()))
            offers.append(self.gateway.offer_to(client))  # here, as it may be about to leave
            came.set()

        loop.service.queue.post(join)
        assert came.wait(WAIT)
        offer = read_offer(offers[0])
        assert offer is not None
        return offer.token.encode()

    def connection(self) -> socket.socket:
        connected = socket.socket(socket.AF_UNIX)
        connected.settimeout(WAIT)
        connected.connect(self.gateway.path)
        return connected

    def close(self) -> None:
        self.world.loop.service.ending.request()
        self._thread.join(WAIT)
        self.gateway.close()
        self.world.loop.service.queue.close_sockets()
        self.world.close()


class _Attacker:
    """Bytes of one connection, by chance."""

    def __init__(self, chance: random.Random, token: Callable[[], bytes]) -> None:
        self._chance, self._token = chance, token

    def first(self) -> bytes:
        """Return a token, or another start."""
        match self._chance.randrange(6):
            case 0:
                return frame(self._chance.randbytes(32))
            case 1:
                return self._chance.randbytes(self._chance.randrange(40))
            case 2:
                return frame(self._token()[:-1] + b"?")
            case _:
                return frame(self._token())

    def next(self) -> bytes:
        """Return a frame, which may be wrong at any level."""
        chance = self._chance
        calls = [
            Call(
                chance.randrange(9),
                chance.choice((0, 1, 2, 7)),
                chance.choice((0, 1, -1)),
                name,
                [chance.randrange(99)],
            )
            for name in chance.choices(
                ("simxGetJointPosition", "simxGetObjects", "", "x" * 3000), k=chance.randrange(4)
            )
        ]
        data = bytearray(frame(encode(Batch(chance.randrange(1 << 31), 0, calls))))
        match chance.randrange(6):
            case 0:
                data[:5] = struct.pack(
                    "<IB", chance.choice(LENGTHS), chance.choice((MESSAGE, MESSAGE, 1, 77))
                )
            case 1:
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            case 2:
                del data[chance.randrange(len(data)) :]
            case 3:
                data *= chance.randrange(1, 400)
        return bytes(data)


def run(cases: int, seed: int, folder: Path) -> str:
    """Send this number of frames.

    Returns:
        The counts, for people.
    """
    chance = random.Random(seed)
    victim = _Victim(folder)
    sent = cuts = connections = 0
    try:
        with victim.connection() as bystander:
            bystander.sendall(frame(victim.token("bystander")))
            assert bystander.recv(100) == memory_frame(0)
            while sent < cases:
                connections += 1
                name = f"attacker-{connections % 7}"
                attacker = _Attacker(chance, lambda name=name: victim.token(name))
                with victim.connection() as connected:
                    connected.settimeout(0.05)
                    try:
                        connected.sendall(attacker.first())
                        for _ in range(chance.randrange(60)):
                            sent += 1
                            connected.sendall(attacker.next())
                            if chance.random() < 0.3:
                                with contextlib.suppress(TimeoutError):
                                    connected.recv(1 << 16)
                    except OSError:
                        cuts += 1
                _is_served(bystander, sent)
    finally:
        victim.close()
    return f"{connections} connections, {cuts} were cut"


def _is_served(client: socket.socket, number: int) -> None:
    """Make a call of the client that breaks no rules, and check its answer."""
    call_id = number + 1
    client.sendall(frame(encode(Batch(number, 0, [Call(call_id, Operation.CANCEL, 0, "", [0])]))))
    frames = Frames()
    while not frames.whole:
        data = client.recv(1 << 16)
        assert data, "the bystander lost its connection"
        frames.add(data)
    assert [reply.call_id for reply in decode_delivery(frames.whole[0][1]).replies] == [call_id]
