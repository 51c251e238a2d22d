"""Batches by the client id that simxStart returned. New code uses `Client.batch` and `Client.many`.

with batch.Batch(clientID) as calls:
    position = calls.simxGetJointPosition(joint)
print(position.value)
"""

from __future__ import annotations

import time
from types import TracebackType

from simx_client.calls.answers import Answer
from simx_client.calls.strict import Strict

from .client.servers import Servers
from .connection.calls import Calls
from .connection.exchange import Exchange, connection_of
from .connection.timeouts import DEFAULT_TIMEOUT
from .errors import CallsFailed, Failure

__all__ = ["Answer", "Batch", "Calls", "CallsFailed", "Failure", "Servers"]


class Batch(Strict):
    """Calls that are noted in a ``with`` block and made at its end."""

    __slots__ = ("__weakref__", "_calls", "_check", "_connection", "_timeout")

    def __init__(self, client: int, *, timeout: float = DEFAULT_TIMEOUT, check: bool = True) -> None:
        """Prepare a batch to one server; it is sent at the end of the block.

        Args:
            client: client id that simxStart returned.
            timeout: time-out for all answers together in seconds.
            check: raise if a call failed; otherwise read the code of each answer.

        Raises:
            ValueError: no client has this id.
        """
        self._connection = connection_of(client)
        self._timeout, self._check = timeout, check
        self._calls = Calls(0, self._connection.where)

    def __repr__(self) -> str:
        connection = self._connection
        return f"<Batch to {connection.where}, {connection.condition}: {len(self._calls.noted)} calls noted>"

    def __enter__(self) -> Calls:
        return self._calls

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Send the calls and wait for the answers; send nothing if the block raised.

        Raises:
            CallsFailed: the server refused calls, is gone, or did not answer in time.
        """
        if error is not None or not self._calls.noted:
            return
        exchange = Exchange(self._connection, self._calls.noted)
        exchange.send()
        exchange.finish(time.monotonic() + self._timeout, self._timeout)
        if self._check and exchange.failures:
            raise CallsFailed(exchange.failures)
