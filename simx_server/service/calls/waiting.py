"""Reasons for the rest of a batch to wait, and when it goes on.

The calls behind a trigger wait for the simulation step, or for the client's next batch. A paced call (`pacing.py`) does
the same, and waits itself as well. It also waits for the first images of the streams that its client has armed: in
V-REP they were there after two blocking calls. A call that takes several steps (`background.py`) delays the other calls
of its client, but no other client.

While other clients wait, a long batch is executed in slices, and these clients are served in between. No simulation
step is made meanwhile, so that the calls of one batch act together, unless the batch takes very long.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING

from simx_client.protocol.commands import TRIGGER
from simx_client.protocol.messages import Call, Operation, Reply, of_fields
from simx_server.service.answers.answers import DONE, Answer
from simx_server.service.answers.replies import Messages
from simx_server.service.watcher import Watcher

from .background import Unfinished, after_all, wait_for_step
from .interrupted import Interrupted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from simx_server.service.clients.sessions import ClientSession
    from simx_server.service.due import Due
    from simx_server.service.queue.inbox import Inbox
    from simx_server.service.watcher import Watchers
    from simx_server.simulation.simulation import Simulation

    from .executor import Executor
    from .serving import Serving

MOST_ROUNDS = 2
"""Rounds of the server loop, mostly simulation steps, that a paced call waits for images: at least one whole step."""

LONGEST_TOGETHER = 0.25
"""Seconds for which a batch in slices holds up simulation steps. A longer one is spread over several steps."""


class _Awaited:
    """A trigger whose reply is sent after its step, or when it is known that no step comes."""

    __slots__ = ("_batch", "_call_id", "_session", "_time_ms", "_waiting")

    def __init__(
        self, waiting: Waiting, session: ClientSession, batch: Interrupted, call_id: int, time_ms: int
    ) -> None:
        self._waiting, self._session, self._batch = waiting, session, batch
        self._call_id, self._time_ms = call_id, time_ms

    def set_result(self, result: None, /) -> None:
        """Reply that the step was made."""
        self._reply(DONE)

    def set_exception(self, exception: BaseException, /) -> None:
        """Reply why the step cannot be made."""
        self._reply(self._waiting.failure(self._session, exception))

    def _reply(self, answer: Answer) -> None:
        status, values = answer
        reply = of_fields(Reply, (self._call_id, status, self._time_ms, values))
        self._waiting.go_on_with(self._session, self._batch, reply)


class Waiting(Watcher):
    """The batches that wait, at most one of each client. Physics thread only, except where a method says otherwise."""

    def __init__(
        self,
        simulation: Simulation,
        sessions: Mapping[str, ClientSession],
        queue: Inbox,
        serving: Serving,
        due: Due,
        watchers: Watchers,
        executor: Executor,
        messages: Messages,
        execute_rest: Callable[[ClientSession], object],
    ) -> None:
        """Make it empty.

        Args:
            execute_rest: executes the rest of the batch that a client has interrupted.
        """
        self._simulation, self._sessions, self._queue, self._serving = simulation, sessions, queue, serving
        self._due, self._watchers, self._executor, self._messages = due, watchers, executor, messages
        self._execute_rest = execute_rest
        self._for_step: dict[str, Interrupted] = {}
        """Batches that wait because of a paced call, by client."""

        self._for_images: dict[str, Interrupted] = {}
        """Batches that wait because of a paced call after an image was requested, by client."""

        self._in_slices: dict[str, float] = {}
        """The clients with a partly executed batch, and the time until which it holds up simulation steps."""

    def forget(self, session: ClientSession) -> None:
        """Forget why a client's batch waits: it goes on."""
        self._for_step.pop(session.client, None)
        self._for_images.pop(session.client, None)

    def _goes_on(self, client: str, batch: Interrupted) -> None:
        """Schedule the rest of a batch for the client's next turn, if the client is still there."""
        if session := self._sessions.get(client):
            self._queue.put_first(client, partial(self._go_on, session, batch, None))

    def _go_on(self, session: ClientSession, batch: Interrupted, reply: Reply | None) -> None:
        """Execute what has waited now, unless it was executed already.

        Args:
            reply: the reply to the trigger in front of it, if it waits for one.
        """
        if self._serving.is_active:
            self._queue.hold(partial(self._go_on, session, batch, reply))
        elif session.interrupted is batch and self._sessions.get(session.client) is session:
            for react in self._watchers.batch_goes_on:
                react(session.client)
            if reply is not None:
                batch.replies.append(reply)
            self._execute_rest(session)
        elif reply is not None:
            session.link.deliver(self._messages.delivery(session, [reply]))

    # --- for a simulation step, or images --------------------------------------------------------

    def must_wait(self, session: ClientSession, call: Call, batch: Interrupted, has_waited: bool) -> bool:
        """Return whether a paced call must wait, and record the call.

        Args:
            batch: the batch from this call on, which then continues later.
            has_waited: the simulation step that it waited for was made.
        """
        if call.operation == Operation.STREAM:
            return False
        if session.paced.images:
            self._await_images(session, batch)
            return True
        if self._due.is_running_freely and session.paced.must_wait(call) and not has_waited:
            self._for_step[session.client] = batch
            session.interrupt(batch)
            return True
        return False

    def _await_images(self, session: ClientSession, batch: Interrupted) -> None:
        """Continue with a batch when the images requested before it have left.

        It never continues at once, so that a replay, which makes no images, finds it here too.
        """
        batch.rounds_left = MOST_ROUNDS
        self._for_images[session.client] = batch
        session.interrupt(batch)
        images = list(session.paced.images)
        session.paced.images.clear()
        go_on = partial(self._go_on, session, batch, None)
        after_all(images, partial(self._queue.put_first, session.client, go_on))

    @property
    def is_for_step(self) -> bool:
        """Return whether paced calls wait for a simulation step."""
        return bool(self._for_step)

    def end_for_step(self) -> None:
        """Continue paced calls in their order, because a simulation step was made, or none will come for a while."""
        if self._for_step:
            for client, batch in self._for_step.items():
                self._goes_on(client, batch)
            self._for_step.clear()

    def run_stopped(self) -> None:
        """Refuse the paced calls that wait, when they are continued, if their simulation step cannot be made."""
        if problem := self._simulation.failure:
            for batch in self._for_step.values():
                batch.problem = problem

    def count_round(self) -> None:
        """Continue paced calls that have waited long enough for images."""
        if not self._for_images:
            return
        for client, batch in list(self._for_images.items()):
            batch.rounds_left -= 1
            if not batch.rounds_left:
                batch.rounds_left = MOST_ROUNDS
                del self._for_images[client]
                self._goes_on(client, batch)

    # --- for other clients -----------------------------------------------------------------------

    def cut(self, session: ClientSession, rest: list[Call]) -> None:
        """Execute the rest of a long batch later: other clients wait."""
        batch = Interrupted([], rest, False, True)
        session.interrupt(batch)
        self._in_slices.setdefault(session.client, time.perf_counter() + LONGEST_TOGETHER)
        self._goes_on(session.client, batch)

    def end_slice(self, session: ClientSession) -> None:
        """Note that no slice of this client's batch waits any more, if that is so."""
        if self._in_slices and (session.interrupted is None or not session.interrupted.is_slice):
            self._in_slices.pop(session.client, None)

    @property
    def hold_steps(self) -> bool:
        """Return whether the rest of a partly executed batch belongs to the same simulation step."""
        if not self._in_slices:
            return False
        now = time.perf_counter()
        return any(now < until and client in self._sessions for client, until in self._in_slices.items())

    # --- for a trigger's answer, or an image -----------------------------------------------------

    def send_later(
        self, session: ClientSession, call: Call, answer: Future[Answer], made: list[Reply], rest: list[Call]
    ) -> None:
        """Reply to a call when its answer is available; the next paced call waits for an image without a caller."""
        sent: Future[None] = Future()
        batch = self._batch_behind(session, call.command, made, rest)
        answered = partial(self._answered, session, batch, call.call_id, self._messages.time_ms(), sent)
        answer.add_done_callback(answered)
        if call.command != TRIGGER and (call.operation == Operation.STREAM or call.delay_ms > 0):
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
            session.interrupt(batch)
        else:
            session.keep_for_trigger(made)
        return batch

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
        if self.go_on_with(session, batch, Reply(call_id, status, time_ms, values)):
            sent.set_result(None)

    def await_trigger(self, session: ClientSession, call: Call, made: list[Reply], rest: list[Call]) -> None:
        """Allow one simulation step, and reply to its trigger afterwards."""
        batch = self._batch_behind(session, TRIGGER, made, rest)
        session.add_trigger(_Awaited(self, session, batch, call.call_id, self._messages.time_ms()))

    def failure(self, session: ClientSession, error: BaseException) -> Answer:
        """Return the answer to a trigger whose step cannot be made."""
        return self._executor.failure(session, TRIGGER, error)

    def go_on_with(self, session: ClientSession, batch: Interrupted, reply: Reply) -> bool:
        """Continue behind a call with its reply; return whether nothing is left, and it was delivered. Any thread."""
        if batch.rest:
            self._queue.put_first(session.client, partial(self._go_on, session, batch, reply))
            return False
        replies = [*batch.replies, reply]
        batch.replies.clear()
        session.link.deliver(self._messages.delivery(session, replies))
        return True

    # --- for a step of a call --------------------------------------------------------------------

    def await_step(self, session: ClientSession, call: Unfinished, asked: Call, batch: Interrupted) -> None:
        """Continue with a call, and then with the rest of its batch, when its step is done."""
        session.interrupt(batch)
        batch.call = call
        client = session.client
        self._queue.keep_back(client, True)

        def done(_: object) -> None:
            self._queue.put_first(client, partial(self._take_step, session, asked, batch))
            self._queue.keep_back(client, False)

        call.task.done.add_done_callback(done)
        call.task.start()

    def _take_step(self, session: ClientSession, asked: Call, batch: Interrupted) -> None:
        """Start the next step of a call after one is done, or execute the rest of its batch."""
        if session.interrupted is not batch or self._sessions.get(session.client) is not session:
            return  # it has left
        assert batch.call is not None
        command, steps = batch.call.command, batch.call.steps
        executor = self._executor
        tally = executor.tally()
        with executor.doing(session.client, command.name):
            answer = executor.execute(session, tally, command, lambda: steps, (), wait_for_step)
            tally.end()
        if isinstance(answer, Unfinished):
            self.await_step(session, answer, asked, batch)
            return
        assert not isinstance(answer, Future)  # images do not take steps
        status, values = answer
        if batch.noted is not None:
            batch.noted.finish(status, values)
        batch.replies.append(Reply(asked.call_id, status, self._messages.time_ms(), values))
        self._execute_rest(session)
