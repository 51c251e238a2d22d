"""The physics thread's loop: it alone touches the simulation.

It takes calls from a queue whenever it waits for the wall clock and at pass boundaries, so a blocking call
costs a round trip and never a simulation step. After each pass every stream that is due is computed once.

A script that runs long holds the thread. Others are answered meanwhile, see `inbox.py`.
"""

from __future__ import annotations

import logging
import math
import time
from collections import Counter
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any

from simx_client.protocol.codec import CodecError, decode_batch, decode_callers
from simx_client.protocol.commands import TRIGGER
from simx_client.protocol.constants import sim_api_errormessage_report
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, Call, Operation, Reply

from .clock import Pacer
from .dispatch import Answer, Dispatch, Run
from .handlers.registry import Handler
from .inbox import Arrival, Event, Inbox, Read, interfere
from .limits import LimitReached
from .metrics import Metrics
from .outbox import Outbox
from .publishing import Publisher
from .sessions import ClientSession, Interrupted, Link
from .simulation import Simulation, SimulationState

if TYPE_CHECKING:
    from .recording import Recorder

logger = logging.getLogger(__name__)

IDLE_PASS = 0.02
"""Seconds between two executions of the streams while no pass is due."""

HELD = 0.002
"""Seconds until a pass that is held (`Simulation.pass_holders`) is looked at again."""

_OPERATIONS = len(Operation)
_CANCEL, _STREAM = int(Operation.CANCEL), int(Operation.STREAM)

MOST_REFUSALS = 1_000_000
"""Calls that are answered of a message that is beyond a limit."""


class Engine:
    """Sessions, passes and streams of one simulation."""

    def __init__(
        self,
        simulation: Simulation,
        handlers: Mapping[str, Handler],
        pacer: Pacer,
        *,
        starting_port: int | None = None,
    ) -> None:
        """Make an engine; ``run`` or ``turn`` drive it.

        Args:
            starting_port: a client that comes by this port starts a stopped simulation, because in V-REP
                the service behind it existed only while a simulation ran.
        """
        self.simulation = simulation
        self.sessions: dict[str, ClientSession] = {}
        self.metrics = Metrics(pacer)
        self._dispatch = Dispatch(simulation, handlers, self.metrics)
        self._publisher = Publisher(simulation, self._dispatch, pacer, self.metrics)
        self._pacer = pacer
        self._starting_port = starting_port
        self._inbox = Inbox()
        self._outbox = Outbox(self._inbox, self._publisher.message)
        self._executing = ""
        """The client whose batch is being executed."""

        self._is_serving = False
        """Within `serve_others`."""
        self._next_idle_pass = 0.0
        self._is_paced = False
        """Passes follow the wall clock at present."""

        self._is_ending = False
        self.recorder: Recorder | None = None
        """Told of all that is done for clients, in order."""

        simulation.on_stop.append(self._end_stepping)
        simulation.on_script_stopped.append(self._tell_everybody)
        simulation.serve_others = self.serve_others

    # --- from any thread -------------------------------------------------------------------------

    def post(self, event: Event) -> None:
        """Have something done on the physics thread, in order of posting."""
        self._inbox.put(event)

    def submit(self, client: str, payload: bytes) -> None:
        """A batch of calls has arrived. Safe to use from Zenoh's threads: it only enqueues."""
        self._inbox.put(Arrival(client, payload))

    def inlet(self, kind: type, read: Read) -> Callable[[Any], None]:
        """As ``submit``, for what is to be read on the physics thread; to be called before that runs.

        Args:
            kind: the class of what the function that is returned is given.
        """
        self._inbox.read_by(kind, read)
        return self._inbox.put

    def end(self) -> None:
        """Let ``run`` return."""
        self._inbox.put(self._end)

    # --- the loop --------------------------------------------------------------------------------

    def run(self, deadline: float | None = None) -> None:
        """Serve until ``end``, or until a time on the monotonic clock."""
        while not self._is_ending and (deadline is None or time.monotonic() < deadline):
            left = 1.0 if deadline is None else deadline - time.monotonic()
            self.turn(max_wait=max(0.0, min(1.0, left)))
            self.metrics.tick()
        self._outbox.send()

    def turn(self, max_wait: float = 0.0) -> None:
        """Wait for the first of: an event, a pass that is due, ``max_wait``. Then deal with it.

        At a pass boundary everything that has arrived is executed first: commands act on the coming pass.
        """
        self._inbox.shed(self.simulation.limits.waiting)
        self._tell_dropped()
        wait = min(max_wait, self._seconds_until_pass())
        if wait > 0:
            event = self._inbox.wait(wait)
            while event is not None:
                self._handle(event)
                self.simulation.settle()
                event = self._inbox.wait(0) if self._outbox.is_keeping else None
            return
        for event in self._inbox.at_hand():
            self._handle(event)
            self.simulation.settle()  # after each, however many came together
        self.simulation.settle()
        if self._seconds_until_pass() <= 0:
            self._outbox.send()
            self._pass()

    def serve_others(self) -> None:
        """For a script that runs long: deal with what does not interfere with it."""
        if self._is_serving:
            return
        self._is_serving = True
        try:
            self._outbox.send()
            for event in self._inbox.meanwhile(self._executing, self.simulation.limits.waiting):
                if isinstance(event, Arrival) and self._brings_on_what_interferes(event.client):
                    self._inbox.hold(event)
                else:
                    self._handle(event)
            self._tell_dropped()
        finally:
            self._is_serving = False

    def _brings_on_what_interferes(self, client: str) -> bool:
        """Whether a batch of this client has what follows a trigger executed, and that must wait for a script."""
        session = self.sessions.get(client)
        return session is not None and session.interrupted is not None and interfere(session.interrupted.rest)

    def _tell_dropped(self) -> None:
        """Nobody can fill the memory by sending faster than is executed; who has tried is told."""
        if not self._inbox.dropped:
            return
        dropped, self._inbox.dropped = self._inbox.dropped, Counter()
        refusal = self.simulation.limits.reached("waiting", "wait for answers now and then")
        for client, count in dropped.items():
            if session := self.sessions.get(client):
                session.has_lost(count, str(refusal))

    def _handle(self, event: Event | Arrival) -> None:
        try:
            if isinstance(event, Arrival):
                self._execute_batch(event.client, event.payload)
            else:
                event()
        except Exception:
            logger.exception("a request could not be dealt with; the server goes on")
        if self._is_serving:
            self._outbox.send()
        else:
            self._outbox.send_unless_more_comes()

    def _end(self) -> None:
        self._is_ending = self.simulation.is_ending = True

    @property
    def is_ending(self) -> bool:
        return self._is_ending

    @property
    def is_serving(self) -> bool:
        """Whether others are served while a script runs."""
        return self._is_serving

    @property
    def is_waiting_for_trigger(self) -> bool:
        """Whether a running simulation stands still until stepped clients trigger (parameter 45)."""
        return self.simulation.state is SimulationState.RUNNING and any(
            session.is_waiting for session in self.sessions.values()
        )

    def _is_advancing(self) -> bool:
        return self.simulation.state is SimulationState.RUNNING and not self.is_waiting_for_trigger

    def _is_stepped(self) -> bool:
        return any(session.is_stepping for session in self.sessions.values())

    def _seconds_until_pass(self) -> float:
        if self._is_advancing() and not self._is_stepped():
            if not self._is_paced:
                self._is_paced = True
                self._pacer.restart()  # after a stop, a pause or stepped mode there is no time to make up
            return self._pacer.seconds_left() or self._seconds_held(math.isinf(self._pacer.speed))
        self._is_paced = False
        if self._is_advancing():
            return self._seconds_held(True)
        if self._idle_is_wanted() or any(session.streams.by_id for session in self.sessions.values()):
            return max(0.0, self._next_idle_pass - time.monotonic())
        return math.inf

    def _seconds_held(self, is_free: bool) -> float:
        """`is_free`: of the wall clock, whose pace nothing may hold up."""
        return HELD if is_free and any(holds() for holds in self.simulation.pass_holders) else 0.0

    def _idle_is_wanted(self) -> bool:
        return bool(self.simulation.on_idle) and self.simulation.state is not SimulationState.RUNNING

    def _pass(self) -> None:
        """One pass when the simulation advances; in any case the streams."""
        is_advancing = self._is_advancing()
        if is_advancing:
            try:
                began = time.perf_counter()
                self.simulation.advance()
                self.metrics.passed(self.simulation.time_step, time.perf_counter() - began)
            except Exception as error:
                logger.exception("the pass failed, so the simulation is stopped")
                self._handle(self.simulation.stop)
                self._tell_everybody(f"the pass failed, so the simulation is stopped: {error!r}")
            if self._is_paced:
                self._pacer.passed(self.simulation.time_step)
            self._publisher.publish(self.sessions.values(), after_pass=True)
            for session in self.sessions.values():
                # What is read after a trigger is of the new state, streamed pictures too.
                session.release_triggers(after=session.streams.pictures_on_the_way())
        else:
            if self._idle_is_wanted():
                self._handle(self.simulation.idle)
            self._publisher.publish(self.sessions.values(), after_pass=False)
        if self.recorder is not None:
            self.recorder.passed(is_advancing=is_advancing)
        self._next_idle_pass = time.monotonic() + IDLE_PASS

    def _tell_everybody(self, problem: str) -> None:
        """An error of a script's own, or of a pass, is told to every client, as nobody's call has brought it about."""
        if self.simulation.parameters.error_report_mode & sim_api_errormessage_report:
            for session in self.sessions.values():
                session.errors.append(problem)

    def _end_stepping(self) -> None:
        """A stop request ends stepped mode of every client; it must be asked for again for each run."""
        for session in self.sessions.values():
            session.set_stepping(False)

    # --- clients ---------------------------------------------------------------------------------

    def join(self, client: str, name: str, port: int, link: Link) -> ClientSession:
        """A client has said hello. Saying it again (after a loss) begins anew."""
        self.leave(client)
        session = ClientSession(client, name, port, link)
        self.sessions[client] = session
        if self.recorder is not None:
            self.recorder.joined(client, name, port)
        logger.info("client %s joined by port %d", name, port)
        is_stopped = self.simulation.state is SimulationState.STOPPED
        if port == self._starting_port and is_stopped and not session.may_only_read:
            if self._is_serving:
                self._inbox.hold(partial(self._start_for, port))
            else:
                self._start_for(port)
        return session

    def _start_for(self, port: int) -> None:
        logger.info("starting the simulation, as port %d exists only while one runs", port)
        if self.recorder is not None:
            self.recorder.started()
        self.simulation.start()

    def leave(self, client: str) -> None:
        """A client has gone: its streams and its stepped mode go with it."""
        session = self.sessions.pop(client, None)
        if session is not None:
            if self.recorder is not None:
                self.recorder.left(client)
            self.metrics.left(client)
            session.set_stepping(False)
            session.link.close()
            logger.info("client %s left", session.name)

    # --- calls -----------------------------------------------------------------------------------

    def _execute_batch(self, client: str, payload: bytes) -> None:
        session = self.sessions.get(client)
        if session is None:
            logger.debug("calls of a client that has not said hello or has gone")
            return
        if self.recorder is not None:
            self.recorder.batch(client, payload)
        limits = self.simulation.limits
        try:
            if len(payload) > limits.message:
                self._refuse(session, payload, limits.reached("message", "send less at a time"))
                return
            batch = decode_batch(payload)
            if len(batch.calls) > limits.calls:
                self._refuse(session, payload, limits.reached("calls", "send less at a time"))
                return
        except CodecError as error:
            logger.warning("client %s sent something unreadable: %s", session.name, error)
            session.errors.append(str(error))
            return
        while (before := session.interrupted) is not None:  # this batch may be what lets its pass come
            session.interrupted = None  # until there is another trigger in the rest
            self._execute(session, before.rest, before.replies)
        if early := session.before_trigger[:]:  # its pass has not come: they must not come after newer ones
            session.before_trigger.clear()
            self._outbox.put(session, early)
        self._outbox.send_before(batch.calls)
        self.metrics.called(client, len(batch.calls))
        session.message_id, session.client_time = batch.message_id, batch.client_time
        self._execute(session, batch.calls, [])

    def _refuse(self, session: ClientSession, payload: bytes, problem: LimitReached) -> None:
        """Answer each call of a batch that is beyond a limit, and do nothing of it. Raises CodecError."""
        self._outbox.send()
        session.message_id, session.client_time, callers = decode_callers(payload, MOST_REFUSALS)
        logger.warning("client %s: %s", session.name, problem)
        session.errors.append(str(problem))
        time_ms = self._publisher.time_ms()
        replies = [Reply(call_id, STATUS_REMOTE_ERROR, time_ms, [str(problem)]) for call_id in callers]
        self._outbox.put(session, replies)

    def _execute(self, session: ClientSession, calls: list[Call], replies: list[Reply]) -> None:
        """Execute calls of a batch; `replies` are those to calls before these."""
        before, self._executing = self._executing, session.client
        run = self._dispatch.run(session)
        try:
            self._execute_in_order(session, run, calls, replies)
        finally:
            run.end()
            self._executing = before

    def _execute_in_order(
        self, session: ClientSession, run: Run, calls: list[Call], replies: list[Reply]
    ) -> None:
        for position, call in enumerate(calls, 1):
            if call.operation == _CANCEL:
                stream_id = call.arguments[0] if call.arguments else 0
                session.streams.cancel(stream_id if type(stream_id) is int else 0)
                if call.call_id:
                    replies.append(Reply(call.call_id, STATUS_OK, self._publisher.time_ms(), []))
                continue
            if not 0 <= call.operation < _OPERATIONS:
                text = f"there is no operation {call.operation}; valid: {', '.join(map(repr, Operation))}"
                replies.append(Reply(call.call_id, STATUS_REMOTE_ERROR, self._publisher.time_ms(), [text]))
                continue
            answer = run.execute(call.command, call.arguments)
            time_ms = self._publisher.time_ms()
            if call.operation == _STREAM:
                self._publisher.arm(session, call, answer)
            if isinstance(answer, Future):
                before: list[Reply] = []
                if call.command == TRIGGER:
                    # Whoever steps waits for the pass: all answers come in one message after it.
                    before, replies = replies, []
                later = partial(self._deliver_later, session, before, call.call_id, time_ms)
                if call.command == TRIGGER and position < len(calls):
                    # What follows is executed after the pass, or when the client's next batch comes before that.
                    session.interrupted = Interrupted(before, calls[position:])
                    later = partial(self._go_on_later, session, session.interrupted, call.call_id, time_ms)
                elif call.command == TRIGGER:
                    session.before_trigger = before
                answer.add_done_callback(later)
                if session.interrupted is not None:
                    return
            else:
                replies.append(Reply(call.call_id, answer.status, time_ms, answer.values))
        if replies:
            self._outbox.put(session, replies)

    def _go_on_later(
        self, session: ClientSession, batch: Interrupted, call_id: int, time_ms: int, done: Future[Answer]
    ) -> None:
        """A triggered pass is made, in the middle of a batch; runs on whichever thread finished it."""
        status, values = done.result()
        self.post(partial(self._go_on, session, batch, Reply(call_id, status, time_ms, values)))

    def _go_on(self, session: ClientSession, batch: Interrupted, reply: Reply) -> None:
        if self._is_serving:
            self._inbox.hold(partial(self._go_on, session, batch, reply))
        elif session.interrupted is batch and self.sessions.get(session.client) is session:
            if self.recorder is not None:
                self.recorder.went_on(session.client)
            session.interrupted = None
            self._execute(session, batch.rest, [*batch.replies, reply])
        else:
            session.link.deliver(self._publisher.message(session, [reply]))

    def _deliver_later(
        self, session: ClientSession, before: list[Reply], call_id: int, time_ms: int, done: Future[Answer]
    ) -> None:
        """A picture is rendered or a triggered pass made; runs on whichever thread finished it."""
        status, values = done.result()
        replies = [*before, Reply(call_id, status, time_ms, values)]
        before.clear()
        session.link.deliver(self._publisher.message(session, replies))
