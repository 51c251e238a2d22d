"""Connect a client and the server loop in one process and one thread, with messages and without a network.

While the client waits, it turns the server loop; so a test needs no sockets, threads or sleeps.
"""

from __future__ import annotations

import math
import queue
import threading
import time
import uuid
from collections import deque

from simx_client.errors import ConnectionFailed
from simx_client.protocol.messages import PROTOCOL_VERSION, Welcome
from simx_server.limits import LimitReached
from simx_server.service.answers.link import PackingLink
from simx_server.service.calls.work import BatchWork
from simx_server.service.loop import ServerLoop


class LoopbackTransport(PackingLink):
    """A ``simx_client.transport.transport.Transport`` to a server loop in this process."""

    def __init__(
        self, loop: ServerLoop, *, name: str = "loopback", port: int = 0, turns: bool = True
    ) -> None:
        """Make a link.

        Args:
            turns: turn the server loop while waiting; False when another thread runs it.
        """
        self.client = uuid.uuid4().hex
        self._loop, self._service = loop, loop.service
        self._name, self._port = name, port
        self._turns = turns
        self._deliveries: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._stream: deque[bytes] = deque(maxlen=1)
        self._images: dict[int, bytes] = {}
        self._connected = False
        self._lost = False

    # --- the client's side -----------------------------------------------------------------------

    @property
    def is_connected(self) -> bool:
        return self._connected

    @property
    def was_lost(self) -> bool:
        return self._lost

    def greet(self, timeout: float) -> Welcome:
        if self._service.ending.has_come:
            raise ConnectionFailed("the server loop has ended")
        joined = threading.Event()
        refusals: list[LimitReached] = []

        def join() -> None:
            try:
                self._service.clients.join(self.client, self._name, self._port, self)
            except LimitReached as problem:
                refusals.append(problem)
            joined.set()

        self._connected, self._lost = True, False
        self._deliveries = queue.SimpleQueue()  # discards what a lost link had not delivered
        self._service.queue.post(join)
        if self._turns:
            while not joined.is_set():  # a turn may execute what has come before
                self._loop.turn()
        elif not joined.wait(timeout):
            raise ConnectionFailed("the server loop does not answer")
        if refusals:
            self._connected = False
            raise ConnectionFailed(str(refusals[0]))
        return Welcome(PROTOCOL_VERSION, "", "loopback", "", "")

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        self._service.queue.submit(self.client, BatchWork(payload))

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        deadline = time.monotonic() + timeout
        while True:
            try:
                if self._turns:
                    return self._deliveries.get_nowait()
                return self._deliveries.get(timeout=max(0.0, timeout))
            except queue.Empty:
                if not self._turns:
                    return None
            remaining = deadline - time.monotonic()
            self._loop.turn(max_wait=max(0.0, min(0.001, remaining)))
            if remaining <= 0:
                try:
                    return self._deliveries.get_nowait()
                except queue.Empty:
                    return None

    def is_still(self) -> bool:
        return False

    def newest(self) -> bytes | None:
        return self._stream.pop() if self._stream else None

    def images(self) -> list[bytes]:
        images, self._images = self._images, {}
        return list(images.values())

    def lose(self) -> None:
        """Cut the link, as when the client's process dies or the server goes away."""
        self._connected, self._lost = False, True
        self._service.clients.depart(self.client)
        self._deliveries.put(None)
        if self._turns:
            self._loop.turn()

    # --- the server's side: the link -------------------------------------------------------------

    def put_replies(self, payload: bytes) -> None:
        self._deliveries.put(payload)

    def put_values(self, payload: bytes) -> None:
        self._stream.append(payload)

    def put_image(self, stream_id: int, payload: bytes) -> None:
        self._images[stream_id] = payload

    def close(self) -> None:
        """Close the link, for either side: the client leaves the server."""
        if self._connected:
            self._connected = False
            self._service.clients.depart(self.client)
            if self._turns:
                self._loop.turn()
