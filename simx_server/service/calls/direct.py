"""Execute the calls of a client in this process: without messages, in the caller's thread.

Everything that does not depend on the arguments is prepared once for each command.
"""

from __future__ import annotations

import time
from concurrent.futures import Future
from functools import partial
from types import GeneratorType
from typing import TYPE_CHECKING, Any

from simx_client.protocol.commands import Command
from simx_client.protocol.kinds import INT
from simx_client.protocol.messages import STATUS_OK
from simx_client.protocol.precision import Values, through_message
from simx_server.errors import CommandError
from simx_server.service.answers.answers import Answer, answer_of
from simx_server.service.clients.sessions import ClientSession

from .background import Unfinished
from .dispatch import Dispatch, check
from .executor import Executor

if TYPE_CHECKING:
    from simx_server.service.server_loop import ServerLoop

    from .batches import Batches

TIMED = 16
"""One call of this many of a command is timed: two clock readings and a count cost as much as reading a value."""


class DirectCall:
    """One command of one client, to be called within a turn."""

    __slots__ = (
        "_batches", "_check", "_command", "_count", "_executor", "_gives_one", "_loop", "_run", "_sent", "_session",
        "_simulation", "may_change_pace", "received",
    )  # fmt: skip

    def __init__(
        self,
        batches: Batches,
        dispatch: Dispatch,
        executor: Executor,
        session: ClientSession,
        command: Command,
        loop: ServerLoop,
    ) -> None:
        """Prepare a command. If the client may not call it, each call is answered with the reason."""
        kinds = [argument.kind for argument in command.arguments]
        self._batches, self._executor, self._loop = batches, executor, loop
        self._simulation = executor.world.simulation
        self._session, self._command = session, command
        try:
            self._run = dispatch.handler(session, command).bound(dispatch.world, session)
        except CommandError as error:
            self._run = partial(_refuse, error)
        # The client's marshalling has made 32-bit integers already.
        is_checked = all(kind is INT for kind in kinds)
        self._check = None if is_checked else partial(check, command)
        self._sent = through_message(kinds)
        self.received = through_message([result.kind for result in command.results])
        """Gives values of an answer the form that a message would give them."""

        self.may_change_pace = command.waits_for_scripts
        """Whether it may start, stop or step the simulation."""

        self._gives_one = len(command.results) == 1
        self._count = 0

    def execute(self, arguments: Values) -> Answer | Future[Answer]:
        """Execute the call with the marshalled arguments, with all its steps."""
        self._count = count = self._count + 1
        if count % TIMED == 1:
            began = time.perf_counter()
            answer = self._execute(arguments)
            self._record(time.perf_counter() - began)
        else:
            answer = self._execute(arguments)
        if (log := self._loop.log_of_calls) is not None:
            command = self._command
            log.note(self._session.name, command.name, arguments, answer, only_reads=command.only_reads)
        return answer

    def _execute(self, arguments: Values) -> Answer | Future[Answer]:
        batches, command = self._batches, self._command
        outer = batches.executing, batches.command
        batches.executing, batches.command = self._session.client, command.name
        try:
            if self._check is not None:
                arguments = self._check(self._sent(arguments))
            result: Any = self._run(*arguments)
            if result.__class__ is GeneratorType or result.__class__ is Future:
                return self._later(result)
            return (STATUS_OK, [result]) if self._gives_one else answer_of(command, result)
        except Exception as error:
            return self._executor.failure(self._session, command.name, error)
        finally:
            batches.executing, batches.command = outer
            if not self._simulation.is_settled:
                self._simulation.settle()

    def _later(self, result: Any) -> Answer | Future[Answer]:
        answer = self._executor.answer(self._session, self._command, result, self._executor.finish)
        assert not isinstance(answer, Unfinished)  # its steps are finished
        return answer

    def _record(self, seconds: float) -> None:
        """Count this call for all that follow until the next timed one."""
        times = 1 if self._count == 1 else TIMED
        name, client = self._command.name, self._session
        metrics = self._executor.metrics
        metrics.executed(name, seconds, times)
        metrics.called(client.client, times)
        client.called[name] += times


def _refuse(error: CommandError, *_arguments: Any) -> None:
    raise error
