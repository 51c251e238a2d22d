"""Execute batches of the table's calls in order; answer each call at once, or when its result is available.

`waiting.py` decides why the rest of a batch waits.
"""

from __future__ import annotations

import logging
import time
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import CodecError
from simx_client.protocol.commands import ANSWERED, TRIGGER, Command
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, Batch, Call, Operation, Reply
from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.service.answers.answers import DONE, Answer
from simx_server.service.answers.outbox import Outbox
from simx_server.service.answers.publishing import Publisher
from simx_server.service.answers.replies import Replies
from simx_server.service.clients.sessions import ClientSession
from simx_server.service.monitoring.metrics import UNKNOWN, Tally
from simx_server.simulation.simulation import SimulationState

from .background import Unfinished, refuse_steps
from .dispatch import Handling, no_such_command
from .executor import Executor
from .waiting import Interrupted, Waiting
from .work import TableWork, Work

if TYPE_CHECKING:
    from collections.abc import Mapping

    from simx_server.service.due import Due
    from simx_server.service.queue.inbox import Inbox
    from simx_server.service.watcher import Watchers
    from simx_server.simulation.simulation import Simulation

    from .addresses import Addresses, Exact
    from .serving import Serving

logger = logging.getLogger(__name__)

_EXECUTE, _STREAM, _CANCEL = int(Operation.EXECUTE), int(Operation.STREAM), int(Operation.CANCEL)

MOST_REFUSALS = 1_000_000
"""Most calls to answer of a message that exceeds a limit."""

MOST_AT_ADDRESSES = 200
"""Most values to read or set at their addresses before the time is looked at."""

SLICE = 0.002
"""Seconds to spend on a batch before other waiting clients are served."""


class _Run:
    """The calls of one batch that are executed one after the other."""

    __slots__ = ("command", "exact", "handling", "name", "replies", "session", "tally")

    def __init__(self, session: ClientSession, replies: Replies, tally: Tally) -> None:
        self.session, self.replies, self.tally = session, replies, tally
        self.name: str | None = None
        """The name of the last call, which mostly is that of the next one."""

        self.command: Command | None = None
        self.handling: Handling | None = None
        """Executes it; None until it is needed."""

        self.exact: Exact | None = None
        """How calls of this name read or set a value at its address, without the handler; None: they need it."""


class Batches:
    """Executes the batches of all clients. Physics thread only."""

    def __init__(
        self,
        simulation: Simulation,
        sessions: Mapping[str, ClientSession],
        queue: Inbox,
        serving: Serving,
        due: Due,
        watchers: Watchers,
        executor: Executor,
        publisher: Publisher,
        outbox: Outbox,
        addresses: Addresses,
    ) -> None:
        self._simulation, self._sessions, self._serving = simulation, sessions, serving
        self._exact = addresses.of_table
        self._watchers, self._executor = watchers, executor
        self._publisher, self._outbox = publisher, outbox
        self._messages = outbox.messages
        self.waiting = Waiting(
            simulation, sessions, queue, serving, due, watchers, executor, outbox.messages, self.execute_rest
        )

    def execute(self, client: str, work: Work) -> None:
        """Execute a message of a client."""
        session = self._sessions.get(client)
        if session is None:
            logger.debug("calls of a client that has not said hello or has gone")
            return
        work.run(session, self)

    def run(self, session: ClientSession, work: TableWork) -> None:
        """Execute a batch and put its replies into the outbox."""
        for react in self._watchers.batch_comes:
            react(session.client, work.recorded())
        batch = self._read(session, work)
        if batch is None:
            return
        while session.interrupted is not None:  # this batch may be what allows its step to come
            self._outbox.send()
            self.execute_rest(session)
        if early := session.before_trigger[:]:  # its step has not come: send these replies before newer ones
            session.before_trigger.clear()
            self._outbox.put(session, early)
        self._outbox.send_before(batch.calls)
        self._executor.metrics.called(session.client, len(batch.calls))
        session.heard(batch.message_id, batch.client_time)
        self._execute(session, batch.calls, [])

    def execute_rest(self, session: ClientSession) -> None:
        """Execute the rest of a batch that was interrupted."""
        batch = session.take_rest()  # until the rest has another reason to wait
        assert batch is not None
        self.waiting.forget(session)
        rest, replies = batch.rest, batch.replies
        if batch.problem:
            call, *rest = rest
            status, values = self._executor.failure(session, call.command, CommandError(batch.problem))
            replies.append(Reply(call.call_id, status, self._messages.time_ms(), values))
        self._execute(session, rest, replies, has_waited=batch.has_waited_for_step)

    # --- reading ---------------------------------------------------------------------------------

    def _read(self, session: ClientSession, work: TableWork) -> Batch | None:
        """Return the batch; None if it is unreadable or exceeds a limit, which is reported to the client."""
        limits = self._simulation.limits
        try:
            exceeded = "message"
            if work.size <= limits.message:
                batch = work.read()
                if len(batch.calls) <= limits.calls:
                    return batch
                exceeded = "calls"
            self._refuse(session, work, limits.reached(exceeded, "send less at a time"))
        except CodecError as error:
            if session.is_news("unreadable"):
                logger.warning("client %s sent something unreadable: %s", session.name, error)
            session.errors.append(str(error))
        return None

    def _refuse(self, session: ClientSession, work: TableWork, problem: LimitReached) -> None:
        """Answer each call of a batch that exceeds a limit, and execute none of them. Raises CodecError."""
        self._outbox.send()
        message_id, client_time, callers = work.callers(MOST_REFUSALS)
        session.heard(message_id, client_time)
        if session.is_news(str(problem)):
            logger.warning("client %s: %s", session.name, problem)
        session.errors.append(str(problem))
        time_ms = self._messages.time_ms()
        replies = [Reply(call_id, STATUS_REMOTE_ERROR, time_ms, [str(problem)]) for call_id in callers]
        self._outbox.put(session, replies)

    # --- executing -------------------------------------------------------------------------------

    def _execute(
        self, session: ClientSession, calls: list[Call], made: list[Reply], *, has_waited: bool = False
    ) -> None:
        """Execute calls of a batch in order, until one of them makes the rest wait.

        Args:
            made: the replies to the calls before these.
            has_waited: the first of the calls was paced, and the simulation step that it waited for was made.
        """
        executor = self._executor
        run = _Run(session, Replies(made), Tally(executor.metrics, session.called))
        outer = executor.begin(session.client, executor.command)
        try:
            if self._execute_until_wait(run, calls, has_waited) and run.replies.made:
                self._outbox.put(session, run.replies.made, is_awaited=run.replies.is_awaited)
        finally:
            run.tally.end()
            executor.end(outer)
            self.waiting.end_slice(session)

    def _execute_until_wait(self, run: _Run, calls: list[Call], has_waited: bool) -> bool:
        """Execute calls; return False if one of them makes the rest wait."""
        now, execute, session, waiting = time.perf_counter, self._execute_one, run.session, self.waiting
        until = now() + SLICE
        position, count = 0, len(calls)
        while position < count:
            call = calls[position]
            position += 1
            if now() >= until and position > 1:
                if self._serving.must_give_way():
                    if run.replies.made:  # one message for all at the end would take long as well
                        self._outbox.put(session, run.replies.made)
                    waiting.cut(session, calls[position - 1 :])
                    return False
                until = now() + SLICE
            if call.delay_ms < 0:
                batch = Interrupted(run.replies.made, calls[position - 1 :], False)
                if waiting.must_wait(session, call, batch, has_waited):
                    return False
            has_waited = False
            if call.operation == _EXECUTE:
                if call.command != run.name:
                    self._turn_to(run, call.command)
                if run.exact is not None:
                    after = self._at_addresses(run, run.exact, calls, position - 1)
                    if after >= position:
                        position = after
                        continue
                    run.exact = None  # those that follow mostly need the handler too
            if execute(run, call, calls, position):
                return False
        return True

    def _at_addresses(self, run: _Run, exact: Exact, calls: list[Call], position: int) -> int:
        """Execute the calls from a position on that read or set values at their addresses; return where these end."""
        name, at_address, takes, only_reads = run.name, exact.run, exact.takes, exact.only_reads
        add, done, time_ms, begin = run.replies.add, run.replies.done, self._messages.time_ms(), position
        for call_id, operation, delay_ms, called, arguments in calls[begin : begin + MOST_AT_ADDRESSES]:
            if called != name or operation != _EXECUTE or len(arguments) != takes:
                break
            if delay_ms != 0 if only_reads else delay_ms <= 0:
                break
            result = at_address(*arguments)
            if result is None:
                break
            if only_reads:
                add(call_id, STATUS_OK, time_ms, [result])
            else:
                done(call_id, time_ms)
            position += 1
        run.tally.count += position - begin
        return position

    def _execute_one(self, run: _Run, call: Call, calls: list[Call], position: int) -> bool:
        """Execute the call in front of a position of a batch; return whether it makes the rest wait."""
        call_id, operation, delay_ms, name, arguments = call
        session, replies, executor = run.session, run.replies, self._executor
        if operation != _EXECUTE and operation != _STREAM:
            self._do_without_command(session, call, replies)
            return False
        if name != run.name:
            self._turn_to(run, name)
        command, handling = run.command, run.handling
        if name == TRIGGER and self._may_trigger(run, operation, arguments):
            return self._trigger(run, call, calls[position:])
        if handling is None:
            command, handling = run.command, run.handling = executor.dispatch.find(session, name)
        if command is None or handling is None:
            session.called[UNKNOWN] += 1
            answer = executor.failure(session, name, no_such_command(name))
        else:
            at_step = self._at_step if operation == _EXECUTE else refuse_steps
            answer = executor.execute(session, run.tally, command, handling, arguments, at_step)
        noted = executor.log_of_calls and self._note(session, call, command, answer)
        if isinstance(answer, Unfinished):
            rest = Interrupted(replies.made, calls[position:], False, noted=noted)
            self.waiting.await_step(session, answer, call, rest)
            return True
        time_ms = self._messages.time_ms()
        if delay_ms > 0 and answer is DONE and operation == _EXECUTE:
            replies.done(call_id, time_ms)
            return False
        if operation == _STREAM and command is not None:
            self._publisher.arm(session, call, command, answer)
        if isinstance(answer, Future):
            self.waiting.send_later(session, call, answer, replies.made, calls[position:])
            return name == TRIGGER
        status, values = answer
        replies.add(call_id, status, time_ms, values)
        return False

    def _turn_to(self, run: _Run, name: str) -> None:
        """Find what the calls of a name execute, and how to do without a handler where nothing watches it."""
        run.name, run.command, run.handling = name, ANSWERED.get(name), None
        self._executor.command = run.command.name if run.command else ""
        exact = self._exact.get(name)
        if exact is None or run.command is None or not self._is_plain(run.session):
            run.exact = None
        else:
            run.exact = exact
            run.tally.turn_to(run.command)

    def _is_plain(self, session: ClientSession) -> bool:
        """Return whether this client may make any call, and no history notes it."""
        return session.guard is None and self._executor.log_of_calls is None and not session.may_only_read

    def _may_trigger(self, run: _Run, operation: int, arguments: list[Any]) -> bool:
        """Return whether a call of the trigger has nothing but its step to wait for."""
        session = run.session
        is_running = self._simulation.state is SimulationState.RUNNING
        return (
            operation == _EXECUTE
            and not arguments
            and is_running
            and session.is_stepping
            and self._is_plain(session)
        )

    def _trigger(self, run: _Run, call: Call, rest: list[Call]) -> bool:
        """Allow a step, as the trigger's handler, which makes a future that any thread can wait for."""
        assert run.command is not None
        run.tally.turn_to(run.command)
        run.tally.count += 1
        self.waiting.await_trigger(run.session, call, run.replies.made, rest)
        return True

    def _note(
        self,
        session: ClientSession,
        call: Call,
        command: Command | None,
        answer: Answer | Future[Answer] | Unfinished,
    ) -> Any:
        """Note a call for the history."""
        called = self._executor.note(
            session,
            call.command if command is None else command.name,
            call.arguments,
            None if isinstance(answer, Unfinished) else answer,
            only_reads=command is not None and command.only_reads,
        )
        if called is not None and call.operation == _STREAM:
            called.mark_stream()
        return called

    def _at_step(self, call: Unfinished) -> Any:
        """Wait for the step of a call, or finish all its steps first."""
        return call if self._serving.may_cut else self._executor.finish(call)

    def _do_without_command(self, session: ClientSession, call: Call, replies: Replies) -> None:
        """End a stream, or refuse an unknown operation."""
        if call.operation != _CANCEL:
            text = f"there is no operation {call.operation}; valid: {', '.join(map(repr, Operation))}"
            replies.add(call.call_id, STATUS_REMOTE_ERROR, self._messages.time_ms(), [text])
            return
        stream_id = call.arguments[0] if call.arguments else 0
        session.streams.cancel(stream_id if type(stream_id) is int else 0)
        if call.call_id:
            replies.add(call.call_id, STATUS_OK, self._messages.time_ms(), [])
