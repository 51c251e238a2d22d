"""The least that could carry a call: a bare Zenoh query, bare Zenoh publications, a TCP socket.

``python -m bench.measuring.baselines query|stepping|publications|tcp`` is the far end: it answers every request of n
bytes with the m bytes it was asked for, prints a ready line, and leaves when its standard input ends. The Zenoh ends
use the configuration and the runtime that simx uses. The one that steps is what a few lines of Zenoh and MuJoCo come
to: before each answer it makes the physics steps of a pass of the tutorial's scene.

A request starts with the wanted size of the answer, four bytes, little endian; the rest is padding.
"""

from __future__ import annotations

import queue
import socket
import struct
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from simx_client.protocol.zenoh import link

QUERY, STEPPING, PUBLICATIONS, TCP = "query", "stepping", "publications", "tcp"
TIMEOUT_S = 5.0
_KEY, _BACK = "simx-bench/there", "simx-bench/back"
_SIZES = struct.Struct("<II")
_RECEIVE = 1 << 20


def request_of(size: int, answer_size: int) -> bytes:
    """A request of `size` bytes (8 at least) that asks for an answer of `answer_size` bytes."""
    return _SIZES.pack(answer_size, size).ljust(size, b"\0")


class Answers:
    """Ready answers by size: making them is not what is measured."""

    def __init__(self) -> None:
        self._by_size: dict[int, bytes] = {}

    def to(self, request: bytes | memoryview) -> bytes:
        size = _SIZES.unpack_from(request)[0]
        if size not in self._by_size:
            # Bytes as a camera gives them: about half of them above 127, which are dear as Python ints.
            self._by_size[size] = (bytes(range(256)) * (size // 256 + 1))[:size]
        return self._by_size[size]


# --- the far end: one thread answers, Zenoh's threads only enqueue ----------------------------------


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _far_session(zenoh: Any, port: int) -> Any:
    options = {**link.COMMON, "mode": "peer", "listen/endpoints": [f"tcp/127.0.0.1:{port}"]}
    return zenoh.open(link.configure(zenoh.Config(), options))


def _serve_queries(
    port: int, say_ready: Callable[[int], None], work: Callable[[], object] = lambda: None
) -> None:
    zenoh = link.import_zenoh(link.SERVER_RUNTIME)
    session, answers = _far_session(zenoh, port), Answers()
    waiting: queue.SimpleQueue[Any] = queue.SimpleQueue()
    session.declare_queryable(_KEY, zenoh.handlers.Callback(waiting.put, indirect=False), complete=True)
    say_ready(port)
    while True:
        with waiting.get() as query:
            work()
            query.reply(_KEY, answers.to(query.payload.to_bytes()))


def _serve_steps(port: int, say_ready: Callable[[int], None]) -> None:
    from bench.world.physics import Physics

    with ExitStack() as stack:
        _serve_queries(port, say_ready, Physics(stack).step)


def _serve_publications(port: int, say_ready: Callable[[int], None]) -> None:
    zenoh = link.import_zenoh(link.SERVER_RUNTIME)
    session, answers = _far_session(zenoh, port), Answers()
    waiting: queue.SimpleQueue[Any] = queue.SimpleQueue()
    session.declare_subscriber(_KEY, zenoh.handlers.Callback(waiting.put, indirect=False))
    back = _publisher(zenoh, session, _BACK)
    say_ready(port)
    while True:
        if answer := answers.to(waiting.get().payload.to_bytes()):
            back.put(answer)


def _publisher(zenoh: Any, session: Any, key: str) -> Any:
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.BLOCK,
        reliability=zenoh.Reliability.RELIABLE,
    )


def _serve_tcp(port: int, say_ready: Callable[[int], None]) -> None:
    answers = Answers()
    with socket.create_server(("127.0.0.1", port)) as listener:
        say_ready(port)
        connection, _ = listener.accept()
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    buffer = memoryview(bytearray(_RECEIVE))
    while count := connection.recv_into(buffer):
        size = _SIZES.unpack_from(buffer)[1]
        while count < size:
            count += connection.recv_into(buffer[count:])
        connection.sendall(answers.to(buffer))


_FAR_ENDS = {
    QUERY: _serve_queries,
    STEPPING: _serve_steps,
    PUBLICATIONS: _serve_publications,
    TCP: _serve_tcp,
}


# --- the near end: exchange(request) -> answer -----------------------------------------------------


def _near_session(zenoh: Any, port: int) -> Any:
    options = {**link.COMMON, "mode": "client", "connect/endpoints": [f"tcp/127.0.0.1:{port}"]}
    return zenoh.open(link.configure(zenoh.Config(), options))


class Query:
    """A declared Querier; the reply is taken from its channel."""

    def __init__(self, port: int) -> None:
        zenoh = link.import_zenoh()
        self._session = _near_session(zenoh, port)
        self._querier = self._session.declare_querier(
            _KEY, consolidation=zenoh.ConsolidationMode.NONE, timeout=TIMEOUT_S
        )

    def exchange(self, request: bytes) -> bytes:
        return self._querier.get(payload=request).recv().ok.payload.to_bytes()

    def close(self) -> None:
        self._session.close()


class Publications:
    """Publications both ways; what comes back is put into a queue by Zenoh's thread."""

    def __init__(self, port: int) -> None:
        zenoh = link.import_zenoh()
        self._session = _near_session(zenoh, port)
        self._arrived: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._session.declare_subscriber(_BACK, zenoh.handlers.Callback(self._arrived.put, indirect=False))
        self._there = _publisher(zenoh, self._session, _KEY)

    def exchange(self, request: bytes) -> bytes:
        self._there.put(request)
        return self._arrived.get(timeout=TIMEOUT_S).payload.to_bytes()

    def put(self, request: bytes) -> None:
        self._there.put(request)

    def close(self) -> None:
        self._session.close()


class Tcp:
    """A blocking socket without Nagle's algorithm."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # A time-out of the kernel's: Python's own costs one more system call each time.
        self._socket.settimeout(None)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", int(TIMEOUT_S), 0))
        self._buffer = memoryview(bytearray(4 * _RECEIVE))

    def exchange(self, request: bytes) -> memoryview:
        self._socket.sendall(request)
        wanted, count = _SIZES.unpack_from(request)[0], 0
        while count < wanted:
            received = self._socket.recv_into(self._buffer[count:])
            if not received:
                raise ConnectionError("the far end of the TCP baseline is gone")
            count += received
        return self._buffer[:count]

    def close(self) -> None:
        self._socket.close()


def main(arguments: list[str]) -> int:
    """Be one of the far ends until standard input ends."""
    serve = _FAR_ENDS[arguments[0]]

    def say_ready(port: int) -> None:
        sys.stdout.write(f"ready tcp/127.0.0.1:{port}\n")
        sys.stdout.flush()

    threading.Thread(target=serve, args=(_free_port(), say_ready), daemon=True).start()
    sys.stdin.read()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
