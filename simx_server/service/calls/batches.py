"""Execute batches of calls in order; answer each call at once, or when its result is available.

After a trigger in the middle of a batch, the calls behind it wait for the simulation step, or for the client's next
batch. A paced call (`pacing.py`) does the same, and waits itself as well. It also waits for the first images of the
streams that its client has armed: in V-REP they were there after two blocking calls.

While other clients wait, a long batch is executed in slices, and these clients are served in between. No simulation
step is made meanwhile, so that the calls of one batch act together, unless the batch takes very long.

A call that takes several steps (`background.py`) delays the other calls of its client, but no other client.
"""

from __future__ import annotations

import logging
import time
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import CodecError, decode_batch, decode_callers
from simx_client.protocol.commands import TRIGGER, Command
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, Batch, Call, Operation, Reply
from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.service.answers.answers import DONE, Answer
from simx_server.service.answers.outbox import Outbox
from simx_server.service.answers.publishing import Publisher
from simx_server.service.answers.replies import Messages, Replies
from simx_server.service.clients.sessions import ClientSession, Interrupted, after_all
from simx_server.service.monitoring.metrics import UNKNOWN
from simx_server.service.queue.inbox import Inbox

from .background import Unfinished, refuse_steps, wait_for_step
from .direct import DirectCall
from .dispatch import Work, no_such_command
from .executor import Executor

if TYPE_CHECKING:
    from simx_server.history.calls import Called
    from simx_server.service.server_loop import ServerLoop

logger = logging.getLogger(__name__)

_EXECUTE, _STREAM, _CANCEL = int(Operation.EXECUTE), int(Operation.STREAM), int(Operation.CANCEL)

MOST_REFUSALS = 1_000_000
"""Most calls to answer of a message that exceeds a limit."""


MOST_ROUNDS = 2
"""Passes of the server loop, mostly simulation steps, that a paced call waits for images: at least one whole step."""

SLICE = 0.002
"""Seconds to spend on a batch before other waiting clients are served."""

LONGEST_TOGETHER = 0.25
"""Seconds for which a batch in slices holds up simulation steps. A longer one is spread over several steps."""


class Batches:
    """Executes the batches of all clients. Physics thread only, except where a method says otherwise."""

    def __init__(
        self,
        loop: ServerLoop,
        executor: Executor,
        publisher: Publisher,
        messages: Messages,
        inbox: Inbox,
        outbox: Outbox,
    ) -> None:
        self._loop = loop
        self._dispatch, self._executor = executor.dispatch, executor
        self._publisher, self._messages = publisher, messages
        self._inbox, self._outbox = inbox, outbox
        self.executing = ""
        """The client whose batch is being executed."""

        self.command = ""
        """The command that is being executed for it."""

        self._waiting_for_step: dict[str, Interrupted] = {}
        """Batches that wait because of a paced call, by client."""

        self._waiting_for_images: dict[str, Interrupted] = {}
        """Batches that wait because of a paced call after an image was requested, by client."""

        self._in_slices: dict[str, float] = {}
        """The clients with a partly executed batch, and the time until which it holds up simulation steps."""

    def execute(self, client: str, payload: bytes) -> None:
        """Execute a batch and put its replies into the outbox."""
        session = self._loop.sessions.get(client)
        if session is None:
            logger.debug("calls of a client that has not said hello or has gone")
            return
        if session.serve is not None:
            session.serve(payload)
            return
        if self._loop.recorder is not None:
            self._loop.recorder.batch(client, payload)
        batch = self._read(session, payload)
        if batch is None:
            return
        while session.interrupted is not None:  # this batch may be what allows its step to come
            self._outbox.send()
            self.execute_rest(session)
        if early := session.before_trigger[:]:  # its step has not come: send these replies before newer ones
            session.before_trigger.clear()
            self._outbox.put(session, early)
        self._outbox.send_before(batch.calls)
        self._loop.metrics.called(client, len(batch.calls))
        session.message_id, session.client_time = batch.message_id, batch.client_time
        self._execute(session, batch.calls, [])

    def direct_call(self, session: ClientSession, command: Command) -> DirectCall:
        """Prepare a command of a client in this process."""
        return DirectCall(self, self._dispatch, self._executor, session, command, self._loop)

    def begin_work(self, client: str, command: str) -> tuple[str, str]:
        """Mark a call of another protocol as the one that is being executed; pass the result to `end_work` after it."""
        outer = self.executing, self.command
        self.executing, self.command = client, command
        return outer

    def end_work(self, outer: tuple[str, str]) -> None:
        """Mark the call before as the one that is being executed."""
        self.executing, self.command = outer

    def failed(self, session: ClientSession, name: str, error: Exception) -> str:
        """Count and log the failure of a call of another protocol; return the text for its client."""
        _, values = self._executor.failure(session, name, error)
        return str(values[0]) if values else f"{name}: {error}"

    def _read(self, session: ClientSession, payload: bytes) -> Batch | None:
        """Return the batch; None if it is unreadable or exceeds a limit, which is reported to the client."""
        limits = self._loop.simulation.limits
        try:
            exceeded = "message"
            if len(payload) <= limits.message:
                batch = decode_batch(payload)
                if len(batch.calls) <= limits.calls:
                    return batch
                exceeded = "calls"
            self._refuse(session, payload, limits.reached(exceeded, "send less at a time"))
        except CodecError as error:
            if session.is_news("unreadable"):
                logger.warning("client %s sent something unreadable: %s", session.name, error)
            session.errors.append(str(error))
        return None

    def execute_rest(self, session: ClientSession) -> None:
        """Execute the rest of a batch that was interrupted."""
        batch = session.interrupted
        session.interrupted = None  # until the rest has another reason to wait
        assert batch is not None
        self._waiting_for_step.pop(session.client, None)
        self._waiting_for_images.pop(session.client, None)
        has_waited = not (batch.waits_for_trigger or batch.is_slice or batch.call or batch.rounds_left)
        rest, replies = batch.rest, batch.replies
        if batch.problem:
            call, *rest = rest
            status, values = self._executor.failure(session, call.command, CommandError(batch.problem))
            replies.append(Reply(call.call_id, status, self._messages.time_ms(), values))
        self._execute(session, rest, replies, has_waited=has_waited and not batch.problem)

    @property
    def are_waiting_for_step(self) -> bool:
        """Return whether paced calls wait for a simulation step."""
        return bool(self._waiting_for_step)

    @property
    def hold_steps(self) -> bool:
        """Return whether the rest of a partly executed batch belongs to the same simulation step."""
        if not self._in_slices:
            return False
        now = time.perf_counter()
        return any(now < until and client in self._loop.sessions for client, until in self._in_slices.items())

    def end_waiting_for_step(self) -> None:
        """Continue paced calls in their order, because a simulation step was made, or none will come for a while."""
        for client, batch in self._waiting_for_step.items():
            if session := self._loop.sessions.get(client):
                self._loop.post_for(client, partial(self._go_on, session, batch, None))
        self._waiting_for_step.clear()

    def count_round(self) -> None:
        """Continue paced calls that have waited long enough for images."""
        for client, batch in list(self._waiting_for_images.items()):
            batch.rounds_left -= 1
            if not batch.rounds_left:
                batch.rounds_left = MOST_ROUNDS
                del self._waiting_for_images[client]
                if session := self._loop.sessions.get(client):
                    self._loop.post_for(client, partial(self._go_on, session, batch, None))

    def fail_waiting_for_step(self, problem: str) -> None:
        """Refuse the paced calls that wait, when they are continued: their simulation step cannot be made."""
        for batch in self._waiting_for_step.values():
            batch.problem = problem

    def _refuse(self, session: ClientSession, payload: bytes, problem: LimitReached) -> None:
        """Answer each call of a batch that exceeds a limit, and execute none of them. Raises CodecError."""
        self._outbox.send()
        session.message_id, session.client_time, callers = decode_callers(payload, MOST_REFUSALS)
        if session.is_news(str(problem)):
            logger.warning("client %s: %s", session.name, problem)
        session.errors.append(str(problem))
        time_ms = self._messages.time_ms()
        replies = [Reply(call_id, STATUS_REMOTE_ERROR, time_ms, [str(problem)]) for call_id in callers]
        self._outbox.put(session, replies)

    def _execute(
        self, session: ClientSession, calls: list[Call], made: list[Reply], *, has_waited: bool = False
    ) -> None:
        """Execute calls of a batch in order, until one of them makes the rest wait.

        Args:
            made: the replies to the calls before these.
            has_waited: the first of the calls was paced, and the simulation step that it waited for was made.
        """
        outer, self.executing = (self.executing, self.command), session.client
        replies, tally = Replies(made), self._executor.tally(session.called)
        bound: str | None = None
        command: Command | None = None
        work: Work | None = None
        now, execute, at_step = time.perf_counter, self._executor.execute, self._at_step
        until = now() + SLICE
        try:
            for position, call in enumerate(calls, 1):
                call_id, operation, delay_ms, name, arguments = call
                if now() >= until and position > 1:
                    if self._inbox.others_have_come() and self._loop.may_cut_batches:
                        self._cut(session, replies, calls[position - 1 :])
                        return
                    until = now() + SLICE
                if delay_ms < 0 and self._waits(
                    session, call, Interrupted(replies.made, calls[position - 1 :], False), has_waited
                ):
                    return
                has_waited = False
                if operation != _EXECUTE and operation != _STREAM:
                    self._do_without_command(session, call, replies)
                    continue
                if name != bound:
                    bound, (command, work) = name, self._dispatch.find(session, name)
                    self.command = command.name if command else ""
                may_step = at_step if operation == _EXECUTE else refuse_steps
                answer = (
                    self._refuse_unknown(session, name)
                    if command is None or work is None
                    else execute(session, tally, command, work, arguments, may_step)
                )
                noted = self._loop.log_of_calls and self._note(session, call, command, answer)
                if isinstance(answer, Unfinished):
                    rest = Interrupted(replies.made, calls[position:], False, noted=noted)
                    self._await_step(session, answer, call, rest)
                    return
                time_ms = self._messages.time_ms()
                if delay_ms > 0 and answer is DONE and operation == _EXECUTE:
                    replies.done(call_id, time_ms)
                    continue
                if operation == _STREAM and command is not None:
                    self._publisher.arm(session, call, command, answer)
                if isinstance(answer, Future):
                    self._send_later(session, call, answer, replies.made, calls[position:])
                    if name == TRIGGER:
                        return
                else:
                    status, values = answer
                    replies.add(call_id, status, time_ms, values)
            self._send(session, replies)
        finally:
            tally.end()
            self.executing, self.command = outer
            self._forget_slice(session)

    def _note(
        self,
        session: ClientSession,
        call: Call,
        command: Command | None,
        answer: Answer | Future[Answer] | Unfinished,
    ) -> Called | None:
        """Note a call for the history."""
        log = self._loop.log_of_calls
        assert log is not None
        called = log.note(
            session.name,
            call.command if command is None else command.name,
            call.arguments,
            None if isinstance(answer, Unfinished) else answer,
            only_reads=command is not None and command.only_reads,
        )
        if called is not None and call.operation == _STREAM:
            called.is_stream = True
        return called

    def _send(self, session: ClientSession, replies: Replies) -> None:
        if replies.made:
            self._outbox.put(session, replies.made, is_awaited=replies.is_awaited)

    def _forget_slice(self, session: ClientSession) -> None:
        """Note that no slice of this client's batch waits any more, if that is so."""
        if self._in_slices and (session.interrupted is None or not session.interrupted.is_slice):
            self._in_slices.pop(session.client, None)

    def _cut(self, session: ClientSession, replies: Replies, rest: list[Call]) -> None:
        """Execute the rest of a long batch later: other clients wait."""
        if replies.made:  # one message for all at the end would take long as well
            self._outbox.put(session, replies.made)
        self._interrupt(session, Interrupted([], rest, False, True))

    def _send_later(
        self, session: ClientSession, call: Call, answer: Future[Answer], made: list[Reply], rest: list[Call]
    ) -> None:
        """Reply to a call when its answer is available; the next paced call waits for an image without a caller."""
        sent: Future[None] = Future()
        batch = self._batch_behind(session, call.command, made, rest)
        answered = partial(self._answered, session, batch, call.call_id, self._messages.time_ms(), sent)
        answer.add_done_callback(answered)
        if call.command != TRIGGER and (call.operation == _STREAM or call.delay_ms > 0):
            session.paced.images.append(sent)

    def _batch_behind(
        self, session: ClientSession, name: str, made: list[Reply], rest: list[Call]
    ) -> Interrupted:
        """Return the batch that a call continues whose answer comes later.

        All replies to a client that steps leave in one message after the simulation step. The calls behind the trigger
        are executed then, or when the client's next batch comes before that.
        """
        if name != TRIGGER:
            return Interrupted([], [])
        batch = Interrupted(made, rest)
        if rest:
            session.interrupted = batch
        else:
            session.before_trigger = made
        return batch

    def _refuse_unknown(self, session: ClientSession, name: str) -> Answer:
        """Refuse a call with a name that is not in the table of commands."""
        session.called[UNKNOWN] += 1
        return self._executor.failure(session, name, no_such_command(name))

    def _at_step(self, call: Unfinished) -> Any:
        """Wait for the step of a call, or finish all its steps first."""
        return call if self._loop.may_cut_batches else self._executor.finish(call)

    def _interrupt(self, session: ClientSession, rest: Interrupted) -> None:
        """Schedule the rest of a batch for the client's next turn."""
        session.interrupted = rest
        self._in_slices.setdefault(session.client, time.perf_counter() + LONGEST_TOGETHER)
        self._loop.post_for(session.client, partial(self._go_on, session, rest, None))

    def _await_step(self, session: ClientSession, call: Unfinished, asked: Call, batch: Interrupted) -> None:
        """Continue with a call, and then with the rest of its batch, when its step is done."""
        session.interrupted, batch.call = batch, call
        client = session.client
        self._loop.keep_back(client, True)

        def done(_: object) -> None:
            self._loop.post_for(client, partial(self._take_step, session, asked, batch))
            self._loop.keep_back(client, False)

        call.task.done.add_done_callback(done)
        call.task.start()

    def _take_step(self, session: ClientSession, asked: Call, batch: Interrupted) -> None:
        """Start the next step of a call after one is done, or execute the rest of its batch."""
        if session.interrupted is not batch or self._loop.sessions.get(session.client) is not session:
            return  # it has left
        assert batch.call is not None
        command, steps = batch.call.command, batch.call.steps
        outer, tally = (self.executing, self.command), self._executor.tally()
        self.executing, self.command = session.client, command.name
        try:
            answer = self._executor.execute(session, tally, command, lambda: steps, (), wait_for_step)
        finally:
            tally.end()
            self.executing, self.command = outer
        if isinstance(answer, Unfinished):
            self._await_step(session, answer, asked, batch)
            return
        assert not isinstance(answer, Future)  # images do not take steps
        status, values = answer
        if batch.noted is not None:
            batch.noted.finish(status, values)
        batch.replies.append(Reply(asked.call_id, status, self._messages.time_ms(), values))
        self.execute_rest(session)

    def _waits(self, session: ClientSession, call: Call, batch: Interrupted, has_waited: bool) -> bool:
        """Return whether a paced call must wait, and record the call.

        Args:
            batch: the batch from this call on, which then continues later.
            has_waited: the simulation step that it waited for was made.
        """
        if call.operation == _STREAM:
            return False
        if session.paced.images:
            self._await_images(session, batch)
            return True
        if self._loop.is_running_freely and session.paced.must_wait(call) and not has_waited:
            session.interrupted = self._waiting_for_step[session.client] = batch
            return True
        return False

    def _await_images(self, session: ClientSession, batch: Interrupted) -> None:
        """Continue with a batch when the images requested before it have left.

        It never continues at once, so that a replay, which makes no images, finds it here too.
        """
        batch.rounds_left = MOST_ROUNDS
        session.interrupted = self._waiting_for_images[session.client] = batch
        images = list(session.paced.images)
        session.paced.images.clear()
        go_on = partial(self._go_on, session, batch, None)
        after_all(images, partial(self._loop.post_for, session.client, go_on))

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

    def _go_on(self, session: ClientSession, batch: Interrupted, reply: Reply | None) -> None:
        """Execute what waits for a simulation step now, unless it was executed already.

        Args:
            reply: the reply to the trigger in front of it, if it waits for one.
        """
        if self._loop.is_serving:
            self._inbox.hold(partial(self._go_on, session, batch, reply))
        elif session.interrupted is batch and self._loop.sessions.get(session.client) is session:
            if self._loop.recorder is not None:
                self._loop.recorder.went_on(session.client)
            if reply is not None:
                batch.replies.append(reply)
            self.execute_rest(session)
        elif reply is not None:
            session.link.deliver(self._messages.pack(session, [reply]))

    def _answered(
        self,
        session: ClientSession,
        batch: Interrupted,
        call_id: int,
        time_ms: int,
        sent: Future[None],
        done: Future[Answer],
    ) -> None:
        """Continue behind a trigger, or deliver its reply, or an image; runs on the thread that finished it."""
        status, values = done.result()
        reply = Reply(call_id, status, time_ms, values)
        if batch.rest:
            self._loop.post_for(session.client, partial(self._go_on, session, batch, reply))
            return
        replies = [*batch.replies, reply]
        batch.replies.clear()
        session.link.deliver(self._messages.pack(session, replies))
        sent.set_result(None)
