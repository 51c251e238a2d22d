"""One message of calls to one server and its answers. Sending and waiting are separate, so that several can
run at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any, Protocol

from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.errors import Failure
from simx_client.protocol.messages import Reply

from .clients import CLIENTS
from .connection import Connection

_REPLY = attrgetter("reply")


class Party(Protocol):
    """The part of a connection that an exchange uses; see `Connection` for the methods."""

    where: str

    @property
    def connection_id(self) -> int: ...
    @property
    def condition(self) -> str: ...
    @property
    def why_gone(self) -> str: ...
    def send_together(
        self, calls: Iterable[tuple[Marshal, list[Any], Callable[[Reply], None]]]
    ) -> Sequence[int]: ...
    def receive_until(self, is_enough: Callable[[], bool], deadline: float, *, is_soon: bool) -> None: ...
    def forget(self, call_ids: Iterable[int]) -> None: ...


def connection_of(client: int) -> Connection:
    """Return the connection with this client id.

    Raises:
        ValueError: no connection has this id.
    """
    connection = CLIENTS.get(client)
    if connection is None:
        raise ValueError(f"there is no client {client!r}; pass what simxStart returned, before simxFinish")
    return connection


class Exchange:
    """Calls to one server, sent together."""

    def __init__(self, connection: Party, answers: Sequence[Answer[Any]]) -> None:
        """Prepare an exchange. The answers may be those of an earlier one."""
        self.connection = connection
        self._answers = answers
        self._ids: Sequence[int] = ()
        self._sent_on = -1
        """Number of the connection; another number means that the server was lost and has come back."""

    def send(self) -> None:
        """Send the calls; do not wait. If sending fails, ``finish`` stores the reason in the answers."""
        for answer in self._answers:
            answer.reply = None
        self._sent_on = self.connection.connection_id
        self._ids = self.connection.send_together(
            [(answer.marshal, answer.arguments, answer.take) for answer in self._answers]
        )

    def finish(self, deadline: float, timeout: float) -> None:
        """Wait until all answers are here, the server is lost, or the deadline has passed.

        Args:
            deadline: on the monotonic clock; several servers may share it.
            timeout: the time-out in seconds, for the message.
        """
        if self._is_answered():
            return
        if self._ids:
            is_soon = all(answer.marshal.command.answers_soon for answer in self._answers)
            self.connection.receive_until(self._is_answered, deadline, is_soon=is_soon)
        if not self._is_answered():
            now_on = self.connection.connection_id
            if now_on == -1 or now_on != self._sent_on:
                reason = self.connection.why_gone
            elif not self._ids:
                reason = "communication is paused; resume first with simxPauseCommunication(clientID, False)"
            else:
                reason = f"no answer within {timeout:g} s"
            for answer in self._answers:
                if answer.reply is None:
                    answer.give_up(reason)
            self.connection.forget(self._ids)

    def _is_answered(self) -> bool:
        return None not in map(_REPLY, self._answers)

    @property
    def failures(self) -> list[Failure]:
        """Return the failures, empty without any."""
        return [answer.failure for answer in self._answers if answer.has_failed]

    @property
    def is_lost(self) -> bool:
        """Return whether an answer is missing, so that the server counts as lost."""
        return not self._is_answered()
