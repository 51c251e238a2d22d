"""The outcome of a call: a status and wire values."""

from __future__ import annotations

from typing import Any

from simx_client.protocol.commands import Command
from simx_client.protocol.messages import STATUS_OK

Answer = tuple[int, list[Any]]
"""A status and wire values. A plain tuple, because each call and each stream makes one in every step."""

DONE: Answer = STATUS_OK, []
"""The answer of a handler that returns nothing."""


def answer_of(command: Command, result: Any) -> Answer:
    """Return the result of a handler as an answer: no value, one, or those of a tuple."""
    count = len(command.results)
    return STATUS_OK, [result] if count == 1 else list(result) if count else []
