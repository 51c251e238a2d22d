"""The answer to one call of a batch: empty before the batch is sent, then a value or the reason for its
absence."""

from __future__ import annotations

import reprlib
from typing import Any, Generic, TypeVar, cast

from simx_client.errors import CallsFailed, Failure
from simx_client.protocol import constants as c
from simx_client.protocol.messages import Reply

from .marshalling import Marshal
from .strict import Explained

T = TypeVar("T")

_NOT_YET = "there is no value yet; the first simulation step brings it"
"""Reason of a refusal without a text: the server sends none where a value is to come."""


class Answer(Explained, Generic[T]):
    """Answer to one call of a batch.

    ``value`` of ``simxGetObjectPosition`` is a list of three floats, of a function without results ``None``,
    of one with several results a tuple.
    """

    __slots__ = ("_reason", "arguments", "marshal", "may_be_refused", "reply", "server", "where")

    def __init__(self, marshal: Marshal, arguments: list[Any], server: int, where: str) -> None:
        self.marshal = marshal
        self.arguments = arguments
        self.server = server
        self.where = where
        self.reply: Reply | None = None
        self._reason = "the batch has not been sent yet"
        self.may_be_refused = False
        """Whether the batch succeeds if the server refuses this call; ``code`` tells it then."""

    def __repr__(self) -> str:
        call = self.failure.call
        if self.reply is not None and not self.reply.status:
            return f"<Answer of {call}: {reprlib.repr(self.value)}>"
        return f"<Answer of {call}: none, {self.failure.reason}>"

    def allow_refusal(self) -> None:
        """Let the batch succeed if the server refuses this call."""
        self.may_be_refused = True

    def take(self, reply: Reply) -> None:
        """Store the server's reply."""
        self.reply = reply

    def give_up(self, reason: str) -> None:
        """Store the reason why no answer came."""
        self.reply, self._reason = None, reason

    @property
    def code(self) -> int:
        """Return 0, or the code of the legacy function: 8 refused, 2 no answer."""
        return c.simx_return_timeout_flag if self.reply is None else self.reply.status

    @property
    def has_failed(self) -> bool:
        """Return whether the call has no result, other than by a refusal that was expected."""
        reply = self.reply
        if reply is not None and not reply.status:
            return False
        return not (self.may_be_refused and self.code == c.simx_return_remote_error_flag)

    @property
    def value(self) -> T:
        """Return the result.

        Raises:
            CallsFailed: the call has no result; names the server, the call and the reason.
        """
        reply = self.reply
        if reply is None or reply.status:
            raise CallsFailed([self.failure])
        result = self.marshal.success(reply.values)
        if result == 0:
            return cast(T, None)
        return cast(T, result[1] if len(result) == 2 else result[1:])

    @property
    def failure(self) -> Failure:
        """Return the reason for the missing value."""
        reply, name = self.reply, self.marshal.command.name
        # The server's text starts with the function's name, as simxGetLastErrors returns it.
        told = [str(value) for value in reply.values[:1]] if reply is not None else [self._reason]
        reason = told[0].removeprefix(f"{name}: ") if told else _NOT_YET
        call = f"{name}({', '.join(map(reprlib.repr, self.arguments))})"
        return Failure(self.server, self.where, call, self.code, reason)
