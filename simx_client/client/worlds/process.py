"""A process with some of the worlds of a program: ``python -m simx_client.client.worlds.process DESCRIPTOR``.

It gets its settings, starts the simulations and executes calls until the program closes the connection or ends.
"""

from __future__ import annotations

import logging
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection as Pipe
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.client.opening import open_embedded
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Reply

from .worker import Order, Request


class _Executor:
    """Executes requests."""

    def __init__(self, connections: Sequence[Connection], timeout: float) -> None:
        self._connections, self._timeout = connections, timeout
        self._marshals: dict[str, Marshal] = {}

    def execute(self, request: Request) -> tuple[int, list[tuple[Any, ...]]]:
        """Execute the calls for one world; return the world and the fields of the replies."""
        place, calls = request
        connection = self._connections[place]
        replies: list[Reply] = []
        call_ids = connection.send_together(
            [(self._marshal(name), values, replies.append) for name, values in calls]
        )
        if len(replies) < len(calls):  # recorded calls are messages, also within a process
            deadline = time.monotonic() + self._timeout
            connection.receive_until(lambda: len(replies) == len(calls), deadline, is_soon=False)
            connection.forget(call_ids)
        return place, [tuple(reply) for reply in replies]

    def _marshal(self, name: str) -> Marshal:
        marshal = self._marshals.get(name)
        if marshal is None:
            marshal = self._marshals[name] = Marshal(ANSWERED[name])
        return marshal


def serve(pipe: Pipe) -> None:
    """Start the simulations, answer None or the reason why they cannot start, then execute requests.

    One message has the requests of a turn, another one their replies, so the program and this process never wait for
    each other's full buffers.
    """
    order = Order(*pipe.recv())
    logging.basicConfig(level=order.log_level, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    with ExitStack() as stack:
        connections: list[Connection] = []
        try:
            for _ in range(order.worlds):
                connection, server = open_embedded(order.arguments, order.timeout)
                stack.callback(server.close)
                stack.callback(CLIENTS.discard, connection)
                connections.append(connection)
        except ConnectionFailed as error:
            pipe.send(str(error))
            return
        pipe.send(None)
        executor = _Executor(connections, order.timeout)
        while True:
            pipe.send([executor.execute(request) for request in pipe.recv()])


def main() -> None:
    """Serve the program at the other end of the socket whose descriptor is the argument."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program, which closes the connection
    # The program closes the connection when it needs these worlds no longer, or ends.
    with Pipe(int(sys.argv[1])) as pipe, suppress(EOFError, BrokenPipeError, ConnectionResetError):
        serve(pipe)


if __name__ == "__main__":
    main()
