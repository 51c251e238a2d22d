"""Run calls: handlers of the table, their steps and streams, and functions of the namespaces of scripts.

Each run is timed and counted, and the result or exception becomes an answer. This file keeps for all of them
the name of the call that is executed, the notes for the history and the texts of failures.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from types import GeneratorType
from typing import TYPE_CHECKING, Any, overload

import mujoco

from simx_client.protocol import constants as c
from simx_client.protocol.commands import Command
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR
from simx_server.errors import CommandError, one_line, shortened
from simx_server.service.answers.answers import DONE, Answer, answer_of
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.monitoring.metrics import Metrics, Tally

from .background import Unfinished, refuse_steps
from .dispatch import Dispatch, Handling

if TYPE_CHECKING:
    from simx_server.service.monitoring.log_of_calls import Called, LogOfCalls

logger = logging.getLogger(__name__)

_NOT_YET = frozenset((Future, GeneratorType))
"""Types that a handler returns for results that come later: an image, or steps."""


class Executor:
    """Runs handlers. Physics thread only, except `failure`; images finish on the render thread."""

    def __init__(self, dispatch: Dispatch, metrics: Metrics) -> None:
        self.dispatch = dispatch
        self.world = dispatch.world
        self.metrics = metrics
        self.client = ""
        """The client whose call is being executed; empty if there is none."""

        self.command = ""
        """The function that is being executed for it."""

        self.log_of_calls: LogOfCalls | None = None
        """Notes the calls of clients; None while no history is kept. See `note_in`."""

    # --- what is being executed ------------------------------------------------------------------

    def begin(self, client: str, command: str) -> tuple[str, str]:
        """Mark a call as the one that is being executed; pass the result to `end` after it."""
        outer = self.client, self.command
        self.client, self.command = client, command
        return outer

    def end(self, outer: tuple[str, str]) -> None:
        """Mark the call before as the one that is being executed."""
        self.client, self.command = outer

    @contextmanager
    def doing(self, client: str, command: str) -> Generator[None]:
        """Mark a call as the one that is being executed within the block."""
        outer = self.begin(client, command)
        try:
            yield
        finally:
            self.end(outer)

    def note_in(self, log: LogOfCalls | None) -> None:
        """Note calls in a log from now on; None: nowhere."""
        self.log_of_calls = log

    def note(
        self,
        client: ClientSession,
        function: str,
        arguments: Sequence[Any],
        answer: Answer | Future[Answer] | None,
        *,
        only_reads: bool,
    ) -> Called | None:
        """Note a call for the history; None if there is none, or it is not noted.

        Args:
            answer: None if it comes later.
        """
        if self.log_of_calls is None:
            return None
        return self.log_of_calls.note(client.name, function, arguments, answer, only_reads=only_reads)

    # --- handlers of the table -------------------------------------------------------------------

    @overload
    def execute(
        self, client: ClientSession, tally: Tally, command: Command, work: Handling
    ) -> Answer | Future[Answer]: ...

    @overload
    def execute(
        self,
        client: ClientSession,
        tally: Tally,
        command: Command,
        work: Handling,
        arguments: Sequence[Any],
        at_step: Callable[[Unfinished], Any],
    ) -> Answer | Future[Answer] | Unfinished: ...

    def execute(
        self,
        client: ClientSession,
        tally: Tally,
        command: Command,
        work: Handling,
        arguments: Sequence[Any] = (),
        at_step: Callable[[Unfinished], Any] = refuse_steps,
    ) -> Answer | Future[Answer] | Unfinished:
        """Run a handler. Never raises.

        Args:
            tally: counts and times it, together with earlier executions.
            work: the handler, bound to the world; it may refuse the arguments.
            at_step: decides what to do with a call that takes several steps: returns its result, returns the call
                itself if the caller must wait for the step, or raises.

        Returns:
            A future if the result comes later; the call if the caller must wait for its step.
        """
        if command is not tally.command:
            tally.turn_to(command)
        tally.count += 1
        try:
            result = work(*arguments)
            if result.__class__ in _NOT_YET:
                return self.answer(client, command, result, at_step)
            if len(command.results) == 1:
                return STATUS_OK, [result]
            return DONE if result is None and not command.results else answer_of(command, result)
        except Exception as error:
            return self.failure(client, command.name, error)

    def tally(self, called: dict[str, int] | None = None) -> Tally:
        """Return a tally that counts and times handlers that run one after another.

        Args:
            called: how often a client called each command; the tally adds to it as well.
        """
        return Tally(self.metrics, called)

    def finish(self, call: Unfinished) -> Any:
        """Run all steps of a call at once, for ``execute``; return its result, or raise what the steps raise."""
        return self.world.trials.finish(call.all_steps())

    def answer(
        self, client: ClientSession, command: Command, result: Any, at_step: Callable[[Unfinished], Any]
    ) -> Answer | Future[Answer] | Unfinished:
        """Return the answer to a call with a later result. Raises what the handler or `at_step` raises."""
        if isinstance(result, GeneratorType):
            try:
                # A handler may return steps, or a future, of anything.
                call = Unfinished(command, result, next(result))  # pyright: ignore[reportUnknownArgumentType]
            except StopIteration as end:
                result = end.value
            else:
                result = at_step(call)
                if result is call:
                    return call
        if isinstance(result, Future):
            # As with steps.
            return self._later(client, command, result)  # pyright: ignore[reportUnknownArgumentType]
        return answer_of(command, result)

    def _later(self, client: ClientSession, command: Command, result: Future[Any]) -> Future[Answer]:
        answer: Future[Answer] = Future()

        def finish(done: Future[Any]) -> None:
            try:
                outcome = answer_of(command, done.result())
            except Exception as error:
                outcome = self.failure(client, command.name, error)
                # Its frames refer to `done`, which keeps the error: this cycle would keep all of them alive.
                error.__traceback__ = None
            answer.set_result(outcome)

        result.add_done_callback(finish)
        return answer

    # --- failures --------------------------------------------------------------------------------

    def failure(self, client: ClientSession, name: str, error: BaseException) -> Answer:
        """Return the answer to a failed call; add the reason to the log, the counters and the client's errors."""
        if isinstance(error, mujoco.FatalError):  # a readable text, and not an error of this program
            error = CommandError(f"MuJoCo cannot do that: {one_line(error)}")
        if isinstance(error, CommandError) and error.silent:
            self.metrics.failed(name, "")
            return STATUS_REMOTE_ERROR, []
        if isinstance(error, CommandError):
            text = shortened(str(error) if str(error).startswith(name) else f"{name[:64]}: {error}")
            if client.is_news(text):
                logger.info("%s of %s failed: %s", name[:64], client.name, shortened(str(error)))
        else:
            text = shortened(f"{name}: internal error, see the server's log: {type(error).__name__}: {error}")
            if client.is_news(text):
                logger.error("%s of %s failed", name, client.name, exc_info=error)
        self.metrics.failed(name, text, is_internal=not isinstance(error, CommandError))
        mode = self.world.parameters.error_report_mode
        if mode & c.sim_api_errormessage_report:
            client.errors.append(text)
        if mode & c.sim_api_errormessage_output:
            self.world.status_bar.add(text)
        return STATUS_REMOTE_ERROR, [text]

    def failed(self, client: ClientSession, name: str, error: Exception) -> str:
        """Return the text of `failure`, for an API whose answers are not the table's. Physics thread."""
        _, values = self.failure(client, name, error)
        return str(values[0]) if values else f"{name}: {error}"
