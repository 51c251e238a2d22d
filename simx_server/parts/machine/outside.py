"""Answers that the simulation does not determine, such as bytes from a serial port: a recording has them.

A replay repeats the recorded answers, in their order, and touches nothing outside.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from simx_server.errors import CommandError

Answer = list[Any]
"""Values that MessagePack has: texts, bytes, numbers, Booleans."""


class Outside:
    """The one way by which scripts and clients get something from outside. Physics thread only."""

    def __init__(self) -> None:
        self._listeners: list[Callable[[Answer], object]] = []
        self._recorded: deque[Answer] | None = None

    def ask(self, act: Callable[[], Answer], *kinds: type) -> Answer:
        """Return what `act` returns, or in a replay what it returned when the recording was made.

        Args:
            act: uses the machine.
            kinds: the types of its values.

        Raises:
            CommandError: the recording has no such answer here.
        """
        if self._recorded is None:
            answer = act()
            for listen in self._listeners:
                listen(answer)
            return answer
        answer = self._recorded.popleft() if self._recorded else []
        if [type(value) for value in answer] != list(kinds):
            raise CommandError("the recording has no such answer from outside here")
        return answer

    def listen(self, listener: Callable[[Answer], object]) -> None:
        """Tell each answer to a recorder."""
        self._listeners.append(listener)

    def repeat(self, recorded: deque[Answer]) -> None:
        """Give these answers from now on, the first one first, and touch nothing outside."""
        self._recorded = recorded
