"""Many servers driven from one process in lock-step; their observations are gathered as arrays.

All servers get their message before the first answer is awaited, so they compute at the same time. One
message per server and simulation step carries the writes, the trigger and the reads after it; one message
returns the answers.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from typing import TYPE_CHECKING, Any, TypeVar, cast

from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.calls.strict import Strict
from simx_client.connection.calls import Calls
from simx_client.connection.exchange import Exchange, Party, connection_of
from simx_client.connection.timeouts import DEFAULT_TIMEOUT
from simx_client.errors import CallsFailed, ConnectionFailed, Failure
from simx_client.legacy.local import simxFinish, simxStart

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_client.transport.direct import Crew, Plan, Refusal

T = TypeVar("T")
Record = Callable[[Calls, int], T]
"""Notes the calls for one server. Arguments: the recorder and the server's index, from 0."""


class Servers(Strict):
    """Servers that step together. A context manager: leaving it closes the connections.

    A failure raises ``CallsFailed`` when all other servers have answered. A server that is gone, or did not
    answer in time, is in ``lost`` from then on: it is reported once and gets no more calls, and its rows are
    NaN. The row of a server where a call failed is NaN too.
    """

    __slots__ = ("__weakref__", "_connections", "_observations", "_watched", "clients", "lost", "timeout")

    def __init__(self, clients: Iterable[int], *, timeout: float = DEFAULT_TIMEOUT) -> None:
        """Drive servers that simxStart has connected.

        Args:
            clients: client ids that simxStart returned.
            timeout: time-out in seconds for the answers of all servers together.

        Raises:
            ValueError: one of the ids is not a client.
        """
        self.clients = tuple(clients)
        self._drive([connection_of(client) for client in self.clients], timeout)

    def _drive(self, connections: Sequence[Party], timeout: float) -> None:
        self.timeout = timeout
        self._connections = connections
        self.lost: dict[int, Failure] = {}
        """Lost servers by index, with the reason."""

        self._watched: list[list[Answer[Any]]] = [[] for _ in connections]
        self._observations: NDArray[np.float64] | None = None

    @classmethod
    def connect(
        cls, addresses: Iterable[int | tuple[str, int]], *, timeout: float = DEFAULT_TIMEOUT
    ) -> Servers:
        """Connect to servers, as `Client.many` does."""
        clients: list[int] = []
        for address in addresses:
            host, port = ("127.0.0.1", address) if isinstance(address, int) else address
            client = simxStart(host, port, True, True, int(timeout * 1000), 5)
            if client == -1:
                for connected in clients:
                    simxFinish(connected)
                raise ConnectionFailed(f"no connection to server {len(clients)} at {host}:{port}")
            clients.append(client)
        return cls(clients, timeout=timeout)

    def __repr__(self) -> str:
        places = ", ".join(each.where for each in self._connections[:4]) + ", …" * (len(self) > 4)
        return (
            f"<{len(self)} {type(self).__name__}: {places}{f'; {len(self.lost)} lost' if self.lost else ''}>"
        )

    def __enter__(self) -> Servers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections. Idempotent. The simulations continue unchanged."""
        for client in self.clients:
            simxFinish(client)

    def __len__(self) -> int:
        return len(self._connections)

    @property
    def observations(self) -> NDArray[np.float64]:
        """Return the watched values after the newest step: float64, servers × values, NaN where a value is
        missing.

        Raises:
            RuntimeError: `watch` was not called.
        """
        if self._observations is None:
            raise RuntimeError("nothing is watched; say what with watch()")
        return self._observations

    def each(self, record: Record[T], *, check: bool = True) -> list[T]:
        """Make calls on every server, one message each.

        Args:
            record: notes the calls and returns their answers, which have values when `each` returns.
            check: raise if a call failed; otherwise read the code of each answer.

        Returns:
            The results of `record`, one per server.

        Raises:
            CallsFailed: servers are gone or refused calls; the others have executed theirs.
        """
        recorders = self._recorders()
        results = [record(calls, place) for place, calls in enumerate(recorders)]
        failures = self._exchange([calls.noted for calls in recorders])
        if check and failures:
            raise CallsFailed(failures)
        return results

    def watch(self, record: Record[Sequence[Answer[Any]]]) -> NDArray[np.float64]:
        """Set the values that ``step`` returns: it makes these calls after every simulation step.

        Args:
            record: returns the answers whose numbers form a server's row, in this order; a list of three
                numbers fills three columns. It replaces the values watched before.

        Returns:
            float64, servers × values: the present values.

        Raises:
            CallsFailed: as ``each``.
            ValueError: the servers' rows differ in length, or contain something other than numbers.
        """
        recorders = self._recorders()
        self._watched = [list(record(calls, place)) for place, calls in enumerate(recorders)]
        return self._look([calls.noted for calls in recorders])

    def step(self, record: Record[object] | None = None) -> NDArray[np.float64]:
        """Make one simulation step on every server: all get their calls before the first answer is awaited.

        Needs stepped mode and a running simulation.

        Args:
            record: notes the writes before the step; reads belong into ``watch``.

        Returns:
            float64, servers × values, a new array: the watched values after this step. Without ``watch``:
            servers × 0.

        Raises:
            CallsFailed: as ``each``; ``observations`` has the rows of the others.
        """
        recorders = self._recorders()
        for place, calls in enumerate(recorders):
            if record is not None and place not in self.lost:
                record(calls, place)
            calls.simxSynchronousTrigger()
        return self._look(
            [[*calls.noted, *watched] for calls, watched in zip(recorders, self._watched, strict=True)]
        )

    def crew(self, plan: Plan, threads: int) -> Crew:
        """Return what steps simulations of this process together; see `simx_client.transport.direct`.

        Args:
            plan: what they do in each step.
            threads: number of threads, with that of the caller.

        Raises:
            ConnectionFailed: they are not in this process, or cannot step in threads; the text gives the reason.
        """
        from simx_client.connection.embedded import EmbeddedConnection  # few programs need it

        links = [each.link for each in self._connections if isinstance(each, EmbeddedConnection)]
        if len(links) < len(self._connections):
            raise ConnectionFailed("threads can only step simulations of this process")
        return links[0].crew_of(links, plan, threads)

    def failure_of(self, refusal: Refusal) -> Failure:
        """Return the failure of a call of a crew."""
        where = self._connections[refusal.place].where
        answer: Answer[Any] = Answer(Marshal(refusal.command), refusal.arguments, refusal.place, where)
        answer.take(refusal.reply)
        return answer.failure

    def _look(self, noted: Sequence[Sequence[Answer[Any]]]) -> NDArray[np.float64]:
        """Make calls, including the watched ones, and gather the watched values."""
        failures = self._exchange(noted)
        self._observations = self._gather({failure.server for failure in failures}.union(self.lost))
        if failures:
            raise CallsFailed(failures)
        return self._observations

    def _gather(self, failed: Set[int]) -> NDArray[np.float64]:
        """Return the rows of all servers; NaN for those where a call failed."""
        import numpy as np

        rows = [
            [] if place in failed else [number for answer in watched for number in _numbers(answer)]
            for place, watched in enumerate(self._watched)
        ]
        lengths = {len(row) for row in rows if row}
        if len(lengths) > 1:
            raise ValueError(
                f"rows must be equally long to make an array; they have {sorted(lengths)} numbers"
            )
        width = lengths.pop() if lengths else 0 if self._observations is None else self._observations.shape[1]
        observations = np.full((len(rows), width), np.nan)
        for place, row in enumerate(rows):
            if row:
                observations[place] = row
        return observations

    def _recorders(self) -> list[Calls]:
        return [Calls(place, connection.where) for place, connection in enumerate(self._connections)]

    def _exchange(self, noted: Sequence[Sequence[Answer[Any]]]) -> list[Failure]:
        """Send to all servers, then wait for all. Return the failures; servers without an answer count as
        lost."""
        exchanges: dict[int, Exchange] = {}
        for place, answers in enumerate(noted):
            if place in self.lost:
                for answer in answers:
                    answer.give_up(f"left out, since {self.lost[place].reason}")
            elif answers:
                exchanges[place] = Exchange(self._connections[place], answers)
        self._send(exchanges.values())
        failures: list[Failure] = []
        deadline = time.monotonic() + self.timeout
        for place, exchange in exchanges.items():
            exchange.finish(deadline, self.timeout)
            failures += exchange.failures
            if exchange.is_lost:
                self.lost[place] = exchange.failures[0]
        return failures

    def _send(self, exchanges: Iterable[Exchange]) -> None:
        """Send to all servers before the first answer is awaited."""
        for exchange in exchanges:
            exchange.send()


def _numbers(answer: Answer[Any]) -> Iterator[float]:
    """Yield the numbers in the answer to a watched call.

    Raises:
        ValueError: the answer is something else, such as a text or an image.
    """
    for value in answer.reply.values if answer.reply is not None else ():
        for number in cast(list[Any], value) if isinstance(value, list) else (value,):
            if not isinstance(number, (int, float)):
                raise ValueError(
                    f"{answer.marshal.command.name} brings a {type(number).__name__}, not numbers"
                )
            yield number
