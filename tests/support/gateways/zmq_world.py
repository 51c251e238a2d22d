"""A server on a thread of the test's process, with the gateway of the ZeroMQ remote API on a free port."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from real_world import RealWorld

from simx_client.protocol.cli.installing import extra_line, line

zmq = pytest.importorskip("zmq", reason=line(["pyzmq"]))
cbor2 = pytest.importorskip("cbor2", reason=extra_line("zmq"))
INSTALL = line(["coppeliasim-zmqremoteapi-client==2.0.4"])

from simx_server.gateways.zmq.gateway import ZmqGateway  # noqa: E402  # after the packages that it needs

TIMEOUT = 20_000
"""Milliseconds until an answer that does not come fails the test."""

SCENE = """
<mujoco>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
    <body name="box" pos="1 0 0.5"><freejoint/><geom name="cuboid" type="box" size="0.1 0.1 0.1"/></body>
    <site name="nose" pos="0 0 3"/>
    <body name="shelf" pos="3 0 0.5"><geom type="box" size="0.1 0.1 0.1"/><site name="shelfScript" group="5"/></body>
  </worldbody>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
  <custom>
    <text name="simx:proximity:nose" data="range=0.5"/>
    <text name="simx:object:shelfScript" data="type=script"/>
    <text name="simx:lua:customization:shelfScript" data="function where() return 'shelf' end"/>
    <text name="simx:lua:arm" data="function double(x) return 2 * x end function say() return 'text', '\\0\\1' end"/>
  </custom>
</mujoco>
"""


class RawClient:
    """A peer that sends what it likes."""

    def __init__(self, port: int, kind: int = zmq.REQ) -> None:
        self.context = zmq.Context()
        self.socket = self.context.socket(kind)
        self.socket.setsockopt(zmq.RCVTIMEO, TIMEOUT)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.connect(f"tcp://127.0.0.1:{port}")
        self.uuid = str(uuid.uuid4())

    def ask(self, function: Any, *arguments: Any, **more: Any) -> Any:
        """Send a call and return the answer, whatever it is."""
        self.send(function, *arguments, **more)
        return self.answer()

    def answer(self) -> Any:
        return cbor2.loads(self.socket.recv())

    def send(self, function: Any, *arguments: Any, **more: Any) -> None:
        message = {"func": function, "args": list(arguments), "argsL": len(arguments), "uuid": self.uuid}
        self.socket.send(cbor2.dumps(message | more))

    def ask_bytes(self, payload: bytes) -> Any:
        self.socket.send(payload)
        return cbor2.loads(self.socket.recv())

    def close(self) -> None:
        self.context.destroy(linger=0)


class ZmqWorld:
    """The server, its gateway, and its clients."""

    gateway_class: type[ZmqGateway] = ZmqGateway

    def __init__(self, world: RealWorld) -> None:
        self.world = world
        self.loop, self.simulation = self.world.loop, self.world.simulation
        self.gateway = self.gateway_class(self.loop.service, "127.0.0.1:0")
        self.port = self.gateway.port
        self._clients: list[Any] = []
        self._thread = threading.Thread(target=self.loop.run, name="test-server")
        self._thread.start()

    def client(self) -> Any:
        """Return an official client."""
        package = pytest.importorskip("coppeliasim_zmqremoteapi_client", reason=INSTALL)
        client = package.RemoteAPIClient(port=self.port)
        client.socket.setsockopt(zmq.RCVTIMEO, TIMEOUT)
        self._clients.append(client)
        return client

    def sim(self) -> Any:
        """Return ``sim`` of a new official client."""
        return self.client().require("sim")

    def raw(self, kind: int = zmq.REQ) -> RawClient:
        client = RawClient(self.port, kind)
        self._clients.append(client)
        return client

    def on_server(self, question: Any) -> Any:
        """Return what a function returns on the server's thread."""
        answers: list[Any] = []
        done = threading.Event()

        def ask() -> None:
            answers.append(question())
            done.set()

        self.loop.service.queue.post(ask)
        assert done.wait(TIMEOUT / 1000)
        return answers[0]

    def wait_until(self, condition: Any) -> bool:
        """Return whether a condition comes true on the server's thread; each look follows a turn of its loop."""
        return any(self.on_server(condition) for _ in range(20_000))

    def close_clients(self) -> None:
        for client in self._clients:
            client.context.destroy(linger=0)
        self._clients.clear()

    def close(self) -> None:
        self.loop.service.ending.request()
        self._thread.join(20)
        self.gateway.close()
        self.loop.service.queue.close_sockets()
        self.close_clients()
        self.world.close()


@contextmanager
def zmq_world(folder: Path, *, scene: str = SCENE, speed: float = float("inf")) -> Iterator[ZmqWorld]:
    """Open a server with a scene for a test."""
    path = folder / "scene.xml"
    path.write_text(scene, encoding="utf-8")
    opened = ZmqWorld(RealWorld(path, speed=speed))
    try:
        yield opened
    finally:
        opened.close()
