"""A proxy of CoppeliaSim's ZeroMQ remote API.

It forwards the frames of the program as they are. After each answer it asks the simulator, as a separate client, for
the time, and when that has changed for the poses and joints of all objects. A sample counts only if no simulation step
was made while it was read.
"""

from __future__ import annotations

import math
import threading
import uuid
from collections.abc import Iterator, Sequence
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.gateways.zmq.functions import described
from simx_server.gateways.zmq.wire.messages import EXECUTED, MAX_MESSAGE

from ..quantities import ANSWER, FORCE, JOINT, ORIENTATION, POSITION
from ..trajectories import SAME_TIME, Call, Collector, Quantity

TIMEOUT_MS = 60_000
MOST_OBJECTS = 300
"""Objects whose poses are read; each takes a call."""

_ATTEMPTS = 3
"""Times that a sample is read before it is left out, where the simulation does not wait."""

_STEP = "sim.step"
_FULL_PATH = 5
"""Form of an alias: the shortest path that is unique."""


class ZmqProxy:
    """Listens at a free port of this machine, and forwards to a simulator."""

    def __init__(self, host: str, port: int, collector: Collector) -> None:
        """Listen.

        Raises:
            CommandError: the simulator does not answer.
        """
        import zmq

        self._zmq: Any = zmq
        self._context: Any = zmq.Context()
        self._upstream = f"tcp://{host}:{port}"
        self._front: Any = self._socket(zmq.ROUTER)
        self.port: int = self._front.bind_to_random_port("tcp://127.0.0.1")
        self._clients: dict[bytes, Any] = {}
        self._waiting: dict[bytes, _Asked] = {}
        self._collector = collector
        self._observer = _Observer(self._connected(), collector)
        self.problems: list[str] = []
        self._wake: Any = self._socket(zmq.PAIR)
        self._wake.bind("inproc://end")
        self._end: Any = self._socket(zmq.PAIR)
        self._end.connect("inproc://end")
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _socket(self, kind: int) -> Any:
        made = self._context.socket(kind)
        made.setsockopt(self._zmq.LINGER, 0)
        made.setsockopt(self._zmq.MAXMSGSIZE, MAX_MESSAGE)
        return made

    def _connected(self) -> Any:
        made = self._socket(self._zmq.REQ)
        made.connect(self._upstream)
        return made

    def _run(self) -> None:
        poller = self._zmq.Poller()
        poller.register(self._front, self._zmq.POLLIN)
        poller.register(self._wake, self._zmq.POLLIN)
        try:
            self._observer.start()
            while True:
                ready = dict(poller.poll())
                if self._wake in ready:
                    return
                if self._front in ready:
                    self._forward(poller)
                for identity, upstream in self._clients.items():
                    if upstream in ready:
                        self._answer(identity, upstream)
        except (CommandError, self._zmq.ZMQError) as problem:
            self.problems.append(str(problem))
        finally:
            for each in (*self._clients.values(), self._front, self._wake, self._observer.socket):
                each.close()

    def _forward(self, poller: Any) -> None:
        identity, *frames = self._front.recv_multipart()
        if identity not in self._clients:
            self._clients[identity] = self._connected()
            poller.register(self._clients[identity], self._zmq.POLLIN)
        if identity in self._waiting:
            raise CommandError("the program sent a message before it had the answer to the one before")
        self._waiting[identity] = _Asked.of(frames[-1], self._collector, self._observer.names)
        self._clients[identity].send(frames[-1])

    def _answer(self, identity: bytes, upstream: Any) -> None:
        answer = upstream.recv()
        asked = self._waiting.pop(identity)
        self._observer.look()  # before the program goes on
        asked.answered(answer, self._collector)
        self._front.send_multipart([identity, b"", answer])

    def close(self) -> None:
        """End all connections."""
        self._end.send(b"")
        self._thread.join(TIMEOUT_MS / 1000)
        self._end.close()
        self._context.destroy(linger=0)


class _Asked:
    """A request of the program, until its answer comes."""

    def __init__(self, call: Call | None) -> None:
        self._call = call

    @classmethod
    def of(cls, request: bytes, collector: Collector, names: dict[int, str]) -> _Asked:
        content = _loads(request)
        function = content.get("func")
        if not isinstance(function, str) or function == EXECUTED or function.startswith("zmqRemoteApi."):
            return cls(None)
        # Only the first argument is a handle for sure: others may be numbers that happen to be one.
        arguments = [
            _plain(each, {} if place else names) for place, each in enumerate(content.get("args") or ())
        ]
        call = Call(collector.time, function, arguments, not described(function).only_reads)
        collector.note(call)
        if function == _STEP:
            collector.steps = True
        return cls(call)

    def answered(self, answer: bytes, collector: Collector) -> None:
        """Record the numbers of an answer to a call that reads."""
        if self._call is None or self._call.changes:
            return
        content = _loads(answer)
        numbers = list(_numbers(content.get("ret")))
        time = collector.at(collector.time)
        if time is not None and numbers and all(map(math.isfinite, numbers)):
            collector.add(time, [(Quantity(str(self._call), ANSWER), numbers)])


def _loads(message: bytes) -> dict[str, Any]:
    """Return a message as a map; an empty one if it is something else."""
    from cbor2 import CBORDecodeError, loads

    try:
        content = loads(message)
    except CBORDecodeError:
        return {}
    return cast(dict[str, Any], content) if isinstance(content, dict) else {}


def _plain(value: Any, names: dict[int, str]) -> Any:
    """Return an argument as JSON has it; a number that is a handle becomes the object's name."""
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, int) and not isinstance(value, bool):
        return names.get(value, value)
    if isinstance(value, list):
        return [_plain(each, {}) for each in cast(list[Any], value)]
    return value if isinstance(value, (str, int, float, bool)) or value is None else str(value)


def _numbers(value: Any) -> Iterator[float]:
    """Yield the real numbers of an answer; handles are whole, and differ between simulators."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, (list, tuple)):
        for each in cast(list[Any], value):
            yield from _numbers(each)


class _Refusal(CommandError):
    """The simulator refused a call of the observer."""


class _Observer:
    """Reads the states of the simulator's objects."""

    def __init__(self, socket: Any, collector: Collector) -> None:
        self.socket = socket
        self._collector = collector
        self._uuid = str(uuid.uuid4())
        self._joints: list[int] = []
        self.names: dict[int, str] = {}
        self._last: float | None = None
        self._handles: list[int] = []

    def start(self) -> None:
        """Get to know the simulator. Raises CommandError: it does not answer."""
        self._ask("zmqRemoteApi.info", "sim")

    def look(self) -> None:
        """Take a sample if the simulation has made a step since the last one. Raises CommandError."""
        for _ in range(_ATTEMPTS):
            began = float(self._ask("sim.getSimulationTime"))
            if self._last is not None and abs(began - self._last) < SAME_TIME:
                return
            try:
                self._find_objects()
                sample = list(self._read())
            except _Refusal:  # an object was removed meanwhile
                self._handles = []
                continue
            if abs(float(self._ask("sim.getSimulationTime")) - began) < SAME_TIME:
                self._last = began
                time = self._collector.at(began)
                if time is not None:
                    self._collector.add(time, sample)
                return

    def _find_objects(self) -> None:
        handles: list[int] = self._ask("sim.getObjectsInTree", _HANDLE_SCENE)[:MOST_OBJECTS]
        if handles == self._handles:
            return
        self.names = {handle: str(self._ask("sim.getObjectAlias", handle, _FULL_PATH)) for handle in handles}
        kinds = {handle: self._ask("sim.getObjectType", handle) for handle in handles}
        self._joints = [
            handle
            for handle, kind in kinds.items()
            if kind == _JOINT_TYPE and self._ask("sim.getJointType", handle) != _SPHERICAL
        ]
        self._handles = handles

    def _read(self) -> Iterator[tuple[Quantity, Sequence[float]]]:
        for handle, name in self.names.items():
            pose = self._ask("sim.getObjectPose", handle, -1)
            if pose is not None:
                yield Quantity(name, POSITION), pose[:3]
                yield Quantity(name, ORIENTATION), [pose[6], *pose[3:6]]
        for handle in self._joints:
            yield Quantity(self.names[handle], JOINT), [self._ask("sim.getJointPosition", handle)]
            yield Quantity(self.names[handle], FORCE), [self._ask("sim.getJointForce", handle)]

    def _ask(self, function: str, *arguments: Any) -> Any:
        """Call a function of the simulator. Raises CommandError."""
        from cbor2 import dumps

        message = {"func": function, "args": list(arguments), "argsL": len(arguments), "uuid": self._uuid}
        self.socket.send(dumps(message | {"ver": 2, "lang": "python"}))
        while True:
            if not self.socket.poll(TIMEOUT_MS):
                raise CommandError(f"the simulator did not answer {function} within {TIMEOUT_MS / 1000:g} s")
            answer = _loads(self.socket.recv())
            if "err" in answer:
                raise _Refusal(f"the simulator refused {function}: {answer['err']!s:.200}")
            if not answer:
                raise CommandError(f"the simulator answered {function} with something that is no map")
            if answer.get("func") == "_*repeat*_":
                self.socket.send(dumps(message))
            elif "func" in answer:
                self.socket.send(dumps(message | {"func": EXECUTED, "args": [], "argsL": 0}))
            else:
                results: list[Any] = answer.get("ret") or [None]
                return results[0] if len(results) == 1 else results


_JOINT_TYPE, _SPHERICAL = 1, 12
_HANDLE_SCENE = -12
"""`sim.handle_scene`: in place of an object, everything."""
