"""The router of a fleet: what it lets pass, and connections that say nothing."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh
from processes import server, wait_until
from raw_peer import connect
from routers import free_port, silent
from zmq_world import zmq_world

import simx_client as v
from simx_client.connection.discovery import find_servers
from simx_client.fleet.router import Router
from simx_server.gateways.zenoh.gateway import ZenohGateway

pytestmark = pytest.mark.slow

TIMEOUT = 20.0
SCENE = "<mujoco><worldbody><body name='ball'><geom size='.1'/></body></worldbody></mujoco>"


@pytest.fixture
def port() -> Iterator[int]:
    port = free_port()
    router = Router(f"tcp/127.0.0.1:{port}")
    yield port
    router.end()


def test_servers_and_clients_meet_there(port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scene.xml").write_text(SCENE)
    endpoint = f"tcp/127.0.0.1:{port}"
    with server(tmp_path / "scene.xml", "--connect", endpoint, "--realm", "north", "--no-local"):
        assert [found.realm for found in find_servers([endpoint])[0]] == ["north"]
        monkeypatch.setenv("SIMX_CONNECT", endpoint)
        monkeypatch.setenv("SIMX_REALM", "north")
        client = v.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
        assert v.simxGetObjectHandle(client, "ball", v.simx_opmode_blocking)[0] == 0
        v.simxFinish(client)


class _DeclaresLate(ZenohGateway):
    """Declares itself when its link to the router is there, as on a busy machine."""

    def _declare(self) -> None:
        assert wait_until(lambda: bool(self._session.info.routers_zid()), TIMEOUT)
        super()._declare()


def test_a_server_that_comes_back_knows_clients_that_have_waited_for_it(port: int, tmp_path: Path) -> None:
    with zmq_world(tmp_path) as world:

        def come() -> _DeclaresLate:
            return _DeclaresLate(
                world.loop.service, ports=[0], connect=[f"tcp/127.0.0.1:{port}"], realm="north"
            )

        gateway = world.on_server(come)
        client = v.simxStart("north@127.0.0.1", port, True, False, 5000, 5)
        assert v.simxGetPingTime(client)[0] == v.simx_return_ok
        world.on_server(gateway.leave)
        assert wait_until(lambda: v.simxGetConnectionId(client) == -1, TIMEOUT)
        gateway = world.on_server(come)
        assert wait_until(lambda: v.simxGetPingTime(client)[0] == v.simx_return_ok, TIMEOUT)
        v.simxFinish(client)
        world.on_server(gateway.close)


def test_what_is_of_no_simulator_does_not_pass(port: int) -> None:
    heard: list[str] = []
    has_come = threading.Event()

    def hear(sample: zenoh.Sample) -> None:
        heard.append(str(sample.key_expr))
        if heard[-1] == "simx/north/call/own":
            has_come.set()

    with connect(port, "client") as listener, connect(port, "client") as sender:
        kept = [
            listener.declare_subscriber(key, hear)
            for key in ("**", "simx/**", "other/key", "simx/north/call/own")
        ]
        while not has_come.wait(0.05):  # the last one arrives, so the others would have too
            for key in ("other/key", "simx/north/call/another", "simx/north/call/own"):
                sender.put(key, b"x")
        assert set(heard) == {"simx/north/call/own"}
        (zid,) = sender.info.routers_zid()
        assert not [reply for reply in sender.get(f"@/{zid}/**", timeout=1.0) if reply.ok is not None]
        assert len(kept) == 4


def test_connections_that_say_nothing_lock_nobody_out(port: int) -> None:
    with silent(port, 300):
        for _ in range(3):
            with connect(port, "client") as session:
                assert isinstance(session, zenoh.Session)
