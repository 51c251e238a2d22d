"""Silent connections, and clients that only come, keep no other client out."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from original_peer import ints, message, packed, peer
from processes import wait_until
from zmq_world import ZmqWorld, zmq_world

from simx_server.gateways.lane import gateway as local
from simx_server.gateways.lane.gateway import LaneGateway
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.gateways.zmq import clients, gateway
from simx_server.limits import LimitReached, Limits
from simx_server.service.clients.admission.entrance import Entrance
from simx_server.service.clients.admission.places import Places
from simx_server.service.clients.sessions import ClientSession

TIMEOUT = 20.0


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def house(tmp_path: Path, closing: ExitStack) -> ZmqWorld:
    return closing.enter_context(zmq_world(tmp_path))


def is_closed(connected: socket.socket) -> bool:
    try:
        while connected.recv(1 << 16):
            pass
    except ConnectionResetError:
        pass
    return True


def places(count: int, *entrances: Entrance) -> Places:
    sessions = {
        str(n): cast(ClientSession, SimpleNamespace(entrance=each)) for n, each in enumerate(entrances)
    }
    made = Places(lambda: Limits(clients=count), sessions)
    for each in ("a", "b", "c"):
        made.open(each)
    return made


def test_each_gateway_keeps_places_for_itself() -> None:
    full = places(32, *[Entrance("a")] * 28)
    with pytest.raises(
        LimitReached, match="let others of this port leave first, as each other port keeps 2 places"
    ):
        full.check(Entrance("a"))
    full.check(Entrance("b"))
    with pytest.raises(LimitReached, match="each other port keeps"):
        full.check(Entrance())
    places(32, *[Entrance("a")] * 28, *[Entrance("b")] * 3).check(Entrance("c"))
    with pytest.raises(LimitReached, match="at most 32 clients"):
        places(32, *[Entrance("a")] * 28, *[Entrance("b")] * 4).check(Entrance("c"))
    full.close("b")
    full.check(Entrance("a"))
    places(2, Entrance("a")).check(Entrance("a"))


def test_one_other_machine_gets_half_of_the_places() -> None:
    full = places(32, *[Entrance("a", "10.0.0.1")] * 16)
    with pytest.raises(LimitReached, match="your machine"):
        full.check(Entrance("b", "10.0.0.1"))
    full.check(Entrance("b", "10.0.0.2"))
    places(32, *[Entrance("a", "127.0.0.1")] * 16).check(Entrance("a", "127.0.0.1"))


def test_a_gateway_full_of_clients_does_not_close_the_others(house: ZmqWorld, closing: ExitStack) -> None:
    legacy = house.on_server(lambda: OriginalGateway(house.loop, ["127.0.0.1:0"]))
    closing.callback(lambda: house.on_server(legacy.close))
    house.simulation.limits = Limits(clients=32)
    crowd = Entrance(house.gateway.endpoints[0])

    def fill() -> None:
        for number in range(30):
            house.loop.clients.join(
                f"zmq/{number}", "one of many", house.port, cast(Any, NoLink()), entrance=crowd
            )

    house.on_server(fill)
    assert "each other port keeps 2 places" in house.raw().ask("sim.getSimulationTime")["err"]
    with peer(legacy.ports[0]) as original:
        assert not original.call(0x1021, ints(1)).has_failed


class NoLink:
    def close(self) -> None: ...


def test_the_longest_connection_without_a_client_gives_its_place(
    house: ZmqWorld, closing: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gateway, "MOST_CONNECTIONS", 4)
    present = house.sim()
    silent = [
        closing.enter_context(socket.create_connection(("127.0.0.1", house.port), TIMEOUT)) for _ in range(9)
    ]
    assert house.sim().getObject("/box") >= 0
    assert all(map(is_closed, silent[:7]))
    assert present.getObject("/box") >= 0


def test_a_client_with_many_idle_connections_gives_one(
    house: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gateway, "MOST_CONNECTIONS", 3)
    several = [house.raw() for _ in range(3)]
    for each in several:
        each.uuid = "one-client"
        assert "ret" in each.ask("sim.getSimulationTime")
    assert house.sim().getObject("/box") >= 0
    assert "ret" in several[2].ask("sim.getSimulationTime")


def test_connections_of_one_other_machine_are_counted(
    house: ZmqWorld, closing: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gateway, "MOST_OF_ONE", 2)
    monkeypatch.setattr(gateway, "is_elsewhere", lambda address: address == "127.0.0.1")
    silent = [
        closing.enter_context(socket.create_connection(("127.0.0.1", house.port), TIMEOUT)) for _ in range(3)
    ]
    assert is_closed(silent[0])


def test_clients_with_one_call_that_read_give_their_places(
    house: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clients, "ONE_CALL", -1.0)
    house.simulation.limits = Limits(clients=4)
    crowd = [house.raw() for _ in range(4)]
    for each in crowd:
        assert "ret" in each.ask("sim.getSimulationTime")
    stays = crowd[0]
    assert "ret" in stays.ask("sim.getSimulationTime")
    newcomer = house.raw()
    for _ in range(100):
        answer = newcomer.ask("sim.getSimulationTime")
        if answer.get("func") != "_*repeat*_":
            break
    assert "ret" in answer
    names = house.on_server(lambda: set(house.loop.sessions))
    assert names == {f"zmq/{each.uuid}" for each in (stays, *crowd[2:], newcomer)}
    for each in (stays, crowd[2]):
        each.ask("sim.setInt32Signal", "s", 1)
    for each in (newcomer, crowd[3]):
        each.ask("sim.getSimulationTime")
    assert "limit 'clients'" in house.raw().ask("sim.getSimulationTime")["err"]


def test_silent_connections_give_way_to_originals(house: ZmqWorld, closing: ExitStack) -> None:
    legacy = house.on_server(lambda: OriginalGateway(house.loop, ["127.0.0.1:0"]))
    closing.callback(lambda: house.on_server(legacy.close))
    house.simulation.limits = Limits(clients=3)
    silent = [
        closing.enter_context(socket.create_connection(("127.0.0.1", legacy.ports[0]), TIMEOUT))
        for _ in range(5)
    ]
    with peer(legacy.ports[0]) as original:
        original.socket.sendall(packed(message(0)))
        original.read()
    assert all(map(is_closed, silent[:3]))


def test_strangers_at_the_lane_give_way(
    house: ZmqWorld, closing: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(local, "MOST_STRANGERS", 2)
    lane = house.on_server(lambda: LaneGateway(house.loop))
    closing.callback(lambda: house.on_server(lane.close))
    strangers = [closing.enter_context(socket.socket(socket.AF_UNIX)) for _ in range(4)]
    for each in strangers:
        each.settimeout(TIMEOUT)
        each.connect(lane.path)
    assert all(map(is_closed, strangers[:2]))
    assert wait_until(lambda: len(lane._peers) == 2, TIMEOUT)
