"""Simulations of one scene that step together, in worker processes or in this process."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterable, Sequence
from contextlib import ExitStack

from simx_client.client.opening import open_embedded
from simx_client.client.servers import Servers
from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedding import as_arguments
from simx_client.connection.exchange import Exchange, Party
from simx_client.connection.timeouts import DEFAULT_TIMEOUT

from .worker import Worker, WorldConnection

MAX_WORLDS = 1000


class Worlds(Servers):
    """Simulations of one scene, used like `Servers`. A context manager: leaving it ends them.

        with Worlds("two_link_arm", 16) as worlds:
            worlds.each(lambda calls, place: (calls.simxSynchronous(True), calls.simxStartSimulation()))

    Worker processes share the worlds, one process per processor core; calls need no port and no network. Results do
    not depend on the number of processes.
    """

    __slots__ = ("_end", "_workers")

    def __init__(
        self,
        scene: str | os.PathLike[str] | None,
        count: int,
        *,
        processes: int | None = None,
        timeout: float = DEFAULT_TIMEOUT,
        **settings: object,
    ) -> None:
        """Start simulations.

        Args:
            scene: what ``simx-server`` takes: a V-REP, MJCF or URDF file, or the name of a shipped scene.
            count: number of simulations, 1..1000.
            processes: number of worker processes; default: one per processor core. 0: all simulations are in this
                process (at most 255), and ``clients`` has their client ids for the legacy functions.
            timeout: time-out of calls in seconds.
            settings: flags of ``simx-server``, with underscores, for all simulations; see `Client.embedded`.

        Raises:
            ConnectionFailed: the server is not installed, or the scene or a setting cannot be used.
            ValueError: a number is not valid.
        """
        if not 1 <= count <= MAX_WORLDS:
            raise ValueError(f"count must be 1..{MAX_WORLDS}, not {count}")
        if processes is None:
            processes = min(count, cores()) if min(count, cores()) > 1 and os.name == "posix" else 0
        elif not 0 <= processes <= count:
            raise ValueError(f"processes must be 0..{count} for {count} worlds, not {processes}")
        elif processes and os.name != "posix":
            raise ValueError("worker processes need Linux or macOS; use processes=0")
        arguments = as_arguments(scene, settings)
        where = "the default scene" if scene is None else os.fspath(scene)
        self.clients = ()
        with ExitStack() as stack:
            self._workers: list[Worker] = []
            if processes:
                connections = self._in_workers(stack, arguments, count, processes, timeout, where)
            else:
                connections = self._in_this_process(stack, arguments, count, timeout)
            self._drive(connections, timeout)
            self._end = weakref.finalize(self, stack.pop_all().close)

    def _in_this_process(
        self, stack: ExitStack, arguments: list[str], count: int, timeout: float
    ) -> Sequence[Party]:
        connections: list[Party] = []
        for _ in range(count):
            connection, server = open_embedded(arguments, timeout)
            stack.callback(server.close)
            stack.callback(CLIENTS.discard, connection)
            connections.append(connection)
            self.clients = (*self.clients, CLIENTS.id_of(connection))
        return connections

    def _in_workers(
        self, stack: ExitStack, arguments: list[str], count: int, processes: int, timeout: float, where: str
    ) -> Sequence[Party]:
        for number in range(processes):
            worlds = len(range(number, count, processes))
            self._workers.append(Worker(arguments, worlds, timeout))
            stack.callback(self._workers[-1].close)
        for worker in self._workers:
            worker.wait_until_ready()
        return [
            WorldConnection(self._workers[place % processes], place // processes, f"world {place} of {where}")
            for place in range(count)
        ]

    def close(self) -> None:
        """End the simulations. Idempotent."""
        self._end()

    def _send(self, exchanges: Iterable[Exchange]) -> None:
        super()._send(exchanges)
        for worker in self._workers:
            worker.post()


def cores() -> int:
    """Return the number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
