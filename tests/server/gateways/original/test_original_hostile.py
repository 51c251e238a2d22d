"""Peers that break the rules of the original's protocol are cut or get errors, and harm no other client."""

from __future__ import annotations

import random
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
from fuzz import originals
from original_peer import (
    BLOCKING,
    COMMAND,
    MESSAGE,
    ONESHOT,
    ONESHOT_SPLIT,
    STREAMING,
    Peer,
    Served,
    command,
    ints,
    message,
    packed,
    peer,
    served,
    text,
)
from processes import wait_until

from simx_server.gateways.original import connection, packets
from simx_server.gateways.original.forms import Reader, Unreadable
from simx_server.gateways.original.forms import read as read_form
from simx_server.gateways.original.messages import Malformed
from simx_server.gateways.original.messages import read as read_message
from simx_server.gateways.original.translation import WIRES, translate

pytestmark = [pytest.mark.slow, pytest.mark.gl]

SCENE = Path(__file__).parents[3] / "conformance" / "scene.xml"
HEADER = struct.pack(MESSAGE, 0, 11, 0, 0, 0, 0, 0)
PING = command(0x1021, ints(1))


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Served]:
    with served(SCENE, tmp_path) as server:
        yield server


@pytest.fixture
def bystander(server: Served) -> Iterator[Peer]:
    """A client that must be served as before, whatever the others do."""
    with peer(server.port) as client:
        client.exchange()
        yield client
        assert not client.call(0x1021, ints(1)).has_failed
        assert client.seen[-1].payload != b""


def raw_command(
    size: int, full: int, cmd: int = 0x1021 | BLOCKING, offset: int = 0, body: bytes = b""
) -> bytes:
    return struct.pack(COMMAND, size, full, 4, offset, cmd, 0, 0, 0, 0) + body


WRONG = {
    "another program": b"GET / HTTP/1.1\r\n\r\n",
    "big-endian": struct.pack(">HHH", 1, 18, 0) + HEADER,
    "an empty packet": struct.pack("<HHH", 1, 0, 0),
    "a wrong countdown": struct.pack("<HHH", 1, 18, 2) + HEADER + struct.pack("<HHH", 1, 18, 0) + HEADER,
    "less than a header": packed(b"short"),
    "a command without its end": packed(HEADER + b"\0" * 10),
    "a command of no size": packed(HEADER + raw_command(0, 0)),
    "a command of a negative size": packed(HEADER + raw_command(-30, -30)),
    "a command longer than its message": packed(HEADER + raw_command(1000, 1000)),
    "a piece of less than itself": packed(HEADER + raw_command(30, 29, body=ints(1))),
    "a piece at a negative offset": packed(HEADER + raw_command(30, 60, offset=-1, body=ints(1))),
    "less than its identification": packed(HEADER + raw_command(28, 28, body=b"ab")),
    "a text without its end": packed(HEADER + raw_command(29, 29, 0x3001, body=b"abc")),
    "a second text without its end": packed(HEADER + raw_command(33, 33, 0x3401, body=ints(1) + b"a\0b")),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_peer_with_wrong_bytes_is_cut(server: Served, bystander: Peer, name: str) -> None:
    with server.connect() as connected:
        connected.sendall(WRONG[name])
        assert Peer(connected).is_cut()


def test_endless_messages_are_cut_at_the_limit(
    server: Served, bystander: Peer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        connection, "read_message", lambda receive, _: packets.read_message(receive, 1_000_000)
    )
    packet = bytes(30_000)
    with server.connect() as connected:
        try:
            for left in range(0xFFFF, 0, -1):
                connected.sendall(struct.pack("<HHH", 1, len(packet), left) + packet)
        except OSError:
            return  # cut while it still sends
        pytest.fail("65,535 packets were accepted")


def test_a_silent_client_and_one_that_stops_within_a_message_are_dropped(
    server: Served, bystander: Peer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "STALL", 0.05)
    with server.connect() as connected:
        connected.sendall(struct.pack("<HHH", 1, 18, 0) + HEADER[:5])
        assert Peer(connected).is_cut()
    monkeypatch.setattr(connection, "SILENCE", 0.05)
    with server.connect() as connected:
        assert Peer(connected).is_cut()
    monkeypatch.undo()


def test_a_silent_client_loses_its_stepping_before_it_is_dropped(
    server: Served, bystander: Peer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "FROZEN", 0.05)
    with peer(server.port) as client:
        assert not client.call(0x0001).has_failed
        (stepper,) = [
            each for each in server.world.loop.service.clients.sessions.values() if each.is_stepping
        ]
        assert wait_until(lambda: not stepper.is_stepping, 20)
        assert "nothing was heard of it" in stepper.lost_stepping
        assert client.call(0x0003).has_failed
        assert client.call(0x1021, ints(1)).payload, "it is still connected"
    monkeypatch.undo()


def test_a_client_that_does_not_read_its_answers_is_dropped(
    server: Served, bystander: Peer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "STALL", 0.1)
    assert not bystander.call(0x3015, text("s"), bytes(8_000_000)).has_failed
    with server.connect() as connected:
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connected.sendall(packed(message(0, command(0x3012, text("s")))) + packed(message(1)))
        assert wait_until(lambda: len(server.world.loop.service.clients.sessions) == 1, 20)
    monkeypatch.undo()


def test_a_client_that_has_said_nothing_is_no_client(server: Served, bystander: Peer) -> None:
    with server.connect():
        bystander.exchange()
        assert len(server.world.loop.service.clients.sessions) == 1


def test_so_many_streams_are_refused_and_the_others_go_on(server: Served, bystander: Peer) -> None:
    most = 1000
    server.world.simulation.limits = type(server.world.simulation.limits).of((f"streams={most}",))
    with peer(server.port) as client:
        for first in range(0, most + 100, 100):
            client.exchange(*(command(0x200B, ints(first + each, 0), mode=STREAMING) for each in range(100)))
        assert not client.call(0x1021, ints(1)).has_failed
        assert any(each.has_failed for each in client.seen)
        (_, session) = server.world.loop.service.clients.sessions.values()
        assert len(session.streams.by_id) <= most


def test_a_flood_of_commands_of_one_message_is_cut(server: Served, bystander: Peer) -> None:
    flood = command(0x3008, text(""), b"", ONESHOT, keeps_equal=True)
    with server.connect() as connected:
        connected.sendall(packed(message(0, *[flood] * (server.world.simulation.limits.calls + 1))))
        assert Peer(connected).is_cut()


def test_many_commands_without_a_pause_are_all_executed(server: Served, bystander: Peer) -> None:
    with peer(server.port) as client:
        for _ in range(5):
            client.exchange(*[command(0x3016, text("s"), b"x" * 10, ONESHOT, keeps_equal=True)] * 500)
        assert client.call(0x3012, text("s")).payload == b"x" * 25_000


def test_pieces_that_are_never_complete_are_forgotten(server: Served, bystander: Peer) -> None:
    with peer(server.port) as client:
        for each in range(40):
            part = command(0x3015, text(f"s{each}"), bytes(500_000), ONESHOT_SPLIT, full=0x7FFF0000)
            client.exchange(part)
        assert not client.call(0x1021, ints(1)).has_failed


def test_more_clients_than_allowed_are_refused(server: Served, bystander: Peer) -> None:
    limits = server.world.simulation.limits
    server.world.simulation.limits = type(limits).of(("clients=2",))
    with peer(server.port) as client:
        assert not client.call(0x1021, ints(1)).has_failed
        with server.connect() as connected:
            connected.sendall(packed(message(0)))
            assert Peer(connected).is_cut()


def test_a_client_that_is_cut_within_a_call_leaves_nothing(server: Served, bystander: Peer) -> None:
    with server.connect() as connected:
        connected.sendall(packed(message(0, command(0x0001), command(0x1007, ints(0)))))
        Peer(connected).read()
        connected.sendall(packed(message(1, command(0x0003))))
    assert wait_until(lambda: len(server.world.loop.service.clients.sessions) == 1, 20)
    bystander.call(0x1007, ints(2))


def test_hostile_originals_disturb_no_client(tmp_path: Path) -> None:
    """More of them by ``python tests/fuzz/run.py originals CASES``."""
    originals.run(60, 1, tmp_path)


def test_garbage_of_every_kind_is_an_error_or_a_cut() -> None:
    """The parsers alone, with many cases; seeds make a failure repeatable."""
    for seed in range(3000):
        chance = random.Random(seed)
        id = chance.choice([id for id, _ in WIRES])
        body = chance.randbytes(chance.randrange(60))
        if chance.random() < 0.7:
            body = ints(1) + text("a") + text("b") + body if id == 0x3401 else text("a") + body
        data = HEADER + command(id, b"", body, chance.choice([ONESHOT, BLOCKING, ONESHOT_SPLIT]))
        try:
            for request in read_message(data, 100).requests:
                translated = translate(request)
                assert isinstance(translated.arguments, list)
        except Malformed:
            pass


@pytest.mark.parametrize("form", ["i", "b", "f", "z", "3f", "12f", "2i?", "6f?", "lists", "colour"])
def test_a_form_that_lacks_bytes_is_unreadable(form: str) -> None:
    with pytest.raises(Unreadable):
        read_form(Reader(b""), form)
