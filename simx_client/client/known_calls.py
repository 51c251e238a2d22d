"""Calls that are made while the results of a step are read: most of them repeat calls whose answers are at hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.connection.calls import Calls

T = TypeVar("T")

Reads = dict[tuple[Any, ...], Answer[Any]]
"""Calls that only read, by function and arguments."""

_AS_THEY_ARE = frozenset((int, str))
"""Types of arguments that marshalling does not change, or makes unequal to all known ones."""


class _NotAtHand(Exception):
    """The answer to a call is not known."""


class KnownCalls(Calls):
    """Calls that are not made: their answers are at hand."""

    __slots__ = ("_looked_at", "answers")

    def __init__(self, where: str, answers: Reads, looked_at: Reads) -> None:
        """Note calls.

        Args:
            where: the address of the server, for messages.
            answers: those at hand.
            looked_at: more of them; the calls that are noted are added.
        """
        super().__init__(0, where)
        self.answers, self._looked_at = answers, looked_at

    def result(self, note: Callable[[Calls], T]) -> T | None:
        """Return what `note` returns if the answers to all calls that it notes are at hand, and no refusals."""
        self.noted.clear()
        try:
            result = note(self)
        except _NotAtHand:
            return None
        for answer in self.noted:
            if answer.reply is None or answer.reply.status:
                return None
        return result

    def note(self, marshal: Marshal, arguments: tuple[Any, ...]) -> Answer[Any]:
        key = (marshal.command.name, *arguments)
        answer = self.answers.get(key) if _AS_THEY_ARE.issuperset(map(type, arguments)) else None
        if answer is None:
            raise _NotAtHand
        self._looked_at[key] = answer
        self.noted.append(answer)
        return answer
