"""From a call to an answer: find the command, check its arguments, run its handler, turn exceptions into codes."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any, NamedTuple

from simx_client.protocol import constants as c
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR

from .errors import CommandError, shortened
from .handlers.registry import Handler
from .metrics import UNKNOWN, Metrics
from .sessions import ClientSession
from .simulation import Simulation

logger = logging.getLogger(__name__)


class Answer(NamedTuple):
    """What a call ended in: a status and wire values."""

    status: int
    values: list[Any]


class Dispatch:
    """Runs commands on a simulation. Physics thread only; pictures finish on the render thread."""

    def __init__(self, simulation: Simulation, handlers: Mapping[str, Handler], metrics: Metrics) -> None:
        self._simulation = simulation
        self._handlers = handlers
        self._metrics = metrics

    def execute(self, client: ClientSession, name: str, arguments: list[Any]) -> Answer | Future[Answer]:
        """Execute a command; a Future when its result comes later. Never raises."""
        try:
            command, checked = self.check(name, arguments)
        except Exception as error:
            meant = self.command(name)
            client.called[UNKNOWN if meant is None else meant.name] += 1
            return self._failure(client, name, error)
        client.called[command.name] += 1
        return self.carry_out(client, command, checked)

    def carry_out(
        self, client: ClientSession, command: Command, checked: list[Any]
    ) -> Answer | Future[Answer]:
        """As `execute`, with what `check` gave: a stream asks the same after each pass."""
        began = time.perf_counter()
        try:
            if client.may_only_read and not command.only_reads:
                raise CommandError(
                    f"{command.name} changes something, and {client.name} is a viewer, who may only read"
                )
            handler = self._handlers.get(command.name)
            if handler is None:
                raise CommandError(
                    f"{command.name} is not available in this version; 'simx-server --commands' lists what is"
                )
            result = handler(self._simulation, client, checked)
        except Exception as error:
            return self._failure(client, command.name, error)
        finally:
            self._metrics.executed(command.name, time.perf_counter() - began)
        if isinstance(result, Future):
            return self._later(client, command, result)
        return Answer(STATUS_OK, _values(command, result))

    def handler(self, command: Command) -> Handler | None:
        """What carries it out, if it is available."""
        return self._handlers.get(command.name)

    def look(self, client: ClientSession, handler: Handler, checked: list[Any]) -> Answer | Future[Answer]:
        """As `carry_out`, for what only reads and is asked after each pass; whoever asks counts it."""
        try:
            result = handler(self._simulation, client, checked)
        except Exception as error:
            return self._failure(client, handler.command.name, error)
        if isinstance(result, Future):
            return self._later(client, handler.command, result)
        return Answer(STATUS_OK, _values(handler.command, result))

    def command(self, name: str) -> Command | None:
        """The table's entry, if this is a remote command."""
        return ANSWERED.get(name)

    def check(self, name: str, arguments: list[Any]) -> tuple[Command, list[Any]]:
        """The command and its arguments as the handler gets them. Raises CommandError."""
        command = self.command(name)
        if command is None:
            raise CommandError(f"there is no command {name[:64]!r}; 'simx-server --commands' lists all")
        if len(arguments) != len(command.arguments):
            names = ", ".join(argument.name for argument in command.arguments) or "no arguments"
            raise CommandError(f"{command.name} takes {names}; got {len(arguments)} arguments")
        checked = []
        for argument, value in zip(command.arguments, arguments, strict=True):
            try:
                checked.append(argument.kind.check(value))
            except ValueError as error:
                raise CommandError(f"{command.name}: {argument.name} {error}") from None
        return command, checked

    def _failure(self, client: ClientSession, name: str, error: BaseException) -> Answer:
        if isinstance(error, CommandError) and error.silent:
            self._metrics.failed(name, "")
            return Answer(STATUS_REMOTE_ERROR, [])
        if isinstance(error, CommandError):
            text = shortened(str(error) if str(error).startswith(name) else f"{name[:64]}: {error}")
            if client.is_news(text):
                logger.info("%s of %s failed: %s", name[:64], client.name, shortened(str(error)))
        else:
            text = shortened(f"{name}: internal error, see the server's log: {type(error).__name__}: {error}")
            if client.is_news(text):
                logger.error("%s of %s failed", name, client.name, exc_info=error)
        self._metrics.failed(name, text, is_internal=not isinstance(error, CommandError))
        mode = self._simulation.parameters.error_report_mode
        if mode & c.sim_api_errormessage_report:
            client.errors.append(text)
        if mode & c.sim_api_errormessage_output:
            self._simulation.status_bar.add(text)
        return Answer(STATUS_REMOTE_ERROR, [text])

    def _later(self, client: ClientSession, command: Command, result: Future[Any]) -> Future[Answer]:
        answer: Future[Answer] = Future()

        def finish(done: Future[Any]) -> None:
            try:
                outcome = Answer(STATUS_OK, _values(command, done.result()))
            except Exception as error:
                outcome = self._failure(client, command.name, error)
            answer.set_result(outcome)

        result.add_done_callback(finish)
        return answer


def _values(command: Command, result: Any) -> list[Any]:
    """A handler's return value as wire values: none, one, or a tuple of several."""
    count = len(command.results)
    if count == 0:
        return []
    return [result] if count == 1 else list(result)
