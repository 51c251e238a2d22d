"""One message of calls to one server and its answers; sending and waiting apart, so that many can be on the way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from simx_client.errors import Failure

from .answers import Answer
from .clients import CLIENTS
from .connection import Connection


def connection_of(client: int) -> Connection:
    """The connection behind a client id.

    Raises:
        ValueError: there is none.
    """
    connection = CLIENTS.get(client)
    if connection is None:
        raise ValueError(f"there is no client {client!r}; pass what simxStart returned, before simxFinish")
    return connection


class Exchange:
    """Calls to one server, sent together."""

    def __init__(self, connection: Connection, answers: Sequence[Answer[Any]]) -> None:
        """Prepare; ``send`` and ``finish`` do the rest. Answers of an earlier exchange may come again."""
        self._connection = connection
        self._answers = answers
        self._ids: list[int] = []
        self._sent_on = -1
        """Number of the connection; another one means that the server was lost and has come back."""

    def send(self) -> None:
        """Send; does not wait. If that is not possible, ``finish`` finds no answers and says why."""
        for answer in self._answers:
            answer.reply = None
        self._sent_on = self._connection.connection_id
        self._ids = self._connection.send_together(
            [(answer.shape, answer.arguments, answer.take) for answer in self._answers]
        )

    def finish(self, deadline: float, timeout: float) -> None:
        """Wait until all answers are here, the server is lost, or it is too late.

        Args:
            deadline: on the monotonic clock; it may be shared with other servers.
            timeout: what it was made of, for the message.
        """
        if self._ids:
            is_soon = all(answer.shape.command.answers_soon for answer in self._answers)
            self._connection.receive_until(self._is_answered, deadline, is_soon=is_soon)
        if not self._is_answered():
            now_on = self._connection.connection_id
            if now_on == -1 or now_on != self._sent_on:
                reason = "the server went away"
            elif not self._ids:
                reason = "communication is paused; resume first with simxPauseCommunication(clientID, False)"
            else:
                reason = f"no answer within {timeout:g} s"
            for answer in self._answers:
                if answer.reply is None:
                    answer.give_up(reason)
            self._connection.forget(self._ids)

    def _is_answered(self) -> bool:
        return all(answer.reply is not None for answer in self._answers)

    @property
    def failures(self) -> list[Failure]:
        """What went wrong; empty if nothing did."""
        return [answer.failure for answer in self._answers if answer.code]

    @property
    def is_lost(self) -> bool:
        """Whether an answer is missing, so that nothing is to be expected of this server."""
        return not self._is_answered()
