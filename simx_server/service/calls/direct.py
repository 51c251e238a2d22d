"""Execute the calls of a client in this process: without messages, in the caller's thread.

Everything that does not depend on the arguments is prepared once for each command.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from types import GeneratorType
from typing import Any

from simx_client.protocol.commands import Command
from simx_client.protocol.kinds import BOOL, BYTES, FLOAT, INT, MAX_BYTES, MAX_TEXT, TEXT, Kind
from simx_client.protocol.messages import STATUS_OK
from simx_client.protocol.precision import Values, as_single, through_message
from simx_server.errors import CommandError
from simx_server.service.answers.answers import Answer, answer_of
from simx_server.service.clients.sessions import ClientSession

from .background import Unfinished
from .dispatch import check
from .executor import Executor

_TIMED = 16
"""One call of this many of a command is timed: two clock readings and a count cost as much as reading a value."""


class DirectCall:
    """One command of one client, to be called within a turn."""

    __slots__ = (
        "_command", "_count", "_executor", "_gives_one", "_name", "_run", "_session", "_simulation", "_take",
        "may_change_pace", "received",
    )  # fmt: skip

    def __init__(self, executor: Executor, session: ClientSession, command: Command) -> None:
        """Prepare a command. If the client may not call it, each call is answered with the reason."""
        self._executor, self._simulation = executor, executor.world.simulation
        self._session, self._command, self._name = session, command, command.name
        try:
            self._run = executor.dispatch.handler(session, command).bound(executor.world, session)
        except CommandError as error:
            self._run = partial(_refuse, error)
        self._take = _taking(command)
        self.received = through_message([result.kind for result in command.results])
        """Gives values of an answer the form that a message would give them."""

        self.may_change_pace = command.waits_for_scripts
        """Whether it may start, stop or step the simulation."""

        self._gives_one = len(command.results) == 1
        self._count = 0

    def execute(self, arguments: Values) -> Answer | Future[Answer]:
        """Execute the call with the marshalled arguments, with all its steps."""
        began = self.begin()
        executor, session = self._executor, self._session
        outer = executor.client, executor.command
        executor.client, executor.command = session.client, self._name
        try:
            result: Any = self._run(*(arguments if self._take is None else self._take(arguments)))
            if result.__class__ is GeneratorType or result.__class__ is Future:
                answer = self._later(result)
            elif self._gives_one:
                answer = STATUS_OK, [result]
            else:
                answer = answer_of(self._command, result)
        except Exception as error:
            answer = executor.failure(session, self._name, error)
        finally:
            executor.client, executor.command = outer
            if not self._simulation.is_settled:
                self._simulation.settle()
        if began is not None:
            self.record(time.perf_counter() - began)
        if executor.log_of_calls is not None:
            executor.note(session, self._name, arguments, answer, only_reads=self._command.only_reads)
        return answer

    def begin(self) -> float | None:
        """Count an execution; return the time of its start if its duration is to be recorded."""
        count = self._count
        self._count = count + 1
        return None if count % _TIMED else time.perf_counter()

    def _later(self, result: Any) -> Answer | Future[Answer]:
        answer = self._executor.answer(self._session, self._command, result, self._executor.finish)
        assert not isinstance(answer, Unfinished)  # its steps are finished
        return answer

    def record(self, seconds: float) -> None:
        """Record the time of an execution, for all that follow until the next timed one."""
        times = 1 if self._count == 1 else _TIMED
        client = self._session
        metrics = self._executor.metrics
        metrics.executed(self._name, seconds, times)
        metrics.called(client.client, times)
        client.called[self._name] += times


def _refuse(error: CommandError, *_arguments: Any) -> None:
    raise error


# --- arguments -----------------------------------------------------------------------------------


def _taking(command: Command) -> Callable[[Values], Values] | None:
    """Return a function that gives coerced arguments the form that a message and the checks would give them.

    None if they have it already: the client's marshalling has made 32-bit integers.
    """
    kinds = [argument.kind for argument in command.arguments]
    others = [(position, kind) for position, kind in enumerate(kinds) if kind is not INT]
    if not others:
        return None
    sent = through_message(kinds)

    def in_general(arguments: Values) -> Values:
        return check(command, sent(arguments))

    if any(kind not in _PLAIN for _, kind in others):
        return in_general
    plain = [(position, _PLAIN[kind]) for position, kind in others]

    def take(arguments: Values) -> Values:
        taken = arguments.copy()
        for position, valid in plain:
            if (value := valid(taken[position])) is None:
                return in_general(arguments)  # which says what is wrong
            taken[position] = value
        return taken

    return take


def _number(value: float) -> float | None:
    number = as_single(value)
    return number if math.isfinite(number) else None


_PLAIN: dict[Kind, Callable[[Any], Any]] = {
    FLOAT: _number,
    BOOL: lambda value: value,
    TEXT: lambda value: value if value.__class__ is str and len(value) <= MAX_TEXT else None,
    BYTES: lambda value: value if len(value) <= MAX_BYTES else None,
}
"""Coercions of the most usual kinds, with the results of a message and the check; None if the value is refused."""
