"""A server on a thread of the test's process with the port of API 2, and a client made from the wire's description."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from real_world import RealWorld
from zmq_world import SCENE, TIMEOUT, ZmqWorld, cbor2, zmq

from simx_server.gateways.zmq2.gateway import Zmq2Gateway

SCENE_HANDLE, APP, SELF = -12, -13, -4

OBJECT, FUNCTION, POSE, QUATERNION, COLOR, MATRIX = (
    *(4294999999, 4294999997, 4294980500, 4294980000, 4294970000),
    40,
)


class Refused(Exception):
    """The server has answered with an error."""


class WireClient:
    """A client of API 2: numbered requests in both directions over one DEALER socket."""

    def __init__(self, port: int, kind: int = zmq.DEALER) -> None:
        self.context = zmq.Context()
        self.socket = self.context.socket(kind)
        self.socket.setsockopt(zmq.RCVTIMEO, TIMEOUT)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.connect(f"tcp://127.0.0.1:{port}")
        self.numbers = itertools.count(1)
        self.functions: dict[str, Callable[..., Any]] = {}
        self.has_numbers = kind == zmq.DEALER
        self.answers: dict[int, Any] = {}
        """Those that came while a function of the client had a request of its own, by number."""

    def send(self, message: Any) -> None:
        self.socket.send(message if isinstance(message, bytes) else cbor2.dumps(message))

    def receive(self) -> Any:
        return cbor2.loads(self.socket.recv())

    def request(self, message: dict[str, Any]) -> Any:
        """Send a request and return its result as it came; serve the server's calls meanwhile."""
        number = next(self.numbers)
        self.send(message | ({"id": number} if self.has_numbers else {}))
        while number not in self.answers:
            answer = self.receive()
            if answer["msg"] == "call":
                self.serve(answer)
            else:
                self.answers[answer.get("id") or number] = answer
        answer = self.answers.pop(number)
        if answer["error"]:
            raise Refused(answer["result"])
        return answer["result"]

    def serve(self, call: dict[str, Any]) -> None:
        """Answer a call of the server."""
        answer: dict[str, Any] = {"msg": "result", "error": False, "result": []}
        if "id" in call:
            answer["id"] = call["id"]
        try:
            found = self.functions[call["func"]](*call["args"])
            answer["result"] = [] if found is None else [found]
        except Exception as problem:
            answer |= {"error": True, "result": str(problem)}
        self.send(answer)

    def call(self, target: int | None, name: str, *arguments: Any) -> Any:
        """Return the results of a method as a list."""
        return self.request({"msg": "call", "target": target, "func": name, "args": list(arguments)})

    def get(self, target: int, name: str) -> Any:
        (found,) = self.call(target, "getProperty", name, {})
        return found

    def at(self, path: str) -> int:
        """Return the handle of the object at a path."""
        (found,) = self.call(SCENE_HANDLE, "getObject", path)
        assert found.tag == OBJECT
        return found.value

    def register(self, name: str, function: Callable[..., Any], *, is_global: bool = False) -> None:
        self.functions[name] = function
        assert self.request({"msg": "registerCallback", "func": name, "global": is_global}) is True

    def poll_until(self, condition: Callable[[], bool]) -> None:
        """Serve the server's calls until a condition holds."""
        while not condition():
            self.serve(self.receive())


class Zmq2World(ZmqWorld):
    """The server, its gateway for API 2, and its clients."""

    gateway_class = Zmq2Gateway

    def wire(self, kind: int = zmq.DEALER) -> WireClient:
        client = WireClient(self.port, kind)
        self._clients.append(client)
        return client


@contextmanager
def zmq2_world(folder: Path, *, scene: str = SCENE, speed: float = float("inf")) -> Iterator[Zmq2World]:
    """Open a server with a scene for a test."""
    path = folder / "scene.xml"
    path.write_text(scene, encoding="utf-8")
    opened = Zmq2World(RealWorld(path, speed=speed))
    try:
        yield opened
    finally:
        opened.close()
