"""One connection to a server's port of API 2: requests in both directions over one ZeroMQ socket.

It needs pyzmq, cbor2 and numpy. Both spellings of the public client's names are there.
"""

from __future__ import annotations

import itertools
import math
import os
import time
from collections.abc import Callable, Sequence
from typing import Any, cast

from simx_client.protocol.api2.objects import Object
from simx_client.protocol.api2.tags import ARRAYS, COLOR, FUNCTION, MATRIX, OBJECT, POSE, QUATERNION
from simx_client.protocol.cli.installing import line

try:
    import cbor2
    import numpy as np
    import zmq
except ImportError:
    raise ImportError(
        f"clients of API 2 need pyzmq, cbor2 and numpy; install them with: {line(['pyzmq', 'cbor2', 'numpy'])}"
    ) from None

PORT = 24020

KEEP_ALIVE = 5.0
"""Seconds without a message to the server after which a client that spins sends a sign of life."""


class ZMQRemoteAPI:
    """A connection. Its methods raise Exception with the server's text where a call fails there."""

    def __init__(self, options: dict[str, Any] | None = None) -> None:
        """Connect.

        Args:
            options: `host` (127.0.0.1), `port` (24020), `name` and `verbose`; `server` is an error.
        """
        given = options or {}
        if given.get("server"):
            raise ValueError("this class is a client: start the server with simx-server --zmq2")
        self.name, self.verbose = given.get("name"), given.get("verbose", 0)
        self.callables: dict[str, Callable[..., Any]] = {}
        self.last_send_time = self.last_recv_time = time.time()
        self._numbers = itertools.count(1)
        self._names = itertools.count(1)
        self._results: dict[int, dict[str, Any]] = {}
        self._context = zmq.Context()
        self._socket: Any = self._context.socket(zmq.DEALER)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.connect(f"tcp://{given.get('host', '127.0.0.1')}:{_port(given.get('port'))}")

    @property
    def lastSendTime(self) -> float:
        """Return when the last message was sent, as time.time()."""
        return self.last_send_time

    @property
    def isRemoteAlive(self) -> bool:
        """Return whether the server has been heard in the last 10 s."""
        return time.time() - self.last_recv_time < 2 * KEEP_ALIVE

    def cleanup(self) -> None:
        """Close the connection."""
        if self._socket is not None:
            self._socket.close()
            self._context.term()
            self._socket = None

    def __del__(self) -> None:
        if hasattr(self, "_socket"):
            self.cleanup()

    # --- requests --------------------------------------------------------------------------------

    def call(self, target: int | None, function: str, *arguments: Any) -> Any:
        """Call a method of an object, or without a target a function; serve the server's calls meanwhile."""
        message = {
            "msg": "call",
            "target": target,
            "func": function,
            "args": [self._out(each) for each in arguments],
        }
        return self._request(message)

    def register_callback(self, name: str, function: Callable[..., Any], is_global: bool = False) -> None:
        """Let the server call a function; with `is_global` in the phase of the simulation that its name is."""
        if not callable(function):
            raise TypeError(f"{function!r} is no function")
        self.callables[name] = function
        self._request({"msg": "registerCallback", "func": name, "global": is_global})

    registerCallback = register_callback

    def _request(self, message: dict[str, Any]) -> Any:
        number = next(self._numbers)
        self.send(message | {"id": number})
        while number not in self._results:
            received = self.recv()
            if received is not None:
                self.handle_request(received)
        answer = self._results.pop(number)
        if answer.get("error"):
            raise Exception(answer["result"])
        found: Any = answer["result"]
        if not isinstance(found, (list, tuple)):
            return found
        values = tuple(cast(Sequence[Any], found))
        return values[0] if len(values) == 1 else values

    # --- messages of the server ------------------------------------------------------------------

    def handle_request(self, message: dict[str, Any]) -> None:
        """Act on a message of the server."""
        kind, number = message.get("msg"), message.get("id")
        if kind == "result" and isinstance(number, int):
            self._results[number] = message
        elif kind == "call":
            self.send({"msg": "result", "id": number, **self._answer(message)})

    handleRequest = handle_request

    def _answer(self, message: dict[str, Any]) -> dict[str, Any]:
        name = message.get("func", "")
        try:
            function = self.callables.get(name)
            if function is None:
                raise NameError(f"no such function: {name}")
            result: Any = function(*message.get("args", ()))
            values = cast(
                tuple[Any, ...], () if result is None else result if isinstance(result, tuple) else (result,)
            )
            return {"error": False, "result": [self._out(each) for each in values]}
        except Exception as problem:
            return {"error": True, "result": str(problem)}

    def poll(self, timeout: float = 0) -> bool:
        """Serve one message of the server, if one comes within some seconds; return whether one came."""
        if time.time() - self.last_send_time > KEEP_ALIVE:
            self.send({"msg": "noop"})
        if not self._socket.poll(int(timeout * 1000), zmq.POLLIN):
            return False
        received = self.recv()
        if received is not None:
            self.handle_request(received)
        return True

    spinOnce = poll

    def handle_requests(self, timeout: float = -1) -> None:
        """Serve messages of the server for some seconds, or for ever."""
        end = math.inf if timeout < 0 else time.monotonic() + timeout
        while (left := end - time.monotonic()) > 0:
            self.poll(min(left, 0.1))

    handleRequests = spinSome = handle_requests

    # --- bytes -----------------------------------------------------------------------------------

    def send(self, message: dict[str, Any]) -> None:
        """Send a message."""
        self._socket.send(cbor2.dumps(message, default=_encode))
        self.last_send_time = time.time()

    def recv(self, block: bool = True) -> dict[str, Any] | None:
        """Return the next message; None without one, if it does not block."""
        try:
            data = self._socket.recv(0 if block else zmq.NOBLOCK)
        except zmq.Again:
            return None
        self.last_recv_time = time.time()
        return cbor2.loads(data, tag_hook=_decode)

    def _out(self, value: Any) -> Any:
        """Return a value with names in place of functions."""
        if isinstance(value, (Object, np.ndarray)) or not (
            callable(value) or isinstance(value, (list, tuple, dict))
        ):
            return cast(Any, value)
        if isinstance(value, dict):
            return {key: self._out(each) for key, each in cast(dict[Any, Any], value).items()}
        if isinstance(value, (list, tuple)):
            return [self._out(each) for each in cast(Sequence[Any], value)]
        name = f"@tmpcallback_{next(self._names)}"
        self.callables[name] = value
        return cbor2.CBORTag(FUNCTION, name)


def _encode(encoder: Any, value: Any) -> None:
    if isinstance(value, Object):
        encoder.encode(cbor2.CBORTag(OBJECT, value.handle))
    elif isinstance(value, (np.ndarray, np.generic)):
        numbers = cast(Any, value)
        if numbers.ndim == 2:
            rows, columns = numbers.shape
            encoder.encode(cbor2.CBORTag(MATRIX, [[rows, columns], numbers.astype(float).ravel().tolist()]))
        else:
            encoder.encode(numbers.tolist())
    else:
        raise TypeError(f"a {type(value).__name__} cannot travel to the server")


def _decode(first: Any, second: Any) -> Any:
    """Return the value of a tag, which is the first argument since cbor2 6, and was the second."""
    tag: Any = first if isinstance(first, cbor2.CBORTag) else second
    value: Any = tag.value
    if tag.tag == OBJECT:
        return None if value in (None, -1) else Object(value)
    if tag.tag == MATRIX:
        numbers: Any = np.array(value[1], dtype=np.float64)
        return numbers.reshape([int(each) for each in value[0]])
    if tag.tag in (QUATERNION, POSE):
        return np.array(value, dtype=np.float64)
    if tag.tag == COLOR:
        return tuple(value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value)
    if tag.tag in ARRAYS:
        return cast(Any, np).frombuffer(value, dtype=f"<{ARRAYS[tag.tag]}")
    return tag


def _port(given: int | None) -> int:
    """Return the port to connect to: for the usual one that of ``SIMX_ZMQ2_PORT``, which `simx-run` sets."""
    return int(os.environ.get("SIMX_ZMQ2_PORT", PORT)) if given in (None, PORT) else given


def connect(host: str = "127.0.0.1", port: int | None = None) -> ZMQRemoteAPI:
    """Return a connection at the port that the first one names, as programs make it with two of them.

    Args:
        host: of the server.
        port: its first port; None: ``SIMX_ZMQ2_PORT``, or 24020.
    """
    first = ZMQRemoteAPI({"host": host, "port": port})
    found = first.call(None, "getPort")
    first.cleanup()
    return ZMQRemoteAPI({"host": host, "port": found})
