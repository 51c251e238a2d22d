"""No program calls in the name of a client of another gateway, also when its name is known."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from original_peer import ints, peer
from raw_peer import connect
from zmq_world import RawClient, cbor2, zmq_world

from simx_client.protocol.codec import encode
from simx_client.protocol.messages import OLDEST_PROTOCOL, PROTOCOL_VERSION, Batch, Call, Greeting
from simx_client.protocol.zenoh import keys
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.gateways.ros2.client import Ros2Client
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.gateways.zmq.gateway import ZmqGateway

TIMEOUT = 20.0
GATEWAYS = ("zenoh", "zenoh of a script", "zmq", "zmq of viewers", "legacy", "ros2")
START = encode(Batch(1, 0, [Call(1, 0, 0, "simxStartSimulation", [])]))


class House:
    """A server with all gateways, and a client at each of them."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.server = stack.enter_context(zmq_world(folder))
        loop = self.loop = self.server.loop
        self.zenoh = {name: ZenohGateway(loop, ports=[0]) for name in GATEWAYS[:2]}
        viewers = self.server.on_server(lambda: ZmqGateway(loop, "127.0.0.1:0", may_only_read=True))
        legacy = OriginalGateway(loop, ["127.0.0.1:0"])
        self.zmq = {"zmq": self.server.port, "zmq of viewers": viewers.port}
        for gateway in (*self.zenoh.values(), legacy):
            stack.callback(gateway.close)
        stack.callback(lambda: self.server.on_server(viewers.close))
        self.names: dict[str, str] = {}
        """Names of the clients by gateway."""

        for at, gateway in self.zenoh.items():
            session = stack.enter_context(connect(gateway.ports[0]))
            token = session.liveliness().declare_token(keys.client(gateway.realm, f"of-{len(self.names)}"))
            stack.callback(token.undeclare)
            greet(session, gateway, f"of-{len(self.names)}", b"secret")
            self._note(at)
        for at, port in self.zmq.items():
            client = RawClient(port)
            stack.callback(client.close)
            assert client.ask("sim.getSimulationTime") == {"ret": [0.0]}
            self._note(at)
        original = stack.enter_context(peer(legacy.ports[0]))
        original.call(0x1021, ints(1))
        self._note("legacy")
        node = self.server.on_server(lambda: Ros2Client(loop, "ros2 /simx", 0))
        stack.callback(lambda: self.server.on_server(node.leave))
        self._note("ros2")
        self.sessions = dict(loop.sessions)

    def _note(self, at: str) -> None:
        (self.names[at],) = set(self.loop.sessions) - set(self.names.values())


def greet(session: Any, gateway: ZenohGateway, name: str, secret: bytes | None) -> list[Any]:
    greeting = encode(Greeting(OLDEST_PROTOCOL, name, name, gateway.ports[0], PROTOCOL_VERSION))
    for _ in range(100):  # the server may see the token later than the greeting
        found = list(
            session.get(keys.hello(gateway.realm), payload=greeting, attachment=secret, timeout=TIMEOUT)
        )
        if found:
            return found
    raise AssertionError("the server does not answer a greeting")


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    with ExitStack() as stack:
        yield House(tmp_path_factory.mktemp("house"), stack)


@pytest.mark.parametrize("by", ["zenoh", "zenoh of a script"])
@pytest.mark.parametrize("at", GATEWAYS)
def test_over_zenoh(house: House, at: str, by: str) -> None:
    gateway, name = house.zenoh[by], house.names[at]
    with connect(gateway.ports[0]) as impostor:
        for secret in (None, b"", b"another"):
            impostor.put(keys.call(gateway.realm, name), START, attachment=secret)
        if "/" not in name:  # otherwise it has no name in a greeting
            token = impostor.liveliness().declare_token(keys.client(gateway.realm, name))
            for secret in (None, b"another"):
                (refusal,) = greet(impostor, gateway, name, secret)
                assert b"another client is called" in refusal.ok.payload.to_bytes()
            impostor.put(keys.call(gateway.realm, name), START)
            token.undeclare()
        assert list(impostor.get(keys.status(gateway.realm), timeout=TIMEOUT))  # all before has arrived
    unharmed(house)


@pytest.mark.parametrize(
    ("by", "at"),
    [(by, at) for by in ("zmq", "zmq of viewers") for at in GATEWAYS if at != by],
)
def test_over_zeromq(house: House, at: str, by: str) -> None:
    """At one gateway the identity is all that this protocol has, and the connections of a client share it."""
    for name in {house.names[at], house.names[at].rpartition("/")[2]}:
        impostor = RawClient(house.zmq[by])
        impostor.uuid = name
        before = set(house.loop.sessions)
        answer = impostor.ask_bytes(cbor2.dumps({"func": "sim.getSimulationTime", "args": [], "uuid": name}))
        assert "uuid must be" in str(answer) or len(set(house.loop.sessions) - before) == 1
        impostor.close()
        assert house.server.wait_until(lambda: len(house.loop.sessions) == len(GATEWAYS))
    unharmed(house)


def unharmed(house: House) -> None:
    """Each client has its session, and nothing was executed."""
    assert house.server.on_server(lambda: dict(house.loop.sessions)) == house.sessions
    assert house.server.on_server(lambda: house.server.simulation.state.value) == "stopped"
