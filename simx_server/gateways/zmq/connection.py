"""Answer the messages of one connection: run a call, continue it after simulation steps, call the client's functions.

A client waits for one answer at a time on a connection. A function of the client is the exception: its request is the
answer to the call that needs it, and meanwhile the client may call the server again.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR
from simx_server import sim_api as api
from simx_server.errors import CommandError, UnknownName
from simx_server.scripting.interpreter import ScriptError, Waiting
from simx_server.service.calls.lasting import LastingCall, Results
from simx_server.service.monitoring.metrics import UNKNOWN

from .calls import NoSuchFunction, invoke
from .functions import described
from .results import to_client, with_functions
from .wire.messages import END, EXECUTED, Request, WireError
from .wire.requests import Requests

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.world.world import World

    from .client import Client
    from .peer import Peer

_Result = TypeVar("_Result")

_SPACES = ("zmqRemoteApi", *api.NAMESPACES)

MOST_NESTED = 8
"""Functions of the client that may wait for each other."""

_STEPS = ("sim.step", "sim.setStepping")
"""Functions that come with every step of a client that steps."""

SILENCE = 0.9
"""Seconds that the client may take for the functions in one call, or in one simulation step of a call that waits."""


class Patience(NamedTuple):
    """More time that functions of a client have in one call or step."""

    quick: float
    """Seconds more for each message: a call that needs thousands of quick answers gets them."""

    longest: float
    """Seconds for all functions together, with the calls that they make."""


ALONE, AMONG_OTHERS = Patience(0.02, 10.0), Patience(0.002, 3.0)
"""While no other client waits for the server, and while others wait for the end of the call."""


class Clients(Protocol):
    """The list of all clients, as their connections use it; `clients.ZmqClients` documents the members."""

    service: Service
    world: World
    answer: Callable[[Peer, Any], object]

    def note(self, connection: Connection, payload: bytes) -> None: ...
    def wait(self, connection: Connection) -> None: ...
    def pass_on(self, connection: Connection, payload: bytes) -> None: ...
    def next_message(self, connection: Connection, queue: deque[bytes | None], name: str) -> bytes: ...
    def has_held_others(self, client: Client, seconds: float) -> None: ...


class ClientFunction:
    """A function of the client that it passed to the server; see `interpreter.Function`."""

    def __init__(self, client: Client, name: str) -> None:
        self._client, self._name = client, name

    def __call__(self, *arguments: Any) -> list[Any]:
        connection = self._client.acting
        if connection is None:
            raise ScriptError(
                f"{self._name} of a client can be called only while the client waits for a call"
            )
        return connection.call_back(self._name, arguments)


class Connection:
    """One connection of a client. Physics thread."""

    def __init__(self, clients: Clients, client: Client, peer: Peer) -> None:
        self.client, self.peer = client, peer
        self._clients = clients
        self._world = clients.world
        self._executor = clients.service.executor
        self._requests = Requests()
        self._call: LastingCall | None = None
        """The call that is being executed, or waits."""

        self._depth = 0
        """Functions of the client that are running."""

        self._began = 0.0
        """The start of the present piece of the call."""

        self._left = 0.0
        """Seconds that are left for the client itself."""

        self._patience = ALONE
        self._held_others = 0.0
        """Seconds for which others have waited for functions of the client in the present piece of the call."""

        self._is_broken = False
        """A function of the client was not waited for any longer, so the client does not wait for the present call."""

        self._next: tuple[str, Waiting] | None = None
        """The call with which the client has gone on, instead of ending its function."""

        self._lost = "no function of this client was asked for a result"
        """Why the result of a function is not taken."""

    # --- messages --------------------------------------------------------------------------------

    @property
    def is_waiting(self) -> bool:
        """Return whether a call of this connection waits."""
        return self._call is not None and self._call.is_waiting

    def receive(self, payload: bytes) -> None:
        """Answer a message that does not come from within a function of the client."""
        try:
            request = self._requests.read(payload)
        except WireError as problem:
            self._refuse("message", CommandError(str(problem)))
            return
        if request.function == EXECUTED:
            self._send({"err": self._lost})
        elif request.function == END:
            self._clients.note(self, payload)
            self.end()
            self.client.level = self.client.locks = 0
            self.client.set_stepping()
            self._send({})
        elif self._call is not None and self._call.is_waiting:
            self._refuse(request.function, CommandError(f"{self._call.name} is not answered yet"))
        else:
            if self._clients.service.watchers.batch_comes:
                self._clients.note(self, payload)
            self._execute(request)

    def _execute(self, request: Request) -> None:
        session = self.client.session
        value = self._clients.service.at_once.result(session, request.function, request.arguments)
        if value is not None:
            self._send({"ret": [value]})
            return
        function = described(request.function)
        name = function.full_name
        call = self._call = LastingCall(self._executor, session, request.function)
        call.begin(
            request.function if function.is_known else UNKNOWN,
            name,
            [_as_text(each) for each in request.arguments] if self._executor.log_of_calls else (),
            only_reads=name in _STEPS or function.only_reads,
        )
        self._run(partial(call.run, partial(self._invoke, request)))

    def go_on(self) -> None:
        """Continue a call that waits, because a simulation step was made or none will come for a while."""
        if self._call is not None and self._call.is_waiting:
            self._run(self._call.go_on)

    def fail(self, problem: str) -> None:
        """End a call that waits, when it is continued: no simulation step comes."""
        if self._call is not None:
            self._call.fail(CommandError(problem))

    def _invoke(self, request: Request) -> tuple[Any, ...] | Waiting:
        arguments = with_functions(request.arguments, self._function_of_client)
        return invoke(self.client, request.function, arguments)

    def _function_of_client(self, name: str) -> ClientFunction:
        """Return a function that the client passes. Raises CommandError: it may pass none."""
        if self.client.session.may_only_read:
            raise CommandError(
                f"{self.client.name} is a viewer, who may only read, and passes no functions: others would wait"
            )
        return ClientFunction(self.client, name)

    def _run(self, piece: Callable[[], Results | None]) -> None:
        """Run a piece of the present call, and answer it, unless it waits."""
        results, problem = None, None
        try:
            results = self._act(piece)
        except Exception as error:
            problem = error
        if results is None and problem is None:
            self._clients.wait(self)
        elif self._is_broken:
            self._turn_to_next()
        else:
            self._answer(results, problem)

    def _act(self, piece: Callable[[], _Result]) -> _Result:
        """Run a piece of the present call: this connection acts."""
        client = self.client
        outer, client.acting = client.acting, self
        self._began = time.perf_counter()
        self._left, self._held_others, self._patience = SILENCE, 0.0, ALONE
        try:
            return piece()
        finally:
            client.acting = outer
            if self._held_others:
                self._clients.has_held_others(client, self._held_others)

    # --- answers ---------------------------------------------------------------------------------

    def _answer(self, results: Results | None, problem: Exception | None) -> None:
        """Answer the present call, after what it has left for later; within a script, that comes after the script."""
        call = self._call
        assert call is not None
        if problem is None and not self._clients.service.serving.is_active:
            problem = call.settled()
        if problem is None and results is not None:
            call.answered(STATUS_OK, results)
            problem = self._send_results(call.name, results)
        if problem is not None:
            call.answered(STATUS_REMOTE_ERROR, [self._refuse(call.name, problem)])

    def _turn_to_next(self) -> None:
        """Turn to the call for which the client waits now, as it does not wait for the present one any more."""
        self._is_broken = False
        if self._next is not None:
            (name, rest), self._next = self._next, None
            self._call = LastingCall(self._executor, self.client.session, name)
            self._call.wait_for(rest)
            if not self._clients.service.serving.is_active:  # not within a script
                self._world.simulation.settle()  # what the client has asked for before
            self.go_on()

    def _send_results(self, function: str, results: Results) -> Exception | None:
        """Send the results of a function; return why they cannot travel, if they cannot."""
        try:
            self._send({"ret": to_client(function, results)})
        except (TypeError, ValueError) as problem:
            return CommandError(f"the result cannot be sent: {problem}")
        return None

    def _refuse(self, function: str, problem: Exception) -> str:
        """Send the reason of a failure, and return it."""
        if isinstance(problem, UnknownName):
            problem = CommandError(f"object does not exist: {problem}")  # words that programs look for
        text = self._executor.failed(self.client.session, function, problem)
        if isinstance(problem, NoSuchFunction):
            text = str(problem)
        elif described(function).space in _SPACES:
            text = f"in {text}"  # the start of CoppeliaSim's texts
        self._send({"err": text.encode("utf-8", "backslashreplace").decode()})  # a name may be no text
        return text

    def _send(self, message: dict[str, Any]) -> None:
        self._clients.answer(self.peer, message)

    def end(self) -> None:
        """Abandon a call that waits: its client has left, or says good-bye."""
        waiting = self._call.abandon() if self._call is not None else None
        if waiting is not None and self.client.acting is not self:
            waiting.close()

    # --- functions of the client -----------------------------------------------------------------

    def call_back(self, name: str, arguments: tuple[Any, ...]) -> list[Any]:
        """Call a function of the client and return its results; meanwhile answer what it calls.

        None at the end of the arguments, such as auxiliary data that a motion was not given, is left out, as in
        CoppeliaSim: functions for (pose, velocities, accelerations) are called with three arguments.

        Raises:
            ScriptError: it takes too long, or the client has left.
        """
        with self._nested() as queue:
            self._send({"func": name, "args": to_client("", _without_last_nones(arguments))})
            while True:
                request = self._next_request(queue, name)
                if request is None:
                    continue
                if request.function == EXECUTED:
                    return request.arguments
                self._serve_within(request, name)

    @contextmanager
    def _nested(self) -> Generator[deque[bytes | None]]:
        """Give the messages that come within a function of the client, None at its end. Raises ScriptError."""
        if self._depth >= MOST_NESTED:
            raise ScriptError(f"more than {MOST_NESTED} functions of a client wait for each other")
        queue: deque[bytes | None] = deque()
        outer = self.peer.nest(queue)
        if self.peer.is_gone:
            queue.append(None)
        self._depth += 1
        try:
            yield queue
        finally:
            self._depth -= 1
            self.peer.nest(outer)
            for left in queue:  # it came behind the answer
                if outer is not None:
                    outer.append(left)
                elif left is not None:
                    self._clients.pass_on(self, left)

    def _next_request(self, queue: deque[bytes | None], name: str) -> Request | None:
        """Return the next message of the client; None if it was unreadable and is answered already."""
        payload = self._clients.next_message(self, queue, name)
        try:
            return self._requests.read(payload)
        except WireError as problem:
            self._refuse("message", CommandError(str(problem)))
            return None

    def is_late(self) -> bool:
        """Return whether the functions of the client have taken too long."""
        return self._left <= 0 or time.perf_counter() > self._began + self._patience.longest

    def has_waited(self, seconds: float, *, others_wait: bool) -> None:
        """Count time for which the server has waited for the client, and perhaps others with it."""
        self._left -= seconds
        self._patience = AMONG_OTHERS if others_wait else ALONE
        if others_wait:
            self._held_others += seconds

    def has_answered(self) -> None:
        """Count a message of the client."""
        self._left = min(SILENCE, self._left + self._patience.quick)

    def too_long(self, name: str) -> str:
        """Return why a function of the client is not waited for any longer."""
        quick, longest = self._patience
        others = ", while other clients wait" if self._patience is AMONG_OTHERS else ""
        return (
            f"the function {name} took too long: all functions in one call may take {SILENCE:g} s, and {quick * 1e3:g} "
            f"ms more for each message, at most {longest:g} s{others}; make calls with fewer objects, or keep the time "
            "between two answers short"
        )

    def broken(self, reason: str) -> ScriptError:
        """Return the error that ends the present call; its answer is not sent."""
        self._is_broken, self._lost = True, reason
        return ScriptError(reason)

    def _serve_within(self, request: Request, name: str) -> None:
        """Answer a call that the client makes in its function."""
        try:
            outcome = self._invoke(request)
        except Exception as problem:
            if self._is_broken:  # within a function that this call has called
                raise
            self._refuse(request.function, problem)
            return
        if not isinstance(outcome, Generator):
            if problem := self._send_results(request.function, outcome):
                self._refuse(request.function, problem)
            return
        self._next = request.function, outcome
        raise self.broken(
            f"{request.function} waits for a simulation step, so it cannot be called within {name}"
        )


def _as_text(argument: Any) -> Any:
    """Return a text, which this protocol does not tell from bytes, as a text."""
    if not isinstance(argument, bytes):
        return argument
    try:
        return argument.decode()
    except UnicodeDecodeError:
        return argument


def _without_last_nones(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    count = len(arguments)
    while count and arguments[count - 1] is None:
        count -= 1
    return arguments[:count]
