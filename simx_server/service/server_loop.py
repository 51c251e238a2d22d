"""The loop of the physics thread, which alone touches the simulation.

It takes calls from a queue while it waits for the wall clock and between simulation steps, so a blocking call costs a
round trip and never a simulation step. After each simulation step, every stream that is due is computed once. A
long-running script holds the thread. Other clients are answered meanwhile, see `inbox.py`.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Protocol

from simx_client.protocol.constants import sim_api_errormessage_report
from simx_server.simulation.part import Part
from simx_server.simulation.simulation import SimulationState

from .answers.outbox import LINGER, Outbox
from .answers.publishing import Publisher
from .answers.replies import Messages
from .calls.batches import Batches
from .calls.busy import BusyDesk, Doing
from .calls.dispatch import Dispatch
from .calls.executor import Executor
from .calls.registry import Handler
from .calls.work import Work, interfere
from .clients.admission.unfinished import Unfinished
from .clients.clients import Clients
from .clock import Pacer
from .ending import Ending
from .memory import Memory
from .monitoring.metrics import Metrics
from .queue.box import Arrival, Event
from .queue.inbox import Inbox
from .queue.sockets import Sockets

if TYPE_CHECKING:
    from simx_server.history import History
    from simx_server.history.returning import Returning
    from simx_server.recording import Recorder
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

IDLE_INTERVAL = 0.02
"""Seconds between two executions of the streams while no simulation step is due."""

SERVING = 0.05
"""Most seconds that clients are served before a step without pacing: the time that a step usually stands for."""

SERVING_WHEN_LATE = 0.01
"""The same for a step that is due by the wall clock: clients were served while it was not due."""

SERVING_DURING_SCRIPT = 0.02
"""The same for each time that a long-running script allows the server to serve others."""

LOOK = 0.05
"""Least seconds between two looks at work that is due now and then: a look after each turn would cost every call."""

HELD = 0.002
"""Seconds until a held simulation step (`Part.holds_step`) is checked again."""


_STREAMS, _WANTS_IDLE = attrgetter("streams.by_id"), attrgetter("wants_idle")
"""Each turn asks for these; a generator would take three times as long."""


class Idler(Protocol):
    """Something with work for the time in which the simulation is stopped or paused."""

    @property
    def wants_idle(self) -> bool:
        """Return whether there is such work now."""
        ...

    def idle(self) -> object:
        """Do a piece of it; called every `IDLE_INTERVAL` seconds."""
        ...


class ServerLoop(Part):
    """Sessions, simulation steps and streams of one simulation."""

    def __init__(
        self,
        world: World,
        handlers: Mapping[str, Handler],
        pacer: Pacer,
        *,
        starting_port: int | None = None,
    ) -> None:
        """Make a server loop; ``run`` or ``turn`` drive it.

        Args:
            starting_port: a client that comes by this port starts a stopped simulation, because in V-REP the service
                behind it existed only while a simulation ran.
        """
        self.world = world
        self.simulation = simulation = world.simulation
        self.metrics = Metrics(pacer)
        self._dispatch = Dispatch(world, handlers)
        self.executor = executor = Executor(self._dispatch, self.metrics)
        """Runs all calls, and knows what is being executed."""

        messages = Messages(simulation, pacer)
        self._messages = messages
        self._publisher = Publisher(executor, messages)
        self._pacer = pacer
        self._inbox = Inbox(lambda: self.simulation.limits)
        self.clients = clients = Clients(
            simulation, self._inbox, self.metrics, starting_port, lambda: self._is_serving
        )
        self.sessions = clients.sessions
        self.ending = Ending(simulation, self._inbox, self.sessions, lambda: executor.client)
        self._memory = Memory(self._inbox)
        for watcher in (self.metrics, self._memory, self.ending):
            clients.watch(watcher)
        self._outbox = Outbox(messages)
        self._batches = Batches(self, executor, self._publisher, self._outbox)
        self._waiting = self._batches.waiting
        self.readers_while_busy: list[Callable[[], object]] = []
        """Read sockets from another thread while the physics thread, which reads them otherwise, is busy."""

        self.unfinished = Unfinished(lambda: simulation.limits)
        """Counts what is held of messages that have not arrived completely, at all gateways."""

        self._busy = BusyDesk(self._inbox, self.sessions, messages, self._doing, self.readers_while_busy)
        self._is_serving = False
        """Within `serve_others`."""
        self._next_idle_round = 0.0
        self._has_handled = False
        """Something was handled since the last look."""

        self._is_paced = False
        """Simulation steps follow the wall clock at present."""

        self.idlers: list[Idler] = []
        """Want to be called now and then while the simulation is stopped or paused, beside the scene's scripts."""

        self.watches: list[Callable[[], object]] = []
        """Called about once per second, or more often: time-outs of work on other threads."""

        self.watches.append(self.unfinished.look)

        self.recorder: Recorder | None = None
        """Records everything that is done for clients, in order."""

        self.history: History | None = None
        """Keeps past steps of a run; None: nothing can ask for one."""

        self.returning: Returning | None = None
        """Clients of a crashed server whose successor this is; None: there was none."""

        self.is_going_back = False
        """A stop is followed by a start at once: a new run goes on from an earlier step (`history.going_on`)."""

        simulation.attach(self)
        simulation.interruptions.serve_others = self.serve_others
        simulation.interruptions.is_end_wanted = self._is_end_wanted

    # --- from any thread -------------------------------------------------------------------------

    def post(self, event: Event) -> None:
        """Schedule an event on the physics thread, in order of posting."""
        self._inbox.post(event)

    def post_for(self, client: str, event: Event) -> None:
        """Schedule an event as part of a client's messages, in front of those that wait."""
        self._inbox.put_first(client, event)

    def ask(self, kind: str, question: Event) -> int:
        """Queue a query from outside; return how many of its kind wait, 0 if they are too many."""
        return self._inbox.ask(kind, question)

    def submit(self, client: str, work: Work) -> bool:
        """Queue a message; return whether the client may continue at this rate, see `Inbox.put`."""
        return self._inbox.put(client, work, work.size, _unchanged)

    def submit_as(self, client: str, payload: Any, size: int, read: Callable[[Any], Work]) -> bool:
        """Queue a message as ``submit`` does, but make work of it only if there is space for it."""
        return self._inbox.put(client, payload, size, read)

    def keep_back(self, client: str, is_kept: bool) -> None:
        """Execute nothing more of a client until a step of its call is done, or continue."""
        self._inbox.keep_back(client, is_kept)

    def suspend(self, client: str, is_behind: bool) -> None:
        """Execute nothing more of a client that does not read its answers, or continue."""
        self._inbox.suspend(client, is_behind)

    def is_departing(self, client: str) -> bool:
        """Return whether a client is about to leave."""
        return self._inbox.is_leaving(client)

    def limit_reached(self, client: str, size: int) -> str:
        """Return why a message of this many bytes would not be queued; empty if it would be."""
        reached = self._inbox.limit_reached(client, size)
        return (
            str(self.simulation.limits.reached(reached, "wait for answers now and then")) if reached else ""
        )

    def has_much_waiting(self, client: str) -> bool:
        """Return whether a client has so much waiting that nothing more should be read from it. Any thread."""
        return self._inbox.has_much(client)

    def hand_over(self, client: str, work: Work) -> bool:
        """Execute a message next that the physics thread has read while it waited; False: ``submit`` it."""
        return self._inbox.hand_over(client, work)

    def post_behind(
        self,
        client: str,
        event: Event,
        *,
        waits_for_scripts: bool = False,
        stops: Callable[[], bool] | None = None,
    ) -> None:
        """Schedule an event behind the messages of a client that wait now.

        Args:
            waits_for_scripts: it does what must not be done while a script runs.
            stops: returns whether it would stop the simulation; None: it would not. Physics thread.
        """
        self._inbox.put_last(client, event, waits_for_scripts=waits_for_scripts, stops=stops)

    @property
    def sockets(self) -> Sockets:
        """Return the sockets that the physics thread reads; made on first use. Physics thread, or before it runs."""
        if self._inbox.sockets is None:
            self._inbox.sockets = Sockets()
        return self._inbox.sockets

    def others_wait_for(self, client: str) -> bool:
        """Return whether others wait for the end of a client's call: their messages, or the simulation that they use.

        Those who only look on do not count, nor does the simulation of a client that steps it. Physics thread.
        """
        if self._inbox.has_something_of_others(client):
            return True
        session = self.sessions.get(client)
        if self.simulation.state is not SimulationState.RUNNING or (session and session.is_stepping):
            return False
        return any(each is not session and not each.is_onlooker for each in self.sessions.values())

    @property
    def executing(self) -> str:
        """Return the client whose call is being executed; empty if there is none."""
        return self.executor.client

    def hold(self, event: Event) -> None:
        """Do something as soon as no script runs."""
        self._inbox.hold(event)

    def must_give_way(self) -> bool:
        """Return whether other clients wait, and may be served inside a batch."""
        return self._inbox.others_have_come() and self.may_cut_batches

    def look_on(self) -> None:
        """Mark the client that is being served as one that only shows the simulation: an end does not wait for it."""
        if session := self.sessions.get(self.executor.client):
            session.is_onlooker = True

    def busy_with(self) -> str:
        """Describe the work that keeps the physics thread from answering, if it takes long; empty otherwise."""
        return self._busy.describe()

    def answering_while_busy(self) -> AbstractContextManager[None]:
        """Refuse the blocking calls of clients of other processes within the block, while work takes too long."""
        return self._busy.open()

    def record(self, recorder: Recorder) -> None:
        """Have everything recorded from now on."""
        self.recorder = recorder
        self.clients.watch(recorder)

    def expect(self, returning: Returning) -> None:
        """Expect the clients of a crashed server, whose successor this is."""
        if self.returning is not None:
            self.clients.unwatch(self.returning)
        self.returning = returning
        self.clients.watch(returning)

    # --- for a client in this process: its thread is the physics thread during the call ------------

    def execute(self, client: str, work: Work) -> None:
        """Execute a message at once."""
        self._handle(Arrival(client, work))
        self._settle()
        self._outbox.send()

    @property
    def messages(self) -> Messages:
        """Return what knows the times and headers of replies."""
        return self._messages

    @property
    def advances_alone(self) -> bool:
        """Return whether something happens without calls: simulation steps, regular work, or what was queued."""
        return self.is_running_freely or self._idle_is_wanted() or self._inbox.has_work()

    def are_streams_due(self) -> bool:
        """Return whether streams are to be computed now, although no simulation step is made."""
        return (
            time.monotonic() >= self._next_idle_round and not self.is_running_freely and self._has_streams()
        )

    def seconds_until_turn(self) -> float:
        """Return the seconds until ``turn`` has something to do, if nothing arrives before."""
        return self._seconds_until_round()

    def wait_for_work(self, seconds: float) -> None:
        """Wait until something arrives, or the time is over; take nothing. Any thread, without a turn."""
        self._inbox.wait_for_work(seconds)

    # --- the loop --------------------------------------------------------------------------------

    def run(self, deadline: float | None = None) -> None:
        """Serve until ``end``, or a time on the monotonic clock."""
        next_look = 0.0
        with self._busy.open():
            while not self.ending.has_come and (deadline is None or time.monotonic() < deadline):
                left = 1.0 if deadline is None else deadline - time.monotonic()
                if self._has_handled:  # a look at what it changed must not wait for the next event
                    left = min(left, next_look - time.monotonic())
                self.turn(max_wait=max(0.0, min(1.0, left)))
                if (now := time.monotonic()) >= next_look:
                    next_look, self._has_handled = now + LOOK, False
                    self.look()
            self._outbox.send()

    def look(self) -> None:
        """Do what is due now and then."""
        self.metrics.tick()
        self._memory.look()
        for look in tuple(self.watches):  # a look may close a gateway, which takes its own from the list
            look()

    def close(self) -> None:
        """Abandon calls with a step under way, after ``run`` has returned for the last time."""
        for session in self.sessions.values():
            session.abandon_call()

    def close_sockets(self) -> None:
        """Read no sockets any more, after the gateways that have them are closed."""
        sockets, self._inbox.sockets = self._inbox.sockets, None
        if sockets is not None:
            sockets.close()

    def turn(self, max_wait: float = 0.0) -> None:
        """Wait for the first of: an event, a simulation step that is due, ``max_wait``. Then handle it.

        Before a simulation step, everything that has arrived is executed: commands act on the coming step.
        """
        self._tell_dropped()
        if self._waiting.is_for_step and not self.is_running_freely:
            self._waiting.end_for_step()
        wait = min(max_wait, self._seconds_until_round())
        if wait > 0:
            event = self._inbox.wait(min(wait, LINGER) if self._outbox.is_keeping else wait)
            if event is None:
                self._outbox.send()
                return
            self._handle(event)
            self._settle()
            # Mostly the next one is here already. Take only one: a simulation step may be due by now.
            if self._outbox.is_keeping and (event := self._inbox.wait(0)) is not None:
                self._handle(event)
                self._settle()
            return
        for event in self._inbox.at_hand(self._serving_time()):
            self._handle(event)
            self._settle()  # after each, however many came together
        self._outbox.send()
        self._settle()
        if self._seconds_until_round() <= 0 and not self._waiting.hold_steps:
            outer = self._busy.begin()
            try:
                self._round()
            finally:
                self._busy.go_back_to(outer)

    def _serving_time(self) -> float:
        """Return how many seconds clients are served at most before the step that is due."""
        return SERVING_WHEN_LATE if self._is_paced and math.isfinite(self._pacer.speed) else SERVING

    def _settle(self) -> None:
        if not self.simulation.is_settled:
            self._outbox.send()
            self.simulation.settle()

    def serve_others(self) -> None:
        """Serve the calls that do not interfere with the long-running script that calls this."""
        if self._is_serving:
            return
        self._is_serving = True
        try:
            self._outbox.send()
            executing, waits = self.executor.client, self._brings_on_what_interferes
            for event in self._inbox.meanwhile(executing, waits, SERVING_DURING_SCRIPT):
                self._handle(event)
            self._tell_dropped()
        finally:
            self._is_serving = False

    def _is_end_wanted(self) -> bool:
        """Return whether the server ends, or a client of any gateway waits for the run to stop."""
        is_stopped = self.simulation.state is SimulationState.STOPPED
        return self.ending.has_come or (self._inbox.has_stop_waiting and not is_stopped)

    def _brings_on_what_interferes(self, client: str) -> bool:
        """Return whether a batch of this client continues behind a trigger with calls that must wait for a script."""
        session = self.sessions.get(client)
        return session is not None and session.interrupted is not None and interfere(session.interrupted.rest)

    def _tell_dropped(self) -> None:
        """Report dropped messages to their clients, so that flooding cannot fill the memory unnoticed."""
        if not self._inbox.dropped:
            return
        limits = self.simulation.limits
        for (client, name), count in self._inbox.take_dropped().items():
            self.metrics.dropped += count
            if session := self.sessions.get(client):
                session.has_lost(count, str(limits.reached(name, "wait for answers now and then")))

    def _doing(self) -> Doing:
        return Doing(self.executor.client, self.executor.command)

    def _handle(self, event: Event | Arrival) -> None:
        self._has_handled = True
        outer = self._busy.begin()
        began = time.perf_counter()
        try:
            if isinstance(event, Arrival):
                self._batches.execute(event.client, event.work)
            else:
                self._outbox.send()
                event()
        except Exception:
            logger.exception("a request could not be dealt with; the server goes on")
        finally:
            self._busy.go_back_to(outer)
            self._inbox.served(time.perf_counter() - began)
        if self._is_serving:
            self._outbox.send()
        else:
            self._outbox.send_what_is_awaited()

    @property
    def is_ending(self) -> bool:
        return self.ending.has_come

    @property
    def is_serving(self) -> bool:
        """Return whether others are served while a script runs."""
        return self._is_serving

    @property
    def may_cut_batches(self) -> bool:
        """Return whether others may be served inside a batch, or between streams.

        A recording contains whole batches only.
        """
        return self.recorder is None and not self._is_serving

    @property
    def is_waiting_for_trigger(self) -> bool:
        """Return whether a running simulation waits until stepped clients trigger (parameter 45)."""
        if self.simulation.state is SimulationState.RUNNING:
            for session in self.sessions.values():  # each turn runs this, and `any` takes three times as long
                if session.is_waiting:
                    return True
        return False

    def _is_advancing(self) -> bool:
        return self.simulation.state is SimulationState.RUNNING and not self.is_waiting_for_trigger

    def _is_stepped(self) -> bool:
        return any(session.is_stepping for session in self.sessions.values())

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow automatically: no client steps, and the simulation is running."""
        return self.simulation.state is SimulationState.RUNNING and not self._is_stepped()

    def _seconds_until_round(self) -> float:
        if self.is_running_freely:
            if self.returning is not None and (awaited := self.returning.seconds_left()) > 0:
                return awaited
            if not self._is_paced:
                self._is_paced = True
                self._pacer.restart()  # the time of a stop, a pause or stepped mode is not caught up
            return self._pacer.seconds_left() or self._seconds_held(math.isinf(self._pacer.speed))
        self._is_paced = False
        if self._is_advancing():
            return self._seconds_held(True)
        if self._idle_is_wanted() or self._has_streams():
            return max(0.0, self._next_idle_round - time.monotonic())
        return math.inf

    def _has_streams(self) -> bool:
        return any(map(_STREAMS, self.sessions.values()))

    def _seconds_held(self, is_free: bool) -> float:
        """Return the seconds to wait if the step is held; `is_free`: the step does not follow the wall clock."""
        return HELD if is_free and self.simulation.is_held else 0.0

    def _idle_is_wanted(self) -> bool:
        if self.simulation.state is SimulationState.RUNNING:
            return False
        return self.world.scripts.want_idle or any(map(_WANTS_IDLE, self.idlers))

    def _round(self) -> None:
        """Make one simulation step if the simulation advances; compute the streams in any case."""
        is_advancing = self._is_advancing()
        if is_advancing:
            try:
                began = time.perf_counter()
                self.world.step()
                self.metrics.passed(self.simulation.time_step, time.perf_counter() - began)
            except (
                KeyboardInterrupt
            ):  # of an embedded simulation: a step that is half done cannot be continued
                logger.warning("Ctrl-C came within a simulation step, so the simulation is stopped")
                self._handle(self.simulation.stop)
                raise
            except Exception as error:
                logger.exception("the pass failed, so the simulation is stopped")
                problem = f"the pass failed, so the simulation is stopped: {error!r}"
                self._handle(partial(self.simulation.fail, problem))
            if self._is_paced:
                self._pacer.passed(self.simulation.time_step)
            self._publisher.publish(self.sessions.values(), after_step=True, is_bounded=self.may_cut_batches)
            for session in self.sessions.values():
                # Values read after a trigger are of the new state, including streamed images.
                session.release_triggers(after=session.streams.images_on_the_way())
                session.paced.step_made()
            self._waiting.end_for_step()
        else:
            if self._idle_is_wanted():
                self._handle(self.world.idle)
                for idler in self.idlers:
                    self._handle(idler.idle)
            self._publisher.publish(self.sessions.values(), after_step=False, is_bounded=self.may_cut_batches)
        if self.recorder is not None:
            self.recorder.passed(is_advancing=is_advancing)
        self._waiting.count_round()
        self._next_idle_round = time.monotonic() + IDLE_INTERVAL

    def script_stopped(self, problem: str) -> None:
        """Report an error of a script, or of a simulation step, to every client: no single call has caused it."""
        if self.world.parameters.error_report_mode & sim_api_errormessage_report:
            for session in self.sessions.values():
                if not (
                    session.errors and session.errors[-1].endswith(problem)
                ):  # the error of a call that waited
                    session.errors.append(problem)

    def run_stopped(self) -> None:
        """End stepped mode of every client, which must enable it again for each run.

        If the run cannot continue, the calls that wait for its steps fail.
        """
        if failure := self.simulation.failure:
            for session in self.sessions.values():
                session.fail_triggers(failure)
            self._waiting.fail_for_step(failure)
        for session in self.sessions.values():
            session.set_stepping(False)


def _unchanged(work: Work) -> Work:
    return work
