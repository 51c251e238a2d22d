"""From a call to an answer: find the command, check its arguments, run its handler, turn exceptions into codes."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from types import GeneratorType
from typing import Any, NamedTuple

import mujoco

from simx_client.protocol import constants as c
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.kinds import apply
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, of_fields
from simx_server.errors import CommandError, one_line, shortened
from simx_server.handlers.registry import Handler
from simx_server.world.world import World

from .background import Steps, Task
from .monitoring.metrics import UNKNOWN, Metrics, Tally
from .sessions import ClientSession

logger = logging.getLogger(__name__)


class Answer(NamedTuple):
    """What a call ended in: a status and wire values."""

    status: int
    values: list[Any]


DONE = Answer(STATUS_OK, [])
"""Of what gives nothing."""


@dataclass(eq=False)
class Unfinished:
    """A call of which a step is to be done beside the physics thread, see `steps.py`."""

    command: Command
    steps: Steps[Any]
    task: Task[Any]
    """The step."""

    def all_steps(self) -> Steps[Any]:
        """This step, and those behind it."""
        yield self.task
        return (yield from self.steps)

    def abandon(self) -> None:
        """Its client has left."""
        self.task.give_up()
        self.steps.close()


class Dispatch:
    """Runs commands on a simulation. Physics thread only; pictures finish on the render thread."""

    def __init__(self, world: World, handlers: Mapping[str, Handler], metrics: Metrics) -> None:
        self.world = world
        self._handlers = handlers
        self.metrics = metrics
        self.executing = ""
        """The command of the last call that was begun."""

    def run(self, client: ClientSession) -> Run:
        """To execute calls of this client, one behind the other; ``end`` it."""
        return Run(self, client)

    def carry_out(
        self, client: ClientSession, command: Command, checked: list[Any]
    ) -> Answer | Future[Answer]:
        """Execute a command with what `check` gave: a stream asks the same after each pass. Never raises."""
        began = time.perf_counter()
        try:
            handler = self.handler(client, command)
            answer = self.begin(client, command, handler(self.world, client, checked))
            return self.refuse(client, answer) if isinstance(answer, Unfinished) else answer
        except Exception as error:
            return self.failure(client, command.name, error)
        finally:
            self.metrics.executed(command.name, time.perf_counter() - began)

    def handler(self, client: ClientSession, command: Command) -> Handler:
        """What carries it out for this client. Raises CommandError."""
        if client.may_only_read and not command.only_reads:
            raise CommandError(
                f"{command.name} changes something, and {client.name} is a viewer, who may only read"
            )
        handler = self._handlers.get(command.name)
        if handler is None:
            raise CommandError(
                f"{command.name} is not available in this version; 'simx-server --commands' lists what is"
            )
        return handler

    def check(self, name: str, arguments: list[Any]) -> tuple[Command, list[Any]]:
        """The command and its arguments as the handler gets them. Raises CommandError."""
        command = _command(name)
        return command, _checked(command, arguments)

    def begin(
        self, client: ClientSession, command: Command, result: Any
    ) -> Answer | Future[Answer] | Unfinished:
        """As ``answer``, for what may take several steps."""
        if isinstance(result, GeneratorType):
            return self._take_steps(client, command, result)
        return self.answer(client, command, result)

    def answer(self, client: ClientSession, command: Command, result: Any) -> Answer | Future[Answer]:
        """What a handler gave, as an answer."""
        if result is None and not command.results:
            return DONE
        if isinstance(result, Future):
            return self._later(client, command, result)
        return of_fields(Answer, (STATUS_OK, _values(command, result)))

    def _take_steps(
        self, client: ClientSession, command: Command, steps: Steps[Any]
    ) -> Answer | Future[Answer] | Unfinished:
        """Raises what the handler raises."""
        try:
            task = next(steps)
        except StopIteration as end:
            return self.answer(client, command, end.value)
        return Unfinished(command, steps, task)

    def go_on(self, client: ClientSession, call: Unfinished) -> Answer | Future[Answer] | Unfinished:
        """Take the steps behind the one that is done. Never raises."""
        began = time.perf_counter()
        self.executing = call.command.name
        try:
            return self._take_steps(client, call.command, call.steps)
        except Exception as error:
            return self.failure(client, call.command.name, error)
        finally:
            self.metrics.executed(call.command.name, time.perf_counter() - began)

    def finish(self, client: ClientSession, call: Unfinished) -> Answer | Future[Answer]:
        """Take all steps before returning. Never raises."""
        try:
            return self.answer(client, call.command, self.world.trials.finish(call.all_steps()))
        except Exception as error:
            return self.failure(client, call.command.name, error)

    def refuse(self, client: ClientSession, call: Unfinished) -> Answer:
        """A stream asks again after each pass, and this would take longer."""
        call.abandon()
        text = "a file that a client sent cannot be loaded by a stream; call it with a blocking mode"
        return self.failure(client, call.command.name, CommandError(text))

    def failure(self, client: ClientSession, name: str, error: BaseException) -> Answer:
        """The answer to a call that failed; the log, the counters and the client's errors are told why."""
        if isinstance(error, mujoco.FatalError):  # a text for people, and no fault of this program's
            error = CommandError(f"MuJoCo cannot do that: {one_line(error)}")
        if isinstance(error, CommandError) and error.silent:
            self.metrics.failed(name, "")
            return Answer(STATUS_REMOTE_ERROR, [])
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
        return Answer(STATUS_REMOTE_ERROR, [text])

    def _later(self, client: ClientSession, command: Command, result: Future[Any]) -> Future[Answer]:
        answer: Future[Answer] = Future()

        def finish(done: Future[Any]) -> None:
            try:
                outcome = Answer(STATUS_OK, _values(command, done.result()))
            except Exception as error:
                outcome = self.failure(client, command.name, error)
                error.__traceback__ = (
                    None  # its frames know `done`, which keeps the error: nothing of it would go
                )
            answer.set_result(outcome)

        result.add_done_callback(finish)
        return answer


class Run:
    """Calls of one client, one behind the other. What is the same for calls of one command is done once for them."""

    __slots__ = ("_carry_out", "_client", "_command", "_dispatch", "_name", "_tally")

    def __init__(self, dispatch: Dispatch, client: ClientSession) -> None:
        self._dispatch, self._client = dispatch, client
        self._name: str | None = None
        """What the last call named, if it could be executed."""

        self._command: Command
        self._carry_out: Callable[..., Any]
        self._tally = Tally(dispatch.metrics)

    def execute(self, name: str, arguments: list[Any]) -> Answer | Future[Answer] | Unfinished:
        """Execute a call; a Future when its result comes later. Never raises."""
        try:
            if name != self._name:
                self._turn_to(name)
            self._tally.count += 1
            command = self._command
            result = self._carry_out(*_checked(command, arguments))
            if result is None and not command.results:
                return DONE
            return self._dispatch.begin(self._client, command, result)
        except Exception as error:
            known = ANSWERED.get(name)  # aliases are counted together
            return self._dispatch.failure(self._client, name if known is None else known.name, error)

    def _turn_to(self, name: str) -> None:
        """Find what is the same for all calls of this name. Raises CommandError."""
        self.end()
        try:
            command = _command(name)
        except CommandError:
            self._client.called[UNKNOWN] += 1
            raise
        self._tally.turn_to(command.name)
        try:
            handler = self._dispatch.handler(self._client, command)
        except CommandError:
            self._client.called[command.name] += 1
            self._tally.count += 1
            self._tally.end()
            raise
        self._name, self._command = name, command
        self._dispatch.executing = command.name
        self._carry_out = handler.bound(self._dispatch.world, self._client)

    def end(self) -> None:
        """Count what was executed."""
        if self._name is not None:
            self._client.called[self._command.name] += self._tally.count
            self._tally.end()
            self._name = None


def _command(name: str) -> Command:
    """The table's entry, if this is a remote command. Raises CommandError."""
    command = ANSWERED.get(name)
    if command is None:
        raise CommandError(f"there is no command {name[:64]!r}; 'simx-server --commands' lists all")
    return command


def _checked(command: Command, arguments: list[Any]) -> list[Any]:
    """The arguments as the handler gets them. Raises CommandError."""
    checks = command.checks
    if len(arguments) == len(checks):
        try:
            return list(map(apply, checks, arguments))
        except ValueError:
            pass
    raise _refusal(command, arguments)


def _refusal(command: Command, arguments: list[Any]) -> CommandError:
    """What is wrong with these arguments."""
    if len(arguments) != len(command.arguments):
        names = ", ".join(argument.name for argument in command.arguments) or "no arguments"
        return CommandError(f"{command.name} takes {names}; got {len(arguments)} arguments")
    for argument, value in zip(command.arguments, arguments, strict=True):
        try:
            argument.kind.check(value)
        except ValueError as error:
            return CommandError(f"{command.name}: {argument.name} {error}")
    raise AssertionError(f"these arguments of {command.name} are right")


def _values(command: Command, result: Any) -> list[Any]:
    """A handler's return value as wire values: none, one, or a tuple of several."""
    count = len(command.results)
    if count == 0:
        return []
    return [result] if count == 1 else list(result)
