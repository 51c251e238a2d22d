"""Answer the messages of one connection: call methods, and call the functions that the client has registered.

Both sides number their requests, so the server may call the client at any time: within a call of the client, as an
argument of which a function came, or in a phase of the simulation, such as ``sysCall_sensing``.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.scripting.conversion.strings import NUMBERS
from simx_server.scripting.interpreter import ScriptError, Waiting
from simx_server.service.calls.lasting import LastingCall
from simx_server.service.monitoring.metrics import UNKNOWN
from simx_server.sim_api.object_model.dispatch import is_known

from ..zmq.calls import NoSuchFunction
from ..zmq.connection import Connection
from ..zmq.wire.messages import WireError
from .calls import invoke
from .messages import (
    CALL,
    NOOP,
    REGISTER,
    RESULT,
    Message,
    call_of,
    error_of,
    number_of,
    read_message,
    result_of,
)
from .tags import FunctionName, travelling

if TYPE_CHECKING:
    from simx_server.service.calls.lasting import Results

    from ..zmq.client import Client
    from ..zmq.clients import ZmqClients
    from ..zmq.peer import Peer

logger = logging.getLogger(__name__)

PHASES = (
    *(
        "sysCall_actuation",
        "sysCall_sensing",
        "sysCall_nonSimulation",
        "sysCall_suspend",
        "sysCall_suspended",
    ),
    *("sysCall_resume", "sysCall_beforeSimulation", "sysCall_afterSimulation"),
)
"""Call-backs that clients get; in this order in the original's manual they belong to scripts."""

MOST_REGISTERED = 200
"""Functions of one client."""

_READ_QUICKLY = frozenset(("step", "setStepping"))
_LETTERS = 80


class RegisteredFunction:
    """A function of the client, which the server may call at any time; see `interpreter.Function`."""

    def __init__(self, connection: ModelConnection, name: str) -> None:
        self._connection, self._name = connection, name

    def __call__(self, *arguments: Any) -> list[Any]:
        return self._connection.call_back(self._name, arguments)


class ModelConnection(Connection):
    """One connection of a client of API 2, which has no other. Physics thread."""

    def __init__(self, clients: ZmqClients, client: Client, peer: Peer) -> None:
        super().__init__(clients, client, peer)
        self._has_numbers = True
        """Whether the client numbers its requests; the first clients of API 2 did not."""

        self._number: int | None = None
        """The client's number of the call that is being answered."""

        self._next_number = 1
        self._registered: set[str] = set()
        self._late: set[int] = set()
        """Numbers of the server's calls that the client has not answered in time: no phase calls it until it has."""

        self._is_in_phase = False
        self._deferred: list[bytes] = []
        """Requests that wait for simulation steps and came while a phase called the client: it may have sent them
        before it saw the call, so they are executed after it.
        """

    # --- messages --------------------------------------------------------------------------------

    def receive(self, payload: bytes) -> None:
        try:
            message = read_message(payload)
        except WireError as problem:
            self._refuse_unreadable(payload, problem)
            return
        if message.kind == RESULT:
            self.peer.count_answered()  # nothing answers it
            self._clients.note(self, payload)
            self._come_back(message)
        elif self._may_answer(message):
            self._has_numbers = message.number is not None
            if message.kind == REGISTER:
                self._clients.note(self, payload)
                self._answer_now(message, partial(self._register, message))
            elif self._call is not None and self._call.is_waiting:
                waiting = CommandError(f"{self._call.name} is not answered yet")
                with self._answering(message.number):
                    self._refuse(message.function, waiting)
            else:
                self._number = message.number
                self._clients.note(self, payload)
                self._execute_call(message)

    @contextmanager
    def _answering(self, number: int | None) -> Generator[None]:
        """Answer another request than the present call."""
        present, self._number = self._number, number
        try:
            yield
        finally:
            self._number = present

    def _may_answer(self, message: Message) -> bool:
        """Return whether a message has an answer; log one of unknown kind."""
        if message.kind in (CALL, REGISTER):
            return True
        if message.kind != NOOP:
            logger.info("%s sends a message of unknown kind: %s", self.client.name, message.kind[:_LETTERS])
        self.peer.count_answered()
        return False

    def _refuse_unreadable(self, payload: bytes, problem: WireError) -> None:
        """Answer a message that cannot be read, as far as it shows its number."""
        number = number_of(payload)
        logger.info("%s sends a message that cannot be read: %s", self.client.name, problem)
        self._clients.answer(self.peer, error_of(number, str(problem)))

    def _come_back(self, message: Message) -> None:
        """Take an answer that came too late: the client serves calls again."""
        if message.number is None:
            self._late.clear()
        else:
            self._late.discard(message.number)

    def _execute_call(self, message: Message) -> None:
        name = message.function
        call = self._call = LastingCall(self._executor, self.client.session, name)
        noted = [travelling(each) for each in message.arguments] if self._executor.log_of_calls else ()
        counted = name if message.target is not None and is_known(name) else UNKNOWN
        call.begin(counted, name, noted, only_reads=name in _READ_QUICKLY)
        self._run(partial(call.run, partial(self._do, message)))

    def _do(self, message: Message) -> tuple[Any, ...] | Waiting:
        """Do what a call says. Raises CommandError."""
        if message.target is None:
            return self._call_function(message)
        arguments = [self._with_functions(each) for each in message.arguments]
        return invoke(self.client, message.target, message.function, arguments)

    def _call_function(self, message: Message) -> tuple[Any, ...]:
        """Call a function of the server by name, of those that the original's worker script has."""
        functions: Mapping[str, Callable[[], tuple[Any, ...]]] = {
            "getPort": lambda: (self.client.session.port,),
            NOOP: lambda: (),
        }
        found = functions.get(message.function)
        if found is None:
            advice = did_you_mean(message.function, list(functions))
            raise NoSuchFunction(
                f"no such function: {message.function[:_LETTERS]}{advice}; methods have a target"
            )
        return found()

    def _with_functions(self, value: Any) -> Any:
        """Return an argument with functions of the client in place of their names, there and in lists and maps."""
        if isinstance(value, FunctionName):
            return self._function_of_client(value.name)
        if isinstance(value, str):  # older clients pass the name of a function that they have registered
            is_function = value in self._registered and value not in PHASES
            return self._function_of_client(value) if is_function else value
        if isinstance(value, list):
            items = cast(list[Any], value)
            return (
                items if set(map(type, items)) <= NUMBERS else [self._with_functions(each) for each in items]
            )
        if isinstance(value, dict):
            return {key: self._with_functions(each) for key, each in cast(dict[Any, Any], value).items()}
        return value

    def _function_of_client(self, name: str) -> Any:
        super()._function_of_client(name)  # it refuses those of viewers
        return RegisteredFunction(self, name)

    # --- answers ---------------------------------------------------------------------------------

    def _answer_now(self, message: Message, act: Callable[[], Any]) -> None:
        """Answer a request with the result of an action."""
        try:
            value = act()
        except CommandError as problem:
            with self._answering(message.number):
                self._refuse(message.function, problem)
            return
        self._clients.answer(self.peer, result_of(message.number, value))

    def _send(self, message: dict[str, Any]) -> None:
        """Send an answer to the present request, of the results or the error of the older protocol."""
        if "err" in message:
            self._clients.answer(self.peer, error_of(self._number, message["err"]))
        else:
            self._clients.answer(self.peer, result_of(self._number, message.get("ret", [])))

    def _send_results(self, function: str, results: Results) -> Exception | None:
        try:
            self._send({"ret": travelling(results)})
        except (TypeError, ValueError) as problem:
            return CommandError(f"the result cannot be sent: {problem}")
        return None

    def broken(self, reason: str) -> ScriptError:
        """Return the error that ends the present call, which the client still waits for."""
        return ScriptError(reason)

    # --- functions of the client -----------------------------------------------------------------

    def _register(self, message: Message) -> bool:
        """Note a function of the client; a phase of the simulation calls it from now on. Raises CommandError."""
        name = message.function
        if self.client.session.may_only_read:
            raise CommandError(f"{self.client.name} is a viewer, who may only read, and passes no functions")
        if len(self._registered) >= MOST_REGISTERED and name not in self._registered:
            raise CommandError(f"at most {MOST_REGISTERED} functions of a client are called")
        self._registered.add(name)
        if message.is_global and name.startswith("sysCall_"):
            if name not in PHASES:
                raise CommandError(
                    f"{name[:_LETTERS]} is not called for clients; those are {', '.join(PHASES)}"
                )
            self._world.scripts.phases.outside.add(name, self, partial(self._call_phase, name))
        return True

    def _call_phase(self, name: str, *values: Any) -> None:
        """Call the client in a phase of the simulation, unless it still owes an answer to an earlier call."""
        if self._late or self.peer.is_gone or not self._has_numbers:
            return  # without numbers a client hears nothing outside of its calls
        outer, self._is_in_phase = self._number, True
        try:
            self._act(lambda: self.call_back(name, values))
        except ScriptError as problem:
            self._world.scripts.told_once.tell(f"{self.client.name}: {name}: {problem}")
        finally:
            self._number, self._is_in_phase = outer, False
            deferred, self._deferred = self._deferred, []
            for payload in deferred:
                self._clients.pass_on(self, payload)

    def call_back(self, name: str, arguments: tuple[Any, ...]) -> list[Any]:
        number, self._next_number = self._next_number, self._next_number + 1
        with self._nested() as queue, self._answering(self._number):
            self._late.add(number)
            sent = number if self._has_numbers else None
            self._clients.answer(self.peer, call_of(sent, name, travelling(arguments)))
            while True:
                payload = self._clients.next_message(self, queue, name)
                message = self._readable(payload)
                if message is None:
                    continue
                if message.kind == RESULT:
                    self.peer.count_answered()
                    if message.number not in (number, None):
                        self._late.discard(message.number)
                        continue
                    self._late.discard(number)
                    return self._results_of(name, message)
                self._serve_message(message, payload, name)

    @staticmethod
    def _results_of(name: str, message: Message) -> list[Any]:
        if message.is_error:
            text = str(message.arguments[0]) if message.arguments else "without a text"
            raise ScriptError(f"the function {name} of a client failed: {text}")
        return list(message.arguments)

    def _readable(self, payload: bytes) -> Message | None:
        """Return a message of the client; None if it was unreadable and is answered already."""
        try:
            return read_message(payload)
        except WireError as problem:
            self._refuse_unreadable(payload, problem)
            return None

    def _serve_message(self, message: Message, payload: bytes, name: str) -> None:
        """Answer a request that the client makes in its function."""
        if not self._may_answer(message):
            return
        self._number = message.number
        if message.kind == REGISTER:
            self._answer_now(message, partial(self._register, message))
            return
        try:
            outcome = self._do(message)
            if isinstance(outcome, Generator):
                outcome.close()
                if self._is_in_phase:
                    self._deferred.append(payload)
                    return
                raise CommandError(
                    f"{message.function} waits for a simulation step, so it cannot be called within {name}"
                )
        except Exception as problem:
            self._refuse(message.function, problem)
            return
        if problem := self._send_results(message.function, outcome):
            self._refuse(message.function, problem)

    def leave(self) -> None:
        """Have no phase call the client any more."""
        self._world.scripts.phases.outside.remove(self)
