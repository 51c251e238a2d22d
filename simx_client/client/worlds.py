"""Many simulations in this process, stepped together by threads: MuJoCo computes without Python's interpreter lock."""

from __future__ import annotations

import os
import weakref
from collections import deque
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.embedding import as_arguments
from simx_client.connection.exchange import Exchange
from simx_client.connection.timeouts import DEFAULT_TIMEOUT

from .opening import open_embedded
from .servers import Servers


class Worlds(Servers):
    """Simulations of one scene in this process, used like `Servers`. A context manager: leaving it ends them.

        with Worlds("two_link_arm", 16) as worlds:
            worlds.each(lambda calls, place: calls.simxSynchronous(True))

    Each world has its own thread-safe simulation; an exception in one of them leaves the others unchanged. Results do
    not depend on the number of threads.
    """

    __slots__ = ("_end", "_helpers", "_pool")

    def __init__(
        self,
        scene: str | os.PathLike[str] | None,
        count: int,
        *,
        threads: int | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> None:
        """Start simulations.

        Args:
            scene: what ``simx-server`` takes: a V-REP, MJCF or URDF file, or the name of a shipped scene.
            count: number of simulations, 1..255.
            threads: number of threads that step them, including the caller's; default: one per processor core.
            timeout: time-out of a call in seconds.
            settings: flags of ``simx-server``, with underscores, for all of them; see `Client.embedded`.

        Raises:
            ConnectionFailed: the server is not installed, or the scene or a setting cannot be used.
            ValueError: a number is not valid.
        """
        if not 1 <= count <= CLIENTS.MAX_CLIENTS:
            raise ValueError(f"count must be 1..{CLIENTS.MAX_CLIENTS}, not {count}")
        if threads is not None and threads < 1:
            raise ValueError(f"threads must be at least 1, not {threads}")
        self._helpers = min(count, threads or _cores()) - 1
        arguments = as_arguments(scene, settings)
        with ExitStack() as stack:
            connections: list[Connection] = []
            for _ in range(count):
                connection, server = open_embedded(arguments, timeout)
                stack.callback(server.close)
                stack.callback(CLIENTS.discard, connection)
                connections.append(connection)
            self._pool = stack.enter_context(ThreadPoolExecutor(max(1, self._helpers), "simx-worlds"))
            super().__init__(map(CLIENTS.id_of, connections), timeout=timeout)
            self._end = weakref.finalize(self, stack.pop_all().close)

    def close(self) -> None:
        """End the simulations. Idempotent."""
        self._helpers = 0
        self._end()

    def _send(self, exchanges: Iterable[Exchange]) -> None:
        """Execute the calls of each world; a thread that has finished one world takes the next."""
        waiting = deque(exchanges)
        helpers = [
            self._pool.submit(_take_over, waiting) for _ in range(min(self._helpers, len(waiting) - 1))
        ]
        _take_over(waiting)
        for helper in helpers:
            helper.result()


def _take_over(waiting: deque[Exchange]) -> None:
    while waiting:
        try:
            exchange = waiting.popleft()
        except IndexError:  # another thread has just taken the last one
            return
        exchange.send()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
