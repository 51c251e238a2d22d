"""Messages of which the rest never comes: what all gateways together keep of them is bounded in bytes and in time."""

from __future__ import annotations

import gc
import socket
import struct
import weakref
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from loopback import LoopbackTransport
from original_peer import PACKET
from processes import wait_until
from raw_peer import connect
from zmq_world import RawClient, ZmqWorld, zmq_world

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.lane.frames import MESSAGE, frame
from simx_client.protocol.lane.offer import read_offer
from simx_client.protocol.zenoh import keys, link
from simx_server.gateways.lane.gateway import LaneGateway
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.gateways.zmq.wire.zmtp import GREETING, READY
from simx_server.limits import Limits
from simx_server.service.clients.admission.unfinished import Unfinished

TIMEOUT = 20.0
PART = bytes(100_000)
ROOM = Limits(unfinished=250_000)
"""For two such parts."""


class House:
    """A server with the gateways whose sockets it reads itself."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.server: ZmqWorld = stack.enter_context(zmq_world(folder))
        self.loop = self.server.loop
        self.legacy = self.server.on_server(lambda: OriginalGateway(self.loop.service, ["127.0.0.1:0"]))
        stack.callback(lambda: self.server.on_server(self.legacy.close))
        self.local = self.server.on_server(lambda: LaneGateway(self.loop.service))
        stack.callback(lambda: self.server.on_server(self.local.close))
        self.stack = stack

    def begin(self, gateway: str, size: int = 1_000_000) -> socket.socket:
        """Send the first part of a message of this many bytes; return when the server has read it."""
        before = self.loop.service.unfinished.size
        peer = getattr(self, f"_at_{gateway}")(size)
        peer.sendall(PART[:40_000] if gateway == "legacy" else PART)  # there the first packet is sent already
        assert wait_until(lambda: self.loop.service.unfinished.size >= before + len(PART) - 100, TIMEOUT)
        return peer

    def _connected(self, port: int) -> socket.socket:
        return self.stack.enter_context(socket.create_connection(("127.0.0.1", port), TIMEOUT))

    def _at_zmq(self, size: int) -> socket.socket:
        peer = self._connected(self.server.port)
        ready = READY.replace(b"ROUTER", b"DEALER")
        peer.sendall(GREETING + ready + b"\x01\x00\x02" + size.to_bytes(8, "big"))
        return peer

    def _at_legacy(self, size: int) -> socket.socket:
        peer = self._connected(self.legacy.ports[0])
        peer.sendall(struct.pack(PACKET, 1, 60_000, size // 60_000) + PART[:60_000])
        peer.sendall(struct.pack(PACKET, 1, 60_000, size // 60_000 - 1))
        return peer

    def _at_local(self, size: int) -> socket.socket:
        transport = LoopbackTransport(self.loop, turns=False)
        transport.greet(TIMEOUT)

        def offered() -> Any:
            session = self.loop.service.clients.sessions[transport.client]
            session.link = self.local.invite(transport.client, transport)
            return read_offer(self.local.offer_to(transport.client))

        peer = self.stack.enter_context(socket.socket(socket.AF_UNIX))
        peer.settimeout(TIMEOUT)
        peer.connect(self.local.path)
        peer.sendall(frame(self.server.on_server(offered).token.encode()))
        assert peer.recv(100)  # the memory of its values
        peer.sendall(struct.pack("<IB", size, MESSAGE))
        return peer


def is_cut(peer: socket.socket) -> bool:
    """Return whether the server closes a connection."""
    try:
        while peer.recv(1 << 16):
            pass
    except ConnectionResetError:
        pass
    return True


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    with ExitStack() as stack:
        yield House(tmp_path, stack)


GATEWAYS = ("zmq", "legacy", "local")


@pytest.mark.parametrize("gateway", GATEWAYS)
def test_the_message_that_began_first_goes_whatever_the_gateway(house: House, gateway: str) -> None:
    house.server.simulation.limits = Limits(unfinished=1 << 30)
    oldest = house.begin(gateway)
    others = [house.begin(each) for each in GATEWAYS if each != gateway]
    house.server.simulation.limits = Limits(unfinished=310_000)
    others[-1].sendall(PART[:15_000])
    assert is_cut(oldest)
    assert wait_until(lambda: 200_000 <= house.loop.service.unfinished.size <= 310_000, TIMEOUT)
    client = RawClient(house.server.port)
    assert client.ask("sim.setStringSignal", "s", bytes(90_000)) == {"ret": [1]}
    client.close()


@pytest.mark.parametrize("gateway", GATEWAYS)
def test_a_message_has_a_total_time(house: House, gateway: str, monkeypatch: pytest.MonkeyPatch) -> None:
    slow = house.begin(gateway)
    now = house.loop.service.unfinished._clock()
    monkeypatch.setattr(house.loop.service.unfinished, "_clock", lambda: now + Limits().message_seconds + 1)
    assert is_cut(slow)
    assert house.loop.service.unfinished.size == 0


def test_what_is_complete_is_not_counted_and_small_messages_are_not_either() -> None:
    now = [0.0]
    counter = Unfinished(lambda: ROOM, lambda: now[0])
    cut: list[str] = []
    first, second, third = (counter.holder(cut.append) for _ in range(3))
    first.hold(1000)
    assert counter.size == 0
    first.hold(100_000)
    now[0] = 59.0
    second.hold(100_000)
    first.hold(0)
    third.hold(120_000)
    assert (counter.size, cut) == (220_000, [])
    now[0] = 61.0
    second.hold(90_000, is_new=True)  # the message before is complete
    counter.look()
    third.hold(170_000)
    assert "'unfinished'" in cut[0]
    assert (counter.size, third.is_cut, second.is_cut) == (90_000, True, False)
    now[0] = 122.0
    counter.look()
    assert (counter.size, second.is_cut) == (0, True)
    assert "'message_seconds'" in cut[1]


def test_frames_on_the_lane_are_no_larger_than_a_message(house: House) -> None:
    assert is_cut(house._at_local(MAX_BATCH + 1))


def test_memory_comes_back_without_the_collector_of_circles(house: House) -> None:
    gc.collect()
    gc.disable()
    try:
        with house.begin("local"):
            (inside,) = house.local._peers
            assert inside.link is not None
            held = weakref.ref(inside)
            del inside
        assert wait_until(lambda: not house.local._peers, TIMEOUT)
        assert house.server.wait_until(lambda: held() is None)
        with house.begin("zmq"):
            (there,) = house.server.gateway._peers
            held = weakref.ref(there)
            del there
        assert house.server.wait_until(lambda: held() is None)
    finally:
        gc.enable()


def test_a_peer_with_too_large_a_message_is_cut_by_zenoh(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would be kept for strangers too: one gigabyte for each priority, without a maximum."""
    name = "transport/link/rx/max_message_size"
    assert link.SERVER[name] == MAX_BATCH + link.MARGIN
    monkeypatch.setitem(link.SERVER, name, 1_000_000)
    came: list[int] = []
    monkeypatch.setattr(
        house.loop.service.queue, "put", lambda client, payload, size, read: came.append(size) or True
    )
    gateway = ZenohGateway(house.loop.service, ports=[0])
    house.stack.callback(gateway.close)
    gateway._secrets["somebody"] = None
    for size in (3_000_000, 900_000):
        with connect(gateway.ports[0]) as peer:
            peer.put(keys.call(gateway.realm, "somebody"), bytes(size))
    assert wait_until(lambda: came, TIMEOUT)
    assert came == [900_000]
