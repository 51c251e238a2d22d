"""Messages over Zenoh of which the rest never comes: what many peers hold together is bounded."""

from __future__ import annotations

import contextlib
import logging
import socket
import struct
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh
from processes import wait_until
from raw_peer import connect
from routers import Wire
from zmq_world import ZmqWorld, zmq_world

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.zenoh import connections, keys
from simx_client.protocol.zenoh.connections import Connection, find
from simx_server.gateways.zenoh import held
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.limits import Limits

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Linux counts the bytes of connections")
TIMEOUT = 20.0
PART = 2_000_000
CUT = "the link to 127.0.0.1"


class Place:
    """A server with a Zenoh gateway whose messages are not executed."""

    def __init__(self, folder: Path, stack: ExitStack, monkeypatch: pytest.MonkeyPatch) -> None:
        self.stack = stack
        self.server: ZmqWorld = stack.enter_context(zmq_world(folder))
        self.loop = self.server.loop
        self.came: list[int] = []

        def submit(_client: str, _payload: Any, size: int, _read: Any) -> bool:
            self.came.append(size)
            return True

        monkeypatch.setattr(self.loop.service.queue, "put", submit)
        self.gateway = self.server.on_server(lambda: ZenohGateway(self.loop.service, ports=[0]))
        stack.callback(lambda: self.server.on_server(self.gateway.close))
        self.held = self.gateway._held

    def limit(self, unfinished: int) -> None:
        self.server.simulation.limits = Limits(unfinished=unfinished)

    def key(self, client: str) -> str:
        return keys.call(self.gateway.realm, client)

    def count_twice(self) -> None:
        for _ in range(2):
            last = self.held._last
            assert wait_until(lambda last=last: self.held._last > last, TIMEOUT)

    def begin(self, client: str) -> Any:
        """Have a stranger send the first part of a message; return its session when the part is counted."""
        before = self.loop.service.unfinished.size
        wire = self.stack.enter_context(Wire(self.gateway.ports[0], PART))
        stranger = connect(wire.port)
        self.stack.callback(stranger.close)
        Thread(target=_put, args=(stranger, self.key(client), 2 * PART), daemon=True).start()
        assert wait_until(lambda: self.loop.service.unfinished.size > before + PART // 2, TIMEOUT)
        return stranger

    def come(self, name: str = "") -> tuple[Any, str]:
        """Have a client come that has been greeted; return its session and its key for calls.

        Args:
            name: of a client whose session is not its name, as that of an older version.
        """
        session = self.stack.enter_context(connect(self.gateway.ports[0]))
        client = name or str(session.info.zid())
        self.gateway._secrets[client] = None
        return session, self.key(client)


def _put(session: zenoh.Session, key: str, size: int) -> None:
    with contextlib.suppress(zenoh.ZError):  # closed meanwhile
        session.put(key, bytes(size), congestion_control=zenoh.CongestionControl.BLOCK)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Place]:
    with ExitStack() as stack:
        yield Place(tmp_path, stack, monkeypatch)


def test_the_oldest_message_of_many_peers_goes_when_they_hold_too_much(
    place: Place, caplog: pytest.LogCaptureFixture
) -> None:
    client, key = place.come()
    place.begin("nobody")
    second = place.begin("nobody")
    assert CUT not in caplog.text
    place.limit(PART * 3 // 2)
    with caplog.at_level(logging.WARNING):
        _put(client, key, 100_000)
        assert wait_until(lambda: CUT in caplog.text, TIMEOUT)
    assert caplog.text.count(CUT) == 1
    assert PART // 2 < place.loop.service.unfinished.size < PART * 3 // 2
    assert list(second.info.peers_zid())
    assert place.came == [100_000]


@pytest.mark.parametrize("names", [("", ""), ("", "older"), ("older", "oldest")])
def test_complete_messages_of_clients_do_not_count(
    place: Place, names: tuple[str, str], caplog: pytest.LogCaptureFixture
) -> None:
    place.limit(4 * PART)
    clients = [place.come(name) for name in names]
    for _ in range(40):
        for session, key in clients:
            _put(session, key, PART // 4)
    assert wait_until(lambda: len(place.came) == 80, TIMEOUT)
    place.count_twice()
    assert place.loop.service.unfinished.size == 0
    assert CUT not in caplog.text


def test_messages_of_a_named_client_are_not_credited_to_strangers(place: Place) -> None:
    session, key = place.come()
    _put(session, key, PART)
    assert wait_until(lambda: bool(place.came), TIMEOUT)
    place.count_twice()
    place.begin("nobody")
    before = place.loop.service.unfinished.size
    _put(session, key, PART)
    assert wait_until(lambda: len(place.came) == 2, TIMEOUT)
    place.count_twice()
    assert place.loop.service.unfinished.size > before - PART // 4


def test_sessions_that_declare_while_their_links_are_counted_are_not_blocked(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(held, "PERIOD", 0.0)
    clients = [place.come() for _ in range(3)]

    def declare(session: Any, key: str) -> None:
        for number in range(100):
            place.held.completed(f"of {number}", PART)
            session.declare_subscriber(keys.reply(place.gateway.realm, f"any-{number}"), print).undeclare()
        _put(session, key, 100_000)

    threads = [Thread(target=declare, args=each, daemon=True) for each in clients]
    for thread in threads:
        thread.start()
    assert wait_until(lambda: len(place.came) == len(clients), TIMEOUT)


def test_endpoints_of_zenoh_name_connections() -> None:
    def between(here: str, there: str) -> Connection | None:
        return Connection.of(SimpleNamespace(src=here, dst=there))

    mapped = between("tcp/[::ffff:127.0.0.1]:7447", "tcp/[::ffff:127.0.0.1]:50000")
    assert mapped == Connection(7447, "127.0.0.1", 50000)
    assert between("tls/[fe80::1%2]:7447", "tls/[fe80::2%2]:1") == Connection(7447, "fe80::2", 1)
    assert between("unixsock-stream//tmp/a", "unixsock-stream//tmp/b") is None
    assert mapped is not None
    assert find([mapped]) == {mapped: None}


def test_neither_end_of_a_link_waits_ten_seconds_in_a_thread_of_zenoh_when_it_is_closed(place: Place) -> None:
    def lingers(session: Any) -> list[bool]:
        """Whether the system waits for the other end, for each link of a session."""
        found = []
        for link in session.info.links():
            connection = Connection.of(link)
            assert connection is not None
            with connections._copy(connections._descriptors()[0][connection]) as one:
                option = one.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
                found.append(struct.unpack("ii", option)[0] != 0)
        return found

    stranger = place.come()[0]
    place.count_twice()
    assert lingers(stranger) == [True]  # Zenoh's own choice
    assert lingers(place.gateway._session) == [False]
    client = v.simxStart("127.0.0.1", place.gateway.ports[0], True, True, 5000, 5)
    place.count_twice()
    connection: Any = CLIENTS.get(client)
    transport = connection._transport
    assert lingers(getattr(transport, "zenoh", transport)._session) == [False]
    assert lingers(place.gateway._session) == [False, False]
    v.simxFinish(client)
