"""Hostile clients of the original's protocol at a server of this process, while another client makes its calls."""

from __future__ import annotations

import contextlib
import random
import struct
from pathlib import Path

from original_peer import Peer, command, ints, message, packed, peer, served, text

from simx_server.gateways.original.translation import WIRES

from .scene import SCENE

IDS = (*sorted({id for id, _ in WIRES}), 0x000A, 0x0007, 0x1030, 0x3900, 0x7FFF, 0xFFFF)
MODES = (0x00000, 0x10000, 0x10000, 0x20000, 0x30000, 0x40000, 0x50000, 0x60000, 0x90000)
NAMES = (
    "base",
    "hinge",
    "arm",
    "eye",
    "some",
    "returns",
    "fails",
    "",
    "x" * 3000,
    "REMOTE_API_TEMPFILE_1.xml",
)
ODD = (0, 1, -1, -2, -11, 5, 20, 0x7FFFFFFF, -0x80000000, 0x400000, 98765)
WAIT = 0.5
"""Seconds to wait for an answer: the server waits for the rest of a message that is not complete."""


class Attacker:
    """What one connection sends, by chance."""

    def __init__(self, chance: random.Random) -> None:
        self._chance = chance

    def message(self, number: int) -> bytes:
        """A message as packets, which may be wrong at any level."""
        chance = self._chance
        data = bytearray(message(number, *(self._command() for _ in range(chance.choice((0, 1, 1, 2, 5))))))
        for _ in range(chance.choice((0, 0, 0, 1, 3))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        if chance.random() < 0.05:
            data += chance.randbytes(chance.randrange(40))
        sent = bytearray(packed(bytes(data), chance.choice((7, 1294, 1294, 65_000))))
        if chance.random() < 0.05:
            sent[chance.randrange(6)] ^= 1 << chance.randrange(8)
        return bytes(sent)

    def _command(self) -> bytes:
        chance = self._chance
        id = chance.choice(IDS)
        payload = self._payload()
        full = chance.choice((None, None, None, len(payload) + chance.choice((-1, 0, 10, 5000, 0x7FFF0000))))
        return command(
            id,
            self._ident(id),
            payload,
            chance.choice(MODES),
            chance.choice((0, 1, 50, 65_535)),
            keeps_equal=chance.random() < 0.2,
            full=full,
            offset=chance.choice((0, 0, 0, 5, len(payload), 0x7FFFFFFF)) if full else 0,
        )

    def _ident(self, id: int) -> bytes:
        chance = self._chance
        if id < 0x1000:
            return b""
        if id < 0x3000:
            return ints(*(self._number() for _ in range(id >> 12)))
        names = [text(chance.choice(NAMES)) for _ in range(2 if id == 0x3401 else 1)]
        return (ints(1) if id == 0x3401 else b"") + b"".join(names)

    def _number(self) -> int:
        return self._chance.choice((*ODD, self._chance.randrange(40)))

    def _payload(self) -> bytes:
        chance = self._chance
        match chance.randrange(5):
            case 0:
                return b""
            case 1:
                return ints(*(self._number() for _ in range(chance.randrange(8))))
            case 2:
                return struct.pack(
                    "<4f", *(chance.choice((0.0, 1.0, -10.0, 1e38, float("nan"))) for _ in range(4))
                )
            case 3:
                return text(chance.choice(NAMES)) * chance.randrange(3)
            case _:
                return chance.randbytes(chance.choice((1, 29, 300)))


def run(cases: int, seed: int, folder: Path) -> str:
    """Send this number of messages.

    Returns:
        What was seen, for people.
    """
    chance = random.Random(seed)
    scene = folder / "victim.xml"
    scene.write_text(SCENE)
    cuts = 0
    with served(scene, folder) as server, peer(server.port) as bystander:
        sent = 0
        while sent < cases:
            with peer(server.port) as attacker:
                made = Attacker(chance)
                attacker.socket.settimeout(WAIT)
                with contextlib.suppress(EOFError, ConnectionError, TimeoutError):
                    for number in range(50):
                        sent += 1
                        attacker.socket.sendall(made.message(number))
                        attacker.read()
                        if sent % 10 == 0:
                            _is_served(bystander)
                    continue
                cuts += 1
            _is_served(bystander)
        return f"{cuts} connections were cut"


def _is_served(client: Peer) -> None:
    client.seen.clear()
    assert not client.call(0x1021, ints(1)).has_failed
