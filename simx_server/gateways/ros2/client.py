"""The client of the server loop that stands for all of ROS 2: messages and requests become its calls.

Its calls are those of the remote API's table, so limits, fairness and counters are those of any client, and a recording
has them and replays them without ROS 2.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from simx_client.protocol.messages import NOT_AWAITED_MS, STATUS_OK, Batch, Delivery, Operation, Reply
from simx_client.protocol.messages import Call as TableCall
from simx_server.errors import CommandError
from simx_server.parts.status_bar import as_log_line
from simx_server.service.answers.link import Link
from simx_server.service.calls.work import CallsWork
from simx_server.service.monitoring.report import health

from .table_call import Call

if TYPE_CHECKING:
    from simx_server.service.service import Service

_EXECUTE = int(Operation.EXECUTE)

_MOST_IDS = 1 << 30
"""Ids of calls start again after this number."""


class Ros2Client(Link):
    """The session of ROS 2. Physics thread, except where a method says otherwise."""

    def __init__(self, service: Service, name: str, port: int) -> None:
        """Join the server loop.

        Args:
            name: for logs and metrics.
            port: the router's.

        Raises:
            LimitReached: there are too many clients.
        """
        self.key = f"ros2/{uuid.uuid4().hex}"
        self._service = service
        self._replies: list[Reply] = []
        """Replies to the call of `ask`."""

        self._orders: dict[int, Future[list[Any]]] = {}
        """Calls of `order` without a reply, by their ids."""

        self._awaited = 0
        """Id of this call, 0 for none. Replies to others come at any time: a long batch is executed in slices."""

        self._batches, self._next_call = 0, 1
        self.session = service.clients.join(self.key, name, port, self, is_onlooker=True)

    def execute(self, calls: Iterable[Call]) -> None:
        """Execute calls together for a message, which has no answer; failures are in the log, each once."""
        self._execute(self._numbered(calls, NOT_AWAITED_MS))

    def ask(self, call: Call) -> None:
        """Execute one call, which a batch in slices would not do at once.

        Raises:
            CommandError: it was not executed.
        """
        numbered = self._numbered([call], 0)
        self._awaited = numbered[0].call_id
        self._execute(numbered)
        replies, self._replies, self._awaited = self._replies, [], 0
        for reply in replies:
            if reply.status != STATUS_OK:
                raise CommandError(str(reply.values[0]) if reply.values else "a call has failed")

    def order(self, call: Call) -> Future[list[Any]]:
        """Execute one call that may take long; the physics thread finishes the future with its results.

        The future has a CommandError if the call was not executed. Further calls belong into another turn: see `post`.
        """
        numbered = self._numbered([call], 0)
        future = self._orders[numbered[0].call_id] = Future()
        self._execute(numbered)
        return future

    def _numbered(self, calls: Iterable[Call], delay_ms: int) -> list[TableCall]:
        first = self._next_call
        made = [
            TableCall(number, _EXECUTE, delay_ms, command, arguments)
            for number, (command, arguments) in enumerate(calls, first)
        ]
        self._next_call = first + len(made) if first < _MOST_IDS else 1
        return made

    def _execute(self, calls: list[TableCall]) -> None:
        if calls:
            self._batches += 1
            self._service.handling.execute(self.key, CallsWork(Batch(self._batches, 0, calls)))

    def post(self, event: Callable[[], object], stops: Callable[[], bool] | None = None) -> None:
        """Have the physics thread do something in the turn of this client, when no script runs. Any thread.

        Args:
            stops: returns whether it would stop the simulation; None: it would not.
        """
        self._service.queue.put_last(self.key, event, waits_for_scripts=True, stops=stops)

    def failed(self, name: str, problem: Exception) -> None:
        """Count and log that a message could not be executed, each reason once.

        Args:
            name: of the topic.
        """
        if isinstance(problem, CommandError) and not problem.silent:  # its text may have names of others
            problem = CommandError(as_log_line(str(problem)))
        self._service.executor.failed(self.session, name, problem)

    def problems(self) -> list[str]:
        """Return what is wrong with the server at present, as its health report has it."""
        return list(health(self._service, "")["problems"])

    def leave(self) -> None:
        """Leave the server loop. No thread runs it meanwhile."""
        self._service.clients.leave(self.key)

    # --- the link --------------------------------------------------------------------------------

    def deliver(self, delivery: Delivery) -> None:
        """Keep the reply for `ask`, and finish what was ordered."""
        for reply in delivery.replies:
            if (order := self._orders.pop(reply.call_id, None)) is not None:
                if reply.status == STATUS_OK:
                    order.set_result(list(reply.values))
                else:
                    order.set_exception(_failure(reply))
            elif reply.call_id == self._awaited:
                self._replies.append(reply)


def _failure(reply: Reply) -> CommandError:
    """Return the reason of a failed call, without the name of its function in front."""
    text = str(reply.values[0]) if reply.values else "a call has failed"
    name, colon, why = text.partition(": ")
    return CommandError(why if colon and " " not in name else text)
