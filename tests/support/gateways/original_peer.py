"""A client of the original's protocol byte by byte, from the protocol's description and not from the product's code."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from real_world import RealWorld

from simx_client.protocol.messages import Pace
from simx_server.gateways.original.gateway import OriginalGateway

ONESHOT, BLOCKING, STREAMING = 0x00000, 0x10000, 0x20000
ONESHOT_SPLIT, STREAMING_SPLIT, DISCONTINUE = 0x30000, 0x40000, 0x50000
KILL = 0x000A
PACKET, MESSAGE, COMMAND = "<HHH", "<HBiiiHB", "<iiHiiHiBB"
TIMEOUT = 20.0
"""Seconds until a test gives up; far more than an answer takes."""


def text(value: str) -> bytes:
    """A text as it travels."""
    return value.encode() + b"\0"


def ints(*values: int) -> bytes:
    return struct.pack(f"<{len(values)}i", *values)


def floats(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}f", *values)


def command(
    id: int,
    ident: bytes = b"",
    payload: bytes = b"",
    mode: int = BLOCKING,
    low: int = 0,
    *,
    keeps_equal: bool = False,
    full: int | None = None,
    offset: int = 0,
) -> bytes:
    """One command of a message."""
    size = 26 + len(ident) + len(payload)
    full_size = size if full is None else 26 + len(ident) + full
    head = struct.pack(COMMAND, size, full_size, len(ident), offset, id | mode, low, 0, keeps_equal, 0)
    return head + ident + payload


def message(number: int, *commands: bytes, time_ms: int = 1234) -> bytes:
    return struct.pack(MESSAGE, 0, 11, number, time_ms, 0, 0, 0) + b"".join(commands)


def packed(data: bytes, size: int = 1294) -> bytes:
    """A message as packets."""
    parts = [data[at : at + size] for at in range(0, len(data), size)] or [b""]
    return b"".join(
        struct.pack(PACKET, 1, len(part), len(parts) - 1 - at) + part for at, part in enumerate(parts)
    )


@dataclass(frozen=True)
class Reply:
    """One command of an answer."""

    id: int
    mode: int
    payload: bytes
    """Without the identification data of `ident` bytes."""

    ident: bytes
    has_failed: bool
    time_ms: int
    full_size: int
    offset: int
    low: int


@dataclass(frozen=True)
class Answer:
    """One message of the server."""

    number: int
    client_time: int
    state: int
    replies: list[Reply]
    packets: list[int]
    """Bytes of payload of each packet."""


@dataclass
class Peer:
    """One connection."""

    socket: socket.socket
    number: int = 0
    seen: list[Reply] = field(default_factory=list)
    """All replies so far."""

    def _take(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            part = self.socket.recv(size - len(data))
            if not part:
                raise EOFError
            data += part
        return data

    def read(self) -> Answer:
        """The server's next message."""
        data, sizes, left = b"", [], 1
        while left:
            order, size, left = struct.unpack(PACKET, self._take(6))
            assert order == 1
            data += self._take(size)
            sizes.append(size)
        _, version, number, client_time, _, _, state = struct.unpack_from(MESSAGE, data)
        assert version == 11
        replies, at = [], 18
        while at < len(data):
            size, full, ident, offset, cmd, low, time_ms, status, _ = struct.unpack_from(COMMAND, data, at)
            body = data[at + 26 : at + size]
            replies.append(
                Reply(
                    cmd & 0xFFFF,
                    cmd & 0x7FFF0000,
                    body[ident:],
                    body[:ident],
                    bool(status & 1),
                    time_ms,
                    full,
                    offset,
                    low,
                )
            )
            at += size
        assert at == len(data)
        self.seen += replies
        return Answer(number, client_time, state, replies, sizes)

    def exchange(self, *commands: bytes) -> Answer:
        """Send one message and read its answer."""
        self.socket.sendall(packed(message(self.number, *commands)))
        self.number += 1
        return self.read()

    def call(self, id: int, ident: bytes = b"", payload: bytes = b"", **more: bool) -> Reply:
        """Make a blocking call as the original does: poll until a message is as new as the call's."""
        number = self.number
        answer = self.exchange(command(id, ident, payload, **more))
        while not (answer.replies and answer.number >= number):
            answer = self.exchange()
        (reply,) = [each for each in answer.replies if (each.id, each.mode) == (id, BLOCKING)]
        assert reply.ident[: len(ident)] == ident
        return reply

    def until(self, id: int, *commands: bytes, mode: int | None = None) -> Reply:
        """Send commands, and poll until there is a reply to this one, which may come with the first answer."""
        while True:
            answer, commands = self.exchange(*commands), ()
            for reply in answer.replies:
                if reply.id == id and mode in (None, reply.mode):
                    return reply

    def handle(self, name: str) -> int:
        reply = self.call(0x3001, text(name))
        assert not reply.has_failed, name
        return struct.unpack("<i", reply.payload)[0]

    def is_cut(self) -> bool:
        """Whether the server closes the connection; it may send an answer before."""
        try:
            while self.socket.recv(1 << 16):
                pass
        except ConnectionResetError:
            pass
        return True


@contextmanager
def peer(port: int) -> Iterator[Peer]:
    with socket.create_connection(("127.0.0.1", port), TIMEOUT) as connected:
        connected.settimeout(TIMEOUT)
        yield Peer(connected)


@dataclass
class Served:
    """A server in this process, whose loop runs on a thread."""

    world: RealWorld
    gateway: OriginalGateway

    @property
    def port(self) -> int:
        return self.gateway.ports[0]

    def connect(self) -> socket.socket:
        connected = socket.create_connection(("127.0.0.1", self.port), TIMEOUT)
        connected.settimeout(TIMEOUT)
        return connected


@contextmanager
def served(scene: str | Path, workspace: Path | None = None, pace: Pace = Pace.FREE) -> Iterator[Served]:
    """A server in this process with one port for original clients."""
    world = RealWorld(scene, workspace=workspace)
    gateway = OriginalGateway(world.loop.service, ["127.0.0.1:0"], pace)
    thread = threading.Thread(target=world.loop.run, daemon=True)
    thread.start()
    try:
        yield Served(world, gateway)
    finally:
        world.loop.service.ending.request()
        thread.join(TIMEOUT)
        gateway.close()
        world.loop.service.queue.close_sockets()
        world.close()
