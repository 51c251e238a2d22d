"""What a call ended in: a status and wire values."""

from __future__ import annotations

from typing import Any, NamedTuple

from simx_client.protocol.commands import Command
from simx_client.protocol.messages import STATUS_OK, of_fields


class Answer(NamedTuple):
    """A status and wire values."""

    status: int
    values: list[Any]


DONE = Answer(STATUS_OK, [])
"""The answer of a handler that returns nothing."""


def answer_of(command: Command, result: Any) -> Answer:
    """Return what a handler returned as an answer: no value, one, or those of a tuple."""
    count = len(command.results)
    values = [result] if count == 1 else list(result) if count else []
    return of_fields(Answer, (STATUS_OK, values))
